//! Tests looking up the triangle and the normal of a hit, and spawning rays from the hit: with
//! several meshes, after refits, and with triangles that are not finite.

use intertri::{Hit, Mode, Ray, RayOf, Scalar, SliceScalar, TriangleOf, spawn_ray, spawn_ray_to};
use intertri_lab::rng::Rng;
use intertri_trace::{Bvh, BvhScalar};

/// Generates small triangles, some of which have equal corners, are degenerate, or are not finite.
fn mixed<S: Scalar>(count: usize, rng: &mut Rng) -> Vec<TriangleOf<S>> {
    let mut triangle = |i: usize| {
        let at = rng.cube();
        let mut corner = || {
            let off = rng.cube();
            [0, 1, 2].map(|k| S::nearest(at[k] + 0.3 * off[k]))
        };
        let mut corners = [corner(), corner(), corner()];
        match i % 11 {
            3 => corners[1] = corners[0],
            5 => corners[2][i % 3] = S::nearest(f64::NAN),
            7 => corners[0][i % 3] = S::INFINITY,
            9 => corners = [corners[0]; 3],
            _ => {}
        }
        TriangleOf(corners)
    };
    (0..count).map(&mut triangle).collect()
}

fn is_finite<S: Scalar>(triangle: &TriangleOf<S>) -> bool {
    triangle.0.as_flattened().iter().all(|&x| Into::<f64>::into(x).is_finite())
}

/// Returns a hit on a triangle, with the ids that queries report.
fn named(geometry: usize, triangle: usize) -> Hit {
    Hit { t: 1.0, u: 0.25, v: 0.25, triangle: triangle as u32, geometry: geometry as u32 }
}

/// Checks that every finite triangle is found by its ids, and that no other ids find a triangle.
fn check<S: BvhScalar>(what: &str, bvh: &Bvh<S>, meshes: &[&[TriangleOf<S>]]) {
    assert_eq!(bvh.geometries(), meshes.len(), "{what}");
    for (geometry, mesh) in meshes.iter().enumerate() {
        for (i, triangle) in mesh.iter().enumerate() {
            let (hit, want) = (named(geometry, i), is_finite(triangle).then_some(*triangle));
            assert_eq!(bvh.triangle(&hit), want, "{what}: {hit:?}");
            assert_eq!(bvh.normal(&hit), want.map(|t| t.normal()), "{what}: {hit:?}");
        }
        for beyond in [mesh.len(), mesh.len() + 1, u32::MAX as usize - 1] {
            assert_eq!(
                bvh.triangle(&named(geometry, beyond)),
                None,
                "{what}: {geometry}, {beyond}"
            );
        }
    }
    for beyond in [meshes.len(), meshes.len() + 1, u32::MAX as usize] {
        assert_eq!(bvh.triangle(&named(beyond, 0)), None, "{what}: geometry {beyond}");
    }
    assert_eq!((bvh.triangle(&Hit::MISS), bvh.normal(&Hit::MISS)), (None, None), "{what}");
}

/// The sizes of the meshes in each scene.
const SIZES: [&[usize]; 6] = [&[], &[0], &[1], &[200], &[7, 0, 90, 1], &[0, 40, 40, 0]];

fn slices<S>(meshes: &[Vec<TriangleOf<S>>]) -> Vec<&[TriangleOf<S>]> {
    meshes.iter().map(Vec::as_slice).collect()
}

fn triangles_are_found_by_their_names<S: BvhScalar>() {
    let mut rng = Rng::new(1);
    for sizes in SIZES {
        let what = format!("{sizes:?}");
        let mut meshes: Vec<Vec<TriangleOf<S>>> =
            sizes.iter().map(|&size| mixed(size, &mut rng)).collect();
        let all = slices(&meshes);
        let mut bvh = Bvh::from_meshes(&all).unwrap();
        check(&what, &bvh, &all);
        check(&format!("{what}, cloned"), &bvh.clone(), &all);
        let loaded = Bvh::<S>::from_bytes(&bvh.to_bytes()).unwrap();
        check(&format!("{what}, saved and loaded"), &loaded, &all);

        // Refit several times, each time with different triangles that are not finite.
        for turn in 0..4 {
            for mesh in &mut meshes {
                *mesh = mixed(mesh.len(), &mut rng);
                let by = turn.min(mesh.len());
                mesh.rotate_left(by);
            }
            bvh.refit(&meshes.concat()).unwrap();
            check(&format!("{what}, refitted {turn}"), &bvh, &slices(&meshes));
        }
        let whole = meshes.concat();
        check(&format!("{what}, as one mesh"), &bvh.into_one_mesh(), &[&whole]);
    }
}

