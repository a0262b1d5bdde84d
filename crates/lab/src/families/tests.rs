//! Tests that the families generate what their descriptions promise, with the same bits on every
//! machine.

use std::collections::BTreeSet;

use intertri::{Ray, Triangle};
use intertri_reference::{Ray as F64Ray, Scene as F64Scene, Vector};

use super::{FAMILIES, Family, Scene, adversarial, find};
use crate::rng::Rng;

/// Returns the dot product of the normal and the direction, `t` (NaN if the ray is parallel), and
/// whether the ray hits.
fn ask(triangle: &Triangle, ray: &Ray, threshold: f64) -> (f64, f64, bool) {
    let scene = F64Scene::from_triangles([triangle.0]).with_threshold(threshold);
    let mut t = f64::NAN;
    let hit = scene.inter_tri(0, &F64Ray::new(ray.origin, ray.dir), &mut t) == 1;
    (scene.trian[0].nrm & Vector::from(ray.dir), t, hit)
}

/// Counts the cases of a family for which a condition holds.
fn count(name: &str, n: usize, mut holds: impl FnMut(&Family, &mut Rng) -> bool) -> usize {
    let family = find(name).expect("the family exists");
    let mut rng = Rng::new(7);
    (0..n).filter(|_| holds(family, &mut rng)).count()
}

#[test]
fn names_are_unique_and_found() {
    let names: BTreeSet<_> = FAMILIES.iter().map(|family| family.name).collect();
    assert_eq!(names.len(), FAMILIES.len());
    assert!(find("no such family").is_none());
}

#[test]
fn a_seed_gives_the_same_bits_everywhere() {
    // Compute a checksum over everything that a seed generates. It changes when a family changes,
    // but must not depend on the CPU or the build.
    let mut sum = 0_u64;
    let mut eat = |x: u64| sum = (sum ^ x).wrapping_mul(0x0000_0100_0000_01B3).rotate_left(17);
    for family in FAMILIES {
        let mut rng = Rng::new(2024);
        for triangles in [1, 2, 20, 77, 500] {
            let Scene { triangles, rays, threshold } = family.scene(&mut rng, triangles, 50);
            let numbers = (triangles.iter().flat_map(|t| t.0.into_iter().flatten()))
                .chain(rays.iter().flat_map(|r| r.origin.into_iter().chain(r.dir)))
                .chain(rays.iter().flat_map(|r| [r.t_min, r.t_max]));
            numbers.for_each(|x| eat(u64::from(x.to_bits())));
            eat(threshold.to_bits());
        }
    }
    assert_eq!(sum, CHECKSUM, "{sum:#x}");
}

const CHECKSUM: u64 = 0x2FA4_F0F5_7896_C24F;

#[test]
fn scenes_have_the_size_asked_for() {
    let mut rng = Rng::new(3);
    for family in FAMILIES {
        for n in [0, 1, 2, 7, 18, 100, 1000, 5000] {
            let scene = family.scene(&mut rng, n, 9);
            assert_eq!(scene.rays.len(), if n == 0 { 0 } else { 9 }, "{}", family.name);
            let got = scene.triangles.len();
            assert!(got <= n && got >= n / 5 && (got == n || n > 18), "{}: {got}", family.name);
            assert!(scene.threshold.is_finite() && scene.threshold >= 0.0);
            let finite = |t: &Triangle| t.0.as_flattened().iter().all(|x| x.is_finite());
            assert!(family.name == "not-finite" || scene.triangles.iter().all(finite));
        }
    }
}

#[test]
fn rays_come_near_hitting() {
    // About half of the rays aimed at edges hit. A family with hardly any hits, or hardly any
    // misses, would test nothing.
    let rare = [
        "threshold-vd",
        "threshold-t",
        "threshold-default",
        "zero-area",
        "coplanar",
        "bits",
        "not-finite",
        "zeros",
        "interval",
    ];
    for family in FAMILIES.iter().filter(|family| !rare.contains(&family.name)) {
        let (mut hits, n) = (0, 4000);
        let mut rng = Rng::new(5);
        for _ in 0..n {
            // Use no threshold, because the values in some families are below the default
            // threshold.
            let case = family.case(&mut rng);
            hits += usize::from(ask(&case.triangle, &case.ray, 0.0).2);
        }
        assert!((n / 8..n * 127 / 128).contains(&hits), "{}: {hits} of {n}", family.name);
    }
}

