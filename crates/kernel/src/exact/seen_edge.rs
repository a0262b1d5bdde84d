//! Determines on which side of a directed edge a ray passes, under the *once* rule.
//!
//! ```text
//!             b
//!             ▲    d·(A × B) > 0    The ray passes on this side of the edge.
//!        ·    │    d·(A × B) = 0    The ray meets the edge's line and is moved by (ε, ε², ε³).
//!       ray   │
//!             a    A and B are the ends relative to the ray's origin. The view is along the ray.
//! ```
//!
//! [`crossing`](super::crossing) uses the same signs for the three edges of a triangle, so a sum
//! over edges and a count of crossings agree on the side of each edge. `docs/numerics/winding.md`
//! relies on this property.

use core::cmp::Ordering;

use super::int::{Int, cross, dot};
use super::scale::{Dyadic, Scales};
use super::tier::{Tier, at_tier};
use crate::Scalar;

/// Returns the sign of `d·(A × B)` for a ray moved by (ε, ε², ε³), or `Equal` if A and B are
/// collinear with the origin. All coordinates must be finite.
///
/// ```
/// use core::cmp::Ordering::{Equal, Greater, Less};
/// use intertri::internal::exact::edge_side;
/// let side = |dir: [f32; 3]| edge_side([0.0; 3], dir, [[1.0, -1.0, 4.0], [1.0, 1.0, 4.0]]);
/// assert_eq!([side([0.0, 0.0, 1.0]), side([2.0, 0.0, 4.0])], [Greater, Less]);
/// // A ray through the edge is moved along x, so it passes where x is greater.
/// assert_eq!(side([1.0, 0.5, 4.0]), Less);
/// assert_eq!(edge_side([0.0; 3], [1.0, 0.0, 0.0], [[1.0; 3], [2.0_f32; 3]]), Equal);
/// ```
pub fn edge_side<S: Scalar>(origin: [S; 3], dir: [S; 3], edge: [[S; 3]; 2]) -> Ordering {
    side_by_integers([origin, edge[0], edge[1]].map(Dyadic::vector), Dyadic::vector(dir))
}

#[inline(never)]
fn side_by_integers(points: [[Dyadic; 3]; 3], dir: [Dyadic; 3]) -> Ordering {
    let scales = Scales::of(&points, dir);
    at_tier!(scales.tier(), side::<C, N, V>(points, dir, scales))
}

fn side<const C: usize, const N: usize, const V: usize>(
    [origin, edge @ ..]: [[Dyadic; 3]; 3],
    dir: [Dyadic; 3],
    scales: Scales,
) -> Ordering {
    let [a, b] = scales.points.relative::<C, 2>(origin, edge);
    let normal: [Int<N>; 3] = cross(&a, &b);
    let volume: Int<V> = dot(&scales.dir.vector::<C>(dir), &normal);
    // Under the *once* rule, the result is the sign of the first nonzero value among the volume,
    // Nx, Ny, and Nz (exact.md, section 1).
    normal.iter().fold(volume.sign(), |sign, n| sign.then_with(|| n.sign()))
}

/// Computes `d × A` for a ray moved by (ε, ε², ε³), scaled so that the largest component is near 1.
/// The error in each component is at most a few ulps of the largest component. Returns
/// the zero vector if the point is the ray's origin. All coordinates must be finite.
///
/// ```
/// use intertri::internal::exact::moment;
/// let [x, y, z] = moment([0.0; 3], [0.0, 0.0, 2.0], [3.0e-30_f32, -4.0e-30, 5.0]);
/// assert!(x > 0.0 && (y / x - 0.75).abs() < 1e-6 && z == 0.0);
/// // The point is on the ray. The ray is moved along x, so the point is at smaller x.
/// let [x, y, z] = moment([0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 5.0_f32]);
/// assert!(x == 0.0 && y < 0.0 && z == 0.0);
/// ```
pub fn moment<S: Scalar>(origin: [S; 3], dir: [S; 3], point: [S; 3]) -> [f64; 3] {
    turn_by_integers([origin, point].map(Dyadic::vector), Dyadic::vector(dir))
}

#[inline(never)]
fn turn_by_integers(points: [[Dyadic; 3]; 2], dir: [Dyadic; 3]) -> [f64; 3] {
    let scales = Scales::of(&points, dir);
    at_tier!(scales.tier(), turn::<C, N, V>(points, dir, scales))
}

