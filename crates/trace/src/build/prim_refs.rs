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

/// What is to be sorted, and what is not.
pub(super) struct Prims {
    /// The boxes of all triangles that have one, in order.
    pub refs: Vec<PrimRef>,
    /// The triangles that may be hit outside of any box.
    pub unbounded: Vec<u32>,
    /// Whether some of those with a box have no area.
    pub has_degenerate: bool,
}

/// Looks at all triangles.
pub(super) fn collect(triangles: &(impl Triangles + ?Sized)) -> Result<Prims, NoMemory> {
    let (rare, degenerate) = (AtomicBool::new(false), AtomicBool::new(false));
    let mut refs = each(triangles.count(), |i| {
        let (mut sides, index) = match triangles.hit_bounds(i) {
            HitBounds::Box(bounds) => (SimdAabb::of(&bounds), i as u32),
            HitBounds::Degenerate(bounds) => {
                degenerate.store(true, Ordering::Relaxed);
                (SimdAabb::of(&bounds), i as u32)
            }
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
    Ok(Prims { refs, unbounded, has_degenerate: degenerate.into_inner() })
}
