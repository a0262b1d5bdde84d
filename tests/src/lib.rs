//! Code shared by the differential tests, which compute the result of each query in every available
//! way and compare the results.
//!
//! For each ray and triangle, the expected result comes from the scalar f64 reference or, in the
//! `exact` and `once` modes, from integer arithmetic. The tests compare whether there is a hit,
//! which triangle it is on, and every bit of t, without an epsilon.

mod crossings;
mod fixture;
pub mod fuzz;
pub mod grid_reference;
mod hierarchy;
pub mod oracle;
mod scene;
mod solid;
mod truth;

pub use crossings::check_crossings;
pub use fixture::{as_source, parse};
pub use hierarchy::check_hierarchy;
pub use scene::Scene;
pub use solid::is_on;
use truth::Truth;
pub use truth::reference_ray;

/// Runs the Rust examples in the README and two other pages as doctests.
#[cfg(doctest)]
mod pages {
    #[doc = include_str!("../../docs/embed.md")]
    struct Embed;
    #[doc = include_str!("../../docs/fixed-point.md")]
    struct FixedPoint;
    #[doc = include_str!("../../README.md")]
    struct Readme;
}

use intertri::simd::{Lane, Level, Simd, Width, WithSimd};
use intertri::{
    Blocks, ClosestHit, ClosestHits, Counts, Filter, Hit, LeafSlot, Mode, PacketHits,
    PreparedTriangle, Ray, RayPacket, Threshold, Triangle, TriangleBlock, TriangleId,
};

/// A mode, its name in messages, and its expected results.
type TrueMode<'a> = (Mode, &'static str, &'a Truth);

/// Tests every pair of a ray and a triangle in every mode, width and form of the kernel, at the
/// given levels. Returns the number of pairs that hit, according to the reference.
///
/// # Errors
/// Returns an error that describes the first difference, with everything needed to reproduce it.
pub fn check_kernel(scene: &Scene, levels: &[Level]) -> Result<usize, String> {
    let threshold = Threshold::new(scene.threshold).map_err(|e| e.to_string())?;
    let truths = [Truth::of(scene), Truth::exact(scene), Truth::once(scene)];
    let modes = [
        (Mode::certified_with(threshold), "certified", &truths[0]),
        (Mode::exact(), "exact", &truths[1]),
        (Mode::once(), "once", &truths[2]),
    ];
    check_width::<4>(scene, &modes, levels)?;
    check_width::<8>(scene, &modes, levels)?;
    check_width::<16>(scene, &modes, levels)?;
    for mode in modes {
        check_packets::<8>(scene, mode, levels)?;
        check_packets::<16>(scene, mode, levels)?;
        for &level in levels {
            check_slices(scene, at(mode, level))?;
        }
    }
    Ok(truths[0].hits())
}

/// Returns the same mode at another SIMD level.
fn at((mode, name, truth): TrueMode<'_>, level: Level) -> TrueMode<'_> {
    (mode.at(level), name, truth)
}

/// Checks the closest hits of packets, and of their rays one by one, for packets of a single ray,
/// of neighbouring rays, and of neighbouring rays moved to a common origin.
fn check_packets<const N: usize>(
    scene: &Scene,
    (mode, name, truth): TrueMode<'_>,
    levels: &[Level],
) -> Result<(), String>
where
    Lane<N>: Width,
{
    let single = scene.rays.iter().map(|ray| vec![*ray]);
    let neighbours = || scene.rays.chunks(N).filter(|rays| rays.len() > 1);
    let moved = |rays: &[Ray]| rays.iter().map(|r| Ray { origin: rays[0].origin, ..*r }).collect();
    let packets = single.chain(neighbours().map(<[Ray]>::to_vec)).chain(neighbours().map(moved));
    let bits = |x: Option<(usize, f64)>| x.map(|(obj, t)| (obj, t.to_bits()));
    for rays in packets {
        let (packet, triangles) = (RayPacket::<N>::new(&rays), &scene.triangles[..]);
        let wanted: Vec<_> = rays.iter().map(|ray| truth.closest(ray)).collect();
        for &level in levels {
            let filter = mode.at(level).filter();
            let forms = level.run(PacketClosest { filter, packet: &packet, triangles });
            for (form, found) in ["packet", "all at once", "ray by ray"].into_iter().zip(forms) {
                for ((ray, want), found) in rays.iter().zip(&wanted).zip(found) {
                    if bits(found) != bits(*want) {
                        let level = level.name();
                        return Err(format!(
                            "{name} {level}, closest of {N} rays, {form}: {found:?}, expected {want:?}\n{ray:?}"
                        ));
                    }
                }
            }
        }
    }
    Ok(())
}

/// Finds the closest hits of a packet in three ways: triangle by triangle, with all triangles in
/// one call, and ray by ray with eight triangles at a time. Triangles are stored in reverse order,
/// so that slots differ from indices.
struct PacketClosest<'a, const N: usize> {
    filter: Filter<'a>,
    packet: &'a RayPacket<N>,
    triangles: &'a [Triangle],
}

