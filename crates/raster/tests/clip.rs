//! Compares the implementation of document E with its scalar reference implementation, and tests
//! that two facets cut a shared edge at the same points.

use intertri_raster::{ALL_WALLS, NO_FAR_WALL, Point4, Scratch, clip_edge, clip_facet, outcode};
use intertri_reference::clip_edge as reference;

/// Pseudorandom numbers in -1..1, the same on every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Returns a point near the volume, sometimes behind the eye, on a wall, or far away.
    fn point(&mut self) -> Point4 {
        let w = self.next() + 0.5;
        let [x, y, z] = [(); 3].map(|()| {
            let x = self.next() * 1.6;
            match (x.abs() * 1e4) as u32 % 10 {
                0 => w,
                1 => -w,
                2 => x * 1e4,
                _ => x,
            }
        });
        Point4::new(x, y, z, w)
    }
}

#[test]
fn edges_are_cut_as_the_reference_cuts_them() {
    let mut numbers = Numbers(1);
    let mut kinds = [0; 2];
    for _ in 0..200_000 {
        let (a, c) = (numbers.point(), numbers.point());
        let there = |p: Point4| reference::Point4::new(p.x, p.y, p.z, p.w);
        let (mut ra, mut rc) = (there(a), there(c));
        let visible = reference::clip_edge(&mut ra, &mut rc) == 1;
        kinds[usize::from(visible)] += 1;
        match clip_edge(a, c) {
            None => {
                // The two functions may differ by rounding where the edge touches an edge of the
                // volume.
                let gap = (ra.x - rc.x).abs() + (ra.y - rc.y).abs() + (ra.w - rc.w).abs();
                assert!(!visible || gap < 1e-9 * (1.0 + ra.x.abs()), "{a:?} {c:?}");
            }
            Some((na, nc)) => {
                for (new, old) in [(na, ra), (nc, rc)] {
                    let size = [a.x, a.y, a.z, c.x, c.y, c.z]
                        .map(f64::abs)
                        .into_iter()
                        .fold(2.0, f64::max);
                    let off = [new.x - old.x, new.y - old.y, new.z - old.z, new.w - old.w];
                    let near = off.iter().all(|x| x.abs() < 1e-12 * size);
                    assert!(near || !visible, "{a:?} {c:?}: {new:?} and {old:?}");
                }
            }
        }
    }
    assert!(kinds[0] > 10_000 && kinds[1] > 10_000, "{kinds:?}");
}

#[test]
fn an_edge_is_the_same_from_both_ends_to_the_bit() {
    let mut numbers = Numbers(2);
    for _ in 0..200_000 {
        let (a, c) = (numbers.point(), numbers.point());
        assert_eq!(clip_edge(a, c), clip_edge(c, a).map(|(c, a)| (a, c)));
    }
}

#[test]
fn what_lies_in_a_wall_or_is_not_finite_is_nowhere() {
    let (a, c) = (Point4::new(1.0, 0.0, 0.0, 1.0), Point4::new(1.0, 0.5, 0.0, 1.0));
    assert_eq!(clip_edge(a, c), None);
    assert_eq!(outcode(a.boundaries()), 0b10);
    let inside = Point4::new(0.0, 0.0, 0.0, 1.0);
    assert_eq!(clip_edge(inside, a), Some((inside, a)));
    for bad in [f64::NAN, f64::INFINITY, f64::MAX] {
        let bad = Point4::new(bad, 0.0, 0.0, f64::MAX);
        assert_eq!(clip_edge(inside, bad), None);
        let facet = [inside, c, bad];
        assert!(clip_facet(facet, ALL_WALLS, &mut Scratch::default()).is_empty());
    }
}

#[test]
fn a_facet_behind_the_eye_or_beside_the_volume_is_nowhere() {
    let mut scratch = Scratch::default();
    let behind = [[0.0, 1.0], [1.0, 0.0], [-1.0, -1.0]].map(|[x, y]| Point4::new(x, y, -2.0, -1.0));
    assert!(clip_facet(behind, NO_FAR_WALL, &mut scratch).is_empty());
    let right = behind.map(|p| Point4::new(p.x + 5.0, p.y, 0.0, 1.0));
    assert!(clip_facet(right, ALL_WALLS, &mut scratch).is_empty());
    // This facet is beyond the far wall, which only one of the two sets of walls contains.
    let far = behind.map(|p| Point4::new(p.x * 0.1, p.y * 0.1, 2.0, 1.0));
    assert!(clip_facet(far, ALL_WALLS, &mut scratch).is_empty());
    assert_eq!(clip_facet(far, NO_FAR_WALL, &mut scratch), far);
    assert!(clip_facet([], ALL_WALLS, &mut scratch).is_empty());
}

