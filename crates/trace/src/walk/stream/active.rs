//! The state of a stream's 64 active rays, and sets of the slots that hold these rays.

use intertri::{ClosestHit, PreparedRay};

use crate::walk::single::PackedSlabs;

/// The number of rays that are active at once.
pub(super) const ACTIVE: usize = 64;

/// The state of a ray's traversal, in one cache line.
#[derive(Clone, Copy, Default)]
#[repr(C, align(64))]
pub(super) struct RayState {
    pub(super) slabs: PackedSlabs,
    pub(super) t_min: f32,
    /// Hits beyond this t are ignored.
    pub(super) far: f32,
    /// The node or leaf to visit next.
    pub(super) next: u32,
    /// The top of the ray's stack.
    pub(super) top: u32,
}

const _: () = assert!(size_of::<RayState>() == 64);

/// The part of a ray's state that is needed only at leaves.
#[derive(Clone, Copy)]
pub(super) struct AtLeaves {
    pub(super) ray: PreparedRay,
    pub(super) closest: ClosestHit,
}

/// A set of slots, with one bit per slot. The rays in these slots take the same kind of step next.
#[derive(Clone, Copy)]
pub(super) struct Set(pub(super) u64);

impl Set {
    pub(super) const EMPTY: Self = Self(0);
    pub(super) const ALL: Self = Self(u64::MAX);

    #[inline(always)]
    pub(super) fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Adds a slot if `put` is true.
    #[inline(always)]
    pub(super) fn put(&mut self, place: usize, put: bool) {
        // Do not branch on `put`: its value is practically random, so the branch would often be
        // mispredicted.
        self.0 |= u64::from(put) << (place % ACTIVE);
    }

    /// Returns the slots of this set that are in neither `a` nor `b`.
    #[inline(always)]
    pub(super) fn without(self, a: Self, b: Self) -> Self {
        Self(self.0 & !(a.0 | b.0))
    }

    /// Returns the slots that are in at least one of the two sets.
    #[inline(always)]
    pub(super) fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    #[inline(always)]
    pub(super) fn places(self) -> impl Iterator<Item = usize> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            if left == 0 {
                return None;
            }
            let place = left.trailing_zeros() as usize % ACTIVE;
            // Clear the lowest set bit.
            left &= left - 1;
            Some(place)
        })
    }
}