#[test]
fn triangles_are_found_by_their_names_in_f32() {
    triangles_are_found_by_their_names::<f32>();
}

#[test]
fn triangles_are_found_by_their_names_in_f64() {
    triangles_are_found_by_their_names::<f64>();
}

/// Tests a refit that fails between two lookups.
#[test]
fn a_refit_that_fails_loses_no_triangle() {
    let triangles = mixed::<f32>(50, &mut Rng::new(2));
    let mut bvh = Bvh::new(&triangles).unwrap();
    check("before", &bvh, &[&triangles]);
    assert!(bvh.refit(&triangles[1..]).is_err());
    check("after", &bvh, &[&triangles]);
}

/// Several threads must be able to look up triangles at the same time, even if there was no earlier
/// lookup.
#[test]
fn many_threads_look_up_at_once() {
    let triangles = mixed::<f32>(5000, &mut Rng::new(3));
    let bvh = Bvh::new(&triangles).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| check("a thread", &bvh, &[&triangles]));
        }
    });
}

fn bits<S: Scalar>(ray: &RayOf<S>) -> [u64; 8] {
    let RayOf { origin: [a, b, c], t_min, dir: [d, e, f], t_max } = *ray;
    [a, b, c, t_min, d, e, f, t_max].map(|x| Into::<f64>::into(x).to_bits())
}

/// Rays spawned by a hierarchy must equal the rays that the kernel spawns, and must not hit the
/// triangle on which they start.
fn spawned_rays_leave_their_triangle<S: BvhScalar + SliceScalar>() {
    let (mut rng, mut left) = (Rng::new(4), 0);
    let (one, other) = (mixed::<S>(300, &mut rng), mixed::<S>(200, &mut rng));
    let mut bvh = Bvh::from_meshes(&[&one, &[], &other]).unwrap();
    let mut all = [one, other].concat();
    for turn in 0..2 {
        if turn == 1 {
            all = mixed(all.len(), &mut rng);
            bvh.refit(&all).unwrap();
        }
        let mut query = bvh.query();
        for _ in 0..4000 {
            let mut vector = || rng.cube().map(S::nearest);
            let (ray, dir, target) = (RayOf::new(vector(), vector()), vector(), vector());
            let Some(hit) = query.closest(&ray) else { continue };
            let first = if hit.geometry == 0 { 0 } else { 300 };
            let triangle = all[first + hit.triangle as usize];
            assert_eq!(bvh.triangle(&hit), Some(triangle), "{hit:?}");
            let next = bvh.spawn_ray(&hit, dir);
            assert_eq!(bits(&next), bits(&spawn_ray(&hit, &triangle, dir)), "{hit:?}");
            let to = bvh.spawn_ray_to(&hit, target);
            assert_eq!(bits(&to), bits(&spawn_ray_to(&hit, &triangle, target)), "{hit:?}");
            assert!(to.t_min == S::ZERO && to.t_max == S::ONE, "{to:?}");
            for next in [next, to] {
                assert!(!Mode::exact().any(&[triangle], &next), "{next:?}");
                let again =
                    |found: Hit| (found.geometry, found.triangle) == (hit.geometry, hit.triangle);
                assert!(!query.all(&next).into_iter().any(again), "{next:?}");
            }
            left += 1;
        }
    }
    assert!(left > 1000, "{left}");
}

#[test]
fn spawned_rays_leave_their_triangle_in_f32() {
    spawned_rays_leave_their_triangle::<f32>();
}

