//! Tests crossings: each point of a mesh belongs to exactly one triangle, regardless of the query.
//!
//! Slices in the `once` mode, a hierarchy's `query().once()`, `crossings`, `next_crossing` and the
//! batches must return identical bits for rays aimed at edges and corners of closed meshes. The
//! signed crossings of every ray through a closed mesh must add up to the winding number of the
//! ray's origin.

use intertri::simd::Level;
use intertri::{Crossing, Crossings, Hit, Mode, RayOf, Scalar, SliceScalar, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_tests::oracle;
use intertri_trace::{Bvh, BvhScalar};

use crate::exact::solids::meshes;

/// Limits on the length of lists: none, 0, 1, a few, and more than the number of hits.
const LIMITS: [Option<usize>; 5] = [None, Some(0), Some(1), Some(3), Some(usize::MAX)];

/// Returns all fields of a hit as bits.
fn bits(hit: &Hit) -> [u64; 5] {
    let Hit { t, u, v, triangle, geometry } = *hit;
    [t.to_bits(), u.to_bits(), v.to_bits(), triangle.into(), geometry.into()]
}

/// Returns all fields of crossings as bits.
fn all_bits(crossings: &[Crossing]) -> Vec<([u64; 5], bool)> {
    crossings.iter().map(|crossing| (bits(&crossing.hit), crossing.leaves)).collect()
}

/// Returns the crossings of rays, found by a plain loop over a slice. They are the expected results
/// in this file; the `exact` and `f64` modules compare them with rational arithmetic. All queries
/// over the slice in the `once` mode must agree with them.
fn of_slice<S: SliceScalar>(
    triangles: &[TriangleOf<S>],
    rays: &[RayOf<S>],
    level: Level,
) -> Vec<Vec<Crossing>> {
    let once = Mode::once().at(level);
    let mut closest = vec![Hit::MISS; rays.len()];
    once.closest_batch(triangles, rays, &mut closest);
    let each = rays.iter().zip(&closest).map(|(ray, closest)| {
        let crossings = Mode::exact().at(level).crossings(triangles, ray);
        let first = crossings.first().map_or(Hit::MISS, |crossing| crossing.hit);
        let hits = once.all(triangles, ray);
        assert!(hits.iter().map(bits).eq(crossings.iter().map(|c| bits(&c.hit))), "{ray:?}");
        assert_eq!(bits(&once.closest(triangles, ray).unwrap_or(Hit::MISS)), bits(&first));
        assert_eq!(bits(closest), bits(&first), "{ray:?}");
        assert_eq!(once.any(triangles, ray), first.is_hit(), "{ray:?}");
        assert_eq!(all_bits(&once.crossings(triangles, ray)), all_bits(&crossings), "{ray:?}");
        crossings
    });
    each.collect()
}

/// Checks all queries of a hierarchy that involve crossings.
fn check<S: SliceScalar + BvhScalar>(
    what: &str,
    bvh: &Bvh<S>,
    rays: &[RayOf<S>],
    want: &[Vec<Crossing>],
    level: Level,
) {
    let (query, mut once) = (bvh.query().at(level), bvh.query().once().at(level));
    let lists = LIMITS.map(|limit| (limit, query.crossings_batch(rays, limit).unwrap()));
    let once_lists = LIMITS.map(|limit| once.all_batch(rays, limit).unwrap());
    let counts = query.count_crossings_batch(rays);
    let (closest, any) = (once.closest_batch(rays), once.any_batch(rays));
    let shortcut = bvh.crossings_batch(rays).unwrap();
    let mut query = bvh.query().at(level);
    for (i, (ray, want)) in rays.iter().zip(want).enumerate() {
        let at = || format!("{what}, {}, ray {i}: {ray:?}", level.name());
        let first = want.first();
        let hit = first.map_or(Hit::MISS, |crossing| crossing.hit);
        assert_eq!(all_bits(&query.crossings(ray)), all_bits(want), "{}", at());
        assert_eq!(all_bits(&once.crossings(ray)), all_bits(want), "{}", at());
        assert_eq!(all_bits(shortcut.of(i)), all_bits(want), "{}", at());
        let next = query.next_crossing(ray);
        assert_eq!(all_bits(next.as_slice()), all_bits(first.as_slice_of_one()), "{}", at());

        // Queries under the once rule must return the hits of the crossings.
        assert!(once.all(ray).iter().map(bits).eq(want.iter().map(|c| bits(&c.hit))), "{}", at());
        assert_eq!(bits(&once.closest(ray).unwrap_or(Hit::MISS)), bits(&hit), "{}", at());
        assert_eq!(bits(&closest[i]), bits(&hit), "{}", at());
        assert_eq!([any[i], once.any(ray)], [hit.is_hit(); 2], "{}", at());

        // Lists must end at their limit.
        for ((limit, list), hits) in lists.iter().zip(&once_lists) {
            let some = &want[..want.len().min(limit.unwrap_or(usize::MAX))];
            assert_eq!(all_bits(list.of(i)), all_bits(some), "{limit:?}, {}", at());
            let hits = hits.of(i).iter().map(bits);
            assert!(hits.eq(some.iter().map(|c| bits(&c.hit))), "{limit:?}, {}", at());
        }
        let mut count = Crossings::default();
        for crossing in want {
            count.add(crossing.leaves);
        }
        assert_eq!(counts[i], count, "{}", at());
    }
}

/// Converts an optional crossing to a slice of at most one element.
trait AsSliceOfOne {
    fn as_slice_of_one(&self) -> &[Crossing];
}

impl AsSliceOfOne for Option<&Crossing> {
    fn as_slice_of_one(&self) -> &[Crossing] {
        self.map_or(&[], std::slice::from_ref)
    }
}

/// Generates rays from one point toward corners, edge midpoints and the insides of triangles, along
/// axes, and in random directions. Rays toward corners and edge midpoints hit them exactly if the
/// scalar type can represent the differences. All rays share an origin, so they form a bundle.
fn aimed<S: Scalar>(
    triangles: &[TriangleOf<S>],
    origin: [S; 3],
    count: usize,
    rng: &mut Rng,
) -> Vec<RayOf<S>> {
    let from = origin.map(Into::<f64>::into);
    let to = |p: [f64; 3]| [0, 1, 2].map(|k| S::nearest(p[k] - from[k]));
    let mut ray = |i: usize| {
        let corners = rng.pick(triangles).0.map(|corner| corner.map(Into::<f64>::into));
        let mix = |weights: [f64; 3]| {
            [0, 1, 2].map(|k| (0..3).map(|i| weights[i] * corners[i][k]).sum::<f64>())
        };
        let dir = match i % 6 {
            0 => to(corners[0]),
            1 => to(corners[2]),
            2 => to(mix([0.5, 0.5, 0.0])),
            3 => to(mix([0.0, 0.5, 0.5])),
            4 => to(mix([0.5, 0.25, 0.25])),
            _ if i % 12 == 5 => rng.direction().map(S::nearest),
            _ => [0, 1, 2].map(|k| if k == i / 12 % 3 { S::ONE } else { S::ZERO }),
        };
        RayOf::new(origin, dir)
    };
    (0..count).map(&mut ray).filter(|ray| ray.dir != [S::ZERO; 3]).collect()
}

/// Generates rays from points around a mesh, none of them on the mesh, grouped by origin. Tests
/// compare the other rays of a group with the group's first ray.
fn rays_around<S: Scalar>(triangles: &[TriangleOf<S>], rng: &mut Rng) -> Vec<Vec<RayOf<S>>> {
    let corners = || triangles.iter().flat_map(|triangle| triangle.0);
    let end = |k: usize, most: fn(f64, f64) -> f64| {
        corners().map(|corner| corner[k].into()).reduce(most).unwrap_or(0.0)
    };
    let ends = [0, 1, 2].map(|k| [end(k, f64::min), end(k, f64::max)]);
    let mut origin = || {
        // Use a grid that covers the mesh, so that many differences are exact.
        ends.map(|[low, high]| S::nearest(low + (rng.unit() * 64.0).round() / 48.0 * (high - low)))
    };
    let origins: Vec<[S; 3]> = (0..6)
        .map(|_| origin())
        .filter(|&origin| !triangles.iter().any(|triangle| oracle::is_on(origin, triangle)))
        .collect();
    origins.into_iter().map(|origin| aimed(triangles, origin, 48, rng)).collect()
}

/// Checks that all rays from a point have the same sum of signed crossings. If a crossing were lost
/// or counted twice, the sums would differ. Returns the sum.
fn all_agree(what: &str, crossings: &[Vec<Crossing>]) -> i64 {
    let signed = |crossings: &Vec<Crossing>| {
        crossings.iter().map(|c| if c.leaves { 1 } else { -1 }).sum::<i64>()
    };
    let winding = crossings.first().map_or(0, signed);
    assert!(crossings.iter().all(|some| signed(some) == winding), "{what}: {crossings:?}");
    winding
}

/// Checks closed meshes whose corners are transformed by `place`.
fn closed_meshes<S: SliceScalar + BvhScalar>(place: impl Fn([f32; 3]) -> [S; 3], seed: u64) {
    let (mut rng, mut crossed, mut inside, mut ties) = (Rng::new(seed), 0, 0, 0);
    for mesh in meshes(1) {
        let triangles: Vec<TriangleOf<S>> =
            mesh.triangles.iter().map(|triangle| TriangleOf(triangle.0.map(&place))).collect();
        let bvh = Bvh::new(&triangles).unwrap();
        for (i, rays) in rays_around(&triangles, &mut rng).iter().enumerate() {
            let level = Level::all().nth(i % Level::all().count()).unwrap();
            let want = of_slice(&triangles, rays, level);
            check(mesh.name, &bvh, rays, &want, level);
            inside += u32::from(all_agree(mesh.name, &want) != 0);
            crossed += want.iter().map(Vec::len).sum::<usize>();
            let equal = |pair: &[Crossing]| pair[0].hit.t.to_bits() == pair[1].hit.t.to_bits();
            ties += want.iter().flat_map(|all| all.windows(2)).filter(|pair| equal(pair)).count();
        }
    }
    println!("{crossed} crossings, {ties} ties, {inside} points inside");
    assert!(crossed > 3000 && inside > 10 && ties > 100, "{crossed} {inside} {ties}");
}

#[test]
fn closed_meshes_in_f32() {
    closed_meshes::<f32>(|p| p, 1);
}

#[test]
fn closed_meshes_in_f64() {
    closed_meshes::<f64>(|p| p.map(f64::from), 2);
}

/// Moves the meshes to coordinates at which f32 loses most of their digits, and to coordinates that
/// use all digits of f64.
#[test]
fn closed_meshes_far_out_in_f64() {
    closed_meshes::<f64>(|p| p.map(|x| f64::from(x) + 1_048_576.0), 3);
    closed_meshes::<f64>(|p| p.map(|x| f64::from(x) / 3.0 - 5e5), 4);
}

/// Uses each closed mesh twice, as two geometries. If two crossings have the same t, the lower
/// geometry must come first, even if a limit cuts the list between them.
fn two_geometries<S: SliceScalar + BvhScalar>(place: impl Fn([f32; 3]) -> [S; 3]) {
    let mut rng = Rng::new(5);
    let mut cut = 0;
    for mesh in meshes(1).into_iter().take(8) {
        let one: Vec<TriangleOf<S>> =
            mesh.triangles.iter().map(|triangle| TriangleOf(triangle.0.map(&place))).collect();
        let (bvh, both) = (Bvh::from_meshes(&[&one, &one]).unwrap(), [&one[..], &one].concat());
        let level = Level::best();
        for rays in rays_around(&one, &mut rng) {
            let mut want = of_slice(&both, &rays, level);
            for crossing in want.iter_mut().flatten() {
                let index = crossing.hit.triangle as usize;
                crossing.hit.geometry = (index / one.len()) as u32;
                crossing.hit.triangle = (index % one.len()) as u32;
            }
            check(mesh.name, &bvh, &rays, &want, level);
            for all in want.iter().filter(|all| !all.is_empty()) {
                // A ray through a corner may cross two faces of one copy at the same t, and then
                // also both faces of the other.
                let [one, other] = [0, 1].map(|geometry| {
                    let of_it = all.iter().filter(|crossing| crossing.hit.geometry == geometry);
                    let named = |c: &Crossing| (c.hit.t.to_bits(), c.hit.triangle, c.leaves);
                    of_it.map(named).collect::<Vec<_>>()
                });
                assert_eq!(one, other, "{}", mesh.name);
                assert_eq!(all[0].hit.geometry, 0, "{}", mesh.name);
                cut += 1;
            }
        }
    }
    assert!(cut > 200, "{cut}");
}

#[test]
fn ties_between_geometries_in_f32() {
    two_geometries::<f32>(|p| p);
}

#[test]
fn ties_between_geometries_in_f64() {
    two_geometries::<f64>(|p| p.map(|x| f64::from(x) / 3.0 + 1e6));
}

/// Tests intervals that begin or end at a crossing or next to it.
#[test]
fn intervals_cut_crossings() {
    let mut rng = Rng::new(6);
    let mesh = meshes(1).into_iter().find(|mesh| mesh.name == "knot").unwrap();
    let bvh = Bvh::new(&mesh.triangles).unwrap();
    for rays in rays_around(&mesh.triangles, &mut rng) {
        let whole = of_slice(&mesh.triangles, &rays, Level::best());
        let cut = |(i, (ray, all)): (usize, (&RayOf<f32>, &Vec<Crossing>))| {
            let t = all.get(i % 3).map_or(1.0, |crossing| crossing.hit.t as f32);
            match i % 5 {
                0 => ray.between(t, f32::INFINITY),
                1 => ray.between(0.0, t),
                2 => ray.between(0.0, t.next_up()),
                3 => ray.between(t.next_up(), 4.0 * t),
                _ => ray.between(t, t),
            }
        };
        let rays: Vec<_> = rays.iter().zip(&whole).enumerate().map(cut).collect();
        for level in Level::all() {
            let want = of_slice(&mesh.triangles, &rays, level);
            check("knot", &bvh, &rays, &want, level);
        }
    }
}
