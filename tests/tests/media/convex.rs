//! Generates convex solids with integer coordinates, and computes in rational arithmetic which part
//! of a ray is inside them.

use std::cmp::Ordering;

use intertri_lab::rng::Rng;

pub(super) type Point = [i128; 3];

/// A fraction with a positive denominator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rational(pub(super) i128, pub(super) i128);

impl Rational {
    pub(super) fn cmp(self, other: Self) -> Ordering {
        (self.0 * other.1).cmp(&(other.0 * self.1))
    }

    /// Returns the nearest f64. The numerator and the denominator must be below 2^53, so that only
    /// the quotient is rounded.
    pub(super) fn to_f64(self) -> f64 {
        assert!(self.0.abs() < 1 << 53 && self.1 < 1 << 53, "{self:?}");
        self.0 as f64 / self.1 as f64
    }
}

/// A convex solid: the set of points for which `normal · point <= most` for every side.
#[derive(Clone, Debug)]
pub(super) struct Convex {
    sides: Vec<(Point, i128)>,
    pub(super) triangles: Vec<[Point; 3]>,
    /// Whether the triangles are inside out.
    pub(super) is_turned: bool,
}

fn dot(a: Point, b: Point) -> i128 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// Returns the sign of `normal · d`, where `d` is `dir` perturbed as the once rule prescribes.
fn slope(normal: Point, dir: Point) -> i128 {
    let all = [dot(normal, dir), normal[0], normal[1], normal[2]];
    all.into_iter().find(|x| *x != 0).unwrap_or(0).signum()
}

impl Convex {
    /// Returns the convex solid with the given corners. It has one side in each plane that passes
    /// through three corners and has all other corners on one side of it.
    fn of(corners: &[Point], rng: &mut Rng) -> Self {
        let (mut sides, mut triangles) = (Vec::<(Point, i128)>::new(), Vec::new());
        let count = corners.len();
        for i in 0..count * count * count {
            let [a, b, c] = [i % count, i / count % count, i / count / count].map(|i| corners[i]);
            let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
            let normal =
                [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let most = dot(normal, a);
            let is_side = normal != [0; 3] && corners.iter().all(|p| dot(normal, *p) <= most);
            let is_known = |(n, m): &(Point, i128)| {
                let across =
                    [n[1] * normal[2] - n[2] * normal[1], n[2] * normal[0] - n[0] * normal[2]];
                across == [0; 2]
                    && n[0] * normal[1] == n[1] * normal[0]
                    && m * dot(normal, normal) == most * dot(*n, normal)
            };
            if is_side && !sides.iter().any(is_known) {
                sides.push((normal, most));
                fan(normal, most, corners, rng, &mut triangles);
            }
        }
        Self { sides, triangles, is_turned: rng.one_in(4) }
    }

    /// Generates a box with even coordinates, half of such a box, or the octahedron between the
    /// centres of its sides. The octahedron's coordinates are integers, but may be odd.
    pub(super) fn any(rng: &mut Rng) -> Self {
        let mut even = |below: usize| 2 * rng.below(below) as i128;
        let (low, size) = ([0; 3].map(|_| even(4)), [0; 3].map(|_| 2 + even(3)));
        let high = [0, 1, 2].map(|k| low[k] + size[k]);
        let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] });
        let mut corners: Vec<Point> = (0..8).map(corner).collect();
        match rng.below(5) {
            // An octahedron within the box.
            0 => {
                let middle = [0, 1, 2].map(|k| low[k].midpoint(high[k]));
                corners = (0..6)
                    .map(|i| {
                        let mut corner = middle;
                        corner[i % 3] = if i < 3 { low[i] } else { high[i - 3] };
                        corner
                    })
                    .collect();
            }
            // Half of the box, cut along the matching diagonals of two opposite sides.
            1 => corners.retain(|c| c[0] == low[0] || c[1] == low[1]),
            2 => corners.retain(|c| c[0] == high[0] || c[1] == high[1]),
            _ => {}
        }
        Self::of(&corners, rng)
    }

    /// Returns the part of a ray's line that is inside the solid, or `None` if the line misses the
    /// solid. The ends are clamped to the range from `-2^40` to `2^40`.
    pub(super) fn inside(&self, origin: Point, dir: Point) -> Option<[Rational; 2]> {
        const FAR: i128 = 1 << 40;
        let (mut from, mut to) = (Rational(-FAR, 1), Rational(FAR, 1));
        for &(normal, most) in &self.sides {
            let (along, gap) = (dot(normal, dir), most - dot(normal, origin));
            let t = Rational(gap * along.signum(), along.abs());
            match along.cmp(&0) {
                Ordering::Greater if t.cmp(to).is_lt() => to = t,
                Ordering::Less if t.cmp(from).is_gt() => from = t,
                // The ray is parallel to the side, and it is either outside the side, or on the
                // side and perturbed outward by the once rule.
                Ordering::Equal if gap < 0 || gap == 0 && slope(normal, dir) > 0 => return None,
                _ => {}
            }
        }
        from.cmp(to).is_lt().then_some([from, to])
    }

    /// Returns whether a point is inside the solid, or on a side from which the direction leads
    /// inside.
    pub(super) fn holds(&self, point: Point, dir: Point) -> bool {
        self.sides.iter().all(|&(normal, most)| match dot(normal, point).cmp(&most) {
            Ordering::Less => true,
            Ordering::Equal => slope(normal, dir) < 0,
            Ordering::Greater => false,
        })
    }
}

/// Triangulates the corners in a plane as a fan around a random corner, and adds its triangles to
/// `to`.
fn fan(normal: Point, most: i128, corners: &[Point], rng: &mut Rng, to: &mut Vec<[Point; 3]>) {
    let mut ring: Vec<Point> =
        corners.iter().copied().filter(|p| dot(normal, *p) == most).collect();
    // Sort the corners, so that all others are to the left of each edge.
    for i in 1..ring.len() {
        let left = |a: Point, b: Point, c: Point| {
            let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
            let across =
                [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            dot(across, normal)
        };
        let next = (i..ring.len())
            .find(|&j| (0..ring.len()).all(|k| left(ring[i - 1], ring[j], ring[k]) >= 0));
        ring.swap(i, next.expect("a convex ring has a next corner"));
    }
    let first = rng.below(ring.len());
    ring.rotate_left(first);
    to.extend((1..ring.len() - 1).map(|i| [ring[0], ring[i], ring[i + 1]]));
}
