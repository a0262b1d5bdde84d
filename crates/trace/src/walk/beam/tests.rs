//! Tests that beams return the correct result for each ray and trace the rays that suit them.

use intertri::simd::Level;
use intertri::{Counts, Mode, RayOf, Triangle, TriangleOf};

use super::{Beams, order};
use crate::Bvh;
use crate::containment::Containment;
use crate::scalar::BvhScalar;
use crate::solid::classify;
use crate::util::test_numbers::random;

/// Returns closed shapes around the points of a grid: octahedra, each of whose faces is divided
/// into nine.
fn balls() -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for i in 0..512 {
        let (ball, octant) = (i / 8, i % 8_u32);
        let centre = [ball % 4, ball / 4 % 4, ball / 16].map(|x| x as f32);
        let sign = [0, 1, 2].map(|k| if octant >> k & 1 == 0 { 0.4 } else { -0.4 });
        let at = |a: i32, b: i32| {
            let share = [a, b, 3 - a - b].map(|x| x as f32 / 3.0);
            [0, 1, 2].map(|k| centre[k] + sign[k] * share[k])
        };
        for (a, b) in (0..3).flat_map(|a| (0..3 - a).map(move |b| (a, b))) {
            let mut both = vec![[at(a, b), at(a + 1, b), at(a, b + 1)]];
            if a + b < 2 {
                both.push([at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)]);
            }
            let turned = |[a, b, c]: [[f32; 3]; 3]| {
                if octant.count_ones() % 2 == 0 { [a, b, c] } else { [a, c, b] }
            };
            triangles.extend(both.into_iter().map(turned).map(TriangleOf));
        }
    }
    triangles
}

/// Returns random points among the shapes, corners of triangles, and points next to these corners.
fn points(triangles: &[Triangle], count: usize) -> Vec<[f32; 3]> {
    let mut random = random();
    let mut points: Vec<[f32; 3]> =
        (0..count).map(|_| [0; 3].map(|_| 5.0 * random() - 1.0)).collect();
    points.extend(triangles.iter().map(|t| t.0[0]));
    points.extend(triangles.iter().map(|t| t.0[1].map(f32::next_up)));
    points
}

const DIRS: [[f32; 3]; 3] = [[0.5, 0.3, 0.8], [-0.7, 0.2, 0.1], [0.0, -1.0, 0.0]];

/// Counts the rays that beams leave untraced, in several directions and at every level. Checks that
/// the results for the other rays are correct.
fn left<S: BvhScalar>(triangles: &[TriangleOf<S>], points: &[[S; 3]]) -> usize {
    let bvh = Bvh::new(triangles).unwrap();
    let expected: Vec<Containment> = points.iter().map(|&point| classify(&bvh, point)).collect();
    assert!(
        [Containment::Outside, Containment::Inside(1), Containment::Surface]
            .iter()
            .all(|p| expected.contains(p))
    );
    DIRS.map(|dir| left_of(&bvh, points, &expected, dir)).iter().sum()
}

/// Like [`left`], but for a single direction and given results.
fn left_of<S: BvhScalar>(
    bvh: &Bvh<S>,
    points: &[[S; 3]],
    expected: &[Containment],
    dir: [f32; 3],
) -> usize {
    let mut left = 0;
    let order = order(points, dir.map(f64::from)).unwrap();
    let ray = |&i: &u32| RayOf::new(points[i as usize], dir.map(S::from));
    let rays: Vec<RayOf<S>> = order.iter().map(ray).collect();
    for level in Level::all() {
        let (mode, all) = (Mode::once().at(level), (&rays[..], 0..rays.len()));
        let mut containments = vec![Containment::Outside; rays.len()];
        let mut is_left = vec![false; rays.len()];
        S::with_rays(&bvh.tree, &bvh.originals, mode, all, |filter, rays| {
            let (tree, containments, counts) =
                (&bvh.tree, &mut containments, &mut Counts::default());
            for i in level.run(Beams { tree, filter, rays, containments, counts }) {
                is_left[i.0 as usize] = true;
            }
        });
        for ((&i, place), is_left) in order.iter().zip(containments).zip(&is_left) {
            let i = i as usize;
            assert!(*is_left || place == expected[i], "{:?}, {dir:?}: {place:?}", points[i]);
        }
        left += is_left.iter().filter(|is_left| **is_left).count();
    }
    left
}

/// Returns points far back on the lines through corners and edges of triangles near the coordinate
/// origin. Rays from such distant points have the least accurate positions, but all decisions must
/// still be correct.
fn far_back(triangles: &[Triangle], dir: [f32; 3], count: usize) -> Vec<[f32; 3]> {
    let mut random = random();
    let back = |i: usize| {
        let [a, b, _] = triangles[i % triangles.len()].0;
        let (share, far) = ([0.0, 0.5, 1.0][i % 3], 4000.0 * random() + 4.0);
        [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]) - far * dir[k])
    };
    (0..count).map(back).collect()
}

/// Converts a point to f64 coordinates that are not exact in f32.
fn in_f64(point: [f32; 3]) -> [f64; 3] {
    let [x, y, z] = point.map(f64::from);
    [x * 1.1 + 4e5, y * 0.9 + 5e6, z / 3.0]
}

#[test]
fn beams_give_each_ray_its_own_answer() {
    let triangles = balls();
    let points = points(&triangles, 50_000);
    assert_eq!(left(&triangles, &points), 0);
    let triangles: Vec<_> = triangles.iter().map(|t| TriangleOf(t.0.map(in_f64))).collect();
    let points: Vec<[f64; 3]> = points.into_iter().map(in_f64).collect();
    assert_eq!(left(&triangles, &points), 0);
}

/// Tests that most rays are left untraced if they are far apart or have different directions, and
/// that the results of the other rays are correct.
#[test]
fn beams_leave_what_is_too_much_work() {
    let triangles = balls();
    let points = points(&triangles[..40], 100);
    let levels = Level::all().count();
    assert!(left(&triangles, &points) > 3 * levels * points.len() / 2);
}

/// Traces rays from distant origins. With only a thirtieth of the margin for such origins, some
/// hits would be missed.
#[test]
fn rays_from_far_out_miss_nothing() {
    let triangles = balls();
    let bvh = Bvh::new(&triangles).unwrap();
    for dir in DIRS {
        let points = far_back(&triangles, dir, 200_000);
        let expected: Vec<Containment> =
            points.iter().map(|&point| classify(&bvh, point)).collect();
        let left = left_of(&bvh, &points, &expected, dir);
        assert!(left < points.len());
    }
}
