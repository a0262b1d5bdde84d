use intertri::lanes::Level;
use intertri::{Ray, Triangle, Vec3};
use intertri_reference::{Ray as F64Ray, Scene as F64Scene, THRESHOLD};

use super::badouel::Badouel;
use super::baldwin_weber::BaldwinWeber;
use super::cramer::Cramer;
use super::embree::{EdgeForm, Robust};
use super::inter_tri::InterTri;
use super::moller_trumbore::MollerTrumbore;
use super::pluecker::Pluecker;
use super::signed_volume::SignedVolume;
use super::woop::Woop;
use super::{
    Answer, Bundle, Form, Layout, Method, Nearest, OF_THE_REFERENCE, SUBJECTS, Subject, on_grid,
};
use crate::families::{Case, FAMILIES, find};
use crate::rng::Rng;
use crate::truth::{Place, exact_t, truth};
use crate::workloads::{Model, Workload};

/// One ray and one triangle, in plain numbers.
fn ask<M: Method>(
    method: M,
    corners: [[f64; 3]; 3],
    origin: [f64; 3],
    dir: [f64; 3],
) -> (bool, f64) {
    let vec3 = |[x, y, z]: [f64; 3]| Vec3 { x, y, z };
    method.test(&method.triangle(corners.map(vec3)), &method.ray(vec3(origin), vec3(dir)))
}

/// The answers of a subject to some cases of a family.
fn answers(subject: &Subject, level: Level, cases: &[Case]) -> Vec<Answer> {
    let triangles: Vec<_> = cases.iter().map(|case| case.triangle).collect();
    let rays: Vec<_> = cases.iter().map(|case| case.ray).collect();
    let mut to = vec![Answer::default(); cases.len()];
    subject.pairs(level, THRESHOLD, &triangles, &rays, &mut to);
    to
}

fn cases(name: &str, n: usize) -> Vec<Case> {
    let (family, mut rng) = (find(name).unwrap(), Rng::new(41));
    (0..n).map(|_| family.case(&mut rng)).collect()
}

/// A triangle askew with sides that are easy to follow by hand:
/// `c1 + u (c2 - c1) + v (c3 - c1)`, met at u = 1/4, v = 1/2 in t = 3 from (1, 1, 1).
const CORNERS: [[f64; 3]; 3] = [[2.0, 3.0, 4.0], [6.0, 3.0, 8.0], [4.0, 9.0, 4.0]];
const ORIGIN: [f64; 3] = [1.0, 1.0, 1.0];
const DIR: [f64; 3] = [1.0, 5.0 / 3.0, 4.0 / 3.0];

/// One worked example for each method: the hit with its t, from both sides, and misses all around.
fn worked_example<M: Method>(method: M) {
    let at = |u: f64, v: f64| {
        let point = [0, 1, 2].map(|k| {
            CORNERS[0][k]
                + u * (CORNERS[1][k] - CORNERS[0][k])
                + v * (CORNERS[2][k] - CORNERS[0][k])
        });
        [0, 1, 2].map(|k| (point[k] - ORIGIN[k]) / 3.0)
    };
    assert_eq!(at(0.25, 0.5), DIR);
    let [c1, c2, c3] = CORNERS;
    for corners in [[c1, c2, c3], [c2, c3, c1], [c3, c1, c2], [c1, c3, c2], [c3, c2, c1]] {
        let (hit, t) = ask(method, corners, ORIGIN, DIR);
        assert!(hit && (t - 3.0).abs() < 1e-14, "{hit} {t}");
        for (u, v, inside) in [
            (0.01, 0.5, true),
            (0.5, 0.01, true),
            (0.49, 0.5, true),
            (-0.01, 0.5, false),
            (0.5, -0.01, false),
            (0.51, 0.5, false),
        ] {
            let (hit, t) = ask(method, corners, ORIGIN, at(u, v));
            assert!(hit == inside && (!hit || (t - 3.0).abs() < 1e-13), "{u} {v}: {hit} {t}");
        }
        // Behind, parallel, without area, not a number.
        assert!(!ask(method, corners, ORIGIN, DIR.map(|x| -x)).0);
        assert!(!ask(method, corners, ORIGIN, [4.0, 0.0, 4.0]).0);
        assert!(!ask(method, [c1, c2, c1], ORIGIN, DIR).0);
        assert!(!ask(method, corners, [f64::NAN, 1.0, 1.0], DIR).0);
    }
}

