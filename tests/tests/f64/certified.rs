//! Tests f64 slices in the `certified` mode. The results must be bit-for-bit the same as those of
//! the scalar reference's operations on f64 coordinates.

use intertri::simd::Level;
use intertri::{Hit, Mode, Ray64, Scalar, Threshold, Triangle64, TriangleOf};
use intertri_lab::families::FAMILIES;
use intertri_lab::rng::Rng;
use intertri_reference as reference;

use super::cases::{KINDS, case};

/// Returns the reference's tables for the given triangles.
fn tables(triangles: &[Triangle64], threshold: f64) -> reference::Scene {
    let corners = triangles.iter().flat_map(|triangle| triangle.0).map(Into::into);
    let indices = (0..triangles.len()).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    reference::Scene::new(corners.collect(), indices).unwrap().with_threshold(threshold)
}

/// Returns the bits of a number, mapping all NaNs to the same bits.
fn bits(x: f64) -> u64 {
    if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }
}

/// Runs every query over a slice for every ray. Returns the number of rays that hit.
fn check(what: &str, triangles: &[Triangle64], rays: &[Ray64], threshold: f64) -> usize {
    let scene = tables(triangles, threshold);
    let mode = Mode::certified_with(Threshold::new(threshold).unwrap());
    let mut batch = vec![Hit::MISS; rays.len()];
    mode.closest_batch(triangles, rays, &mut batch);
    let mut hits = 0;
    for (ray, batch) in rays.iter().zip(batch) {
        let line = reference::Ray::new(ray.origin, ray.dir);
        let closest = scene.closest(&line, ray.t_min, ray.t_max);
        let mut all = scene.all(&line, ray.t_min, ray.t_max);
        // The sort is stable, so if two hits have the same t, the lower index comes first.
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        let want = |&(obj, t): &(usize, f64)| {
            let (u, v) = scene.barycentric(obj, &line);
            (obj as u32, [t, u, v].map(bits))
        };
        let (first, all) = (closest.as_ref().map(want), all.iter().map(want).collect::<Vec<_>>());
        let found = |hit: Hit| (hit.triangle, [hit.t, hit.u, hit.v].map(bits));
        for level in Level::all() {
            let (mode, at) = (mode.at(level), || format!("{what}: {ray:?}"));
            assert_eq!(mode.closest(triangles, ray).map(found), first, "{}", at());
            assert_eq!(mode.any(triangles, ray), first.is_some(), "{}", at());
            let every: Vec<_> = mode.all(triangles, ray).into_iter().map(found).collect();
            assert_eq!(every, all, "{}", at());
        }
        assert_eq!(batch.some().map(found), first, "{what}: {ray:?}");
        assert!(scene.any(&line, ray.t_min, ray.t_max) == first.is_some());
        hits += usize::from(first.is_some());
    }
    hits
}

/// Thresholds from zero to a value that rejects most hits.
const THRESHOLDS: [f64; 4] = [1e-9, 0.0, 1e-30, 0.25];

/// Tests pairs of every kind. Each ray is also tested against the triangles of other pairs.
#[test]
fn pairs_of_every_kind() {
    let (mut rng, mut hits) = (Rng::new(1), 0);
    for i in 0..4000 {
        let pairs = [(); 5].map(|()| case(i % KINDS, &mut rng));
        let (rays, mut triangles) = (pairs.map(|pair| pair.0), pairs.map(|pair| pair.1).to_vec());
        // Add a duplicate, to cause a tie.
        triangles.push(triangles[i % 5]);
        let threshold = THRESHOLDS[i / KINDS % THRESHOLDS.len()];
        hits += check(&format!("kind {}", i % KINDS), &triangles, &rays, threshold);
    }
    assert!(hits > 4000, "{hits}");
}

/// Converts cases from all families to f64. The results must equal those of f32 slices.
#[test]
fn families_answer_as_in_f32() {
    let (mut rng, mut hits) = (Rng::new(2), 0);
    for family in FAMILIES {
        for count in [0, 1, 7, 16, 33] {
            let scene = family.scene(&mut rng, count, 12);
            let wide = |p: [f32; 3]| p.map(f64::from);
            let triangles: Vec<Triangle64> =
                scene.triangles.iter().map(|t| TriangleOf(t.0.map(wide))).collect();
            let widen = |ray: &intertri::Ray| {
                Ray64::new(wide(ray.origin), wide(ray.dir))
                    .between(f64::from(ray.t_min), f64::from(ray.t_max))
            };
            let rays: Vec<Ray64> = scene.rays.iter().map(widen).collect();
            hits += check(family.name, &triangles, &rays, scene.threshold);
            let mode = Mode::certified_with(Threshold::new(scene.threshold).unwrap());
            for (ray, in_f32) in rays.iter().zip(&scene.rays) {
                let found = |hit: Hit| (hit.triangle, [hit.t, hit.u, hit.v].map(bits));
                let (a, b) = (mode.all(&triangles, ray), mode.all(&scene.triangles, in_f32));
                assert!(a.into_iter().map(found).eq(b.into_iter().map(found)), "{in_f32:?}");
            }
        }
    }
    assert!(hits > 500, "{hits}");
}

/// Tests intervals that begin or end at t or next to it.
#[test]
fn ends_of_the_interval() {
    let (mut rng, mut ends) = (Rng::new(3), 0);
    for i in 0..3000 {
        let (ray, triangle) = case(i % KINDS, &mut rng);
        let ray = ray.between(0.0, f64::INFINITY);
        let Some(hit) = Mode::certified_with(Threshold::ZERO).closest(&[triangle], &ray) else {
            continue;
        };
        for end in [hit.t.next_down(), hit.t, hit.t.next_up(), f64::NAN] {
            let rays = [ray.between(end, f64::INFINITY), ray.between(f64::ZERO, end)];
            check("an end", &[triangle], &rays, 0.0);
            ends += 1;
        }
    }
    assert!(ends > 1000, "{ends}");
}
