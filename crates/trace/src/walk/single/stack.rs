//! A stack of the nodes and leaves that a ray still has to visit. A push writes eight entries at
//! once, and a pop compares eight.
//!
//! ```text
//!          bottom            entries                 top
//!   child  ⊥ ⊥ ⊥ ⊥ ⊥ ⊥ ⊥ ⊥ │ far … near, far … near │ · · ·
//!   t     -∞ -∞ … -∞ -∞ -∞ │ where each box begins  │ · · ·
//! ```
//!
//! A single lane permutation pushes a node's boxes from far to near. A single lane comparison drops
//! the boxes that begin beyond the best hit.

use std::cell::Cell;
use std::ops::{Deref, DerefMut};

use intertri::simd::{Lanes, Mask, Simd};

use super::child_predictor::ChildPredictor;
use crate::tree::{Node, Tree, far_to_near, first_slot};

/// Marks the bottom of a stack. A ray that pops this entry has nothing left to visit.
pub(crate) const BOTTOM: u32 = u32::MAX;

/// The number of bottom entries, and the number of entries that a pop compares at once.
const LOOK: usize = 8;

/// The stacks of one or several rays.
#[derive(Debug, Default)]
pub(crate) struct Stack {
    /// The children on each ray's stack, stored as the bit patterns of f32 values.
    child: Vec<f32>,
    /// The t at which the ray enters the box of each child.
    t: Vec<f32>,
    /// The capacity per ray.
    each: usize,
}

/// Scratch memory kept from one single-ray query to the next.
#[derive(Debug)]
pub(crate) struct TraversalScratch {
    pub(crate) stack: Stack,
    pub(crate) predictor: ChildPredictor,
}

thread_local! {
    /// Kept per thread, because allocating it can take as long as a query.
    static LAST: Cell<Option<Box<TraversalScratch>>> = const { Cell::new(None) };
}

/// A thread's scratch memory, lent to a query and returned when the query ends.
pub(crate) struct LentScratch(Option<Box<TraversalScratch>>);

impl TraversalScratch {
    /// Creates scratch for single rays in hierarchies that need a stack of this size.
    pub(crate) fn new(size: usize) -> Box<Self> {
        Box::new(Self { stack: Stack::new(1, size), predictor: ChildPredictor::default() })
    }

    /// Returns whether the stack has at least this size.
    pub(crate) fn fits(&self, size: usize) -> bool {
        self.stack.each >= Stack::room(size)
    }

    /// Lends this thread's scratch memory to a query for single rays in a hierarchy.
    pub(crate) fn lend(tree: &Tree) -> LentScratch {
        let last = LAST.try_with(Cell::take).ok().flatten();
        // Drop a stack that was allocated for a shallower tree and is too small for this one.
        let fits = last.filter(|last| last.fits(tree.stack));
        LentScratch(Some(fits.unwrap_or_else(|| Self::new(tree.stack))))
    }
}

impl Deref for LentScratch {
    type Target = TraversalScratch;
    #[inline]
    fn deref(&self) -> &TraversalScratch {
        self.0.as_deref().expect("the scratch is lent until it is dropped")
    }
}

impl DerefMut for LentScratch {
    #[inline]
    fn deref_mut(&mut self) -> &mut TraversalScratch {
        self.0.as_deref_mut().expect("the scratch is lent until it is dropped")
    }
}

impl Drop for LentScratch {
    #[inline]
    fn drop(&mut self) {
        let kept = self.0.take();
        // This fails if the thread is ending; the scratch is no longer needed then.
        let _ = LAST.try_with(|last| last.set(kept));
    }
}

impl Stack {
    /// Returns the capacity for a ray's children. A push always writes eight entries, however many
    /// are valid. An odd number of cache lines per ray keeps the tops of the stacks from competing
    /// for the same cache sets.
    fn room(size: usize) -> usize {
        // Sixteen floats fill a cache line.
        (LOOK + size + 8).next_multiple_of(16) | 16
    }

    /// Creates empty stacks for several rays, each with at most `size` entries.
    fn new(rays: usize, size: usize) -> Self {
        let each = Self::room(size);
        let mut stack = Self { child: vec![0.0; rays * each], t: vec![0.0; rays * each], each };
        for (child, t) in stack.child.chunks_mut(each).zip(stack.t.chunks_mut(each)) {
            // t = -∞ is before any far end, so a pop always stops here without checking for an
            // empty stack.
            child[..LOOK].fill(f32::from_bits(BOTTOM));
            t[..LOOK].fill(f32::NEG_INFINITY);
        }
        stack
    }