impl<const N: usize> WithSimd for PacketClosest<'_, N>
where
    Lane<N>: Width,
{
    type Output = [[Option<(usize, f64)>; N]; 3];

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let Self { filter, packet, triangles } = self;
        let (live, counts) = (packet.live(), &mut Counts::default());
        let stored: Vec<Triangle> = triangles.iter().rev().copied().collect();
        let find = |LeafSlot(slot)| stored[slot as usize];
        let index = |slot: usize| (triangles.len() - 1).wrapping_sub(slot) as u32;

        // Use plain loops, whose values stay in SIMD registers; iterator closures would become
        // function calls.
        let rays = filter.prepare_packet_in::<S, N>(packet);
        let mut closest = ClosestHits::new(&packet.t_max);
        for (slot, triangle) in stored.iter().enumerate() {
            let names = (TriangleId(index(slot)), LeafSlot(slot as u32));
            let triangle = PreparedTriangle::new(triangle);
            filter.packet_closest_in(&rays, &triangle, names, find, live, &mut closest, counts);
        }
        let hits = filter.hits_in(&rays, &closest, find);
        let packets = std::array::from_fn(|lane| {
            let (TriangleId(index), _) = closest.lane(lane).triangle()?;
            assert!(hits.bits >> lane & 1 == 1, "the bit of a hit lane is not set");
            Some((index as usize, hits.t[lane]))
        });

        // Pass all triangles in one call, in their original order, so that slots equal indices.
        let prepared: Vec<_> = triangles.iter().map(PreparedTriangle::new).collect();
        let mut closest = ClosestHits::new(&packet.t_max);
        filter.packet_closest_of_in(&rays, &prepared, live, &mut closest, counts);
        let hits = filter.hits_in(&rays, &closest, |LeafSlot(slot)| triangles[slot as usize]);
        let at_once = std::array::from_fn(|lane| {
            let (TriangleId(index), _) = closest.lane(lane).triangle()?;
            Some((index as usize, hits.t[lane]))
        });

        let mut one_by_one = [None; N];
        for (lane, found) in one_by_one.iter_mut().enumerate() {
            if live >> lane & 1 == 0 {
                continue;
            }
            let ray = packet.ray(lane);
            let (prepared, mut closest) = (filter.prepare_ray(&ray), ClosestHit::new(ray.t_max));
            for (k, eight) in stored.chunks(8).enumerate() {
                let (block, first) = (TriangleBlock::new(eight), LeafSlot(8 * k as u32));
                let indices = std::array::from_fn(|i| index(8 * k + i));
                filter.closest_in::<S>(
                    &prepared,
                    &block,
                    &indices,
                    first,
                    find,
                    &mut closest,
                    counts,
                );
            }
            *found = filter.hit(&ray, &closest, find).map(|hit| (hit.triangle as usize, hit.t));
        }
        [packets, at_once, one_by_one]
    }
}

/// Builds packets of N rays and blocks of N triangles once, and tests them in all modes at all
/// given levels.
fn check_width<const N: usize>(
    scene: &Scene,
    modes: &[TrueMode<'_>],
    levels: &[Level],
) -> Result<(), String>
where
    Lane<N>: Width,
{
    let packets: Vec<RayPacket<N>> = scene.rays.chunks(N).map(RayPacket::new).collect();
    let blocks: Vec<TriangleBlock<N>> = scene.triangles.chunks(N).map(TriangleBlock::new).collect();
    for &level in levels {
        for &mode in modes {
            check_forms(scene, at(mode, level), &packets, &blocks)?;
        }
    }
    Ok(())
}

/// Tests packets of rays against each triangle, and each ray against blocks of triangles.
fn check_forms<const N: usize>(
    scene: &Scene,
    (mode, name, truth): TrueMode<'_>,
    packets: &[RayPacket<N>],
    blocks: &[TriangleBlock<N>],
) -> Result<(), String>
where
    Lane<N>: Width,
{
    let level = mode.level().name();
    for (obj, triangle) in scene.triangles.iter().enumerate() {
        let prepared = PreparedTriangle::new(triangle);
        for (k, (packet, rays)) in packets.iter().zip(scene.rays.chunks(N)).enumerate() {
            let hits = mode.packet(packet, &prepared);
            let want = |lane: usize| truth.t[N * k + lane][obj];
            same(&hits, rays.len(), want).map_err(|(lane, what)| {
                format!("{name} {level} packet of {N}: {what}\n{:?}\n{triangle:?}", rays[lane])
            })?;
            let any =
                mode.level().run(AnyOf { filter: mode.filter(), packet, triangle: &prepared });
            if any != hits.bits {
                let bits = hits.bits;
                return Err(format!(
                    "{name} {level} any of a packet of {N}: {any:b}, not {bits:b}\n{rays:?}\n{triangle:?}"
                ));
            }
        }
    }
    for (i, ray) in scene.rays.iter().enumerate() {
        for (k, (block, triangles)) in blocks.iter().zip(scene.triangles.chunks(N)).enumerate() {
            let hits = mode.block(ray, block);
            let want = |lane: usize| truth.t[i][N * k + lane];
            same(&hits, triangles.len(), want).map_err(|(lane, what)| {
                format!("{name} {level} block of {N}: {what}\n{ray:?}\n{:?}", triangles[lane])
            })?;
        }
    }
    Ok(())
}

/// Finds the lanes of a packet that hit a triangle, without computing t.
struct AnyOf<'a, const N: usize> {
    filter: Filter<'a>,
    packet: &'a RayPacket<N>,
    triangle: &'a PreparedTriangle,
}

