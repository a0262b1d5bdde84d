//! Tests document D: its example, its errors, and its weights, which are compared with document A.

use intertri_reference::cramer::{Corner, Trig, Viewpoint, calc_triangle, xor_pattern};
use intertri_reference::{Ray, Scene, Vector};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Returns the document's example, with its triangle at the given z instead of 0.
fn example(z: f64) -> Trig {
    calc_triangle([
        Corner::new([-1.0, 1.0, z], 0.0, 0.0),
        Corner::new([1.0, 1.0, z], 255.0, 0.0),
        Corner::new([1.0, -1.0, z], 255.0, 255.0),
    ])
}

/// Returns the number of pixels in the document's loop for which a test succeeds.
fn pixels(hit: impl Fn(Vector) -> bool) -> usize {
    let rows = (-100..100).flat_map(|y| (-160..160).map(move |x| (x, y)));
    rows.filter(|&(x, y)| hit(Vector::from([x as f32 / 100.0, y as f32 / 100.0, 1.0]))).count()
}

/// Applies the listing's test unchanged, so only triangles with a negative `t` are hit.
fn listing(view: &Viewpoint, dir: Vector) -> bool {
    let (u, v, d) = (view.u & dir, view.v & dir, view.d & dir);
    u + v < d && u >= 0.0 && v >= 0.0 && view.t_ap < 0.0
}

#[test]
fn the_listing_sees_behind_the_eye_and_the_example_nothing() {
    let eye = Vector::default();
    let count = |z| {
        let view = example(z).seen_from(eye);
        (pixels(|dir| listing(&view, dir)), pixels(|dir| view.inter(dir).is_some()))
    };
    assert_eq!(count(1.0), (0, 19_900), "in front of the eye");
    assert_eq!(count(-1.0), (20_100, 0), "behind the eye");
    assert_eq!(count(0.0), (0, 0), "in the eye's plane, as the document has it");
}

#[test]
fn coefficients_are_the_documents() {
    let trig = example(1.0);
    assert_eq!(trig.t, Vector::new(0.0, 0.0, -4.0));
    assert_eq!(trig.d, trig.t * -1.0);
    assert_eq!(trig.tu, Vector::new(0.0, 255.0, 255.0));
    assert_eq!(trig.tv, Vector::new(0.0, 0.0, 255.0));
    // The expected values are the determinants, written out for AP = (1, -1, -1), AB = (2, 0, 0),
    // AC = (2, -2, 0).
    let view = trig.seen_from(Vector::default());
    assert_eq!(view.u, Vector::new(2.0, 2.0, 0.0));
    assert_eq!(view.v, Vector::new(0.0, -2.0, 2.0));
    assert_eq!(view.t_ap, 4.0);
}

#[test]
fn the_edge_opposite_a_is_outside_and_the_others_inside() {
    let view = example(1.0).seen_from(Vector::default());
    let hit = |x, y| view.inter(Vector::new(x, y, 1.0)).is_some();
    assert!(hit(-1.0, 1.0), "A");
    assert!(hit(0.0, 1.0), "on AB");
    assert!(hit(0.0, 0.0), "on AC");
    assert!(!hit(1.0, 1.0) && !hit(1.0, -1.0) && !hit(1.0, 0.0), "B, C and BC");
    assert!(hit(1.0 - 1e-12, 1.0));
}

#[test]
fn one_side_alone_is_seen() {
    let from =
        |z, dz| example(0.0).seen_from(Vector::new(0.5, 0.5, z)).inter(Vector::new(0.0, 0.0, dz));
    assert_eq!(from(-3.0, 1.5).map(|m| m.t), Some(2.0));
    assert_eq!(from(3.0, -1.5), None, "from the other side");
    assert_eq!(from(-3.0, -1.5), None, "looking away");
    assert_eq!(from(0.0, 1.0), None, "from the plane itself");
}

#[test]
fn nan_and_no_area_are_misses() {
    let dir = Vector::new(0.1, 0.0, 1.0);
    let flat = calc_triangle(
        [[0.0, 0.0, 1.0], [1.0, 1.0, 1.0], [2.0, 2.0, 1.0]].map(|p| Corner::new(p, 0.0, 0.0)),
    );
    assert_eq!(flat.seen_from(Vector::default()).inter(dir), None);
    for i in 0..15 {
        let mut input =
            [-1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.1, 0.2, 1.0];
        let hit = |input: [f64; 15]| {
            let at = |k: usize| Vector::new(input[k], input[k + 1], input[k + 2]);
            let trig = calc_triangle([0, 3, 6].map(|k| Corner::new(at(k), 0.0, 0.0)));
            trig.seen_from(at(9)).inter(at(12)).is_some()
        };
        assert!(hit(input));
        input[i] = f64::NAN;
        assert!(!hit(input), "NaN in input {i}");
    }
}

#[test]
fn the_xor_pattern() {
    assert_eq!(xor_pattern(0.0, 0.0), 0);
    assert_eq!(xor_pattern(5.9, 3.0), 256 * 6);
    assert_eq!(xor_pattern(255.0, 0.99), 0xff00);
    assert_eq!(xor_pattern(-0.9, 0.9), 0, "rounded toward 0");
    assert_eq!(xor_pattern(-1.0, 0.0), -256);
    assert_eq!(xor_pattern(f64::NAN, 7.0), 256 * 7);
    assert_eq!(xor_pattern(1e300, 0.0), i32::MAX.wrapping_mul(256));
}

proptest! {
    // Test the same cases on every run.
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    /// Away from the edges, and seen from the front, hits and their t, u, and v match `inter_tri`.
    #[test]
    fn agrees_with_inter_tri(
        c in prop::array::uniform9(-1.0f32..1.0),
        p in prop::array::uniform3(-3.0f64..3.0),
        aim in (-0.5f64..1.5, -0.5f64..1.5),
    ) {
        let corners = [[c[0], c[1], c[2]], [c[3], c[4], c[5]], [c[6], c[7], c[8]]];
        let scene = Scene::from_triangles([corners]);
        let trig = calc_triangle(corners.map(|c| Corner::new(c, 0.0, 0.0)));
        let org = Vector::from(p);
        let (u, v) = aim;
        let dir = trig.a + trig.ab * u + trig.ac * v - org;
        let near = [u, v, 1.0 - u - v].iter().any(|w| w.abs() < 1e-6);
        prop_assume!(!near && trig.t.length() > 1e-2 && (scene.trian[0].nrm & dir).abs() > 1e-2);

        let ray = Ray { org, dir };
        let hit = scene.hit(0, &ray, 0.0, f64::INFINITY);
        let front = (trig.d & dir) > 0.0;
        let meeting = trig.seen_from(org).inter(dir);
        prop_assert_eq!(meeting.is_some(), hit.is_some() && front);
        if let (Some(meeting), Some(t)) = (meeting, hit) {
            let (u2, v2) = scene.barycentric(0, &ray);
            prop_assert!((meeting.t - t).abs() < 1e-9);
            prop_assert!((meeting.u - u2).abs() < 1e-9 && (meeting.u - u).abs() < 1e-9);
            prop_assert!((meeting.v - v2).abs() < 1e-9 && (meeting.v - v).abs() < 1e-9);
        }
    }

    /// Texture coordinates are interpolated between the corners.
    #[test]
    fn texture_mixes_the_corners(u in 0.0f64..1.0, v in 0.0f64..1.0) {
        let (tx, ty) = example(1.0).texture(u, v);
        prop_assert!((tx - 255.0 * (u + v)).abs() < 1e-10 && (ty - 255.0 * v).abs() < 1e-10);
    }
}
