//! Compares the mutual visibility of points with a plain loop in rational arithmetic, and checks
//! that surfaces do not shadow themselves.

use dashu_ratio::RBig;
use intertri::{Hit, RayOf, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_tests::oracle;
use intertri_trace::{Bvh, BvhScalar};

use crate::nearest::truth::truth;

/// The scalar type of a test, f32 or f64.
trait Float: BvhScalar + From<f32> {
    /// If a triangle is within this distance of a segment's end, relative to the largest
    /// coordinate, the end counts as lying on the triangle. The distance is 16 rounding units.
    const REACH: f64;
    fn of(x: f64) -> Self;
}

impl Float for f32 {
    const REACH: f64 = 16.0 / (1 << 23) as f64;
    fn of(x: f64) -> Self {
        x as f32
    }
}

impl Float for f64 {
    const REACH: f64 = 16.0 / (1_u64 << 52) as f64;
    fn of(x: f64) -> Self {
        x
    }
}

/// Returns whether an end of a segment counts as lying on a triangle, computed in rational
/// arithmetic.
fn lies_on<S: Float>(end: [S; 3], [a, b]: &[[S; 3]; 2], triangle: &TriangleOf<S>) -> bool {
    let largest = |p: &[S; 3]| p.iter().fold(0.0, |most: f64, &x| most.max(x.into().abs()));
    let most = triangle.0.iter().chain([a, b]).map(largest).fold(0.0, f64::max);
    let reach = RBig::try_from(S::REACH * most).unwrap();
    truth(end, triangle).0 <= &reach * &reach
}

/// Returns whether a plain loop finds no triangle that hides the ends of a segment from each other.
fn sees<S: Float>([a, b]: &[[S; 3]; 2], triangles: &[TriangleOf<S>], skip: &[u32]) -> bool {
    let dir = [0, 1, 2].map(|k| S::of(b[k].into() - a[k].into()));
    let ray = RayOf::new(*a, dir).between(S::ZERO, S::ONE);
    let hides = |(number, triangle): (usize, &TriangleOf<S>)| {
        let hit = oracle::truth(&ray, triangle);
        hit.is_some_and(|hit| hit.is_closed_hit() && hit.is_within(&ray))
            && !skip.contains(&(number as u32))
            && ![a, b].iter().any(|&&end| lies_on(end, &[*a, *b], triangle))
    };
    !triangles.iter().enumerate().any(hides)
}

/// Random triangles, on a small grid or at arbitrary positions, with a generator of points on them,
/// next to them, and away from them.
struct Scene<S: Float> {
    rng: Rng,
    triangles: Vec<TriangleOf<S>>,
    size: f64,
}

impl<S: Float> Scene<S> {
    fn new(seed: u64) -> Self {
        let mut rng = Rng::new(seed);
        let (size, off) = (10_f64.powf(rng.unit() * 8.0 - 4.0), (rng.unit() * 3.0).floor() * 30.0);
        let is_grid = rng.unit() < 0.5;
        let mut number = || {
            let x = rng.unit() * 4.0;
            S::of(size * (off + if is_grid { x.round() } else { x }))
        };
        let triangles =
            (0..30).map(|_| TriangleOf([0; 3].map(|_| [0; 3].map(|_| number())))).collect();
        Self { rng, triangles, size: size * (1.0 + off) }
    }

    /// Generates a point at a corner, on an edge or on the face of a triangle, up to rounding, or a
    /// small distance away from the triangle.
    fn point(&mut self) -> [S; 3] {
        let triangle = self.triangles[(self.rng.unit() * 30.0) as usize];
        let (mut u, mut v) = (self.rng.unit(), self.rng.unit());
        match (self.rng.unit() * 5.0) as usize {
            0 => (u, v) = (0.0, 0.0),
            1 => v = 0.0,
            2 => v = 1.0 - u,
            _ => (u, v) = (u * 0.5, v * 0.5),
        }
        let beside = match (self.rng.unit() * 4.0) as usize {
            0 => self.size * S::REACH * (self.rng.unit() * 4.0 - 2.0),
            1 => self.size * 0.01,
            _ => 0.0,
        };
        let [a, b, c] = triangle.0.map(|corner| corner.map(Into::<f64>::into));
        [0, 1, 2].map(|k| S::of((1.0 - u - v) * a[k] + u * b[k] + v * c[k] + beside))
    }
}

fn agrees_with_a_plain_loop<S: Float>() {
    let (mut seen, mut saved, mut skipped) = (0, 0, 0);
    for seed in 0..60 {
        let mut scene = Scene::<S>::new(seed);
        let bvh = Bvh::new(&scene.triangles).unwrap();
        let segments: Vec<_> = (0..60).map(|_| [scene.point(), scene.point()]).collect();
        let visible = bvh.visible_batch(&segments);
        for (segment, &visible) in segments.iter().zip(&visible) {
            let [a, b] = *segment;
            assert_eq!(visible, sees(segment, &scene.triangles, &[]), "{seed}: {segment:?}");
            assert_eq!(visible, bvh.visible(a, b), "{seed}: {segment:?}");
            let dir = [0, 1, 2].map(|k| S::of(b[k].into() - a[k].into()));
            let ray = RayOf::new(a, dir).between(S::ZERO, S::ONE);
            seen += u32::from(visible);
            saved += u32::from(visible && bvh.any(&ray));
        }

        // Each segment skips the first triangle that it hits, and another triangle.
        let named = |&[a, b]: &[[S; 3]; 2]| {
            let dir = [0, 1, 2].map(|k| S::of(b[k].into() - a[k].into()));
            let first = bvh.closest(&RayOf::new(a, dir)).unwrap_or(Hit::MISS);
            [first, Hit { triangle: 7, ..Hit::MISS }]
        };
        let named: Vec<_> = segments.iter().map(named).collect();
        let lists: Vec<&[Hit]> = named.iter().map(|list| &list[..]).collect();
        let (before, mut visible) = (visible, vec![true; segments.len()]);
        bvh.query().skip(&lists).visible_batch_into(&segments, &mut visible);
        for ((segment, list), (&visible, before)) in
            segments.iter().zip(&named).zip(visible.iter().zip(before))
        {
            let skip = list.map(|hit| hit.triangle);
            assert_eq!(visible, sees(segment, &scene.triangles, &skip), "{seed}: {segment:?}");
            skipped += u32::from(visible && !before);
        }
    }
    assert!(seen > 300 && saved > 100 && skipped > 200, "{seen} {saved} {skipped}");
}

#[test]
fn points_see_each_other_as_a_plain_loop_says_in_f32() {
    agrees_with_a_plain_loop::<f32>();
}

#[test]
fn points_see_each_other_as_a_plain_loop_says_in_f64() {
    agrees_with_a_plain_loop::<f64>();
}

/// Returns a sphere with the given number of rings of faces.
fn sphere<S: Float>(rings: usize) -> Vec<TriangleOf<S>> {
    use std::f64::consts::PI;
    let at = |i: usize, j: usize| {
        let (up, around) = (PI * i as f64 / rings as f64, PI * j as f64 / rings as f64);
        [up.sin() * around.cos(), up.cos(), up.sin() * around.sin()].map(S::of)
    };
    let mut triangles = Vec::new();
    for (i, j) in (0..rings).flat_map(|i| (0..2 * rings).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)];
        triangles.extend([TriangleOf([a, b, c]), TriangleOf([b, d, c])]);
    }
    triangles
}