impl<const N: usize> WithSimd for AnyOf<'_, N>
where
    Lane<N>: Width,
{
    type Output = u32;

    #[inline(always)]
    fn run<S: Simd>(self) -> u32 {
        let rays = self.filter.prepare_packet_in::<S, N>(self.packet);
        let live = self.packet.live();
        self.filter.packet_any_in(&rays, self.triangle, live, &mut Counts::default())
    }
}

/// Checks that the live lanes have the expected results and that no other lane reports a hit.
fn same<const N: usize>(
    hits: &PacketHits<N>,
    live: usize,
    want: impl Fn(usize) -> f64,
) -> Result<(), (usize, String)> {
    if hits.bits >> live != 0 {
        return Err((0, format!("a dead lane reports a hit: {:b} of {live}", hits.bits)));
    }
    for lane in 0..live {
        let (want, hit) = (want(lane), hits.bits >> lane & 1 != 0);
        if hit == want.is_nan() {
            return Err((lane, format!("lane {lane}: hit is {hit}, expected t is {want:e}")));
        }
        if hit && hits.t[lane].to_bits() != want.to_bits() {
            let got = hits.t[lane];
            return Err((lane, format!("lane {lane}: t is {got:e}, expected {want:e}")));
        }
    }
    Ok(())
}

/// Checks the queries over slices: closest hits, any hits, and all hits.
fn check_slices(scene: &Scene, (mode, name, truth): TrueMode<'_>) -> Result<(), String> {
    let level = mode.level().name();
    let blocks = Blocks::new(&scene.triangles);
    let mut hits = vec![Hit::MISS; scene.rays.len()];
    mode.closest_batch(&scene.triangles, &scene.rays, &mut hits);
    for (i, (ray, many)) in scene.rays.iter().zip(&hits).enumerate() {
        let answers = &truth.answers[i];
        let want = answers.closest;
        let of = |query: &str, e: String| format!("{name} {level} {query}: {e}\n{ray:?}");
        same_closest(want, many.some()).map_err(|e| of("closest batch", e))?;
        let one = mode.closest(&scene.triangles, ray);
        same_closest(want, one).map_err(|e| of("closest", e))?;
        if let (Some((u, v)), Some(one)) = (answers.weights, one)
            && [one.u, one.v].map(f64::to_bits) != [u, v].map(f64::to_bits)
        {
            return Err(of("weights", format!("{}, {} are not {u}, {v}", one.u, one.v)));
        }
        if mode.any(&scene.triangles, ray) != want.is_some() {
            return Err(of("any", format!("differs from {want:?}")));
        }
        let all = mode.all(&scene.triangles, ray);
        let all: Vec<_> = all.iter().map(|h| (h.triangle as usize, h.t.to_bits())).collect();
        if all != answers.all {
            return Err(of("all", format!("{all:x?} is not {:x?}", answers.all)));
        }
        // Weights may be NaN, so compare their bits.
        let all_bits = |hits: Vec<Hit>| hits.into_iter().map(bits).collect::<Vec<_>>();
        let prepared = (
            blocks.closest(mode, ray).map(bits),
            blocks.any(mode, ray),
            all_bits(blocks.all(mode, ray)),
        );
        let plain = (one.map(bits), one.is_some(), all_bits(mode.all(&scene.triangles, ray)));
        if prepared != plain {
            return Err(of("blocks", format!("{prepared:?} is not {one:?} and {all:x?}")));
        }
    }
    Ok(())
}

/// Compares a closest hit with the expected one.
///
/// # Errors
/// Returns a description of the difference.
pub fn same_closest(want: Option<(usize, f64)>, hit: Option<Hit>) -> Result<(), String> {
    let got = hit.map(|hit| (hit.triangle as usize, hit.t));
    let bits = |x: Option<(usize, f64)>| x.map(|(obj, t)| (obj, t.to_bits()));
    if bits(got) == bits(want) {
        return Ok(());
    }
    Err(format!("(triangle, t) is {got:?}, expected {want:?}"))
}

/// Returns all fields of a hit as bits, because its weights may be NaN.
pub(crate) fn bits(hit: Hit) -> [u64; 5] {
    let Hit { t, u, v, triangle, geometry } = hit;
    [t.to_bits(), u.to_bits(), v.to_bits(), triangle.into(), geometry.into()]
}