#[test]
fn spawned_rays_leave_their_triangle_in_f64() {
    spawned_rays_leave_their_triangle::<f64>();
}

/// A ray spawned from a miss or an unknown triangle must not hit anything, even if its interval is
/// changed.
fn rays_from_a_miss_stay_empty<S: BvhScalar>() {
    let wall = |z: f64| {
        let corners = [[-9.0, -9.0, z], [9.0, -9.0, z], [0.0, 9.0, z]];
        TriangleOf(corners.map(|corner| corner.map(S::nearest)))
    };
    let mut nowhere = wall(1.0);
    nowhere.0[1][2] = S::nearest(f64::NAN);
    let bvh = Bvh::new(&[wall(-1.0), nowhere, wall(0.0), wall(1.0)]).unwrap();
    let up = [S::ZERO, S::ZERO, S::ONE];
    assert!(bvh.any(&RayOf::new([S::ZERO; 3], up)));
    let misses = [Hit::MISS, Hit { triangle: 7, ..named(0, 7) }, named(0, 1), named(1, 0)];
    for hit in misses {
        for ray in [bvh.spawn_ray(&hit, up), bvh.spawn_ray_to(&hit, up)] {
            let far = S::INFINITY;
            let intervals =
                [(S::ZERO, far), (S::ZERO, S::ONE), (S::from(-9.0), far), (S::ONE, far)];
            let rays = intervals.map(|(t_min, t_max)| ray.between(t_min, t_max));
            for ray in &rays {
                assert!(ray.origin.iter().all(|&x| Into::<f64>::into(x).is_nan()), "{ray:?}");
                assert_eq!((bvh.closest(ray), bvh.any(ray)), (None, false), "{ray:?}");
                assert!(bvh.all(ray).is_empty() && bvh.crossings(ray).is_empty(), "{ray:?}");
                assert_eq!(bvh.next_crossing(ray), None, "{ray:?}");
            }
            let query = bvh.query();
            assert!(query.closest_batch(&rays).iter().all(|hit| !hit.is_hit()));
            assert_eq!(query.any_batch(&rays), [false; 4]);
            assert!(query.all_batch(&rays, None).unwrap().items.is_empty());
            assert!(query.crossings_batch(&rays, None).unwrap().items.is_empty());
            assert!(query.count_crossings_batch(&rays).iter().all(|count| count.unsigned == 0));
        }
    }
}

#[test]
fn rays_from_a_miss_stay_empty_in_f32() {
    rays_from_a_miss_stay_empty::<f32>();
}

#[test]
fn rays_from_a_miss_stay_empty_in_f64() {
    rays_from_a_miss_stay_empty::<f64>();
}

/// In document A's operations, comparisons with NaN are false, so rays whose origin is NaN need a
/// separate test in every mode.
#[test]
fn rays_from_a_miss_are_empty_in_every_mode() {
    let wall = |z: f32| TriangleOf([[-9.0, -9.0, z], [9.0, -9.0, z], [0.0, 9.0, z]]);
    let triangles = [wall(-1.0), wall(0.0), wall(1.0)];
    let bvh = Bvh::new(&triangles).unwrap();
    for mode in [Mode::exact(), Mode::once(), Mode::certified()] {
        let mut query = bvh.query().mode(mode);
        for ray in
            [bvh.spawn_ray(&Hit::MISS, [0.0, 0.0, 1.0]), bvh.spawn_ray_to(&Hit::MISS, [1.0; 3])]
        {
            for (t_min, t_max) in [(0.0, f32::INFINITY), (-9.0, 9.0), (0.0, 1.0)] {
                let ray: Ray = ray.between(t_min, t_max);
                assert_eq!(
                    (query.closest(&ray), query.any(&ray)),
                    (None, false),
                    "{mode:?} {ray:?}"
                );
                assert_eq!(mode.closest(&triangles, &ray), None, "{mode:?} {ray:?}");
                assert_eq!(query.closest_batch(&[ray; 40]), [Hit::MISS; 40], "{mode:?} {ray:?}");
            }
        }
    }
}
