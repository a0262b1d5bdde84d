//! The methods that the page compares, and a common interface to them. Each method tests packets of
//! rays against triangles.

use intertri::simd::{Level, Mask, Simd, Vec3, WithSimd};
use intertri::{
    ClosestHits, Counts, LeafSlot, Mode, PreparedTriangle, RayPacket, Triangle, TriangleId,
};
use intertri_lab::methods::baldwin_weber::BaldwinWeber;
use intertri_lab::methods::embree::{EdgeForm, Robust};
use intertri_lab::methods::moller_trumbore::MollerTrumbore;
use intertri_lab::methods::woop::Woop;
use intertri_lab::methods::{Intersector, Number, Real};

/// Receives the hits of a packet on a triangle: the packet's index, a bit mask of the lanes that
/// hit, the triangle's index, and the t of each lane.
pub(crate) trait Sink {
    fn hits(&mut self, packet: usize, bits: u32, triangle: usize, t: &[f64; 8]);
}

/// Packets of rays, and the triangles to test against them. Each packet is tested against all
/// triangles in order.
#[derive(Clone, Copy)]
pub(crate) struct Pairs<'a> {
    pub(crate) packets: &'a [RayPacket<8>],
    pub(crate) triangles: &'a [Triangle],
    /// Whether to report only closest hits, with t, rather than all hits, without t. Even if only
    /// closest hits are requested, a method may report all hits, in the order of the triangles.
    pub(crate) closest: bool,
}

/// A method for testing rays against triangles.
#[derive(Clone, Copy)]
pub struct Method {
    /// The name, as shown on the page.
    pub name: &'static str,
    run: fn(Pairs<'_>, &mut dyn Sink),
}

impl Method {
    pub(crate) fn run(&self, pairs: Pairs<'_>, sink: &mut dyn Sink) {
        (self.run)(pairs, sink);
    }
}

macro_rules! published {
    ($name:literal, $intersector:expr, $double:literal) => {
        Method {
            name: $name,
            run: |pairs, sink| {
                let intersector = $intersector;
                Level::best().run(Published::<_, $double> { intersector, pairs, sink });
            },
        }
    };
}

macro_rules! mode {
    ($name:literal, $mode:expr) => {
        Method { name: $name, run: |pairs, sink| of_mode($mode, pairs, sink) }
    };
}

/// All methods, in the order in which the page shows them. The last one is `exact`, against which
/// the others are compared.
pub static METHODS: [Method; 8] = [
    published!("Möller–Trumbore f32", MollerTrumbore { epsilon: 0.0 }, false),
    published!("Baldwin–Weber f32", BaldwinWeber, false),
    published!("Embree fast f32", EdgeForm, false),
    published!("Embree robust f32", Robust, false),
    published!("Woop watertight f32", Woop { fall_back: true }, false),
    published!("Möller–Trumbore f64", MollerTrumbore { epsilon: 0.0 }, true),
    mode!("intertri certified", Mode::certified()),
    mode!("intertri exact", Mode::exact()),
];

struct Published<'a, M, const DOUBLE: bool> {
    intersector: M,
    pairs: Pairs<'a>,
    sink: &'a mut dyn Sink,
}

impl<M: Intersector, const DOUBLE: bool> WithSimd for Published<'_, M, DOUBLE> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { intersector, pairs, sink } = self;
        if DOUBLE {
            published::<M, S::F64x8>(intersector, pairs, sink);
        } else {
            published::<M, S::F32x8>(intersector, pairs, sink);
        }
    }
}

#[inline(always)]
fn published<M: Intersector, L: Real>(intersector: M, pairs: Pairs<'_>, sink: &mut dyn Sink) {
    let scalar = |corner: [f32; 3]| {
        Vec3::<L::Scalar>::splat(corner.map(|x| L::Scalar::nearest(f64::from(x))))
    };
    let prepared = |triangle: &Triangle| {
        let [a, b, c] = triangle.0;
        intersector.triangle::<L::Scalar>([scalar(a), scalar(b), scalar(c)])
    };
    let triangles: Vec<_> = pairs.triangles.iter().map(prepared).collect();
    for (i, packet) in pairs.packets.iter().enumerate() {
        let (origin, dir) = (Vec3::load_f32(&packet.origin), Vec3::load_f32(&packet.dir));
        let ray = intersector.ray::<L>(origin, dir);
        for (k, triangle) in triangles.iter().enumerate() {
            let (hit, t) = intersector.test(&M::spread::<L>(triangle), &ray);
            let bits = hit.bits() & packet.live();
            if bits != 0 {
                let mut ts = [L::Scalar::nearest(0.0); 8];
                t.store(&mut ts);
                sink.hits(i, bits, k, &ts.map(Into::into));
            }
        }
    }
}

/// Runs a mode of the kernel on packets and triangles.
struct OfMode<'a> {
    mode: Mode,
    pairs: Pairs<'a>,
    sink: &'a mut dyn Sink,
}

impl WithSimd for OfMode<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { mode, pairs: Pairs { packets, triangles, closest }, sink } = self;
        let filter = mode.filter();
        let prepared: Vec<_> = triangles.iter().map(PreparedTriangle::new).collect();
        let find = |LeafSlot(slot)| triangles[slot as usize];
        let mut counts = Counts::default();
        for (i, packet) in packets.iter().enumerate() {
            let (rays, live) = (filter.prepare_packet_in::<S, 8>(packet), packet.live());
            if closest {
                let mut best = ClosestHits::new(&packet.t_max);
                filter.packet_closest_of_in(&rays, &prepared, live, &mut best, &mut counts);
                let t = filter.hits_in(&rays, &best, find).t;
                for lane in 0..8 {
                    if let Some((TriangleId(k), _)) = best.lane(lane).triangle() {
                        sink.hits(i, 1 << lane, k as usize, &t);
                    }
                }
                continue;
            }
            for (k, triangle) in prepared.iter().enumerate() {
                let bits = filter.packet_any_in(&rays, triangle, live, &mut counts);
                if bits != 0 {
                    sink.hits(i, bits, k, &[0.0; 8]);
                }
            }
        }
    }
}

fn of_mode(mode: Mode, pairs: Pairs<'_>, sink: &mut dyn Sink) {
    mode.level().run(OfMode { mode, pairs, sink });
}
