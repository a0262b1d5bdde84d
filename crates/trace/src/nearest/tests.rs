//! Tests that closest-point queries return the same results as a plain loop in integer arithmetic.

use std::cmp::Ordering;

use intertri::Triangle;
use intertri::internal::exact::{Tier, closer_from, closest};

use crate::util::test_numbers::random;
use crate::{Bvh, ClosestPoint, Containment, Solid};

/// Returns the reference result from a plain loop in integer arithmetic.
fn plain(triangles: &[Triangle], point: [f32; 3], radius: f64) -> Option<(u32, f64, [f64; 2])> {
    let finite = |t: &Triangle| t.0.as_flattened().iter().all(|x| x.is_finite());
    let mut best: Option<usize> = None;
    for (i, t) in triangles.iter().enumerate().filter(|(_, t)| finite(t)) {
        let is_closer = best.is_none_or(|best| {
            closer_from(Tier::Wide, point, t, &triangles[best]) == Ordering::Less
        });
        best = if is_closer { Some(i) } else { best };
    }
    let best = best?;
    let found = closest(Tier::Wide, point, &triangles[best]);
    (found.distance <= radius).then_some((best as u32, found.distance, found.weights))
}

fn assert_plain(triangles: &[Triangle], points: &[[f32; 3]], radius: f64) -> usize {
    let bvh = Bvh::new(triangles).unwrap();
    let mut answers = vec![ClosestPoint::NONE; points.len()];
    bvh.closest_point_batch_into(points, radius, &mut answers);
    let mut found = 0;
    for (&point, answer) in points.iter().zip(&answers) {
        let expected = plain(triangles, point, radius);
        let got = answer.some().map(|c| (c.triangle, c.distance, [c.u, c.v]));
        assert_eq!(got, expected, "{point:?}");
        assert_eq!(bvh.closest_point(point, radius), answer.some());
        found += usize::from(got.is_some());
    }
    found
}

/// Compares the results for random points and triangles with the reference: on a small grid, where
/// many distances are equal; at extreme exponents; and at arbitrary coordinates.
#[test]
fn it_is_the_plain_loop() {
    let mut number = random();
    let mut found = 0;
    for round in 0..60 {
        let scale = match round % 6 {
            0..3 => 1.0,
            3 => 1e-37,
            4 => 1e36,
            _ => 1e-44,
        };
        let size = [3.0, 5.0, 1e7][round % 3];
        let mut coordinate = || ((number() * size) as i32 as f32 - size / 2.0) * scale;
        let mut point = || [coordinate(), coordinate(), coordinate()];
        let mut triangles: Vec<Triangle> =
            (0..40).map(|_| Triangle([point(), point(), point()])).collect();
        // Make some triangles degenerate: points and segments, alone and mixed with others.
        for t in triangles.iter_mut().step_by([1, 3, 7][round % 3]) {
            t.0[2] = t.0[round % 2];
            t.0[1] = if round % 4 == 0 { t.0[0] } else { t.0[1] };
        }
        if round % 4 == 0 {
            triangles[3].0[0][0] = f32::NAN;
        }
        let mut points: Vec<[f32; 3]> = (0..60).map(|_| point()).collect();
        points.push(triangles[7].0[1]);
        let radius = if round % 5 == 0 { f64::from(scale) } else { f64::INFINITY };
        found += assert_plain(&triangles, &points, radius);
    }
    assert!(found > 2500, "{found}");
}

