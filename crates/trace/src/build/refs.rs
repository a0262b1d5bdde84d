//! What the builder sorts: a box and an index for each triangle, 32 bytes.

use super::each;
use super::sides::Sides;
use crate::node::NONE;
use crate::sliver::{Extent, extent};
use intertri::Triangle;
use std::sync::atomic::{AtomicBool, Ordering};

/// The box of a triangle, with the triangle's index in its first word.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ref(pub Sides);

/// Keeps indices from looking like numbers so small that arithmetic on them is slow.
const NORMAL: u32 = 1 << 30;

impl Ref {
    pub(super) fn index(&self) -> u32 {
        self.0.word(0) ^ NORMAL
    }
}

/// The boxes of all triangles that have one, in order; and the triangles that may be hit outside of any
/// box.
pub(super) fn collect(triangles: &[Triangle]) -> (Vec<Ref>, Vec<u32>) {
    let rare = AtomicBool::new(false);
    let mut refs = each(triangles.len(), |i| {
        let (mut sides, index) = match extent(&triangles[i]) {
            Extent::Box(bounds) => (Sides::of(&bounds), i as u32),
            Extent::Nowhere | Extent::Unbounded => {
                rare.store(true, Ordering::Relaxed);
                (Sides::EMPTY, NONE)
            }
        };
        sides.set_word(0, index ^ NORMAL);
        Ref(sides)
    });

    let mut unbounded = Vec::new();
    if rare.into_inner() {
        let is = |i: usize| extent(&triangles[i]) == Extent::Unbounded;
        let without = (0..refs.len()).filter(|&i| refs[i].index() == NONE && is(i));
        unbounded.extend(without.map(|i| i as u32));
        refs.retain(|r| r.index() != NONE);
    }
    (refs, unbounded)
}
