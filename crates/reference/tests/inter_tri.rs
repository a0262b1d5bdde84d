//! Tests document A: typical hits and misses, and every edge case listed in the module's
//! documentation.

use intertri_reference::{IndexOutOfRange, Ray, Scene, THRESHOLD, Vector};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]];

fn scene() -> Scene {
    Scene::from_triangles([TRIANGLE])
}

fn down(x: f64, y: f64) -> Ray {
    Ray::new([x, y, 0.0], [0.0, 0.0, 1.0])
}

/// Returns the result of `inter_tri` and the value that it leaves in `t`, which starts at 42.
fn ask(scene: &Scene, ray: &Ray) -> (i32, f64) {
    let mut t = 42.0;
    (scene.inter_tri(0, ray, &mut t), t)
}

#[test]
fn tables_hold_what_the_document_names() {
    let trian = scene().trian[0];
    assert_eq!((trian.c1, trian.c2, trian.c3), (0, 1, 2));
    assert_eq!(trian.h4, Vector::new(1.0, 0.0, 0.0));
    assert_eq!(trian.h5, Vector::new(0.0, 1.0, 0.0));
    assert_eq!(trian.h6, Vector::new(-1.0, 1.0, 0.0));
    assert_eq!(trian.nrm, Vector::new(0.0, 0.0, 1.0));
}

#[test]
fn inside_edges_and_corners_are_hit_from_both_sides() {
    let inside =
        [[0.25, 0.25], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    for [x, y] in inside {
        assert_eq!(ask(&scene(), &down(x, y)), (1, 5.0), "from below at {x}, {y}");
        let above = Ray::new([x, y, 8.0], [0.0, 0.0, -2.0]);
        assert_eq!(ask(&scene(), &above), (1, 1.5), "from above at {x}, {y}");
    }
}

#[test]
fn each_edge_refuses_and_leaves_t_changed() {
    for [x, y] in [[0.5, -1e-12], [-1e-12, 0.5], [0.5, 0.5 + 1e-12]] {
        assert_eq!(ask(&scene(), &down(x, y)), (0, 5.0), "at {x}, {y}");
    }
}

#[test]
fn behind_the_origin_is_a_miss_that_leaves_t_changed() {
    let ray = Ray::new([0.25, 0.25, 7.0], [0.0, 0.0, 1.0]);
    assert_eq!(ask(&scene(), &ray), (0, -2.0));
}

#[test]
fn parallel_leaves_t_alone() {
    let ray = Ray::new([0.25, 0.25, 5.0], [1.0, 0.0, 0.0]);
    assert_eq!(ask(&scene(), &ray), (0, 42.0));
}

#[test]
fn threshold_is_open_for_parallel_and_for_t() {
    // A |vd| equal to the threshold does not count as parallel; the next smaller value does.
    let with_dz = |dz: f64| ask(&scene(), &Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, dz]));
    assert_eq!(with_dz(THRESHOLD).0, 1);
    assert_eq!(with_dz(-THRESHOLD), (0, 5.0 / -THRESHOLD));
    assert_eq!(with_dz(THRESHOLD.next_down()), (0, 42.0));
    assert_eq!(with_dz(-THRESHOLD.next_down()), (0, 42.0));
    // A t equal to the threshold is not a hit; the next larger value is.
    let plane = Scene::from_triangles([TRIANGLE.map(|[x, y, _]| [x, y, 0.0])]);
    let from = |z: f64| ask(&plane, &Ray::new([0.25, 0.25, z], [0.0, 0.0, 1.0])).0;
    assert_eq!(from(-THRESHOLD), 0);
    assert_eq!(from(-THRESHOLD.next_up()), 1);
    // The normal has unit length, so even a tiny triangle does not count as parallel.
    let tiny = Scene::from_triangles([TRIANGLE.map(|[x, y, z]| [x * 1e-20, y * 1e-20, z])]);
    assert_eq!(ask(&tiny, &down(1e-21, 1e-21)), (1, 5.0));
}

#[test]
fn without_area_is_parallel_to_everything() {
    let p = [0.0, 0.0, 5.0f32];
    let q = [1.0, 2.0, 5.0f32];
    let middle = [0.5, 1.0, 5.0f32];
    for triangle in [[p; 3], [p, p, q], [p, q, p], [q, p, p], [p, middle, q], [q, p, middle]] {
        let scene = Scene::from_triangles([triangle]);
        assert_eq!(scene.trian[0].nrm, Vector::default());
        assert_eq!(ask(&scene, &down(0.0, 0.0)), (0, 42.0), "{triangle:?}");
        // With a threshold of 0, nothing is parallel, but the last line rejects t = NaN.
        let (answer, t) = ask(&scene.with_threshold(0.0), &down(0.0, 0.0));
        assert!(answer == 0 && t.is_nan(), "{triangle:?}");
    }
}

#[test]
fn nan_passes_every_test_but_the_last() {
    for i in 0..6 {
        let mut ray = [0.25, 0.25, 0.0, 0.0, 0.0, 1.0];
        ray[i] = f64::NAN;
        let ray = Ray::new([ray[0], ray[1], ray[2]], [ray[3], ray[4], ray[5]]);
        let (answer, t) = ask(&scene(), &ray);
        assert!(answer == 0 && t.is_nan(), "NaN in input {i} of the ray");
    }
    for i in 0..9 {
        let mut triangle = TRIANGLE;
        triangle[i / 3][i % 3] = f32::NAN;
        let (answer, t) = ask(&Scene::from_triangles([triangle]), &down(0.25, 0.25));
        assert!(answer == 0 && t.is_nan(), "NaN in input {i} of the triangle");
    }
    // The edge tests do let NaN through: with a finite t, only they could reject this point.
    let mut broken = scene();
    broken.trian[0].h4.x = f64::NAN;
    broken.trian[0].h5.x = f64::NAN;
    broken.trian[0].h6.x = f64::NAN;
    assert_eq!(ask(&broken, &down(7.0, 7.0)), (1, 5.0));
    // A NaN threshold rejects everything, but only after `t` has been written.
    assert_eq!(ask(&scene().with_threshold(f64::NAN), &down(0.25, 0.25)), (0, 5.0));
}