/// Queries a sphere from afar, from nearby, and from inside. All triangles are about equally close
/// to its centre.
#[test]
fn balls_far_and_near() {
    use std::f32::consts::PI;
    let rings = 12;
    let corner = |i: usize, j: usize| {
        let (a, b) = (PI * i as f32 / 12.0, PI * (j % 24) as f32 / 12.0);
        [a.sin() * b.cos(), a.cos(), a.sin() * b.sin()]
    };
    let squares = (0..rings).flat_map(|i| (0..2 * rings).map(move |j| (i, j)));
    let ball: Vec<Triangle> = squares
        .flat_map(|(i, j)| {
            let [a, b] = [corner(i, j), corner(i, j + 1)];
            let [c, d] = [corner(i + 1, j), corner(i + 1, j + 1)];
            [Triangle([a, b, c]), Triangle([b, d, c])]
        })
        .collect();
    let mut number = random();
    let mut points = vec![[0.0; 3], [1e-30, 0.0, 0.0]];
    for size in [0.1, 1.0, 2.0, 1e3, 1e6, 1e20, 3e38] {
        points.extend((0..40).map(|_| [(); 3].map(|()| (number() - 0.5) * size)));
    }
    points.extend(ball.iter().step_by(9).map(|t| t.0[0]));
    points.extend(
        ball.iter()
            .step_by(7)
            .map(|t| [0, 1, 2].map(|k| t.0[0][k] * 0.5 + t.0[1][k] * 0.25 + t.0[2][k] * 0.25)),
    );
    assert_eq!(assert_plain(&ball, &points, f64::INFINITY), points.len());

    // Check the sign of the distance.
    let solid = Solid::assume_closed(&ball).unwrap();
    let mut distances = vec![0.0; points.len()];
    solid.signed_distance_batch_into(&points, &mut distances);
    let (mut inside, mut on) = (0, 0);
    for (&point, &distance) in points.iter().zip(&distances) {
        match solid.classify(point) {
            Containment::Inside(_) => assert!(distance < 0.0, "{point:?}"),
            Containment::Surface => assert!(distance == 0.0 && distance.is_sign_positive()),
            Containment::Outside => assert!(distance > 0.0, "{point:?}"),
        }
        inside += usize::from(distance < 0.0);
        on += usize::from(distance == 0.0);
        assert_eq!(distance, solid.signed_distance(point));
    }
    assert!(inside > 20 && on > 20, "{inside} inside, {on} on the surface");
    assert!(solid.signed_distance([f32::NAN, 0.0, 0.0]).is_nan());
}

/// Queries a mesh in which one triangle degenerates to a segment and another to a point.
#[test]
fn triangles_without_an_area_are_segments_and_points() {
    let floor = Triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let segment = Triangle([[5.0; 3], [7.0, 5.0, 5.0], [6.0, 5.0, 5.0]]);
    let bvh = Bvh::new(&[floor, segment, Triangle([[9.0; 3]; 3])]).unwrap();
    let near = |point| bvh.closest_point(point, f64::INFINITY).unwrap();
    let found = near([6.5, 5.0, 6.0]);
    assert_eq!((found.triangle, found.distance, found.point), (1, 1.0, [6.5, 5.0, 5.0]));
    assert_eq!([found.u, found.v], [0.75, 0.0]);
    // The closest point is now the third corner, which lies in the interior of the segment.
    assert_eq!(
        near([6.0, 5.0, 6.0]),
        ClosestPoint { point: [6.0, 5.0, 5.0], u: 0.0, v: 1.0, ..found }
    );
    let found = near([9.0, 9.0, 11.0]);
    assert_eq!((found.triangle, found.distance, found.point), (2, 2.0, [9.0; 3]));

    // Rays never hit degenerate triangles, even in a mesh that contains no others.
    let ray = intertri::Ray::new([6.0, 5.0, 9.0], [0.0, 0.0, -1.0]);
    assert_eq!(bvh.closest(&ray), None);
    assert_eq!(bvh.bounds(), Some([[0.0; 3], [1.0, 1.0, 0.0]]));
    assert_eq!(bvh.to_triangles()[1..], [segment, Triangle([[9.0; 3]; 3])]);
    let alone = Bvh::new(&[segment]).unwrap();
    assert_eq!(alone.closest_point([6.0, 5.0, 6.0], 1.0).map(|c| c.distance), Some(1.0));
    assert_eq!(alone.bounds(), None);
}

#[test]
fn what_has_no_answer() {
    let floor = Triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    let bvh = Bvh::new(&[Triangle([[f32::NAN; 3]; 3]), floor]).unwrap();
    let up = [0.25, 3.0, 0.25];
    assert_eq!(bvh.closest_point(up, 3.0).map(|c| (c.triangle, c.distance)), Some((1, 3.0)));
    for radius in [3.0_f64.next_down(), 0.0, -1.0, f64::NAN] {
        assert_eq!(bvh.closest_point(up, radius), None);
    }
    assert_eq!(bvh.closest_point([0.0; 3], 0.0).map(|c| c.distance), Some(0.0));
    for x in [f32::NAN, f32::INFINITY] {
        assert_eq!(bvh.closest_point([0.0, x, 0.0], f64::INFINITY), None);
    }
    assert_eq!(Bvh::new(&[]).unwrap().closest_point(up, f64::INFINITY), None);
}
