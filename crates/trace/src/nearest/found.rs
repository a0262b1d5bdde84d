//! The result of a search: triangles that may be the closest, and the one that is.

use bytemuck::{Pod, Zeroable};
use intertri::internal::exact::{Closest, Tier, closer, closest};
use intertri::{LeafSlot, Scalar, TriangleId, TriangleOf};

use super::mesh::Mesh;

/// The point of a mesh that is closest to a given one. Plain data of 56 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ClosestPoint {
    /// The distance. Its error is at most 0.86 units in the last place, and it is 0 only if the true one is.
    /// For f64 coordinates, the error is at most 0.93 units if the distance is subnormal, and it is infinite
    /// if it is beyond the range of f64.
    pub distance: f64,
    /// The point. The error of each coordinate is at most `2^-50` of the triangle's largest coordinate, plus
    /// `2^-1073` if that is subnormal in f64. It is never outside the triangle's box.
    pub point: [f64; 3],
    /// The weight of the triangle's second corner, rounded once.
    pub u: f64,
    /// The weight of the third corner, rounded once.
    pub v: f64,
    /// The triangle. It is truly the closest; if several are equally close, the lowest index wins.
    pub triangle: u32,
    /// The index of its mesh, if there are several; otherwise 0.
    pub geometry: u32,
}

impl ClosestPoint {
    /// The result for a point without an answer, in a batch: infinitely far away, on triangle `u32::MAX`.
    pub const NONE: Self = Self {
        distance: f64::INFINITY,
        point: [f64::NAN; 3],
        u: f64::NAN,
        v: f64::NAN,
        triangle: u32::MAX,
        geometry: 0,
    };

    /// The point of a finite triangle that is closest to a finite one, without a name for the triangle.
    pub(crate) fn on<S: Scalar>(point: [S; 3], triangle: &TriangleOf<S>) -> Self {
        let Closest { distance, weights: [u, v] } = closest(Tier::Float, point, triangle);
        // Used only for the point: the distance and the weights are exact except for one rounding (nearest.md,
        // section 6).
        let first = (1.0 - u) - v;
        let at = |axis: usize| {
            let [a, b, c]: [f64; 3] = triangle.0.map(|corner| corner[axis].into());
            // Rounding may leave the box, or the range of f64.
            ((first * a + u * b) + v * c).clamp(a.min(b).min(c), a.max(b).max(c))
        };
        Self { distance, point: [at(0), at(1), at(2)], u, v, ..Self::NONE }
    }

    /// This result, or `None` for [`ClosestPoint::NONE`].
    pub fn some(self) -> Option<Self> {
        (self.triangle != u32::MAX).then_some(self)
    }
}

/// A triangle that may be the closest: its slot in the leaves, and a lower bound on its squared distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) slot: LeafSlot,
    pub(super) least: f64,
}

/// The closest of several candidates; if several are equally close, the lowest index wins.
pub(super) fn closest_of<M: Mesh>(
    mesh: M,
    point: [M::Scalar; 3],
    candidates: &mut [Candidate],
) -> Option<(LeafSlot, ClosestPoint)> {
    // In order of the indices: a later triangle replaces the best only if it is strictly closer, so the lowest index
    // wins ties.
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
