//! The mode `certified` in its form for rays that share an origin, as camera rays and hard shadow
//! rays do: the edges' forms belong to a triangle and the origin, and a ray costs three products.
//!
//! The forms are made before the clock starts, like all constants of a triangle: a picture's rays
//! share them.

use std::time::Instant;

use intertri::lanes::{Level, Simd, WithSimd};
use intertri::{
    Bests, Certified, Counts, Lane, Mode, Ray, RayPacket, Threshold, Triangle, TrianglePack, Views,
    Width,
};

use super::forms::{Answer, Bundle, Form, Layout, Nearest, Seconds, one_register};
use super::kernel::answer;

/// Pairs: a ray shares its origin with itself.
pub(super) fn pairs(
    level: Level,
    threshold: f64,
    triangles: &[Triangle],
    rays: &[Ray],
    to: &mut [Answer],
) {
    let mode = Certified::new(Threshold::new(threshold).unwrap_or_default());
    level.run(Pairs { mode, triangles, rays, to });
}

/// The closest hits of bundles; `None` but for packets of rays that share their bundle's origin.
pub(super) fn closest(
    level: Level,
    bundles: &[Bundle],
    layout: Layout,
    nearest: &mut Vec<Nearest>,
) -> Option<Seconds> {
    let bits = |ray: &Ray| ray.origin.map(f32::to_bits);
    let shared = |bundle: &Bundle| bundle.rays.windows(2).all(|two| bits(&two[0]) == bits(&two[1]));
    let has = layout.form == Form::Packets && layout.lanes > 1 && bundles.iter().all(shared);
    has.then(|| level.run(Closest { bundles, lanes: layout.lanes, nearest })).flatten()
}

struct Pairs<'a> {
    mode: Certified,
    triangles: &'a [Triangle],
    rays: &'a [Ray],
    to: &'a mut [Answer],
}

impl WithSimd for Pairs<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { mode, triangles, rays, to } = self;
        for ((triangle, ray), to) in triangles.iter().zip(rays).zip(to) {
            let packet = RayPacket::<4>::new(&[Ray::new(ray.origin, ray.dir)]);
            let view = mode.view(triangle, ray.origin);
            let lanes = mode.prepare_packet_in::<S, 4>(&packet);
            let (find, mut bests) = (|_| *triangle, Bests::new(&packet.t_max));
            let counts = &mut Counts::default();
            mode.view_closest_in(&lanes, &view, (0, 0), find, packet.live(), &mut bests, counts);
            let found = mode.index_and_t(&packet.ray(0), &bests.lane(0), find);
            *to = found.map_or(Answer::default(), |(_, t)| Answer { hit: true, t });
        }
    }
}

struct Closest<'a> {
    bundles: &'a [Bundle],
    lanes: usize,
    nearest: &'a mut Vec<Nearest>,
}

impl WithSimd for Closest<'_> {
    type Output = Option<Seconds>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Seconds> {
        let Self { bundles, lanes, nearest } = self;
        let mode = Certified::default();
        nearest.clear();
        nearest.reserve(bundles.iter().map(|bundle| bundle.rays.len()).sum());
        match lanes {
            4 => Some(packets::<S, 4>(mode, bundles, nearest)),
            8 => Some(packets::<S, 8>(mode, bundles, nearest)),
            _ if const { one_register::<S>() } => Some(packets::<S, 16>(mode, bundles, nearest)),
            _ => None,
        }
    }
}

/// N rays of one origin against one triangle after another.
#[inline(always)]
fn packets<S: Simd, const N: usize>(
    mode: Certified,
    bundles: &[Bundle],
    nearest: &mut Vec<Nearest>,
) -> Seconds
where
    Lane<N>: Width,
{
    let prepared: Vec<(Vec<RayPacket<N>>, Vec<Views>)> = bundles
        .iter()
        .map(|bundle| {
            let origin = bundle.rays.first().map_or([0.0; 3], |ray| ray.origin);
            let packets = bundle.rays.chunks(N).map(RayPacket::new).collect();
            let packs = bundle.triangles.chunks(8).map(TrianglePack::new);
            (packets, packs.map(|pack| mode.views_in::<S>(&pack, origin)).collect())
        })
        .collect();
    let mut counts = Counts::default();

    let start = Instant::now();
    for ((packets, views), bundle) in prepared.iter().zip(bundles) {
        let find = |place: u32| bundle.triangles[place as usize];
        for packet in packets {
            let rays = mode.prepare_packet_in::<S, N>(packet);
            let (live, mut bests) = (packet.live(), Bests::new(&packet.t_max));
            mode.views_closest_in(&rays, views, 0, find, live, &mut bests, &mut counts);
            for lane in 0..live.count_ones() as usize {
                nearest.push(answer(&mode, &packet.ray(lane), &bests.lane(lane), find));
            }
        }
    }
    start.elapsed().as_secs_f64()
}