#[test]
fn inter_tri_by_hand() {
    worked_example(InterTri { threshold: 1e-9 });
}

#[test]
fn moller_trumbore_by_hand() {
    worked_example(MollerTrumbore { epsilon: 0.0 });
    worked_example(MollerTrumbore { epsilon: 1e-6 });
}

#[test]
fn badouel_by_hand() {
    worked_example(Badouel);
}

#[test]
fn baldwin_weber_by_hand() {
    worked_example(BaldwinWeber);
}

#[test]
fn cramer_by_hand() {
    worked_example(Cramer);
}

#[test]
fn embree_by_hand() {
    worked_example(EdgeForm);
    worked_example(Robust);
}

#[test]
fn pluecker_by_hand() {
    worked_example(Pluecker);
}

#[test]
fn signed_volume_by_hand() {
    worked_example(SignedVolume);
}

#[test]
fn woop_by_hand() {
    worked_example(Woop { fall_back: true });
}

#[test]
fn the_epsilon_is_the_papers() {
    // The determinant is the area's double against the direction: here the second side.
    for (side, beyond) in [(1e-6, false), (1.1e-6, true), (-1e-6, false), (-1.1e-6, true)] {
        let corners = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, side, 5.0]];
        let hit = |epsilon| {
            ask(MollerTrumbore { epsilon }, corners, [0.25, 0.25 * side, 0.0], [0.0, 0.0, 1.0]).0
        };
        assert_eq!((hit(0.0), hit(1e-6)), (true, beyond), "{side}");
    }
}

#[test]
fn the_robust_form_takes_a_unit_of_rounding() {
    let corners = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    for (x, fast, robust) in [(1e-17, true, true), (-1e-17, false, true), (-1e-15, false, false)] {
        let dir = [x, 0.25, 1.0];
        assert_eq!(ask(EdgeForm, corners, [0.0; 3], dir).0, fast, "{x}");
        assert_eq!(ask(Robust, corners, [0.0; 3], dir).0, robust, "{x}");
    }
}

#[test]
fn woop_falls_back_where_f32_cannot_tell() {
    // 8193 * 8191 = 8192 * 8192 - 1, the same in f32. So the side from b to c seems to pass through the
    // ray, and two triangles on either side of it both seem to be hit; f64 knows which is.
    let (b, c) = ([8192.0, 8191.0, 1.0], [-8193.0, -8192.0, 1.0]);
    let vec3 = |[x, y, z]: [f32; 3]| Vec3 { x, y, z };
    for (y, is_hit) in [(10.0, true), (-10.0, false)] {
        let triangle = Triangle([[0.0, y, 1.0], b, c]);
        let ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
        assert_eq!(truth(&triangle, &ray).is_hit(), is_hit);
        for (fall_back, hit) in [(true, is_hit), (false, true)] {
            let woop = Woop { fall_back };
            let ray = woop.ray(vec3(ray.origin), vec3(ray.dir));
            assert_eq!(woop.test(&woop.triangle(triangle.0.map(vec3)), &ray).0, hit);
        }
    }
}

#[test]
fn every_subject_answers_ordinary_questions() {
    // Rays well inside or well outside: nobody has an excuse.
    let cases: Vec<_> = cases("uniform", 4000);
    for subject in SUBJECTS {
        let (mut differ, mut hits, mut off) = (0, 0, 0.0_f64);
        for (case, answer) in cases.iter().zip(answers(subject, Level::best(), &cases)) {
            let exact = truth(&case.triangle, &case.ray);
            differ += u32::from(exact.is_hit() != answer.hit);
            if exact.is_hit() && answer.hit {
                hits += 1;
                let t = exact_t(&case.triangle, &case.ray).unwrap().to_f64().value();
                off = off.max((answer.t - t).abs() / t);
            }
        }
        assert!(hits > 400 && differ <= if subject.bits == 24 { 2 } else { 0 }, "{}", subject.name);
        let coarse = subject.bits == 24 || subject.name == "fixed";
        assert!(off < if coarse { 2e-2 } else { 1e-9 }, "{}: {off:e}", subject.name);
    }
}

