//! The kernel's modes and the scalar reference as subjects, in the same forms as the methods.

use std::time::Instant;

use intertri::fixed::{self, Bits, Grid};
use intertri::lanes::{Level, Simd, WithSimd};
use intertri::{
    Best, Bests, Counts, Hits, Lane, Mode, Ray, RayPacket, Triangle, TrianglePack, Width,
};
use intertri_reference as reference;

use super::forms::{Answer, Bundle, Form, Layout, Nearest, Seconds, one_register};

/// A mode of the kernel on pairs: each ray a packet of its own.
pub(super) fn pairs<M: Mode>(mode: M, triangles: &[Triangle], rays: &[Ray], to: &mut [Answer]) {
    for ((triangle, ray), to) in triangles.iter().zip(rays).zip(to) {
        let whole = Ray::new(ray.origin, ray.dir);
        let hits = mode.packet(&RayPacket::<4>::new(&[whole]), &mode.prepare(triangle));
        *to = Answer { hit: hits.bits & 1 == 1, t: hits.t[0] };
    }
}

/// The mode `fixed` on pairs: each on the finest grid that holds it. Where there is none, a miss.
pub(super) fn fixed_pairs(level: Level, triangles: &[Triangle], rays: &[Ray], to: &mut [Answer]) {
    for ((triangle, ray), to) in triangles.iter().zip(rays).zip(to) {
        let whole = Ray::new(ray.origin, ray.dir);
        let points = triangle.0.into_iter().chain([ray.origin]);
        let snapped = Grid::around(points, Bits::FINE)
            .and_then(|grid| Ok((grid.triangle(triangle)?, grid.ray(&whole)?)));
        *to = snapped.map_or(Answer::default(), |(triangle, ray)| {
            let block = fixed::Block::<8>::new([(triangle, 0)]);
            let hit = fixed::Fixed::at(level).closest(&[block], &ray);
            Answer { hit: hit.is_hit(), t: hit.t }
        });
    }
}

/// The closest hits of bundles by the plain loop over the scalar reference, which every time is
/// relative to, and the seconds it took.
pub fn reference_closest(bundles: &[Bundle], nearest: &mut Vec<Nearest>) -> Seconds {
    let scenes: Vec<_> = bundles
        .iter()
        .map(|bundle| reference::Scene::from_triangles(bundle.triangles.iter().map(|t| t.0)))
        .collect();
    nearest.clear();
    nearest.reserve(bundles.iter().map(|bundle| bundle.rays.len()).sum());
    let start = Instant::now();
    for (scene, bundle) in scenes.iter().zip(bundles) {
        for ray in &bundle.rays {
            let line = reference::Ray::new(ray.origin, ray.dir);
            let closest = scene.closest(&line, 0.0, f64::INFINITY);
            nearest.push(closest.map_or(Nearest::MISS, |(k, t)| Nearest { t, triangle: k as u32 }));
        }
    }
    start.elapsed().as_secs_f64()
}

/// The closest hits of bundles, by a mode; `None` for one lane, which the reference is there for, and
/// for 16 where they are no packets or not one register.
pub(super) fn closest<M: Mode>(
    mode: M,
    level: Level,
    bundles: &[Bundle],
    layout: Layout,
    nearest: &mut Vec<Nearest>,
) -> Option<Seconds> {
    let has = layout.lanes > 1;
    has.then(|| level.run(Closest { mode, bundles, layout, nearest })).flatten()
}

struct Closest<'a, M> {
    mode: M,
    bundles: &'a [Bundle],
    layout: Layout,
    nearest: &'a mut Vec<Nearest>,
}