#[test]
fn what_is_left_of_a_facet_is_inside_and_in_its_plane() {
    let mut numbers = Numbers(3);
    let mut scratch = Scratch::default();
    let mut left = 0;
    for _ in 0..100_000 {
        let corners = [numbers.point(), numbers.point(), numbers.point()];
        let size =
            corners.iter().flat_map(|p| [p.x, p.y, p.z, p.w]).fold(1.0_f64, |m, x| m.max(x.abs()));
        let outline = clip_facet(corners, ALL_WALLS, &mut scratch);
        left += usize::from(!outline.is_empty());
        for p in outline {
            let least = p.boundaries().into_iter().fold(f64::INFINITY, f64::min);
            assert!(least > -1e-12 * size, "{corners:?}: {p:?}");
            // The point is in the span of the three corners, as vectors of x, y, z, and w, so the
            // determinant is 0.
            let rows = [corners[0], corners[1], corners[2], *p].map(|p| [p.x, p.y, p.z, p.w]);
            assert!(det4(rows).abs() < 1e-12 * size.powi(3), "{corners:?}: {p:?}");
        }
    }
    assert!(left > 10_000);
}

fn det4(m: [[f64; 4]; 4]) -> f64 {
    let minor = |a: usize, b: usize| m[2][a] * m[3][b] - m[2][b] * m[3][a];
    let mut sum = 0.0;
    for i in 0..4 {
        for j in (0..4).filter(|&j| j != i) {
            let rest: Vec<_> = (0..4).filter(|&k| k != i && k != j).collect();
            let inversions = [i > j, i > rest[0], i > rest[1], j > rest[0], j > rest[1]];
            let sign = if inversions.iter().filter(|&&x| x).count() % 2 == 0 { 1.0 } else { -1.0 };
            sum += sign * m[0][i] * m[1][j] * minor(rest[0], rest[1]);
        }
    }
    sum
}

#[test]
fn two_facets_at_an_edge_cut_it_at_the_same_bits() {
    // Where the walls cut the shared edge, both outlines must have a corner with the same bits. All
    // other corners may belong to one outline only.
    let mut numbers = Numbers(4);
    let (mut one, mut other) = (Scratch::default(), Scratch::default());
    let mut cut = 0;
    for _ in 0..100_000 {
        let (a, b) = (numbers.point(), numbers.point());
        if [a, b].iter().any(|p| p.boundaries().contains(&0.0)) {
            continue; // A wall would cut the edge at its end.
        }
        let first = clip_facet([a, b, numbers.point()], NO_FAR_WALL, &mut one);
        let second = clip_facet([b, a, numbers.point()], NO_FAR_WALL, &mut other);
        let bits = |p: &Point4| [p.x, p.y, p.z, p.w].map(f64::to_bits);
        let on_edge = |p: &&Point4| **p != a && **p != b && on_line(a, b, **p);
        let mut ours: Vec<_> = first.iter().filter(on_edge).map(bits).collect();
        let mut theirs: Vec<_> = second.iter().filter(on_edge).map(bits).collect();
        ours.sort_unstable();
        theirs.sort_unstable();
        cut += ours.len();
        assert_eq!(ours, theirs, "{a:?} {b:?}");
    }
    assert!(cut > 10_000, "{cut}");
}

/// Returns whether p is on the line from a to b, up to rounding.
fn on_line(a: Point4, b: Point4, p: Point4) -> bool {
    let [a, b, p] = [a, b, p].map(|p| [p.x, p.y, p.z, p.w]);
    let along: f64 = (0..4).map(|i| (b[i] - a[i]).powi(2)).sum();
    let t = (0..4).map(|i| (p[i] - a[i]) * (b[i] - a[i])).sum::<f64>() / along;
    let off: f64 = (0..4).map(|i| (p[i] - a[i] - t * (b[i] - a[i])).powi(2)).sum();
    off <= 1e-24 * along.max(1.0)
}
