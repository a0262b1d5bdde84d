//! Tests intersections of f32 rays and triangles: every kind of pair that `cases` generates, and
//! cases in which the hit, the order of hits, or the rounding of t is hard to get right.

use intertri::internal::exact::{self, t};
use intertri::{Crossing, Hit, Hit32, Mode, Ray, Ray64, RayOf, Rule, Triangle, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_tests::oracle::truth;
use intertri_trace::{Bvh, BvhScalar};

use super::cases::{KINDS, case};
use crate::common::compare::Cases;

const CASES: Cases<f32> = Cases { kinds: KINDS, case };

#[test]
fn every_tier_agrees_with_rationals() {
    CASES.agree(80_000);
}

/// Run this test by hand:
/// `cargo test --release -p intertri-tests exact::pairs -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn a_hundred_million_pairs_agree_with_rationals() {
    CASES.agree_for_hours();
}

/// In f64, the normal of this triangle rounds to 0, but the triangle is not degenerate, so rays hit
/// it.
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

/// If two hits have values of t that round to the same f64, they are ordered by exact t, not by
/// index.
#[test]
fn equal_rounded_t_are_told_apart() {
    // The ray passes through the centroid, so t is the mean of the three heights.
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

/// Returns a ray and a triangle that it meets at t = `1 + k 2^-24 + tiny`. For odd k, this value is
/// almost halfway between two f32 numbers, and f64 cannot distinguish it from the midpoint.
fn near_half_way(k: u16, tiny: f32) -> (Ray, Triangle) {
    // t is the mean of the three heights.
    let heights = [0.5 + 3.0 * f32::from(k) * 2.0_f32.powi(-24), 3.0 * tiny, 2.5];
    let corners = [[-1.0, -1.0], [2.0, -1.0], [-1.0, 2.0]];
    let corner = |i: usize| [corners[i][0], corners[i][1], heights[i]];
    (Ray::new([0.0; 3], [0.0, 0.0, 1.0]), Triangle([0, 1, 2].map(corner)))
}

/// Traces a ray in a bundle, in a batch of its own, and by a single call, and returns the hits.
fn hits32<S: BvhScalar>(bvh: &Bvh<S>, ray: &RayOf<S>) -> Vec<Hit32> {
    let mut hits = vec![Hit32::MISS; 2001];
    bvh.query().closest_batch_into(&[*ray; 2000], &mut hits[..2000]);
    bvh.query().closest_batch_into(&[*ray], &mut hits[2000..]);
    hits.extend(bvh.query().closest32(ray));
    assert_eq!(hits.len(), 2002);
    hits
}

/// If t were rounded first to f64 and then to f32, the second and third cases would yield a
/// neighbour of the correct f32.
#[test]
fn what_f64_rounds_to_half_way_is_rounded_once() {
    let tiny = 2.0_f32.powi(-70);
    let wide = |x: f32| f64::from(x);
    for (k, tiny, t) in [
        (1, -tiny, 1.0),
        (1, tiny, 1.0 + f32::EPSILON),
        (3, -tiny, 1.0 + f32::EPSILON),
        (3, 0.0, 1.0 + 2.0 * f32::EPSILON),
    ] {
        let (ray, triangle) = near_half_way(k, tiny);
        assert!(truth(&ray, &triangle).unwrap().are_rounded_to_f32([t, 1.0 / 3.0, 1.0 / 3.0]));
        let bvh = Bvh::new(&[triangle]).unwrap();
        assert!(hits32(&bvh, &ray).iter().all(|hit| hit.t == t), "{k} {tiny}");
        let bvh = Bvh::new(&[TriangleOf(triangle.0.map(|corner| corner.map(wide)))]).unwrap();
        let ray = Ray64::new(ray.origin.map(wide), ray.dir.map(wide));
        assert!(hits32(&bvh, &ray).iter().all(|hit| hit.t == t), "{k} {tiny} in f64");
    }
}

/// Bundles, streams, and single rays must round only once, even if coordinates are so large or so small that t, u
/// or v are outside the range of f32.
#[test]
fn batches_round_once_to_f32() {
    let mut rng = Rng::new(5);
    let mut compared = 0;
    for round in 0..60 {
        let scale = [1.0, 2.0_f32.powi(-60), 2.0_f32.powi(40), 1e-3][round % 4];
        let mut number = || rng.signed() as f32;
        let mut point = |size: f32| [size * number(), size * number(), size * number()];
        let mut triangles: Vec<Triangle> = (0..200)
            .map(|_| {
                let at = point(scale);
                Triangle([(); 3].map(|()| {
                    let by = point(0.2 * scale);
                    [0, 1, 2].map(|k| at[k] + by[k])
                }))
            })
            .collect();
        let eye = point(2.0 * scale);
        let size = [1.0, 2.0_f32.powi(-80), 2.0_f32.powi(90)][round % 3];
        let mut rays: Vec<Ray> = (0..1500)
            .map(|_| {
                let to = point(scale);
                Ray::new(eye, [0, 1, 2].map(|k| size * ((to[k] - eye[k]) / scale)))
            })
            .collect();
        rays.extend((0..500).map(|_| Ray::new(point(scale), point(size))));
        if round % 2 == 0 {
            // Meet edges exactly, so that weights are 0: at their midpoints, on a grid.
            let grid = |x: f32| (x / scale * 64.0).round() * 2.0 * scale;
            triangles
                .iter_mut()
                .flat_map(|triangle| &mut triangle.0)
                .for_each(|c| *c = c.map(grid));
            let eye = eye.map(grid);
            rays.extend(triangles.iter().flat_map(|Triangle([a, b, c])| {
                [(a, b), (b, c), (c, a)].map(|(p, q)| {
                    Ray::new(eye, [0, 1, 2].map(|k| 0.5 * p[k] + 0.5 * q[k] - eye[k]))
                })
            }));
        }
        let bvh = Bvh::new(&triangles).unwrap();
        let mut hits = vec![Hit32::MISS; rays.len()];
        bvh.query().closest_batch_into(&rays, &mut hits);
        for ((ray, hit), closest) in rays.iter().zip(&hits).zip(bvh.closest_batch(&rays)) {
            assert_eq!(hit.triangle, closest.triangle);
            assert_eq!(bvh.query().closest32(ray).unwrap_or(Hit32::MISS), *hit, "{ray:?}");
            if hit.is_hit() {
                let truth = truth(ray, &triangles[hit.triangle as usize]).unwrap();
                assert!(truth.are_rounded_to_f32([hit.t, hit.u, hit.v]), "{ray:?} {hit:?}");
                compared += 1;
            }
        }
    }
    assert!(compared > 10_000, "{compared}");
}
