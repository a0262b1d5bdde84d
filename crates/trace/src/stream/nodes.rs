//! The nodes that active rays are at: their boxes, and where each ray goes on.

use intertri::internal::prefetch;
use intertri::simd::{Level, Simd, WithSimd};

use super::active::{ACTIVE, Set, Way};
use crate::single::{BOTTOM, SlabLanes, Stack};
use crate::tree::{LEAF, Tree};

/// Tests the boxes of the nodes that rays of an octant are at. Gives who is at a node next, and who met
/// nothing.
#[inline(always)]
pub(super) fn visit_nodes(
    level: Level,
    octant: usize,
    bvh: &Tree,
    ways: &mut [Way; ACTIVE],
    stacks: &mut Stack,
    at: Set,
) -> (Set, Set) {
    match octant {
        0 => level.run(Nodes::<0> { bvh, ways, stacks, at }),
        1 => level.run(Nodes::<1> { bvh, ways, stacks, at }),
        2 => level.run(Nodes::<2> { bvh, ways, stacks, at }),
        3 => level.run(Nodes::<3> { bvh, ways, stacks, at }),
        4 => level.run(Nodes::<4> { bvh, ways, stacks, at }),
        5 => level.run(Nodes::<5> { bvh, ways, stacks, at }),
        6 => level.run(Nodes::<6> { bvh, ways, stacks, at }),
        _ => level.run(Nodes::<7> { bvh, ways, stacks, at }),
    }
}

/// The nodes that rays of an octant are at: which side of a box is the near one is known when this is
/// compiled.
struct Nodes<'a, const OCTANT: usize> {
    bvh: &'a Tree,
    ways: &'a mut [Way; ACTIVE],
    stacks: &'a mut Stack,
    at: Set,
}

impl<const OCTANT: usize> WithSimd for Nodes<'_, OCTANT> {
    type Output = (Set, Set);

    #[inline(always)]
    fn run<S: Simd>(self) -> (Set, Set) {
        let Self { bvh, ways, stacks, at } = self;
        let (mut at_node, mut met_nothing) = (Set::EMPTY, Set::EMPTY);
        let mut stacks = stacks.entries();
        for place in at.places() {
            let way = &mut ways[place];
            let node = &bvh.nodes[way.next as usize];
            let lanes = SlabLanes::<S::F32x8>::unpack(&way.slabs, OCTANT);
            let (met, near) = lanes.meet(node, way.t_min, way.far);
            let next = stacks.push::<S>(&mut way.top, node, OCTANT, met, near);
            way.next = next;
            at_node.put(place, next & LEAF == 0);
            met_nothing.put(place, next == BOTTOM);
        }
        (at_node, met_nothing)
    }
}

/// Prefetches those of `things` that rays visit next.
#[inline(always)]
pub(super) fn prefetch_next<T>(things: &[T], ways: &[Way; ACTIVE], at: Set) {
    for place in at.places() {
        prefetch(&things[(ways[place].next & !LEAF) as usize..][..1]);
    }
}
