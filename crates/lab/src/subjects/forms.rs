//! The forms in which a method is at work: rays and triangles in pairs, N rays against one triangle
//! after another, one ray against N triangles at a time.
//!
//! What is computed once for a triangle is computed before the clock starts, and stored as one number
//! a field (packets) or as N (packs); what is computed once for a ray is on the clock. All forms keep
//! the closest hit of each ray without a branch.

use std::time::Instant;

use intertri::lanes::{Level, Mask, Simd, WithSimd};
use intertri::{Ray, RayPacket, Triangle, TrianglePack, Vec3};

use super::{Method, Number, Real};

/// What a subject says of a ray and a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Answer {
    /// Whether there is a hit.
    pub hit: bool,
    /// The `t` of the hit; for a miss, whatever the method left there.
    pub t: f64,
}

/// Rays and triangles that are tested all with all, as at a leaf of a hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    /// The rays.
    pub rays: Vec<Ray>,
    /// The triangles; not none.
    pub triangles: Vec<Triangle>,
}

impl Bundle {
    /// How many triangles each ray hits, all pairs being tested by `pairs`.
    pub(super) fn counts(
        &self,
        mut pairs: impl FnMut(&[Triangle], &[Ray], &mut [Answer]),
    ) -> Vec<u32> {
        let mut to = vec![Answer::default(); self.triangles.len()];
        let count = |ray: &Ray| {
            pairs(&self.triangles, &vec![*ray; self.triangles.len()], &mut to);
            to.iter().filter(|answer| answer.hit).count() as u32
        };
        self.rays.iter().map(count).collect()
    }
}

/// The closest hit of a ray in its bundle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Infinity for a miss.
    pub t: f64,
    /// The number of the triangle in the bundle, [`Nearest::MISS`]'s for a miss.
    pub triangle: u32,
}

impl Nearest {
    /// No triangle.
    pub const MISS: Self = Self { t: f64::INFINITY, triangle: u32::MAX };
}

/// What lies side by side in the lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// N rays against one triangle after another.
    Packets,
    /// One ray after another against N triangles.
    Packs,
}

impl Form {
    /// `packets` or `packs`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Packets => "packets",
            Self::Packs => "packs",
        }
    }
}

/// Which form, and how many lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// What lies in the lanes.
    pub form: Form,
    /// 1, 4, 8 or 16.
    pub lanes: usize,
}

/// The closest hits of bundles, to be found in some layout. `nearest` gets one entry a ray, bundle by
/// bundle.
pub(super) struct Closest<'a, M> {
    pub(super) method: M,
    pub(super) bundles: &'a [Bundle],
    pub(super) layout: Layout,
    pub(super) nearest: &'a mut Vec<Nearest>,
}

/// The seconds on the clock.
pub(super) type Seconds = f64;

/// [`Closest`] in f32 or f64, with four lanes or more.
struct Run<'a, M, const DOUBLE: bool>(Closest<'a, M>);

impl<M: Method> Closest<'_, M> {
    /// Does it, in f32 or f64. `None` for 16 lanes that are not one register.
    pub(super) fn run<const DOUBLE: bool>(self, level: Level) -> Option<Seconds> {
        match (self.layout.lanes, self.layout.form, DOUBLE) {
            (1, Form::Packets, false) => Some(packets::<M, f32, 1>(self)),
            (1, Form::Packets, true) => Some(packets::<M, f64, 1>(self)),
            (1, Form::Packs, false) => Some(packs::<M, f32, 1>(self)),
            (1, Form::Packs, true) => Some(packs::<M, f64, 1>(self)),
            _ => level.run(Run::<M, DOUBLE>(self)),
        }
    }
}

/// Whether sixteen f32 are one register at a level, aligned as such. Where they are not, no code is
/// made for them.
pub(super) const fn one_register<S: Simd>() -> bool {
    align_of::<S::F32x16>() == 16 * size_of::<f32>()
}

impl<M: Method, const DOUBLE: bool> WithSimd for Run<'_, M, DOUBLE> {
    type Output = Option<Seconds>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Seconds> {
        let Self(work) = self;
        let Layout { form, lanes } = work.layout;
        if const { DOUBLE } {
            match (form, lanes) {
                (Form::Packets, 4) => Some(packets::<M, S::F64x4, 4>(work)),
                (Form::Packets, 8) => Some(packets::<M, S::F64x8, 8>(work)),
                (Form::Packs, 4) => Some(packs::<M, S::F64x4, 4>(work)),
                (Form::Packs, 8) => Some(packs::<M, S::F64x8, 8>(work)),
                _ => None,
            }
        } else {
            match (form, lanes) {
                (Form::Packets, 4) => Some(packets::<M, S::F32x4, 4>(work)),
                (Form::Packets, 8) => Some(packets::<M, S::F32x8, 8>(work)),
                (Form::Packs, 4) => Some(packs::<M, S::F32x4, 4>(work)),
                (Form::Packs, 8) => Some(packs::<M, S::F32x8, 8>(work)),
                _ if const { !one_register::<S>() } => None,
                (Form::Packets, _) => Some(packets::<M, S::F32x16, 16>(work)),
                (Form::Packs, _) => Some(packs::<M, S::F32x16, 16>(work)),
            }
        }
    }
}

