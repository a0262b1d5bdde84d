//! What is found: triangles that may be the closest, and the one that is.

use bytemuck::{Pod, Zeroable};
use intertri::internal::exact::{Closest, Tier, closer, closest};
use intertri::{LeafSlot, TriangleId};

use super::mesh::Mesh;

/// The point of a mesh that is closest to a given one. Plain data of 56 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ClosestPoint {
    /// How far it is: the true distance within 0.86 units in the last place, 0 only where that is 0. Of coordinates in
    /// f64, within 0.93 where it is subnormal, and infinite where it is beyond f64.
    pub distance: f64,
    /// Where it is: each coordinate within `2^-50` of the triangle's largest, and `2^-1073` more where that is subnormal in
    /// f64; never outside of the triangle's box.
    pub point: [f64; 3],
    /// The weight of the triangle's second corner, rounded once.
    pub u: f64,
    /// The weight of the third corner, rounded once.
    pub v: f64,
    /// The triangle: truly the closest, and of those that are exactly as close the first.
    pub triangle: u32,
    /// The number of its mesh, where there are several; else 0.
    pub geometry: u32,
}

impl ClosestPoint {
    /// What batches have for a point without an answer: infinitely far away, and of triangle `u32::MAX`.
    pub const NONE: Self = Self {
        distance: f64::INFINITY,
        point: [f64::NAN; 3],
        u: f64::NAN,
        v: f64::NAN,
        triangle: u32::MAX,
        geometry: 0,
    };

    /// Itself, or `None` for [`ClosestPoint::NONE`].
    pub fn some(self) -> Option<Self> {
        (self.triangle != u32::MAX).then_some(self)
    }
}

/// A triangle that may be the closest: its slot in the leaves, and a square that its distance's is not below.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) slot: LeafSlot,
    pub(super) least: f64,
}

/// The closest of some triangles, one of which is; of those that are exactly as close the lowest index.
pub(super) fn closest_of<M: Mesh>(
    mesh: M,
    point: [M::Scalar; 3],
    candidates: &mut [Candidate],
) -> Option<(LeafSlot, ClosestPoint)> {
    // From the lowest index on, a later one must be closer.
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
    let Closest { distance, weights: [u, v] } = closest(Tier::Float, point, &triangle);
    let first = (1.0 - u) - v;
    let at = |axis: usize| {
        let [a, b, c]: [f64; 3] = triangle.0.map(|corner| corner[axis].into());
        // Rounding may lead out of the box, or beyond f64.
        ((first * a + u * b) + v * c).clamp(a.min(b).min(c), a.max(b).max(c))
    };
    let point = [at(0), at(1), at(2)];
    let TriangleId(triangle) = mesh.tree().index_of(slot);
    Some((slot, ClosestPoint { distance, point, u, v, triangle, geometry: 0 }))
}