    /// Creates empty stacks for several rays in a hierarchy.
    pub(crate) fn for_rays(rays: usize, tree: &Tree) -> Self {
        Self::new(rays, tree.stack)
    }

    /// Returns the top of a ray's empty stack.
    #[inline(always)]
    pub(crate) fn bottom(&self, ray: usize) -> u32 {
        (ray * self.each + LOOK) as u32
    }

    /// Returns the contents of the stacks.
    #[inline(always)]
    pub(crate) fn entries(&mut self) -> Entries<'_> {
        // Slice both to the same length, so that one bounds check covers both.
        let len = self.child.len().min(self.t.len());
        Entries { child: &mut self.child[..len], t: &mut self.t[..len] }
    }
}

/// The contents of stacks.
pub(crate) struct Entries<'a> {
    child: &'a mut [f32],
    t: &'a mut [f32],
}

impl Entries<'_> {
    /// Pops the topmost entry whose box begins before `far` from the stack whose top is `top`.
    #[inline(always)]
    pub(crate) fn pop<S: Simd>(&self, top: &mut u32, far: f32) -> u32 {
        let mut at = *top as usize;
        loop {
            let near = S::F32x8::load(&self.t[at - LOOK..]).le(S::F32x8::splat(far)).bits();
            // There is one bit for each of the eight entries below `top`, with the topmost in the
            // highest bit, so the leading zeros count the entries whose boxes begin beyond `far`.
            // The bit below them limits the count to eight.
            let beyond = (near << 24 | 1 << 23).leading_zeros();
            at -= beyond as usize;
            if near != 0 {
                at -= 1;
                *top = at as u32;
                return self.child[at].to_bits();
            }
        }
    }

    /// Like [`Entries::pop`], but with lower latency, for a traversal that has to wait for the
    /// result: reading one entry at a time does not have to wait for recent writes to reach memory.
    #[inline(always)]
    pub(crate) fn pop_at_once(&self, top: &mut u32, far: f32) -> u32 {
        loop {
            *top -= 1;
            if self.t[*top as usize] <= far {
                return self.child[*top as usize].to_bits();
            }
        }
    }

    /// Pops the topmost entry, wherever its box begins.
    #[inline(always)]
    pub(crate) fn pop_last(&self, top: &mut u32) -> u32 {
        *top -= 1;
        self.child[*top as usize].to_bits()
    }

    /// Pushes the children of a node whose boxes the ray hits onto its stack, except for the first
    /// child, which is returned. Returns [`BOTTOM`] if the ray hits no box. `near` is the t at
    /// which each box begins. Children are pushed in the order of the ray's octant, which is
    /// usually near to far.
    #[inline(always)]
    pub(crate) fn push<S: Simd>(
        &mut self,
        top: &mut u32,
        node: &Node,
        octant: usize,
        met: <S::F32x8 as Lanes>::Mask,
        near: S::F32x8,
    ) -> u32 {
        // Write all children; the first one ends up beyond the top.
        let met = met.bits();
        let first = first_slot(met, octant);
        self.put::<S>(*top, node, far_to_near(met, octant), near);
        *top += met.count_ones().saturating_sub(1);
        node.child_or_none(first)
    }

    /// Pushes a root to be visited last.
    #[inline(always)]
    pub(crate) fn push_root(&mut self, top: &mut u32, root: u32) {
        let at = *top as usize;
        (self.child[at], self.t[at]) = (f32::from_bits(root), f32::NEG_INFINITY);
        *top += 1;
    }

    /// Like [`Entries::push`], but stores no t, for use with [`Entries::pop_last`]. The ray must
    /// hit at least one box.
    #[inline(always)]
    pub(crate) fn push_children<S: Simd>(
        &mut self,
        top: &mut u32,
        node: &Node,
        octant: usize,
        met: <S::F32x8 as Lanes>::Mask,
    ) -> u32 {
        let met = met.bits();
        let order = far_to_near(met, octant);
        S::permute(Lanes::load(node.child_lanes()), order).store(&mut self.child[*top as usize..]);
        *top += met.count_ones() - 1;
        node.child_or_none(first_slot(met, octant))
    }

    /// Like [`Entries::push`], but returns the nearest child and orders the others by octant. The
    /// ray must hit at least one box.
    #[inline(always)]
    pub(crate) fn push_nearest_first<S: Simd>(
        &mut self,
        top: &mut u32,
        node: &Node,
        octant: usize,
        met: <S::F32x8 as Lanes>::Mask,
        near: S::F32x8,
    ) -> u32 {
        // Only the first child is chosen by t. The order of the others matters less, and the
        // octant's order comes from a table.
        let nearest = S::lane_of_least(near, met) % 8;
        let others = met.bits() & !(1 << nearest);
        self.put::<S>(*top, node, far_to_near(others, octant), near);
        *top += others.count_ones();
        node.children()[nearest]
    }

    /// Writes a node's children and the t at which their boxes begin, in a given order.
    #[inline(always)]
    fn put<S: Simd>(&mut self, top: u32, node: &Node, order: u64, near: S::F32x8) {
        let top = top as usize;
        // Always write eight lanes. The lanes beyond the new `top` are garbage, which the next push
        // overwrites.
        S::permute(Lanes::load(node.child_lanes()), order).store(&mut self.child[top..]);
        S::permute(near, order).store(&mut self.t[top..]);
    }
}

