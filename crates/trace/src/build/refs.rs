//! What the builder sorts: a box and an index for each triangle, 32 bytes.

use super::join;
use crate::bounds::Bounds;
use crate::node::NONE;
use crate::sliver::{Extent, extent};
use intertri::Triangle;

/// The box of a triangle, with the triangle's index in the lane that the box leaves free.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ref(pub Bounds);

impl Ref {
    fn new(triangle: &Triangle, index: u32) -> Self {
        // Where there is no box the index is that of no triangle.
        let (mut bounds, index) = match extent(triangle) {
            Extent::Box(bounds) => (bounds, index),
            Extent::Nowhere | Extent::Unbounded => (Bounds::EMPTY, NONE),
        };
        bounds.lo[3] = f32::from_bits(index);
        Self(bounds)
    }

    pub(super) fn index(&self) -> u32 {
        self.0.lo[3].to_bits()
    }
}

/// All triangles that have a box, in order.
pub(super) fn collect(triangles: &[Triangle]) -> Vec<Ref> {
    let mut refs = vec![Ref(Bounds::EMPTY); triangles.len()];
    fill(&mut refs, triangles, 0);
    refs.retain(|r| r.index() != NONE);
    refs
}

/// Halves the work until it is small; the depth is that of a binary search.
fn fill(refs: &mut [Ref], triangles: &[Triangle], first: u32) {
    const SMALL: usize = 1 << 14;
    if refs.len() <= SMALL {
        for (i, (r, t)) in refs.iter_mut().zip(triangles).enumerate() {
            *r = Ref::new(t, first + i as u32);
        }
        return;
    }
    let half = refs.len() / 2;
    let (a, b) = refs.split_at_mut(half);
    let (ta, tb) = triangles.split_at(half);
    join(|| fill(a, ta, first), || fill(b, tb, first + half as u32));
}