impl<M: Mode> WithSimd for Closest<'_, M> {
    type Output = Option<Seconds>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Seconds> {
        let Self { mode, bundles, layout, nearest } = self;
        nearest.clear();
        nearest.reserve(bundles.iter().map(|bundle| bundle.rays.len()).sum());
        match (layout.form, layout.lanes) {
            (Form::Packets, 4) => Some(packets::<M, S, 4>(mode, bundles, nearest)),
            (Form::Packets, 8) => Some(packets::<M, S, 8>(mode, bundles, nearest)),
            (Form::Packs, 4) => Some(packs_of_4::<M, S>(mode, bundles, nearest)),
            (Form::Packs, 8) => Some(packs_of_8::<M, S>(mode, bundles, nearest)),
            (Form::Packets, _) if const { one_register::<S>() } => {
                Some(packets::<M, S, 16>(mode, bundles, nearest))
            }
            _ => None,
        }
    }
}

/// N rays against one triangle after another: `t` enclosed in f32 while they run, exact at the end.
#[inline(always)]
fn packets<M: Mode, S: Simd, const N: usize>(
    mode: M,
    bundles: &[Bundle],
    nearest: &mut Vec<Nearest>,
) -> Seconds
where
    Lane<N>: Width,
{
    let prepared: Vec<(Vec<RayPacket<N>>, Vec<_>)> = bundles
        .iter()
        .map(|bundle| {
            let packets = bundle.rays.chunks(N).map(RayPacket::new).collect();
            (packets, bundle.triangles.iter().map(|t| mode.prepare(t)).collect())
        })
        .collect();
    let mut counts = Counts::default();

    let start = Instant::now();
    for ((packets, triangles), bundle) in prepared.iter().zip(bundles) {
        let find = |place: u32| bundle.triangles[place as usize];
        for packet in packets {
            let rays = mode.prepare_packet_in::<S, N>(packet);
            let mut bests = Bests::new(&packet.t_max);
            let live = packet.live();
            mode.packet_closest_of_in(&rays, triangles, 0, find, live, &mut bests, &mut counts);
            for lane in 0..packet.live().count_ones() as usize {
                nearest.push(answer(&mode, &packet.ray(lane), &bests.lane(lane), find));
            }
        }
    }
    start.elapsed().as_secs_f64()
}

/// One ray after another against eight triangles at a time.
#[inline(always)]
fn packs_of_8<M: Mode, S: Simd>(
    mode: M,
    bundles: &[Bundle],
    nearest: &mut Vec<Nearest>,
) -> Seconds {
    let packs = packs::<8>(bundles);
    let mut counts = Counts::default();

    let start = Instant::now();
    for (packs, bundle) in packs.iter().zip(bundles) {
        let find = |place: u32| bundle.triangles[place as usize];
        for ray in &bundle.rays {
            let lanes = mode.prepare_ray(ray);
            let mut best = Best::new(f32::INFINITY);
            for (k, pack) in (0..).step_by(8).zip(packs) {
                let numbers = std::array::from_fn(|lane| k + lane as u32);
                mode.closest_in::<S>(&lanes, pack, &numbers, k, find, &mut best, &mut counts);
            }
            nearest.push(answer(&mode, ray, &best, find));
        }
    }
    start.elapsed().as_secs_f64()
}

/// One ray after another against four triangles at a time.
#[inline(always)]
fn packs_of_4<M: Mode, S: Simd>(
    mode: M,
    bundles: &[Bundle],
    nearest: &mut Vec<Nearest>,
) -> Seconds {
    let packs = packs::<4>(bundles);
    let mut counts = Counts::default();

    let start = Instant::now();
    for (packs, bundle) in packs.iter().zip(bundles) {
        for ray in &bundle.rays {
            let mut best = Nearest::MISS;
            for (k, pack) in (0..).step_by(4).zip(packs) {
                let hits = mode.pack_in::<S, 4>(ray, pack, &mut counts);
                each(&hits, |lane, t| offer(&mut best, t, k + lane as u32));
            }
            nearest.push(best);
        }
    }
    start.elapsed().as_secs_f64()
}

fn packs<const N: usize>(bundles: &[Bundle]) -> Vec<Vec<TrianglePack<N>>> {
    bundles.iter().map(|b| b.triangles.chunks(N).map(TrianglePack::new).collect()).collect()
}

