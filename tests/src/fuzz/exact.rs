//! Compares the `exact` mode with arbitrary-precision integers: single pairs at every tier, scenes
//! with every query, and the crossings of closed fans of triangles.

use intertri::internal::exact::{self, Side, Tier};
use intertri::simd::Level;
use intertri::{Crossing, Crossings, Hit, Mode, Ray, Rule, Triangle, TriangleOf};
use intertri_trace::{Bvh, Containment, MeshTriangle, Solid};

use super::input::Input;
use crate::oracle::{self, Truth};
use crate::{Scene, as_source};

/// Builds a scene or a closed fan of triangles from the bytes, and checks it.
pub fn exact(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    match input.below(4) {
        0 => pairs(&input.scene(4, 4)),
        1 => fan(&mut input),
        2 => queries(&input.scene(24, 10)),
        _ => {
            // Move all rays to one origin and keep their targets, so that they form a bundle.
            let mut scene = input.scene(24, 20);
            let origin = scene.rays[0].origin;
            for ray in &mut scene.rays {
                ray.dir = [0, 1, 2].map(|k| ray.origin[k] - origin[k] + ray.dir[k]);
                ray.origin = origin;
            }
            queries(&scene);
        }
    }
}

/// Asserts equality, and prints the scene as a fixture on failure.
macro_rules! same {
    ($scene:expr, $found:expr, $want:expr, $what:expr) => {
        assert_eq!($found, $want, "{}\n{}", $what, as_source($scene))
    };
}

/// The expected results for a ray: the triangles that it hits within its interval, sorted by t, and
/// which of these hits are crossings.
struct Hits {
    closed: Vec<(usize, Truth)>,
    /// For each crossing, the triangle's index and whether the ray crosses it in the direction of
    /// its normal.
    once: Vec<(usize, bool)>,
}

impl Hits {
    fn of(ray: &Ray, triangles: &[Triangle]) -> Self {
        let truth = |i: usize| oracle::truth(ray, &triangles[i]).filter(|t| t.is_within(ray));
        let hits = (0..triangles.len()).filter_map(|i| truth(i).map(|truth| (i, truth)));
        let mut hits: Vec<_> = hits.filter(|(_, truth)| truth.is_closed_hit()).collect();
        // The sort is stable: if two hits have the same t, the lower index stays first.
        hits.sort_by(|(_, a), (_, b)| a.order(b));
        let once = |(i, truth): &(usize, Truth)| {
            oracle::once(ray, &triangles[*i], Some(truth)).map(|leaves| (*i, leaves))
        };
        let once = hits.iter().filter_map(once).collect();
        Self { closed: hits, once }
    }
}

/// Checks each pair of a ray and a triangle at every tier, under both rules: whether it hits, its
/// t, u and v, and the order of its hit relative to other hits.
fn pairs(scene: &Scene) {
    for ray in &scene.rays {
        let mut met: Vec<(&Triangle, Truth)> = vec![];
        for triangle in &scene.triangles {
            let truth = oracle::truth(ray, triangle);
            let once = oracle::once(ray, triangle, truth.as_ref());
            let within = truth.as_ref().filter(|truth| truth.is_within(ray));
            let closed = within.is_some_and(Truth::is_closed_hit);
            let once = once.filter(|_| within.is_some());
            for &tier in Tier::all::<f32>() {
                let of = |rule| exact::crossing_from(tier, rule, ray, triangle);
                let leaves = of(Rule::Once).map(|side| side == Side::Leaves);
                same!(scene, (of(Rule::Closed).is_some(), leaves), (closed, once), tier_name(tier));
            }
            let Some(truth) = truth else { continue };
            let (t, u, v) = exact::attributes(ray, triangle);
            same!(scene, truth.are_rounded([t, u, v]), true, format!("{t:e} {u:e} {v:e}"));
            for &tier in Tier::all::<f32>() {
                let (t_from, u_from, v_from) = exact::attributes_from(tier, ray, triangle);
                let all = [t_from, u_from, v_from, exact::t_from(tier, ray, triangle)];
                let bits = |x: [f64; 4]| x.map(f64::to_bits);
                same!(scene, bits(all), bits([t, u, v, t]), tier_name(tier));
            }
            met.push((triangle, truth));
        }
        for (one, truth) in &met {
            for (other, of_other) in &met {
                let order = truth.order(of_other);
                same!(scene, exact::order(ray, one, other), order, "order");
                for &tier in Tier::all::<f32>() {
                    let from = exact::order_from(tier, ray, one, other);
                    same!(scene, from, order, tier_name(tier));
                }
            }
        }
    }
}

