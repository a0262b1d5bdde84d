//! The table of all subjects.

use intertri::lanes::{Level, Mask, Simd, WithSimd};
use intertri::{Certified, Double, Lane, Mode, Ray, RayPacket, Triangle, TrianglePack, Vec3};

use super::badouel::Badouel;
use super::baldwin_weber::BaldwinWeber;
use super::cramer::Cramer;
use super::embree::{EdgeForm, Robust};
use super::inter_tri::InterTri;
use super::moller_trumbore::MollerTrumbore;
use super::pluecker::Pluecker;
use super::signed_volume::SignedVolume;
use super::woop::Woop;
use super::{Method, Real};
use intertri_reference::THRESHOLD;

/// What a subject says of a ray and a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Answer {
    /// Whether there is a hit.
    pub hit: bool,
    /// The `t` of the hit; for a miss, whatever the method left there.
    pub t: f64,
}

/// One method in one precision.
#[derive(Clone, Copy, Debug)]
pub struct Subject {
    /// The name by which it is called in tables and charts.
    pub name: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// The significant bits of what it computes in: 24 or 53.
    pub bits: u32,
    pairs: fn(Level, &[Triangle], &[Ray], &mut [Answer]),
}

impl Subject {
    /// Tests ray `i` against triangle `i`, eight pairs at a time, on the lanes of a level.
    ///
    /// The intervals of the rays do not matter.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn pairs(&self, level: Level, triangles: &[Triangle], rays: &[Ray], to: &mut [Answer]) {
        assert!(triangles.len() == rays.len() && rays.len() == to.len(), "as many of each");
        (self.pairs)(level, triangles, rays, to);
    }
}

/// A method at work on pairs, in f32 or f64.
struct Pairs<'a, M, const DOUBLE: bool> {
    method: M,
    triangles: &'a [Triangle],
    rays: &'a [Ray],
    to: &'a mut [Answer],
}

impl<M: Method, const DOUBLE: bool> WithSimd for Pairs<'_, M, DOUBLE> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { method, triangles, rays, to } = self;
        for ((triangles, rays), to) in triangles.chunks(8).zip(rays.chunks(8)).zip(to.chunks_mut(8))
        {
            let (triangles, rays) = (TrianglePack::<8>::new(triangles), RayPacket::<8>::new(rays));
            if DOUBLE {
                eight::<M, S::F64x8>(method, &triangles, &rays, to);
            } else {
                eight::<M, S::F32x8>(method, &triangles, &rays, to);
            }
        }
    }
}

#[inline(always)]
fn eight<M: Method, L: Real>(
    method: M,
    triangles: &TrianglePack<8>,
    rays: &RayPacket<8>,
    to: &mut [Answer],
) {
    let triangle = method.triangle::<L>(triangles.corners().each_ref().map(Vec3::load_f32));
    let ray = method.ray::<L>(Vec3::load_f32(&rays.origin), Vec3::load_f32(&rays.dir));
    let (hit, t) = method.test(&triangle, &ray);
    let mut ts = [<L::Scalar as super::Number>::of(0.0); 8];
    t.store(&mut ts);
    for (lane, to) in to.iter_mut().enumerate() {
        *to = Answer { hit: hit.bits() >> lane & 1 == 1, t: ts[lane].into() };
    }
}

/// A method in one precision as a row of the table.
macro_rules! subject {
    ($name:literal, $source:literal, $method:expr, f32) => {
        subject!(@ $name, $source, $method, 24, false)
    };
    ($name:literal, $source:literal, $method:expr, f64) => {
        subject!(@ $name, $source, $method, 53, true)
    };
    (@ $name:literal, $source:literal, $method:expr, $bits:literal, $double:literal) => {
        Subject {
            name: $name,
            source: $source,
            bits: $bits,
            pairs: |level, triangles, rays, to| {
                level.run(Pairs::<_, $double> { method: $method, triangles, rays, to });
            },
        }
    };
}

/// A mode of the kernel on pairs: each ray a packet of its own.
fn kernel<M: Mode>(mode: M, triangles: &[Triangle], rays: &[Ray], to: &mut [Answer])
where
    Lane<4>: intertri::Width,
{
    for ((triangle, ray), to) in triangles.iter().zip(rays).zip(to) {
        let whole = Ray::new(ray.origin, ray.dir);
        let hits = mode.packet(&RayPacket::<4>::new(&[whole]), &mode.prepare(triangle));
        *to = Answer { hit: hits.bits & 1 == 1, t: hits.t[0] };
    }
}

/// Every subject. Whatever compares methods iterates over this.
pub const SUBJECTS: &[Subject] = &[
    subject!("InterTri f64", "document A", InterTri { threshold: THRESHOLD }, f64),
    subject!("InterTri f32", "document A", InterTri { threshold: THRESHOLD }, f32),
    subject!("Cramer f32", "document D", Cramer, f32),
    subject!("Cramer f64", "document D", Cramer, f64),
    subject!("Möller–Trumbore f32", "Möller, Trumbore 1997", MollerTrumbore { epsilon: 0.0 }, f32),
    subject!("Möller–Trumbore f64", "Möller, Trumbore 1997", MollerTrumbore { epsilon: 0.0 }, f64),
    subject!(
        "Möller–Trumbore ε f32",
        "Möller, Trumbore 1997",
        MollerTrumbore { epsilon: 1e-6 },
        f32
    ),
    subject!("Badouel f32", "Badouel 1990", Badouel, f32),
    subject!("Baldwin–Weber f32", "Baldwin, Weber 2016", BaldwinWeber, f32),
    subject!("Plücker f32", "Jones 2000", Pluecker, f32),
    subject!("signed volume f32", "Segura, Feito 2001", SignedVolume, f32),
    subject!("signed volume f64", "Segura, Feito 2001", SignedVolume, f64),
    subject!("Woop f32", "Woop, Benthin, Wald 2013", Woop { fall_back: true }, f32),
    subject!("Embree fast f32", "Wald et al. 2014", EdgeForm, f32),
    subject!("Embree robust f32", "Wald et al. 2014", Robust, f32),
    Subject {
        name: "double",
        source: "the kernel",
        bits: 53,
        pairs: |level, triangles, rays, to| {
            kernel(Double::default().at(level), triangles, rays, to);
        },
    },
    Subject {
        name: "certified",
        source: "the kernel",
        bits: 53,
        pairs: |level, triangles, rays, to| {
            kernel(Certified::default().at(level), triangles, rays, to);
        },
    },
];