#[test]
fn f32_decides_many_a_random_case_wrongly() {
    // The rays are sensitive to rounding, so the f32 test and the f64 test must differ in many
    // cases.
    let differ = count("random", 10_000, |family, rng| {
        let case = family.case(rng);
        let [c1, c2, c3] = case.triangle.0;
        let sub = |a: [f32; 3], b: [f32; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cross = |a: [f32; 3], b: [f32; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let (e1, e2, s) = (sub(c2, c1), sub(c3, c1), sub(case.ray.origin, c1));
        let p = cross(case.ray.dir, e2);
        let q = cross(s, e1);
        let det = dot(e1, p);
        let (u, v) = (dot(s, p) / det, dot(case.ray.dir, q) / det);
        let hit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && dot(e2, q) / det > 1e-9;
        hit != ask(&case.triangle, &case.ray, case.threshold).2
    });
    assert!(differ > 500, "{differ} of 10000");
}

#[test]
fn thresholds_are_met_on_both_sides() {
    for name in ["threshold-vd", "threshold-t", "threshold-default", "threshold-met"] {
        let (mut below, mut at, mut above) = (0, 0, 0);
        count(name, 4000, |family, rng| {
            let case = family.case(rng);
            let (vd, t, _) = ask(&case.triangle, &case.ray, 0.0);
            for x in [vd.abs(), t] {
                let limit = case.threshold;
                below += u32::from(x < limit && x >= limit * (1.0 - 1e-15));
                at += u32::from(x == limit);
                above += u32::from(x > limit && x <= limit * (1.0 + 1e-15));
            }
            true
        });
        assert!(below > 300 && at > 150 && above > 300, "{name}: {below} {at} {above}");
    }
}

#[test]
fn intervals_end_at_t() {
    let mut met = [0; 3];
    count("interval", 4000, |family, rng| {
        let case = family.case(rng);
        let (_, t, hit) = ask(&case.triangle, &case.ray, case.threshold);
        for end in [case.ray.t_min, case.ray.t_max] {
            let near = t as f32;
            met[0] += u32::from(hit && end == near.next_down());
            met[1] += u32::from(hit && f64::from(end) == t);
            met[2] += u32::from(hit && end == near.next_up());
        }
        true
    });
    assert!(met.iter().all(|&n| n > 150), "{met:?}");
}

#[test]
fn exact_families_are_exact() {
    // A ray that meets a vertex or an edge on the grid has an edge value of exactly 0 in integers.
    for (name, grid) in
        [("icosphere-exact", 262_144.0), ("torus-exact", 262_144.0), ("cube-exact", 1.0)]
    {
        let on_edge = count(name, 2000, |family, rng| {
            let case = family.case(rng);
            let whole = |p: [f32; 3]| {
                p.map(|x| {
                    let x = f64::from(x) * grid;
                    assert!(x as i32 as f64 == x, "{name}: {x} is off the grid");
                    i128::from(x as i64)
                })
            };
            let o = whole(case.ray.origin);
            let d = whole(case.ray.dir);
            let [a, b, c] = case.triangle.0.map(|p| {
                let p = whole(p);
                [p[0] - o[0], p[1] - o[1], p[2] - o[2]]
            });
            let det = |p: [i128; 3], q: [i128; 3]| {
                d[0] * (p[1] * q[2] - p[2] * q[1])
                    + d[1] * (p[2] * q[0] - p[0] * q[2])
                    + d[2] * (p[0] * q[1] - p[1] * q[0])
            };
            [det(b, c), det(c, a), det(a, b)].contains(&0)
        });
        assert!(on_edge > 1500, "{name}: {on_edge} of 2000");
    }
}

#[test]
fn every_input_gets_its_nan_and_infinities() {
    let mut seen = [[false; 4]; 17];
    count("not-finite", 4000, |family, rng| {
        let case = family.case(rng);
        let ray = case.ray;
        let inputs = (case.triangle.0.into_iter().flatten())
            .chain(ray.origin)
            .chain(ray.dir)
            .chain([ray.t_min, ray.t_max]);
        for (seen, x) in seen.iter_mut().zip(inputs) {
            seen[0] |= x.is_nan();
            seen[1] |= x == f32::INFINITY;
            seen[2] |= x == f32::NEG_INFINITY;
            seen[3] |= x.is_finite();
        }
        true
    });
    assert_eq!(seen[..16], [[true; 4]; 16]);
}

#[test]
fn the_mix_is_mostly_rounding_sensitive() {
    let mut rng = Rng::new(11);
    let mut hits = 0;
    for _ in 0..4000 {
        let case = adversarial(&mut rng);
        hits += u32::from(ask(&case.triangle, &case.ray, case.threshold).2);
    }
    assert!((1000..3000).contains(&hits), "{hits}");
}