fn tier_name(tier: Tier) -> String {
    format!("{tier:?}")
}

/// Returns whether a hit is on the expected triangle and its t, u and v are the exact values, each
/// rounded once. If no hit is expected, returns whether it is a miss.
fn is_right(hit: Hit, want: Option<&(usize, Truth)>) -> bool {
    match want {
        None => !hit.is_hit(),
        Some((i, truth)) => hit.triangle as usize == *i && truth.are_rounded([hit.t, hit.u, hit.v]),
    }
}

/// Compares a plain loop and the hierarchy with the expected results for a scene: closest hits, any
/// hits, all hits and crossings, one ray at a time and in batches, under the closed rule and the
/// once rule.
fn queries(scene: &Scene) {
    let (triangles, rays) = (&scene.triangles[..], &scene.rays[..]);
    let truth: Vec<Hits> = rays.iter().map(|ray| Hits::of(ray, triangles)).collect();
    let bvh = Bvh::new(triangles).unwrap();
    for level in [Level::best(), Level::PORTABLE] {
        let mode = Mode::exact().at(level);
        let mut looped = vec![Hit::MISS; rays.len()];
        mode.closest_batch(triangles, rays, &mut looped);
        let mut query = bvh.query().at(level);
        let (hits, any) = (query.closest_batch(rays), query.any_batch(rays));
        let (counts, names) =
            (query.count_crossings_batch(rays), query.closest_triangle_batch(rays));

        for (i, (ray, want)) in rays.iter().zip(&truth).enumerate() {
            let at = format!("{} ray {i}", level.name());
            let first = want.closed.first();
            let one = |hit: Option<Hit>| hit.unwrap_or(Hit::MISS);
            let closest =
                [looped[i], hits[i], one(mode.closest(triangles, ray)), one(query.closest(ray))];
            for hit in closest {
                same!(scene, is_right(hit, first), true, format!("{at}: {hit:?}"));
            }
            let name = |(i, _): &(usize, Truth)| MeshTriangle { triangle: *i as u32, geometry: 0 };
            same!(scene, names[i], first.map_or(MeshTriangle::MISS, name), at);
            let is_hit = [any[i], mode.any(triangles, ray), query.any(ray)];
            same!(scene, is_hit, [first.is_some(); 3], at);

            for all in [mode.all(triangles, ray), query.all(ray)] {
                same!(scene, all.len(), want.closed.len(), at);
                for (hit, want) in all.into_iter().zip(&want.closed) {
                    same!(scene, is_right(hit, Some(want)), true, format!("{at}, all: {hit:?}"));
                }
            }
            let mut count = Crossings::default();
            want.once.iter().for_each(|&(_, leaves)| count.add(leaves));
            same!(scene, counts[i], count, at);
        }
        crossings(scene, &bvh, &truth, level);
    }
}