/// The answer with its exact `t`, as a caller gets it.
#[inline(always)]
pub(super) fn answer<M: Mode>(
    mode: &M,
    ray: &Ray,
    best: &Best,
    find: impl Fn(u32) -> Triangle,
) -> Nearest {
    let found = mode.index_and_t(ray, best, find);
    found.map_or(Nearest::MISS, |(triangle, t)| Nearest { t, triangle })
}

#[inline(always)]
fn each<const N: usize>(hits: &Hits<N>, mut with: impl FnMut(usize, f64))
where
    Lane<N>: Width,
{
    let mut bits = hits.bits;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        with(lane, hits.t[lane]);
    }
}

#[inline(always)]
fn offer(best: &mut Nearest, t: f64, triangle: u32) {
    if t < best.t {
        *best = Nearest { t, triangle };
    }
}

/// The closest hits of bundles, by the mode `fixed`, each bundle on a grid of its own; misses where
/// something does not fit one, `None` but for 4 and 8 lanes.
pub(super) fn fixed_closest(
    level: Level,
    bundles: &[Bundle],
    layout: Layout,
    nearest: &mut Vec<Nearest>,
) -> Option<Seconds> {
    let bundles =
        bundles.iter().map(|bundle| Snapped::new(bundle).unwrap_or(Snapped::none(bundle)));
    let bundles = bundles.collect();
    matches!(layout.lanes, 4 | 8).then(|| level.run(FixedClosest { bundles, layout, nearest }))
}

/// How many triangles of its bundle each ray crosses, by the mode `fixed`; none where something does
/// not fit a grid.
pub(super) fn fixed_counts(level: Level, bundle: &Bundle) -> Vec<u32> {
    let Some(Snapped { rays, triangles, .. }) = Snapped::new(bundle) else {
        return vec![0; bundle.rays.len()];
    };
    let blocks: Vec<_> = fixed::blocks(&triangles).collect();
    let count = |ray| fixed::Fixed::at(level).crossings(&blocks, ray).unsigned as u32;
    rays.iter().map(count).collect()
}

/// A bundle on a grid of its own.
struct Snapped {
    rays: Vec<fixed::Ray>,
    triangles: Vec<fixed::Triangle>,
    /// So many rays were given, of which none are above where something did not fit.
    misses: usize,
}

impl Snapped {
    fn new(bundle: &Bundle) -> Option<Self> {
        let grid = grid(bundle)?;
        let rays: Result<Vec<_>, _> = bundle.rays.iter().map(|ray| grid.ray(ray)).collect();
        let triangles: Result<_, _> = bundle.triangles.iter().map(|t| grid.triangle(t)).collect();
        Some(Self { rays: rays.ok()?, triangles: triangles.ok()?, misses: 0 })
    }

    /// Nothing that could be hit.
    fn none(bundle: &Bundle) -> Self {
        Self { rays: Vec::new(), triangles: Vec::new(), misses: bundle.rays.len() }
    }
}

/// The finest grid that holds a bundle.
fn grid(bundle: &Bundle) -> Option<Grid> {
    let origins = bundle.rays.iter().map(|ray| ray.origin);
    Grid::around(bundle.triangles.iter().flat_map(|t| t.0).chain(origins), Bits::FINE).ok()
}

/// The bundle as the mode `fixed` sees it, snapped and taken back to f32, which changes nothing more:
/// what `fixed` is exact for. `None` where it does not fit a grid.
pub fn on_grid(bundle: &Bundle) -> Option<Bundle> {
    let grid = grid(bundle)?;
    let back = |p| Some(grid.unsnap(grid.snap(p).ok()?).map(|x| x as f32));
    let ray = |ray: &Ray| {
        let dir = grid.ray(ray).ok()?.dir().map(|x| x as f32);
        Some(Ray::new(back(ray.origin)?, dir))
    };
    let triangle = |t: &Triangle| {
        let [a, b, c] = t.0.map(back);
        Some(Triangle([a?, b?, c?]))
    };
    Some(Bundle {
        rays: bundle.rays.iter().map(ray).collect::<Option<_>>()?,
        triangles: bundle.triangles.iter().map(triangle).collect::<Option<_>>()?,
    })
}