/// The closest hit of each lane so far, and the number of its triangle, as a number.
#[derive(Clone, Copy)]
struct Best<L> {
    t: L,
    triangle: L,
}

impl<L: Real> Best<L> {
    #[inline(always)]
    fn new() -> Self {
        Self { t: L::of(f64::INFINITY), triangle: L::of(-1.0) }
    }

    #[inline(always)]
    fn offer(&mut self, hit: L::Mask, t: L, triangle: L) {
        let nearer = hit & t.lt(self.t);
        self.t = L::select(nearer, t, self.t);
        self.triangle = L::select(nearer, triangle, self.triangle);
    }

    /// Lane by lane; lanes beyond the last triangle repeat it.
    #[inline(always)]
    fn lanes<const N: usize>(self, triangles: usize) -> [Nearest; N] {
        let zero = L::Scalar::nearest(0.0);
        let (mut t, mut number) = ([zero; N], [zero; N]);
        self.t.store(&mut t);
        self.triangle.store(&mut number);
        std::array::from_fn(|lane| {
            let number: f64 = number[lane].into();
            if number < 0.0 {
                Nearest::MISS
            } else {
                let triangle = (number as u32).min(triangles as u32 - 1);
                Nearest { t: t[lane].into(), triangle }
            }
        })
    }
}

/// N rays against one triangle after another.
#[inline(always)]
fn packets<M: Method, L: Real, const N: usize>(work: Closest<'_, M>) -> Seconds {
    let Closest { method, bundles, nearest, .. } = work;
    let splat = |p: [f32; 3]| Vec3::<L::Scalar>::splat(p.map(|x| L::Scalar::nearest(x.into())));
    let prepared: Vec<(Vec<_>, Vec<_>)> = bundles
        .iter()
        .map(|bundle| {
            let triangle = |t: &Triangle| method.triangle::<L::Scalar>(t.0.map(splat));
            let packets = bundle.rays.chunks(N).map(RayPacket::<N>::new).collect();
            (packets, bundle.triangles.iter().map(triangle).collect())
        })
        .collect();
    nearest.clear();
    nearest.reserve(bundles.iter().map(|bundle| bundle.rays.len() + N).sum());

    let start = Instant::now();
    for ((packets, triangles), bundle) in prepared.iter().zip(bundles) {
        let end = nearest.len() + bundle.rays.len();
        for packet in packets {
            let ray = method.ray::<L>(Vec3::load_f32(&packet.origin), Vec3::load_f32(&packet.dir));
            let (mut best, mut number) = (Best::new(), L::of(0.0));
            for triangle in triangles {
                let (hit, t) = method.test(&M::spread::<L>(triangle), &ray);
                best.offer(hit, t, number);
                number = number + L::of(1.0);
            }
            nearest.extend_from_slice(&best.lanes::<N>(triangles.len()));
        }
        nearest.truncate(end);
    }
    start.elapsed().as_secs_f64()
}

/// One ray after another against N triangles at a time.
#[inline(always)]
fn packs<M: Method, L: Real, const N: usize>(work: Closest<'_, M>) -> Seconds {
    let Closest { method, bundles, nearest, .. } = work;
    let prepared: Vec<Vec<M::Triangle<L>>> = bundles
        .iter()
        .map(|bundle| {
            let triangles = |chunk: &[Triangle]| {
                let pack = TrianglePack::<N>::new(chunk);
                method.triangle::<L>(pack.corners().each_ref().map(Vec3::load_f32))
            };
            bundle.triangles.chunks(N).map(triangles).collect()
        })
        .collect();
    nearest.clear();
    nearest.reserve(bundles.iter().map(|bundle| bundle.rays.len()).sum());
    let numbers: [L::Scalar; N] = std::array::from_fn(|lane| L::Scalar::nearest(lane as f64));

    let start = Instant::now();
    for (packs, bundle) in prepared.iter().zip(bundles) {
        for ray in &bundle.rays {
            let splat = |p: [f32; 3]| Vec3::splat(p.map(|x| L::Scalar::nearest(x.into())));
            let ray = method.ray::<L>(splat(ray.origin), splat(ray.dir));
            let (mut best, mut number) = (Best::new(), L::load(&numbers));
            for triangles in packs {
                let (hit, t) = method.test(triangles, &ray);
                best.offer(hit, t, number);
                number = number + L::of(N as f64);
            }
            let lanes = best.lanes::<N>(bundle.triangles.len());
            let nearer = |a: &Nearest, b: &Nearest| (b.t, b.triangle) < (a.t, a.triangle);
            let closest = lanes.into_iter().reduce(|a, b| if nearer(&a, &b) { b } else { a });
            nearest.push(closest.unwrap_or(Nearest::MISS));
        }
    }
    start.elapsed().as_secs_f64()
}

/// A method at work on pairs, in f32 or f64.
pub(super) struct Pairs<'a, M, const DOUBLE: bool> {
    pub(super) method: M,
    pub(super) triangles: &'a [Triangle],
    pub(super) rays: &'a [Ray],
    pub(super) to: &'a mut [Answer],
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
    let mut ts = [L::Scalar::nearest(0.0); 8];
    t.store(&mut ts);
    for (lane, to) in to.iter_mut().enumerate() {
        *to = Answer { hit: hit.bits() >> lane & 1 == 1, t: ts[lane].into() };
    }
}
