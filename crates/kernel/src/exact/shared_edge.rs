//! Tests whether a ray meets two triangles on a shared edge or corner, and thus at the same t.
//!
//! ```text
//!        P            d × P = 0           The ray goes through the corner.
//!       /|\
//!      / ● \          d·(P × Q) = 0       The ray meets the line of the edge.
//!     /  |  \
//!    ·---Q---·        P and Q are relative to the ray's origin.
//! ```
//!
//! `docs/numerics/exact.md`, section 9, has the proof.

use core::cmp::Ordering;

use super::float;
use super::input::is_plain;
use super::int::{Int, cross, dot};
use super::scale::{Dyadic, Scales};
use super::tier::{Tier, at_tier, is_f64};
use crate::simd::Vec3;
use crate::{RayOf, Scalar, TriangleOf};

/// Returns whether a ray certainly has the same t for two triangles because it meets both on a
/// shared edge or corner. The ray's line must meet each plane in exactly one point.
pub(super) fn is_met<S: Scalar>(
    ray: &RayOf<S>,
    one: &TriangleOf<S>,
    other: &TriangleOf<S>,
) -> bool {
    let mut shared = one.0.iter().filter(|corner| has_corner(other, corner));
    let Some(&p) = shared.next() else { return false };
    let q = shared.next().copied().unwrap_or(p);
    // The ray nearly always misses the edge, and f64 arithmetic can prove that. For f32
    // coordinates, integers are just as fast.
    if const { is_f64::<S>() } && is_plain(ray, &TriangleOf([p, q, q])) {
        let vec3 = |v: [S; 3]| Vec3::splat(v.map(Into::into));
        if float::passes([p, q].map(vec3), vec3(ray.origin), vec3(ray.dir)) {
            return false;
        }
    }
    meets([ray.origin, p, q].map(Dyadic::vector), Dyadic::vector(ray.dir))
}

/// Returns whether a triangle has this corner. Compares bits: on a CPU that treats subnormal numbers
/// as zero, a floating-point comparison would consider different corners equal.
#[inline(always)]
fn has_corner<S: Scalar>(triangle: &TriangleOf<S>, corner: &[S; 3]) -> bool {
    triangle.0.iter().any(|other| bytemuck::bytes_of(other) == bytemuck::bytes_of(corner))
}

/// Returns whether each corner of one triangle is a corner of the other one, so that both lie in the
/// same plane.
#[inline(always)]
pub(super) fn is_all<S: Scalar>(one: &TriangleOf<S>, other: &TriangleOf<S>) -> bool {
    one.0.iter().all(|corner| has_corner(other, corner))
}

/// Returns whether a triangle has the corner or the edge of another one on which a ray is known to
/// meet that one. Bit i of `edges` stands for the edge opposite corner i + 1; a corner is on two.
pub(super) fn has_feature<S: Scalar>(
    triangle: &TriangleOf<S>,
    other: &TriangleOf<S>,
    edges: u8,
) -> bool {
    // A corner belongs to all edges but the one opposite it.
    (0..3).all(|i| edges >> i & 1 != 0 || has_corner(triangle, &other.0[i]))
}

/// Returns whether a ray meets the line of an edge or, if both ends are equal, a corner. The origin
/// comes before the ends.
#[inline(never)]
fn meets(points: [[Dyadic; 3]; 3], dir: [Dyadic; 3]) -> bool {
    let scales = Scales::of(&points, dir);
    at_tier!(scales.tier(), holds::<C, N, V>(points, dir, scales))
}

fn holds<const C: usize, const N: usize, const V: usize>(
    points: [[Dyadic; 3]; 3],
    dir: [Dyadic; 3],
    scales: Scales,
) -> bool {
    let [origin, edge @ ..] = points;
    let ([p, q], d) = (scales.points.relative::<C, 2>(origin, edge), scales.dir.vector(dir));
    let is_zero = |x: &Int<N>| x.sign() == Ordering::Equal;
    let through = |corner: &[Int<C>; 3]| {
        let moment: [Int<N>; 3] = cross(&d, corner);
        moment.iter().all(is_zero)
    };
    let normal: [Int<N>; 3] = cross(&p, &q);
    // If only one corner is shared, the normal is 0, and the test below would decide nothing.
    if normal.iter().all(is_zero) {
        return through(&p);
    }
    // If d·(P × Q) = 0, the ray lies in the plane through its origin and the edge, so its line
    // meets the edge's line.
    let volume: Int<V> = dot(&d, &normal);
    volume.sign().is_eq()
}

#[cfg(test)]
mod tests {
    use super::has_feature;
    use crate::Triangle;

    /// Compares all edges and corners of a triangle with those of its neighbour.
    #[test]
    fn only_shared_edges_and_corners_decide() {
        let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.5]];
        let (one, other) = (Triangle([a, b, c]), Triangle([c, b, d]));
        // Bits of one edge, or of the two edges that meet at a corner.
        let shared = [1, 2, 4, 3, 5, 6].map(|edges| has_feature(&other, &one, edges));
        // The edge opposite a, and the corners c and b.
        assert_eq!(shared, [true, false, false, true, true, false]);
    }
}
