//! The result of a closest-point search, and the selection of the closest among the final
//! candidates.

use bytemuck::{Pod, Zeroable};
use intertri::internal::exact::{Closest, Tier, closer, closest};
use intertri::{LeafSlot, Scalar, TriangleId, TriangleOf};

use super::mesh::Mesh;

/// The closest point on a mesh to a given point. The type is plain old data, 56 bytes in size.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ClosestPoint {
    /// The distance, with an error of at most 0.86 ulp. It is 0 only if the exact distance is 0.
    /// For f64 coordinates, the error of a subnormal distance is at most 0.93 ulp, and the distance
    /// is infinite if it exceeds the range of f64.
    pub distance: f64,
    /// The point. The error of each coordinate is at most `2^-50` of the triangle's largest
    /// coordinate, plus `2^-1073` if that fraction is subnormal in f64. The point is never outside
    /// the triangle's bounding box.
    pub point: [f64; 3],
    /// The barycentric weight of the triangle's second corner, rounded once.
    pub u: f64,
    /// The barycentric weight of the triangle's third corner, rounded once.
    pub v: f64,
    /// The index of the triangle that is closest in exact arithmetic. If several triangles are
    /// equally close, the lowest index wins.
    pub triangle: u32,
    /// The index of the triangle's mesh; 0 if there is only one mesh.
    pub geometry: u32,
}

impl ClosestPoint {
    /// The batch result of a point that has no closest point: an infinite distance and triangle
    /// `u32::MAX`.
    pub const NONE: Self = Self {
        distance: f64::INFINITY,
        point: [f64::NAN; 3],
        u: f64::NAN,
        v: f64::NAN,
        triangle: u32::MAX,
        geometry: 0,
    };

    /// Returns the closest point on a finite triangle to a finite point. The triangle's index is
    /// not set.
    pub(crate) fn on<S: Scalar>(point: [S; 3], triangle: &TriangleOf<S>) -> Self {
        let Closest { distance, weights: [u, v] } = closest(Tier::Float, point, triangle);
        // This weight is used only to compute the point; the distance and the other weights are
        // rounded only once (nearest.md, section 6).
        let first = (1.0 - u) - v;
        let at = |axis: usize| {
            let [a, b, c]: [f64; 3] = triangle.0.map(|corner| corner[axis].into());
            // Rounding may move the point out of the triangle's box or beyond the range of f64.
            ((first * a + u * b) + v * c).clamp(a.min(b).min(c), a.max(b).max(c))
        };
        Self { distance, point: [at(0), at(1), at(2)], u, v, ..Self::NONE }
    }

    /// Returns `self`, or `None` for [`ClosestPoint::NONE`].
    pub fn some(self) -> Option<Self> {
        (self.triangle != u32::MAX).then_some(self)
    }
}

/// A triangle that may be the closest: its leaf slot and a lower bound on its squared distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) slot: LeafSlot,
    pub(super) least: f64,
}

/// Picks the closest of several candidates. If several are equally close, the lowest index wins.
pub(super) fn closest_of<M: Mesh>(
    mesh: M,
    point: [M::Scalar; 3],
    candidates: &mut [Candidate],
) -> Option<(LeafSlot, ClosestPoint)> {
    // Go in index order: a later triangle replaces the best only if it is strictly closer, so the
    // lowest index wins ties.
    if candidates.len() > 1 {
        candidates.sort_unstable_by_key(|candidate| mesh.tree().index_of(candidate.slot));
    }
    let (first, others) = candidates.split_first()?;
    let mut best = (first.slot, mesh.triangle(first.slot));
    for other in others.iter().filter(|other| other.slot != first.slot) {
        let triangle = mesh.triangle(other.slot);
        if closer(point, &triangle, &best.1).is_lt() {
            best = (other.slot, triangle);
        }
    }

    let (slot, triangle) = best;
    let TriangleId(position) = mesh.tree().index_of(slot);
    Some((slot, ClosestPoint { triangle: position, ..ClosestPoint::on(point, &triangle) }))
}
