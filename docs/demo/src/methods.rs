//! The methods that the page compares, all by one question: rays of one origin against triangles.

use intertri::simd::{Level, Mask, Simd, Vec3, WithSimd};
use intertri::{Certified, ClosestHits, Counts, Exact, LaneQueries, Mode, RayPacket, Triangle};
use intertri_lab::methods::baldwin_weber::BaldwinWeber;
use intertri_lab::methods::embree::{EdgeForm, Robust};
use intertri_lab::methods::moller_trumbore::MollerTrumbore;
use intertri_lab::methods::woop::Woop;
use intertri_lab::methods::{Intersector, Number, Real};

/// Who is told of hits: packet, bits of the lanes, triangle, and the t of each lane.
pub(crate) trait Sink {
    fn hits(&mut self, packet: usize, bits: u32, triangle: usize, t: &[f64; 8]);
}

/// Packets of rays, and triangles: every pair is tested, triangle by triangle within a packet.
#[derive(Clone, Copy)]
pub(crate) struct Pairs<'a> {
    pub(crate) packets: &'a [RayPacket<8>],
    pub(crate) triangles: &'a [Triangle],
    /// What is asked: whether pairs hit, of which no t is told, or each ray's closest hit. Of the latter a method
    /// may tell all hits, in the order of the triangles.
    pub(crate) closest: bool,
}

/// A method: its name, its significant bits, and what it answers.
#[derive(Clone, Copy)]
pub struct Method {
    /// The name, as the page shows it.
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

/// Every method, in the order of the page. The last is the truth.
pub static METHODS: [Method; 8] = [
    published!("Möller–Trumbore f32", MollerTrumbore { epsilon: 0.0 }, false),
    published!("Baldwin–Weber f32", BaldwinWeber, false),
    published!("Embree fast f32", EdgeForm, false),
    published!("Embree robust f32", Robust, false),
    published!("Woop watertight f32", Woop { fall_back: true }, false),
    published!("Möller–Trumbore f64", MollerTrumbore { epsilon: 0.0 }, true),
    mode!("intertri certified", Certified::default()),
    mode!("intertri exact", Exact::default()),
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

/// A mode of the kernel.
struct OfMode<'a, T> {
    test: T,
    pairs: Pairs<'a>,
    sink: &'a mut dyn Sink,
}

impl<T: LaneQueries> WithSimd for OfMode<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { test, pairs: Pairs { packets, triangles, closest }, sink } = self;
        let prepared: Vec<_> = triangles.iter().map(|triangle| test.prepare(triangle)).collect();
        let find = |place: u32| triangles[place as usize];
        let mut counts = Counts::default();
        for (i, packet) in packets.iter().enumerate() {
            let rays = test.prepare_packet_in::<S, 8>(packet);
            if closest {
                let mut best = ClosestHits::new(&packet.t_max);
                test.packet_closest_of_in(
                    &rays,
                    &prepared,
                    0,
                    find,
                    packet.live(),
                    &mut best,
                    &mut counts,
                );
                let t = test.hits_in(&rays, &best, find).t;
                for lane in 0..8 {
                    if let Some((k, _)) = best.lane(lane).triangle() {
                        sink.hits(i, 1 << lane, k as usize, &t);
                    }
                }
                continue;
            }
            for (k, triangle) in prepared.iter().enumerate() {
                let bits = test.packet_any_in(&rays, triangle, packet.live(), &mut counts);
                if bits != 0 {
                    sink.hits(i, bits, k, &[0.0; 8]);
                }
            }
        }
    }
}

fn of_mode<M: Mode>(mode: M, pairs: Pairs<'_>, sink: &mut dyn Sink) {
    mode.level().run(OfMode { test: mode.test(), pairs, sink });
}