#[test]
fn every_level_gives_the_same_answers() {
    // Also lane by lane: a pair's answer does not depend on the other pairs in the register.
    for family in FAMILIES {
        let cases = cases(family.name, 100);
        for subject in SUBJECTS {
            let alone: Vec<_> =
                (cases.iter()).map(|&case| answers(subject, Level::SCALAR, &[case])[0]).collect();
            for level in Level::all() {
                for (a, b) in alone.iter().zip(answers(subject, level, &cases)) {
                    let same = a.hit == b.hit && (!a.hit || a.t.to_bits() == b.t.to_bits());
                    assert!(same, "{} {} {}: {a:?} {b:?}", family.name, subject.name, level.name());
                }
            }
        }
    }
}

#[test]
fn inter_tri_in_f64_is_the_reference() {
    for family in FAMILIES {
        let cases = cases(family.name, 300);
        for subject in SUBJECTS.iter().filter(|s| OF_THE_REFERENCE.contains(&s.name)) {
            for (case, got) in cases.iter().zip(answers(subject, Level::best(), &cases)) {
                let scene = F64Scene::from_triangles([case.triangle.0]);
                let ray = F64Ray::new(case.ray.origin, case.ray.dir);
                let mut t = f64::NAN;
                // A t of infinity is a hit to the listing; the kernel's interval excludes it.
                let hit = scene.inter_tri(0, &ray, &mut t) == 1 && (t.is_finite() || got.hit);
                assert!(hit == got.hit && (!hit || t == got.t), "{} {}", family.name, subject.name);
            }
        }
    }
}

#[test]
fn methods_fail_where_they_are_known_to() {
    // Shares of false misses among exact hits, so that a subject that is not what it claims shows.
    let misses = |name: &str, triangle_of: &dyn Fn(&mut Rng) -> Case| {
        let subject = SUBJECTS.iter().find(|s| s.name == name).unwrap();
        let mut rng = Rng::new(43);
        let cases: Vec<_> = (0..4000)
            .map(|_| triangle_of(&mut rng))
            .filter(|case| truth(&case.triangle, &case.ray).is_hit())
            .collect();
        let missed = answers(subject, Level::best(), &cases).iter().filter(|a| !a.hit).count();
        missed as f64 / cases.len() as f64
    };
    let at =
        |family: &'static str, x: f64| move |rng: &mut Rng| find(family).unwrap().case_at(rng, x);

    // A determinant's epsilon at a small scale; nothing else fails there.
    assert!(misses("Möller–Trumbore ε f32", &at("scale", 1e-6)) > 0.99);
    assert!(misses("Möller–Trumbore f32", &at("scale", 1e-6)) < 0.35);
    // A threshold against a short direction; none with the others.
    assert!(misses("InterTri f64", &at("direction", 1e-12)) > 0.99);
    assert!(misses("signed volume f64", &at("direction", 1e-12)) < 0.01);
    // Methods that do not move the origin to the ray's, far from the origin of the axes.
    assert!(misses("Baldwin–Weber f32", &at("offset", 1e6)) > 0.5);
    assert!(misses("Plücker f32", &at("offset", 1e6)) > 0.3);
}

#[test]
fn watertight_methods_hold_water_and_others_leak() {
    // From inside of a closed mesh, exactly at its edges and vertices. (A few rays of the far origins
    // are left out: their truth is two hits.)
    let scene = find("icosphere-exact").unwrap().scene(&mut Rng::new(44), 320, 2000);
    let inside = |ray: &&Ray| ray.origin.iter().all(|x| x.abs() <= 0.4);
    let rays: Vec<_> = scene.rays.iter().filter(inside).collect();
    let hits = |name: &str| -> (usize, usize) {
        let subject = SUBJECTS.iter().find(|s| s.name == name).unwrap();
        let mut to = vec![Answer::default(); scene.triangles.len()];
        let (mut leaks, mut doubles) = (0, 0);
        for &&ray in &rays {
            subject.pairs(
                Level::best(),
                THRESHOLD,
                &scene.triangles,
                &vec![ray; to.len()],
                &mut to,
            );
            match to.iter().filter(|answer| answer.hit).count() {
                0 => leaks += 1,
                1 => {}
                _ => doubles += 1,
            }
        }
        (leaks, doubles)
    };
    let n = rays.len();
    assert!(n > 900);
    for name in ["Woop f32", "Embree robust f32"] {
        let (leaks, doubles) = hits(name);
        assert!(leaks == 0 && doubles > n / 20, "{name}: {leaks} {doubles} of {n}");
    }
    for name in ["InterTri f32", "Möller–Trumbore f32", "Embree fast f32"] {
        let (leaks, doubles) = hits(name);
        assert!(leaks > 5 && doubles > n / 50, "{name}: {leaks} {doubles} of {n}");
    }
}