/// Checks the crossings that each query reports in a scene.
fn crossings(scene: &Scene, bvh: &Bvh, truth: &[Hits], level: Level) {
    let (triangles, rays, once) = (&scene.triangles[..], &scene.rays[..], Mode::once().at(level));
    let lists = bvh.query().at(level).crossings_batch(rays, None).unwrap();
    let (mut query, mut only) = (bvh.query().at(level), bvh.query().at(level).once());
    for (i, (ray, want)) in rays.iter().zip(truth).enumerate() {
        let at = format!("{} ray {i}", level.name());
        let crossed = query.crossings(ray);
        let sides: Vec<_> = crossed.iter().map(|c| (c.hit.triangle as usize, c.leaves)).collect();
        same!(scene, sides, want.once, at);
        same!(scene, Mode::exact().at(level).crossings(triangles, ray), crossed, at);
        same!(scene, lists.of(i), crossed, at);
        same!(scene, query.next_crossing(ray), crossed.first().copied(), at);
        let hits: Vec<Hit> = crossed.iter().map(|Crossing { hit, .. }| *hit).collect();
        for all in [once.all(triangles, ray), only.all(ray)] {
            same!(scene, all, hits, at);
        }
        for first in [once.closest(triangles, ray), only.closest(ray)] {
            same!(scene, first, hits.first().copied(), at);
        }
        let is_hit = [once.any(triangles, ray), only.any(ray)];
        same!(scene, is_hit, [!hits.is_empty(); 2], at);
    }
}

/// Builds two fans of triangles that join two tips to a common rim. Together they form a closed
/// mesh, wherever the corners are. From a point off the surface, the sum of signed crossings must
/// be the same in every direction. If the sum is not 0, every ray must hit the mesh.
fn fan(input: &mut Input<'_>) {
    let (tip, other) = (input.point(), input.point());
    let rim: Vec<[f32; 3]> = (0..3 + input.below(6)).map(|_| input.point()).collect();
    let next = rim.iter().cycle().skip(1);
    let fan = rim.iter().zip(next).flat_map(|(&r, &s)| [[tip, r, s], [other, s, r]]);
    let triangles: Vec<Triangle> = fan.map(Triangle).collect();
    let origin = input.point();
    let points = triangles.iter().flat_map(|t| t.0).chain([origin]);
    if points.flatten().any(|x| !x.is_finite()) {
        return;
    }

    let to = |p: [f32; 3]| [0, 1, 2].map(|k| p[k] - origin[k]);
    let mut dirs = vec![[1.0, 0.0, 0.0], [-0.0, -1e-30, 0.0], [0.0, 0.0, 1.0], input.point()];
    for TriangleOf([a, b, _]) in &triangles {
        let (a, b) = (to(*a), to(*b));
        dirs.extend([a, a.map(|x| -x), [0, 1, 2].map(|k| a[k] + b[k])]);
    }
    dirs.retain(|dir| dir.iter().all(|x| x.is_finite()) && *dir != [0.0; 3]);
    let rays: Vec<Ray> = dirs.iter().map(|&dir| Ray::new(origin, dir)).collect();
    let scene = Scene { triangles, rays, threshold: 0.0 };
    let Scene { triangles, rays, .. } = &scene;

    let solid = Solid::new(triangles).unwrap();
    let is_on = triangles.iter().any(|triangle| oracle::is_on(origin, triangle));
    same!(&scene, solid.classify(origin) == Containment::Surface, is_on, "on the surface");
    if is_on {
        return;
    }
    let winding = match solid.classify(origin) {
        Containment::Inside(times) => times,
        _ => 0,
    };
    let (query, any) = (solid.bvh().query(), solid.bvh().any_batch(rays));
    let counts = query.count_crossings_batch(rays);
    for ((ray, count), any) in rays.iter().zip(counts).zip(any) {
        same!(&scene, count.signed, i64::from(winding), format!("{ray:?}"));
        same!(&scene, any || winding == 0, true, format!("{ray:?} leaks"));
    }
    // Compare the crossings of one of the rays with those computed from integers.
    let crossing =
        |triangle| oracle::once(&rays[0], triangle, oracle::truth(&rays[0], triangle).as_ref());
    let sides = triangles.iter().filter_map(crossing).map(|leaves| if leaves { 1 } else { -1 });
    same!(&scene, sides.sum::<i32>(), winding, "winding");
}