struct FixedClosest<'a> {
    bundles: Vec<Snapped>,
    layout: Layout,
    nearest: &'a mut Vec<Nearest>,
}

impl WithSimd for FixedClosest<'_> {
    type Output = Seconds;

    #[inline(always)]
    fn run<S: Simd>(self) -> Seconds {
        let Self { bundles, layout, nearest } = self;
        nearest.clear();
        nearest.reserve(bundles.iter().map(|bundle| bundle.rays.len()).sum());
        match (layout.form, layout.lanes) {
            (Form::Packets, 4) => fixed_packets::<S, 4>(&bundles, nearest),
            (Form::Packets, _) => fixed_packets::<S, 8>(&bundles, nearest),
            (Form::Packs, 4) => fixed_packs::<S, 4>(&bundles, nearest),
            (Form::Packs, _) => fixed_packs::<S, 8>(&bundles, nearest),
        }
    }
}

#[inline(always)]
fn fixed_packets<S: Simd, const N: usize>(
    bundles: &[Snapped],
    nearest: &mut Vec<Nearest>,
) -> Seconds
where
    Lane<N>: fixed::IntWidth,
{
    let prepared: Vec<(Vec<fixed::Packet<N>>, Vec<fixed::Prepared>)> = bundles
        .iter()
        .map(|bundle| {
            let packets = bundle.rays.chunks(N).map(fixed::Packet::new).collect();
            (packets, bundle.triangles.iter().map(fixed::Prepared::new).collect())
        })
        .collect();

    let start = Instant::now();
    for ((packets, triangles), bundle) in prepared.iter().zip(bundles) {
        for packet in packets {
            let mut bests = [fixed::Best::default(); N];
            for (number, triangle) in (0..).zip(triangles) {
                packet.crossings_in::<S, true>(triangle, packet.live(), |lane, crossing| {
                    bests[lane].offer(crossing, number);
                });
            }
            let live = packet.live().count_ones() as usize;
            for (best, ray) in bests.iter().zip(packet.rays()).take(live) {
                let hit = best.to_hit(ray);
                nearest.push(Nearest { t: hit.t, triangle: hit.triangle as u32 });
            }
        }
        nearest.extend((0..bundle.misses).map(|_| Nearest::MISS));
    }
    start.elapsed().as_secs_f64()
}

#[inline(always)]
fn fixed_packs<S: Simd, const N: usize>(bundles: &[Snapped], nearest: &mut Vec<Nearest>) -> Seconds
where
    Lane<N>: fixed::IntWidth,
{
    let blocks: Vec<Vec<fixed::Block<N>>> = bundles
        .iter()
        .map(|bundle| {
            let numbered = bundle.triangles.chunks(N).zip((0_u32..).step_by(N));
            let block = |(chunk, first): (&[fixed::Triangle], u32)| {
                fixed::Block::new(chunk.iter().copied().zip(first..))
            };
            numbered.map(block).collect()
        })
        .collect();

    let start = Instant::now();
    for (blocks, bundle) in blocks.iter().zip(bundles) {
        for ray in &bundle.rays {
            let lanes = fixed::RayLanes::<S, N>::new(ray);
            let mut best = fixed::Best::default();
            for block in blocks {
                block.crossings_in::<S, true>(&lanes, |crossing, number| {
                    best.offer(crossing, number);
                });
            }
            let hit = best.to_hit(ray);
            nearest.push(Nearest { t: hit.t, triangle: hit.triangle as u32 });
        }
        nearest.extend((0..bundle.misses).map(|_| Nearest::MISS));
    }
    start.elapsed().as_secs_f64()
}
