//! Worked examples: compares each method's answers with results computed by hand.

use intertri::simd::Vec3;
use intertri::{Ray, Triangle};

use intertri_lab::methods::Intersector;
use intertri_lab::methods::badouel::Badouel;
use intertri_lab::methods::baldwin_weber::BaldwinWeber;
use intertri_lab::methods::cramer::Cramer;
use intertri_lab::methods::embree::{EdgeForm, Robust};
use intertri_lab::methods::inter_tri::InterTri;
use intertri_lab::methods::moller_trumbore::MollerTrumbore;
use intertri_lab::methods::pluecker::Pluecker;
use intertri_lab::methods::signed_volume::SignedVolume;
use intertri_lab::methods::woop::Woop;
use intertri_lab::oracle;

/// Tests one ray against one triangle, with scalars in place of lanes.
fn ask<M: Intersector>(
    intersector: M,
    corners: [[f64; 3]; 3],
    origin: [f64; 3],
    dir: [f64; 3],
) -> (bool, f64) {
    let vec3 = |[x, y, z]: [f64; 3]| Vec3 { x, y, z };
    intersector
        .test(&intersector.triangle(corners.map(vec3)), &intersector.ray(vec3(origin), vec3(dir)))
}

/// A slanted triangle whose sides make computations by hand easy. The ray from (1, 1, 1) meets
/// `c1 + u (c2 - c1) + v (c3 - c1)` at u = 1/4, v = 1/2, and t = 3.
const CORNERS: [[f64; 3]; 3] = [[2.0, 3.0, 4.0], [6.0, 3.0, 8.0], [4.0, 9.0, 4.0]];
const ORIGIN: [f64; 3] = [1.0, 1.0, 1.0];
const DIR: [f64; 3] = [1.0, 5.0 / 3.0, 4.0 / 3.0];

/// Checks one method on the worked example: the hit and its t from both sides of the triangle, and
/// misses all around the triangle.
fn worked_example<M: Intersector>(intersector: M) {
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
        let (hit, t) = ask(intersector, corners, ORIGIN, DIR);
        assert!(hit && (t - 3.0).abs() < 1e-14, "{hit} {t}");
        for (u, v, inside) in [
            (0.01, 0.5, true),
            (0.5, 0.01, true),
            (0.49, 0.5, true),
            (-0.01, 0.5, false),
            (0.5, -0.01, false),
            (0.51, 0.5, false),
        ] {
            let (hit, t) = ask(intersector, corners, ORIGIN, at(u, v));
            assert!(hit == inside && (!hit || (t - 3.0).abs() < 1e-13), "{u} {v}: {hit} {t}");
        }
        // Misses: a triangle behind the ray, a parallel ray, a triangle with zero area, and a NaN.
        assert!(!ask(intersector, corners, ORIGIN, DIR.map(|x| -x)).0);
        assert!(!ask(intersector, corners, ORIGIN, [4.0, 0.0, 4.0]).0);
        assert!(!ask(intersector, [c1, c2, c1], ORIGIN, DIR).0);
        assert!(!ask(intersector, corners, [f64::NAN, 1.0, 1.0], DIR).0);
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
    // The determinant is twice the triangle's area projected along the direction. For these
    // triangles, it equals the length of the second side.
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
    // 8193 * 8191 = 8192 * 8192 - 1, but both products are the same in f32. The ray therefore seems
    // to pass exactly through the side from b to c and to hit the triangles on both sides of it. In
    // f64, the products differ, and the ray hits only one of the triangles.
    let (b, c) = ([8192.0, 8191.0, 1.0], [-8193.0, -8192.0, 1.0]);
    let vec3 = |[x, y, z]: [f32; 3]| Vec3 { x, y, z };
    for (y, is_hit) in [(10.0, true), (-10.0, false)] {
        let triangle = Triangle([[0.0, y, 1.0], b, c]);
        let ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
        assert_eq!(oracle::answer(&triangle, &ray).is_hit(), is_hit);
        for (fall_back, hit) in [(true, is_hit), (false, true)] {
            let woop = Woop { fall_back };
            let ray = woop.ray(vec3(ray.origin), vec3(ray.dir));
            assert_eq!(woop.test(&woop.triangle(triangle.0.map(vec3)), &ray).0, hit);
        }
    }
}
