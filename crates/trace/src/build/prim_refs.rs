//! What the builder sorts: a box and an index for each triangle, 32 bytes.

use super::simd_aabb::SimdAabb;
use super::triangles::Triangles;
use crate::memory::NoMemory;
use crate::threads::each;
use crate::tree::{HitBounds, NONE};
use bytemuck::Zeroable;
use std::sync::atomic::{AtomicBool, Ordering};

/// The box of a triangle, with the triangle's index in its first word.
#[derive(Clone, Copy, Debug, Zeroable)]
pub(super) struct PrimRef(pub SimdAabb);

/// Keeps indices from looking like numbers so small that arithmetic on them is slow.
const NORMAL: u32 = 1 << 30;

impl PrimRef {
    pub(super) fn index(&self) -> u32 {
        self.0.word(0) ^ NORMAL
    }
}

/// The boxes of all triangles that have one, in order; and the triangles that may be hit outside of any
/// box.
pub(super) fn collect(
    triangles: &(impl Triangles + ?Sized),
) -> Result<(Vec<PrimRef>, Vec<u32>), NoMemory> {
    let rare = AtomicBool::new(false);
    let mut refs = each(triangles.count(), |i| {
        let (mut sides, index) = match triangles.hit_bounds(i) {
            HitBounds::Box(bounds) => (SimdAabb::of(&bounds), i as u32),
            HitBounds::Nowhere | HitBounds::Unbounded => {
                rare.store(true, Ordering::Relaxed);
                (SimdAabb::EMPTY, NONE)
            }
        };
        sides.set_word(0, index ^ NORMAL);
        PrimRef(sides)
    })?;

    let mut unbounded = Vec::new();
    if rare.into_inner() {
        let is = |i: usize| triangles.hit_bounds(i) == HitBounds::Unbounded;
        for i in (0..refs.len()).filter(|&i| refs[i].index() == NONE && is(i)) {
            unbounded.try_reserve(1)?;
            unbounded.push(i as u32);
        }
        refs.retain(|r| r.index() != NONE);
    }
    Ok((refs, unbounded))
}