#[test]
fn t_can_overflow_to_a_hit_at_infinity_that_no_interval_contains() {
    let far = Scene::new(
        vec![[0.0, 0.0, 1e300].into(), [1.0, 0.0, 1e300].into(), [0.0, 1.0, 1e300].into()],
        [[0, 1, 2]],
    );
    let far = far.unwrap().with_threshold(0.0);
    let ray = Ray::new([0.0; 3], [0.0, 0.0, 1e-300]);
    assert_eq!(ask(&far, &ray), (1, f64::INFINITY));
    assert_eq!(far.closest(&ray, 0.0, f64::INFINITY), None);
    assert!(!far.any(&ray, 0.0, f64::INFINITY));
    assert!(far.all(&ray, 0.0, f64::INFINITY).is_empty());
}

#[test]
fn infinite_inputs_are_never_hit() {
    for infinity in [f32::INFINITY, f32::NEG_INFINITY] {
        for i in 0..15 {
            let mut input =
                [0.0, 0.0, 5.0, 1.0, 0.5, 5.0, 0.5, 1.0, 5.5, 0.1, 0.05, 0.0, 0.1, 0.1, 1.0];
            let at = |n: [f32; 15], k: usize| [n[k], n[k + 1], n[k + 2]];
            let ask = |n: [f32; 15]| {
                let scene = Scene::from_triangles([[at(n, 0), at(n, 3), at(n, 6)]]);
                let ray = Ray::new(at(n, 9), at(n, 12));
                [1e-9, 0.0].map(|threshold| {
                    scene.clone().with_threshold(threshold).any(
                        &ray,
                        f64::NEG_INFINITY,
                        f64::INFINITY,
                    )
                })
            };
            assert_eq!(ask(input), [true; 2]);
            input[i] = infinity;
            assert_eq!(ask(input), [false; 2], "{infinity} in input {i}");
        }
    }
}

#[test]
fn an_index_out_of_range_is_an_error_that_says_where() {
    let vertx = || TRIANGLE.map(Vector::from).to_vec();
    assert_eq!(Scene::new(vertx(), [[0, 1, 2]]).unwrap(), scene());
    let error = Scene::new(vertx(), [[0, 1, 2], [2, 3, 9]]).unwrap_err();
    assert_eq!(error, IndexOutOfRange { triangle: 1, index: 3, vertices: 3 });
    let text = "triangle 1 refers to vertex 3, but there are 3 vertices, numbered from 0";
    assert_eq!(error.to_string(), text);
    assert!(Scene::new(Vec::new(), [[0, 0, 0]]).is_err());
    assert!(Scene::new(Vec::new(), []).is_ok());
}

proptest! {
    // Test the same cases on every run.
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    /// `(u, v)` and `t` describe the same point, even if it is outside the triangle.
    #[test]
    fn barycentric_weights_rebuild_the_point(
        c in prop::array::uniform9(-1.0f32..1.0),
        org in prop::array::uniform3(-5.0f64..5.0),
        target in prop::array::uniform3(-2.0f64..2.0),
    ) {
        let scene = Scene::from_triangles([[[c[0], c[1], c[2]], [c[3], c[4], c[5]], [c[6], c[7], c[8]]]]);
        let ray = Ray { org: org.into(), dir: Vector::from(target) - Vector::from(org) };
        let tmp = scene.trian[0];
        let mut t = f64::NAN;
        scene.inter_tri(0, &ray, &mut t);
        prop_assume!((tmp.h4 ^ tmp.h5).length() > 1e-2 && (tmp.nrm & ray.dir).abs() > 1e-2);
        let (u, v) = scene.barycentric(0, &ray);
        let there = scene.vertx[tmp.c1] + tmp.h4 * u + tmp.h5 * v;
        let here = ray.org + ray.dir * t;
        prop_assert!((there - here).length() < 1e-8 * (1.0 + here.length()), "{here:?} {there:?}");
    }

    /// The weights match those of the point that the ray aims at.
    #[test]
    fn barycentric_weights_are_those_of_the_aim(u in 0.0f64..1.0, v in 0.0f64..1.0, flip: bool) {
        let scene = scene();
        let z = if flip { 9.0 } else { -1.0 };
        let ray = Ray::new([0.3, -0.2, z], [u - 0.3, v + 0.2, 5.0 - z]);
        let (u2, v2) = scene.barycentric(0, &ray);
        prop_assert!((u - u2).abs() < 1e-14 && (v - v2).abs() < 1e-14, "{u2} {v2}");
    }

    /// Away from the edges, the result matches the signs of the exact weights.
    #[test]
    fn hits_are_where_the_weights_say(x in -1.0f64..2.0, y in -1.0f64..2.0) {
        prop_assume!([x, y, 1.0 - x - y].iter().all(|w| w.abs() > 1e-12));
        let inside = x > 0.0 && y > 0.0 && x + y < 1.0;
        prop_assert_eq!(ask(&scene(), &down(x, y)), (i32::from(inside), 5.0));
    }
}