#[cfg(test)]
mod tests {
    use intertri::simd::{Lanes, Level, Mask, Simd, WithSimd};

    use super::{BOTTOM, Stack};
    use crate::tree::Node;

    fn numbered() -> Node {
        let mut node = Node::NO_CHILDREN;
        *node.children_mut() = [10, 11, 12, 13, 14, 15, 16, 17];
        node
    }

    struct Traverse;
    impl WithSimd for Traverse {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self) {
            let node = numbered();
            let t = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
            let mut stack = Stack::new(2, 24);
            let mut top = stack.bottom(1);

            // Push three levels of eight children each, then pop everything that begins before 2.5.
            let mut stack = stack.entries();
            for _ in 0..3 {
                let all = Mask::from_bits(0xff);
                assert_eq!(stack.push::<S>(&mut top, &node, 0, all, Lanes::load(&t)), 10);
            }
            let none = Mask::from_bits(0);
            assert_eq!(stack.push::<S>(&mut top, &node, 0, none, Lanes::load(&t)), BOTTOM);
            let mut left = vec![];
            while left.last() != Some(&BOTTOM) {
                left.push(stack.pop::<S>(&mut top, 2.5));
            }
            assert_eq!(left, [11, 12, 11, 12, 11, 12, BOTTOM]);
        }
    }

    #[test]
    fn what_begins_too_late_is_dropped() {
        for level in Level::all() {
            level.run(Traverse);
        }
    }

    struct Nearest;
    impl WithSimd for Nearest {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self) {
            let node = numbered();
            let t = [3.0, 2.0, 6.0, 1.0, 0.5, 7.0, 5.0, 4.0];
            for octant in 0..8 {
                for bits in 1..256_u32 {
                    let mut stack = Stack::new(1, 8);
                    let (mut top, mut stack) = (stack.bottom(0), stack.entries());
                    let (met, near) = (Mask::from_bits(bits), Lanes::load(&t));
                    let first = stack.push_nearest_first::<S>(&mut top, &node, octant, met, near);
                    let mut found = vec![first];
                    while found.last() != Some(&BOTTOM) {
                        found.push(stack.pop_at_once(&mut top, f32::INFINITY));
                    }

                    // `push_children` does not sort by t, so all children are in the octant's
                    // order.
                    let mut by_octant = vec![stack.push_children::<S>(&mut 8, &node, octant, met)];
                    let mut top = 7 + bits.count_ones();
                    by_octant.extend((0..bits.count_ones()).map(|_| stack.pop_last(&mut top)));
                    let all = (0..8).map(|i| i ^ octant).filter(|slot| bits >> slot & 1 != 0);
                    assert!(all.map(|slot| 10 + slot as u32).chain([BOTTOM]).eq(by_octant));

                    // The nearest child comes first, then the other children in the octant's order.
                    let slots = (0..8).map(|i| i ^ octant).filter(|slot| bits >> slot & 1 != 0);
                    let mut slots: Vec<usize> = slots.collect();
                    let nearest =
                        (0..slots.len()).min_by(|&a, &b| t[slots[a]].total_cmp(&t[slots[b]]));
                    let nearest = slots.remove(nearest.unwrap());
                    slots.insert(0, nearest);
                    let expected = slots.iter().map(|&slot| 10 + slot as u32).chain([BOTTOM]);
                    assert!(expected.eq(found), "{octant} {bits:b}, {}", S::LEVEL.name());
                }
            }
        }
    }

    #[test]
    fn the_nearest_comes_first_and_the_others_by_the_octant() {
        for level in Level::all() {
            level.run(Nearest);
        }
    }
}