fn turn<const C: usize, const N: usize, const V: usize>(
    [origin, point @ ..]: [[Dyadic; 3]; 2],
    dir: [Dyadic; 3],
    scales: Scales,
) -> [f64; 3] {
    const { assert!(V == N + C) };
    let [a] = scales.points.relative::<C, 1>(origin, point);
    let axis = |k: usize| [0, 1, 2].map(|i| Int::new(i64::from(i == k), 0));
    // Use d × A or, if d × A is 0, the term in ε or ε²: the first nonzero term outweighs the terms
    // that follow. All three terms vanish only if A = 0.
    let moments = [scales.dir.vector::<C>(dir), axis(0), axis(1)].map(|d| cross(&d, &a));
    let is_some = |moment: &&[Int<N>; 3]| moment.iter().any(|x| x.sign().is_ne());
    moments.iter().find(is_some).map_or([0.0; 3], rounded)
}

/// Converts a nonzero vector to f64 and scales it so that the largest component is near 1.
fn rounded<const N: usize>(v: &[Int<N>; 3]) -> [f64; 3] {
    let sizes = v.map(|x| x.size());
    let top = (0..N).rev().find(|&i| sizes.iter().any(|size| size[i] != 0)).unwrap_or(0);
    // Use two limbs of each component, starting at the highest limb that is nonzero in any of them.
    let number = |k: usize| {
        let low = if top > 0 { sizes[k][top - 1] } else { 0 };
        let size = (u128::from(sizes[k][top]) << 64 | u128::from(low)) as f64;
        if v[k].sign().is_lt() { -size } else { size }
    };
    let numbers = [0, 1, 2].map(number);
    let most = numbers.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    // Divide by the largest component, because only the direction of the vector matters.
    numbers.map(|x| x / most)
}

#[cfg(test)]
mod tests {
    use super::{edge_side, moment};
    use crate::exact::{Side, Tier, crossing_from, test_numbers::random};
    use crate::{Ray64, RayOf, TriangleOf};

    /// A ray that crosses a triangle passes all three edges on the side given by T's sign.
    #[test]
    fn sides_are_those_of_crossings() {
        let mut random = random();
        let (mut crossed, mut equal) = (0, 0);
        for i in 0..20_000 {
            let mut point = || [0; 3].map(|_| (3.0 * random()).round());
            let (corners, origin, dir) = ([point(), point(), point()], point(), point());
            let [a, b, c] = corners;
            if dir == [0.0; 3] {
                continue;
            }
            let sides = [[b, c], [c, a], [a, b]].map(|edge| edge_side(origin, dir, edge));
            equal += sides.iter().filter(|side| side.is_eq()).count();
            let ray: RayOf<f64> = Ray64::new(origin, dir);
            let Some(side) =
                crossing_from(Tier::Narrow, crate::Rule::Once, &ray, &TriangleOf(corners))
            else {
                continue;
            };
            let sign = if side == Side::Leaves { 1 } else { -1 };
            assert_eq!(sides.map(|side| side as i32), [sign; 3], "{i}: {ray:?} {corners:?}");
            crossed += 1;
        }
        assert!(crossed > 300 && equal > 1000, "{crossed} crossed, {equal} equal");
    }

    /// Tests moments of points that are closer to the ray than f64 can resolve.
    #[test]
    fn moments_keep_their_digits() {
        let mut random = random();
        for _ in 0..1000 {
            let dir = [0; 3].map(|_| (1000.0 * random()).round());
            let beside = [0; 3].map(|_| random());
            let far = 2.0_f64.powi(60);
            // The point is exactly `far · d`, and the ray's origin is displaced by `beside`.
            let point = dir.map(|d| d * far);
            let cross = |a: [f64; 3], b: [f64; 3]| {
                [0, 1, 2].map(|k| {
                    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                    a[i] * b[j] - a[j] * b[i]
                })
            };
            let expected = cross(beside, dir);
            let most = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let moment = moment(beside, dir, point);
            for k in 0..3 {
                assert!((moment[k] - expected[k] / most).abs() < 1e-12, "{moment:?} {expected:?}");
            }
        }
    }
}