#[test]
fn a_plain_triangle_works_as_a_pair() {
    let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 2.0]);
    for subject in SUBJECTS {
        let mut to = [Answer::default()];
        subject.pairs(Level::best(), THRESHOLD, &[triangle], &[ray], &mut to);
        assert_eq!(to[0], Answer { hit: true, t: 2.5 }, "{}", subject.name);
    }
}

/// Bundles of every workload, some with a number of rays or triangles that fills no register.
fn bundles() -> Vec<Bundle> {
    let (mut rng, model) = (Rng::new(5), Model::built_in());
    let mut all = Vec::new();
    for workload in Workload::ALL {
        for odd in [0, 3] {
            let mut bundle = workload.bundle(&mut rng, &model);
            bundle.rays.truncate(bundle.rays.len() - odd);
            bundle.triangles.truncate(bundle.triangles.len() - odd);
            all.push(bundle);
        }
    }
    all
}

#[test]
fn every_layout_finds_the_hits_of_the_pairs() {
    for bundle in bundles() {
        for subject in SUBJECTS.iter().filter(|subject| subject.name != "fixed") {
            // The closest of each ray and how many there are, pair by pair.
            let (mut expected, mut counts) = (Vec::new(), Vec::new());
            for ray in &bundle.rays {
                let rays = vec![*ray; bundle.triangles.len()];
                let mut to = vec![Answer::default(); rays.len()];
                subject.pairs(Level::best(), THRESHOLD, &bundle.triangles, &rays, &mut to);
                let mut best = Nearest::MISS;
                for (triangle, answer) in (0..).zip(&to) {
                    if answer.hit && answer.t < best.t {
                        best = Nearest { t: answer.t, triangle };
                    }
                }
                expected.push(best);
                counts.push(to.iter().filter(|answer| answer.hit).count() as u32);
            }
            assert_eq!(subject.counts(Level::best(), &bundle), counts);
            let bundles = [bundle.clone(), bundle.clone()];
            for form in [Form::Packets, Form::Packs] {
                for lanes in [1, 4, 8, 16] {
                    let mut nearest = Vec::new();
                    let layout = Layout { form, lanes };
                    if subject.closest(Level::best(), &bundles, layout, &mut nearest).is_some() {
                        let name = subject.name;
                        assert_eq!(
                            nearest,
                            [&expected[..], &expected].concat(),
                            "{name} {layout:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn fixed_on_its_grid_is_the_truth() {
    let fixed = SUBJECTS.iter().find(|subject| subject.name == "fixed").unwrap();
    let mut seen = 0;
    for bundle in bundles().iter().filter_map(on_grid) {
        for (form, lanes) in
            [(Form::Packets, 4), (Form::Packets, 8), (Form::Packs, 4), (Form::Packs, 8)]
        {
            let (mut nearest, layout) = (Vec::new(), Layout { form, lanes });
            let bundles = std::slice::from_ref(&bundle);
            assert!(fixed.closest(Level::best(), bundles, layout, &mut nearest).is_some());
            for (ray, nearest) in bundle.rays.iter().zip(nearest) {
                // Nothing that is hit inside is nearer, and what was found is hit.
                for triangle in &bundle.triangles {
                    let exact = truth(triangle, ray);
                    if exact.is_hit() && exact.place == Place::Inside {
                        let t = exact_t(triangle, ray).unwrap().to_f64().value();
                        assert!(nearest.t <= t);
                        seen += 1;
                    }
                }
                if nearest != Nearest::MISS {
                    assert!(truth(&bundle.triangles[nearest.triangle as usize], ray).is_hit());
                }
            }
        }
    }
    assert!(seen > 1000, "{seen}");
}