/// Checks a convex body: if a face faces the light, its inner points, corners and edge midpoints
/// must be lit, and the inner points of all other faces must be dark. A naive shadow ray reports
/// many lit points as dark.
fn lit_faces_are_lit<S: Float>() {
    let triangles = sphere::<S>(24);
    let bvh = Bvh::new(&triangles).unwrap();
    let light = [3.0, 1.0, 4.0].map(S::of);
    let (mut lit, mut dark, mut by_accident) = (0, 0, 0);
    for triangle in &triangles {
        let corners = triangle.0.map(|corner| corner.map(Into::<f64>::into));
        let [x, y, z] = triangle.normal();
        let toward = [0, 1, 2].map(|k| light[k].into() - corners[0][k]);
        let side = x * toward[0] + y * toward[1] + z * toward[2];
        let length = (x * x + y * y + z * z).sqrt();
        if side.abs() < 1e-3 * length || length < 1e-9 {
            continue;
        }
        for weights in [[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [5.0, 2.0, 1.0]] {
            let sum: f64 = weights.iter().sum();
            let point = [0, 1, 2]
                .map(|k| S::of((0..3).map(|i| weights[i] * corners[i][k]).sum::<f64>() / sum));
            let visible = bvh.visible(point, light);
            assert_eq!(visible, bvh.visible(light, point));
            let inside = weights[2] * weights[1] * weights[0] > 0.0;
            if side > 0.0 {
                assert!(visible, "{triangle:?} {point:?}");
                lit += 1;
                let dir = [0, 1, 2].map(|k| S::of(light[k].into() - point[k].into()));
                let ray = RayOf::new(point, dir).between(S::ZERO, S::ONE);
                by_accident += u32::from(bvh.any(&ray));
            } else if inside {
                assert!(!visible, "{triangle:?} {point:?}");
                dark += 1;
            }
        }
    }
    assert!(lit > 1000 && dark > 1000 && by_accident > 200, "{lit} {dark} {by_accident}");
}

#[test]
fn lit_faces_of_a_sphere_are_lit_in_f32() {
    lit_faces_are_lit::<f32>();
}

#[test]
fn lit_faces_of_a_sphere_are_lit_in_f64() {
    lit_faces_are_lit::<f64>();
}

/// An end that is not finite sees nothing, a point sees itself, and segments longer than the
/// largest f32 are valid.
#[test]
fn segments_of_all_sizes() {
    let far = f32::MAX;
    let wall = TriangleOf([[0.0, -far, -far], [0.0, far, -far], [0.0, 0.0, far]]);
    let bvh = Bvh::new(&[wall]).unwrap();
    let sees = |a, b| bvh.visible(a, b);
    assert!(!sees([-far, 0.0, 0.0], [far, 0.0, 0.0]));
    assert!(sees([far * 0.5, 0.0, 0.0], [far, 0.0, 0.0]));
    assert!(sees([0.0, far, far], [far, -far, far]));
    assert!(sees([1.0; 3], [1.0; 3]));
    for bad in [f32::NAN, f32::INFINITY] {
        assert!(!sees([1.0, bad, 0.0], [2.0, 0.0, 0.0]) && !sees([1.0, 0.0, 0.0], [2.0, 0.0, bad]));
    }
    assert!(bvh.visible_batch(&[]).is_empty());
}
