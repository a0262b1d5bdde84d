//! The node step of a stream: tests the child boxes of each active ray's node and picks the node or
//! leaf that the ray visits next.

use intertri::internal::prefetch;
use intertri::simd::{Level, Simd, WithSimd};

use super::active::{ACTIVE, RayState, Set};
use crate::tree::{LEAF, Tree};
use crate::walk::single::{BOTTOM, SlabLanes, Stack};

/// Visits the current node of each ray in `at`. The directions of these rays must all be in
/// `octant`. Returns the rays that are now at an inner node, and the rays that hit no child.
#[inline(always)]
pub(super) fn visit_nodes(
    level: Level,
    octant: usize,
    tree: &Tree,
    states: &mut [RayState; ACTIVE],
    stacks: &mut Stack,
    at: Set,
) -> (Set, Set) {
    match octant {
        0 => level.run(Nodes::<0> { tree, states, stacks, at }),
        1 => level.run(Nodes::<1> { tree, states, stacks, at }),
        2 => level.run(Nodes::<2> { tree, states, stacks, at }),
        3 => level.run(Nodes::<3> { tree, states, stacks, at }),
        4 => level.run(Nodes::<4> { tree, states, stacks, at }),
        5 => level.run(Nodes::<5> { tree, states, stacks, at }),
        6 => level.run(Nodes::<6> { tree, states, stacks, at }),
        _ => level.run(Nodes::<7> { tree, states, stacks, at }),
    }
}

/// The node step for rays in one octant. The octant is a constant, so the near and far sides of a
/// box are known at compile time.
struct Nodes<'a, const OCTANT: usize> {
    tree: &'a Tree,
    states: &'a mut [RayState; ACTIVE],
    stacks: &'a mut Stack,
    at: Set,
}

impl<const OCTANT: usize> WithSimd for Nodes<'_, OCTANT> {
    type Output = (Set, Set);

    #[inline(always)]
    fn run<S: Simd>(self) -> (Set, Set) {
        let Self { tree, states, stacks, at } = self;
        let (mut at_node, mut met_nothing) = (Set::EMPTY, Set::EMPTY);
        let mut stacks = stacks.entries();
        for place in at.places() {
            let state = &mut states[place];
            let node = &tree.nodes[state.next as usize];
            let lanes = SlabLanes::<S::F32x8>::unpack(&state.slabs, OCTANT);
            let (met, near) = lanes.meet(node, state.t_min, state.far);
            // The ray next visits the nearest child that it hits; the other children that it hits
            // go onto its stack.
            let next = stacks.push::<S>(&mut state.top, node, OCTANT, met, near);
            state.next = next;
            at_node.put(place, next & LEAF == 0);
            met_nothing.put(place, next == BOTTOM);
        }
        (at_node, met_nothing)
    }
}

/// Prefetches the nodes or leaves that the rays in `at` visit next. `things` is the array of all
/// nodes or of all leaves.
#[inline(always)]
pub(super) fn prefetch_next<T>(things: &[T], states: &[RayState; ACTIVE], at: Set) {
    for place in at.places() {
        prefetch(&things[(states[place].next & !LEAF) as usize..][..1]);
    }
}
