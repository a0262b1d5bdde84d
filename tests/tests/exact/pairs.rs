//! Pairs of every kind in f32, and two that are hard in their own ways.

use intertri::internal::exact::{self, t};
use intertri::{Crossing, Hit, Mode, Ray, Rule, Triangle};
use intertri_trace::Bvh;

use super::cases::{KINDS, case};
use crate::common::compare::Cases;

const CASES: Cases<f32> = Cases { kinds: KINDS, case };

#[test]
fn every_tier_agrees_with_rationals() {
    CASES.agree(80_000);
}

/// By hand: `cargo test --release -p intertri-tests exact::pairs -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn a_hundred_million_pairs_agree_with_rationals() {
    CASES.agree_for_hours();
}

/// An f64 product of the edges of this triangle rounds, and the normal is 0; but it has an area, and is hit.
#[test]
fn a_triangle_without_an_f64_normal_is_hit() {
    let [a, b, c] = [[2.320_720_7e-9, 2.320_721_2e-9], [1.705_962; 2], [3.411_924; 2]];
    let triangle = Triangle([a, b, c].map(|[x, y]: [f32; 2]| [x, y, 0.0]));
    assert_eq!(triangle.normal(), [0.0; 3]);
    for [x, y, z] in triangle.0 {
        assert!(exact::hit(Rule::Closed, &Ray::new([x, y, z - 1.0], [0.0, 0.0, 1.0]), &triangle));
        assert!(exact::hit(Rule::Closed, &Ray::new([x, y, z + 1.0], [0.0, 0.0, -1.0]), &triangle));
    }
}

/// Two t that round to the same f64: every ordering is by the exact t, not by the indices.
#[test]
fn equal_rounded_t_are_told_apart() {
    // Through the middle of both: t is the mean of the three heights.
    let at = |z: f32| {
        let heights = [1.0, 2.0_f32.powi(-30), z];
        let corners = [[-1.0, -1.0], [2.0, -1.0], [-1.0, 2.0]];
        Triangle([0, 1, 2].map(|i| [corners[i][0], corners[i][1], heights[i]]))
    };
    let triangles = [at(2.0_f32.powi(-60)), at(2.0_f32.powi(-61)), at(2.0_f32.powi(-61))];
    let ray = Ray::new([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert!(triangles.iter().all(|triangle| t(&ray, triangle) == t(&ray, &triangles[0])));
    let (mode, bvh) = (Mode::exact(), Bvh::new(&triangles).unwrap());
    let numbers = |hits: Vec<Hit>| hits.iter().map(|hit| hit.triangle).collect::<Vec<_>>();
    let crossings = |all: Vec<Crossing>| numbers(all.iter().map(|one| one.hit).collect());
    assert_eq!(numbers(mode.all(&triangles, &ray)), [1, 2, 0]);
    assert_eq!(numbers(bvh.all(&ray)), [1, 2, 0]);
    assert_eq!(crossings(mode.crossings(&triangles, &ray)), [1, 2, 0]);
    assert_eq!(crossings(bvh.crossings(&ray)), [1, 2, 0]);
    let mut hits = bvh.closest_batch(&vec![ray; 2000]);
    hits[0] = mode.closest(&triangles, &ray).unwrap();
    hits[1] = bvh.closest(&ray).unwrap();
    assert!(hits.iter().all(|hit| hit.triangle == 1));
}
