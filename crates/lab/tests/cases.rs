//! Tests the methods on the families, one ray and one triangle at a time.

use intertri::simd::Level;
use intertri::{Ray, Triangle};
use intertri_reference::{Ray as F64Ray, Scene as F64Scene, THRESHOLD};

use intertri_lab::families::{Case, FAMILIES, find};
use intertri_lab::methods::{METHODS, Method, OF_THE_REFERENCE};
use intertri_lab::oracle::{self, exact_t};
use intertri_lab::rng::Rng;
use intertri_lab::test_batch::Answer;

/// Returns a method's answers for a list of cases.
fn answers(method: &Method, level: Level, cases: &[Case]) -> Vec<Answer> {
    let triangles: Vec<_> = cases.iter().map(|case| case.triangle).collect();
    let rays: Vec<_> = cases.iter().map(|case| case.ray).collect();
    let mut to = vec![Answer::default(); cases.len()];
    method.pairs(level, THRESHOLD, &triangles, &rays, &mut to);
    to
}

fn cases(name: &str, n: usize) -> Vec<Case> {
    let (family, mut rng) = (find(name).unwrap(), Rng::new(41));
    (0..n).map(|_| family.case(&mut rng)).collect()
}

#[test]
fn every_method_answers_ordinary_queries() {
    // Most rays pass well inside or well outside the triangle, so every method must find the exact
    // answer. In f32, two cases may differ.
    let cases: Vec<_> = cases("uniform", 4000);
    for method in METHODS {
        let (mut differ, mut hits, mut off) = (0, 0, 0.0_f64);
        for (case, answer) in cases.iter().zip(answers(method, Level::best(), &cases)) {
            let exact = oracle::answer(&case.triangle, &case.ray);
            differ += u32::from(exact.is_hit() != answer.hit);
            if exact.is_hit() && answer.hit {
                hits += 1;
                let t = exact_t(&case.triangle, &case.ray).unwrap().to_f64().value();
                off = off.max((answer.t - t).abs() / t);
            }
        }
        assert!(hits > 400 && differ <= if method.bits == 24 { 2 } else { 0 }, "{}", method.name);
        let coarse = method.bits == 24 || method.name == "fixed";
        assert!(off < if coarse { 2e-2 } else { 1e-9 }, "{}: {off:e}", method.name);
    }
}

#[test]
fn every_level_gives_the_same_answers() {
    // The answer for a pair must not depend on the other pairs in the register either.
    for family in FAMILIES {
        let cases = cases(family.name, 100);
        for method in METHODS {
            let alone: Vec<_> =
                (cases.iter()).map(|&case| answers(method, Level::PORTABLE, &[case])[0]).collect();
            for level in Level::all() {
                for (a, b) in alone.iter().zip(answers(method, level, &cases)) {
                    let same = a.hit == b.hit && (!a.hit || a.t.to_bits() == b.t.to_bits());
                    assert!(same, "{} {} {}: {a:?} {b:?}", family.name, method.name, level.name());
                }
            }
        }
    }
}

#[test]
fn inter_tri_in_f64_is_the_reference() {
    for family in FAMILIES {
        let cases = cases(family.name, 300);
        for method in METHODS.iter().filter(|s| OF_THE_REFERENCE.contains(&s.name)) {
            for (case, got) in cases.iter().zip(answers(method, Level::best(), &cases)) {
                let scene = F64Scene::from_triangles([case.triangle.0]);
                let ray = F64Ray::new(case.ray.origin, case.ray.dir);
                let mut t = f64::NAN;
                // Document A's listing reports a hit at t = infinity, which the kernel's interval
                // excludes.
                let hit = scene.inter_tri(0, &ray, &mut t) == 1 && (t.is_finite() || got.hit);
                assert!(hit == got.hit && (!hit || t == got.t), "{} {}", family.name, method.name);
            }
        }
    }
}

#[test]
fn methods_fail_where_they_are_known_to() {
    // Measures the share of true hits that a method misses. An unexpected share indicates that the
    // method is not implemented as published.
    let misses = |name: &str, triangle_of: &dyn Fn(&mut Rng) -> Case| {
        let method = METHODS.iter().find(|s| s.name == name).unwrap();
        let mut rng = Rng::new(43);
        let cases: Vec<_> = (0..4000)
            .map(|_| triangle_of(&mut rng))
            .filter(|case| oracle::answer(&case.triangle, &case.ray).is_hit())
            .collect();
        let missed = answers(method, Level::best(), &cases).iter().filter(|a| !a.hit).count();
        missed as f64 / cases.len() as f64
    };
    let at =
        |family: &'static str, x: f64| move |rng: &mut Rng| find(family).unwrap().case_at(rng, x);

    // An epsilon on the determinant fails for small triangles; the same test without an epsilon
    // does not.
    assert!(misses("Möller–Trumbore ε f32", &at("scale", 1e-6)) > 0.99);
    assert!(misses("Möller–Trumbore f32", &at("scale", 1e-6)) < 0.35);
    // A threshold fails for short directions; methods without a threshold do not.
    assert!(misses("InterTri f64", &at("direction", 1e-12)) > 0.99);
    assert!(misses("signed volume f64", &at("direction", 1e-12)) < 0.01);
    // Methods that do not take coordinates relative to the ray's origin fail far from the
    // coordinate origin.
    assert!(misses("Baldwin–Weber f32", &at("offset", 1e6)) > 0.5);
    assert!(misses("Plücker f32", &at("offset", 1e6)) > 0.3);
}

#[test]
fn a_plain_triangle_works_as_a_pair() {
    let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 2.0]);
    for method in METHODS {
        let mut to = [Answer::default()];
        method.pairs(Level::best(), THRESHOLD, &[triangle], &[ray], &mut to);
        assert_eq!(to[0], Answer { hit: true, t: 2.5 }, "{}", method.name);
    }
}
