//! The references that the builder sorts: a box and an index for each triangle, in 32 bytes.

use super::simd_aabb::SimdAabb;
use super::triangles::Triangles;
use crate::tree::{Aabb, HitBounds, NONE};
use crate::util::memory::NoMemory;
use crate::util::threads::each;
use bytemuck::Zeroable;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// The box of a triangle, with the triangle's index in its first word.
#[derive(Clone, Copy, Debug, Zeroable)]
pub(super) struct PrimRef(pub SimdAabb);

/// A bit that keeps indices from looking like subnormal numbers, on which arithmetic is slow.
const NORMAL: u32 = 1 << 30;

impl PrimRef {
    pub(super) fn new(bounds: &Aabb, index: u32) -> Self {
        let mut sides = SimdAabb::of(bounds);
        sides.set_word(0, index ^ NORMAL);
        Self(sides)
    }

    pub(super) fn index(&self) -> u32 {
        self.0.word(0) ^ NORMAL
    }
}

/// The triangles to build over.
pub(super) struct Prims {
    /// The boxes of all triangles that go below the root, in order.
    pub refs: Vec<PrimRef>,
    /// The largest distance outside its box at which the reference implementation may report a hit
    /// on one of these triangles.
    pub lean: f32,
    /// Thin triangles, on which the reference implementation may report hits arbitrarily far
    /// outside their boxes.
    pub thin: Vec<u32>,
    /// Whether any triangle with a box is degenerate.
    pub has_degenerate: bool,
}

/// Collects the references of all triangles.
pub(super) fn collect(triangles: &(impl Triangles + ?Sized)) -> Result<Prims, NoMemory> {
    // Non-negative floats compare like their bits, so an integer maximum works.
    let most = AtomicU32::new(0);
    let (rare, degenerate) = (AtomicBool::new(false), AtomicBool::new(false));
    let mut refs = each(triangles.count(), |i| {
        let (mut sides, index) = match triangles.hit_bounds(i) {
            HitBounds::Box { bounds, lean } => {
                // Start with a plain load: most triangles do not raise the maximum, and a write
                // would move the cache line between cores.
                if lean.to_bits() > most.load(Ordering::Relaxed) {
                    most.fetch_max(lean.to_bits(), Ordering::Relaxed);
                }
                (SimdAabb::of(&bounds), i as u32)
            }
            HitBounds::Degenerate(bounds) => {
                degenerate.store(true, Ordering::Relaxed);
                (SimdAabb::of(&bounds), i as u32)
            }
            HitBounds::Nowhere | HitBounds::Thin(_) => {
                rare.store(true, Ordering::Relaxed);
                (SimdAabb::EMPTY, NONE)
            }
        };
        // The whole row is used in f32 arithmetic, in which a small index would be a subnormal
        // number.
        sides.set_word(0, index ^ NORMAL);
        PrimRef(sides)
    })?;

    let mut thin = Vec::new();
    if rare.into_inner() {
        // Find thin triangles in a second pass, because they are rare and a list filled in the
        // first pass would have to be shared by all threads.
        let is_thin = |i: usize| matches!(triangles.hit_bounds(i), HitBounds::Thin(_));
        for i in (0..refs.len()).filter(|&i| refs[i].index() == NONE && is_thin(i)) {
            thin.try_reserve(1)?;
            thin.push(i as u32);
        }
        refs.retain(|r| r.index() != NONE);
    }
    let (lean, has_degenerate) = (f32::from_bits(most.into_inner()), degenerate.into_inner());
    Ok(Prims { refs, lean, thin, has_degenerate })
}
