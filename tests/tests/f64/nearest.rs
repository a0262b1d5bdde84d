//! Compares closest-point queries in f64 with rational arithmetic: pairs at every tier, the bounds
//! computed in SIMD lanes, meshes of all sizes and at all positions, and the sign of the distance.

use dashu_ratio::RBig;
use intertri::internal::exact::{Tier, closer_from, closest, has_area, squares};
use intertri::simd::Vec3;
use intertri::{Triangle64, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_trace::{Bvh, ClosestPoint, Containment, Solid};

use super::hierarchy::soup;
use crate::nearest::flatten;
use crate::nearest::truth::{is_rounded, is_within_one_ulp, truth};

const KINDS: usize = 9;

/// Generates a number of the given kind: a small integer, one with all digits, one far from 0, one
/// from a wide range of exponents, a subnormal one, a huge one, one that is either small or far
/// from 0, one with any exponent, or an f32.
fn number(kind: usize, rng: &mut Rng) -> f64 {
    let unit = rng.signed();
    match kind {
        0 => (unit * 2.5).round(),
        1 => unit,
        2 => 528_980.0 + unit,
        3 => unit * 2.0_f64.powi(rng.within(300)),
        4 => f64::from_bits((rng.unit() * 40.0) as u64),
        5 => unit * f64::MAX,
        6 => 1e12 * f64::from(rng.within(1)) + unit,
        7 => unit * 2.0_f64.powi(rng.within(1000)),
        _ => f64::from(unit as f32),
    }
}

fn point(kind: usize, rng: &mut Rng) -> [f64; 3] {
    [(); 3].map(|()| number(kind, rng))
}

/// Generates a triangle, which is sometimes a needle or degenerate.
fn triangle(kind: usize, rng: &mut Rng) -> Triangle64 {
    let mut t = TriangleOf([(); 3].map(|()| point(kind, rng)));
    if rng.unit() < 0.25 {
        flatten(&mut t.0, rng.unit());
    } else if rng.unit() < 0.2 {
        let share = rng.unit();
        t.0[2] = [0, 1, 2].map(|k| t.0[0][k] * (1.0 - share) + t.0[1][k] * share);
        let k = rng.below(3);
        t.0[2][k] = if rng.one_in(2) { t.0[2][k].next_up() } else { t.0[2][k] };
    }
    t
}

/// Generates a point at an arbitrary position, at a corner, on an edge, near a face, or beyond a
/// corner.
fn point_near(kind: usize, t: &Triangle64, rng: &mut Rng) -> [f64; 3] {
    let [a, b, c] = t.0;
    let (u, v) = (rng.unit(), rng.unit());
    match rng.below(6) {
        0 => a,
        1 => [0, 1, 2].map(|k| a[k] * (1.0 - u) + b[k] * u),
        2 => [0, 1, 2].map(|k| a[k] * (1.0 - u - v) + b[k] * u + c[k] * v),
        3 => [0, 1, 2].map(|k| b[k] * 2.0 - a[k]),
        _ => point(kind, rng),
    }
}

#[test]
fn every_tier_is_right_of_every_pair() {
    let (mut pairs, mut ties, mut ends, mut flat) = (0, 0, 0, 0);
    for i in 0..9_000_u64 {
        let (mut rng, kind) = (Rng::new(i), i as usize % KINDS);
        let (one, mut other) = (triangle(kind, &mut rng), triangle(kind, &mut rng));
        if i % 3 == 0 {
            // Let the two triangles share an edge or a corner.
            other.0[0] = one.0[1];
            other.0[1] = if i % 2 == 0 { one.0[0] } else { other.0[1] };
        }
        let point = point_near(kind, &one, &mut rng);
        let finite = |t: &Triangle64| t.0.as_flattened().iter().all(|x| x.is_finite());
        if !(point.iter().all(|x| x.is_finite()) && finite(&one) && finite(&other)) {
            continue;
        }
        let (first, second) = (truth(point, &one), truth(point, &other));
        pairs += 1;
        flat += usize::from(!has_area(&one));
        ties += usize::from(first.0 == second.0);
        let mut answers = vec![];
        for &tier in Tier::all::<f64>() {
            let what = || format!("{tier:?}: {point:?}, {one:?}, {other:?}");
            let order = closer_from(tier, point, &one, &other);
            assert_eq!(order, first.0.cmp(&second.0), "{}", what());
            let found = closest(tier, point, &one);
            assert!(is_within_one_ulp(found.distance, &first.0), "{}: {found:?}", what());
            for (weight, exact) in found.weights.iter().zip(&first.1) {
                assert!(is_rounded(*weight, exact), "{}: {found:?}", what());
            }
            ends += usize::from(!(1e-300..1e300).contains(&found.distance));
            answers.push(found);
        }
        // Every tier must return the same bits.
        assert!(answers.iter().all(|found| found == &answers[0]), "{answers:?}");

        // Check the bounds computed in lanes, if the coordinates are within the range of the
        // search: the points must be within 2^400 of triangles whose size is about 1.
        if matches!(kind, 0..=2 | 6 | 8) {
            let bounds = squares(one.0.map(Vec3::<f64>::splat), Vec3::splat(point));
            let bound = |x: f64| RBig::try_from(x).unwrap();
            assert!(bound(bounds.least) <= first.0, "{point:?}, {one:?}: {}", bounds.least);
            let above = bounds.most.is_infinite() || bound(bounds.most) >= first.0;
            assert!(above, "{point:?}, {one:?}: {}", bounds.most);
        }
    }
    let counts = format!("{pairs} pairs, {ties} ties, {ends} ends, {flat} with zero area");
    assert!(pairs > 6000 && ties > 600 && ends > 100 && flat > 1000, "{counts}");
}

/// Checks the position of the closest point. Its error must be at most `2^-50` times the largest
/// coordinate plus `2^-1073`, and it must be inside the triangle's box.
fn check_point(point: [f64; 3], triangle: &Triangle64, answer: &ClosestPoint, name: &str) {
    let exact = |x: f64| RBig::try_from(x).unwrap();
    let (_, [u, v]) = truth(point, triangle);
    let largest = triangle.0.as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let off = exact(largest) * exact(2.0_f64.powi(-50)) + exact((-1073.0_f64).exp2());
    for axis in 0..3 {
        let [a, b, c] = triangle.0.map(|corner| corner[axis]);
        let at = exact(a) * (RBig::ONE - &u - &v) + exact(b) * &u + exact(c) * &v;
        let found = answer.point[axis];
        let near = exact(found) - &at <= off && at - exact(found) <= off;
        let is_in = a.min(b).min(c) <= found && found <= a.max(b).max(c);
        assert!(near && is_in, "{name}: {answer:?} of {triangle:?}");
    }
}

/// Compares the distances with the smallest distance to any triangle, computed in rational
/// arithmetic. Returns the number of points that have a closest point.
fn check(name: &str, triangles: &[Triangle64], points: &[[f64; 3]]) -> usize {
    let bvh = Bvh::new(triangles).unwrap();
    let mut answers = vec![ClosestPoint::NONE; points.len()];
    bvh.closest_point_batch_into(points, f64::INFINITY, &mut answers);
    let finite = |t: &Triangle64| t.0.as_flattened().iter().all(|x| x.is_finite());
    for (&point, answer) in points.iter().zip(&answers) {
        let there = (0..triangles.len()).filter(|&i| finite(&triangles[i]));
        let best = there.map(|i| (truth(point, &triangles[i]).0, i)).min();
        let found = answer.some().map(|closest| closest.triangle as usize);
        assert_eq!(found, best.as_ref().map(|best| best.1), "{name}: {point:?}");
        if let Some((square, i)) = best {
            assert!(is_within_one_ulp(answer.distance, &square), "{name}: {answer:?}");
            check_point(point, &triangles[i], answer, name);
        }
        assert_eq!(bvh.closest_point(point, f64::INFINITY), answer.some());
        // A search within this distance must find the point, and a search within a smaller distance
        // must not.
        let within = bvh.closest_point(point, answer.distance);
        assert_eq!(within, answer.some(), "{name}: within {}", answer.distance);
        if answer.distance > 0.0 && answer.distance < f64::INFINITY {
            assert_eq!(bvh.closest_point(point, answer.distance.next_down()), None, "{name}");
        }
    }
    answers.iter().filter(|answer| answer.some().is_some()).count()
}

#[test]
fn meshes_are_asked_as_a_plain_loop() {
    for kind in 0..KINDS {
        let mut rng = Rng::new(100 + kind as u64);
        let triangles: Vec<Triangle64> = (0..60).map(|_| triangle(kind, &mut rng)).collect();
        let points: Vec<[f64; 3]> = (0..50)
            .map(|i| point_near(kind, &triangles[i % 60], &mut rng))
            .filter(|p| p.iter().all(|x| x.is_finite()))
            .collect();
        assert!(check(&format!("kind {kind}"), &triangles, &points) > 20);
    }
}

/// Tests scenes of all sizes and positions, with points nearby and at the limits of the exponents.
#[test]
fn scenes_of_any_size_anywhere() {
    let mut rng = Rng::new(3);
    let sizes = [(1.0, 0.0), (1e-6, 1e3), (30.0, 5e6), (1e-310, 0.0), (1e300, 0.0), (1e-3, 1e12)];
    for (scale, moved) in sizes {
        let triangles = soup(120, 0.05, scale, moved, &mut rng);
        let mut points: Vec<[f64; 3]> = (0..30)
            .map(|_| rng.cube().map(|x| x * scale * 1.5 + moved))
            .chain((0..10).map(|i| triangles[7 * i].0[i % 3]))
            .collect();
        points.extend([[0.0; 3], [f64::MAX, -1.0, 1e-320], [1e150, 1e200, -1e100], [1e40; 3]]);
        let found = check(&format!("{scale} at {moved}"), &triangles, &points);
        assert_eq!(found, points.len());
    }
}

/// Tests points one nanometre from a wall at UTM coordinates, on either side of the wall and on it.
#[test]
fn a_nanometre_is_told_at_utm() {
    let [x, y] = [148_376.0, 528_980.0];
    let corner = |i: usize| [0, 1, 2].map(|k| [x, y, 0.0][k] + 4.0 * f64::from(i as u32 >> k & 1));
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let cube: Vec<Triangle64> = faces
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]].map(|t| TriangleOf(t.map(corner))))
        .collect();
    let solid = Solid::new(&cube).unwrap();
    let at = |d: f64| [x + d, y + 1.0, 1.0];
    for d in [1e-9, 1e-6, 0.25] {
        let point = at(d);
        let inside = solid.signed_distance(point);
        assert_eq!((inside, solid.classify(point)), (x - point[0], Containment::Inside(1)));
        let point = at(-d);
        assert_eq!(solid.signed_distance(point), x - point[0]);
    }
    assert!(
        solid.signed_distance(at(0.0)) == 0.0 && solid.classify(at(0.0)) == Containment::Surface
    );
    assert!(solid.signed_distance([f64::NAN, 0.0, 0.0]).is_nan());
    let closest = solid.bvh().closest_point(at(-1e-6), f64::INFINITY).unwrap();
    assert_eq!(closest.point, at(0.0));
    assert!(has_area(&cube[closest.triangle as usize]));
}
