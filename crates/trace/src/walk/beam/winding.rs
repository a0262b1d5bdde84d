//! Computes the containment of the origins of a beam's rays by counting crossings in the leaves.

use intertri::internal::{AlongAxis, Axis};
use intertri::simd::{Lanes, Mask, Simd, Vec3};
use intertri::{Counts, Filter, LeafSlot, PreparedPacket, Ray, RayId};

use super::tube::{RAYS, Tube};
use crate::containment::Containment;
use crate::tree::Tree;
use crate::util::lane_ops::lanes_of;
use crate::walk::single::Visit;

/// If a beam takes more work than this, tracing its rays one by one is faster. Work is measured as
/// the number of triangles that the tube reaches.
const BUDGET: usize = 256;

/// The fixed amount of work for visiting a leaf.
const LEAF: usize = 4;

/// The state of a beam that is being traced.
pub(super) struct Winding<'a, 'b, S: Simd> {
    tree: &'a Tree,
    filter: Filter<'a>,
    /// The rays, and the ID of the first ray.
    rays: (&'b [Ray], RayId),
    packet: PreparedPacket<'b, S, RAYS>,
    axis: Axis,
    beside: Vec3<S::F32x16>,
    along: &'b mut AlongAxis,
    /// A mask of the rays whose origins have not been found to be on a triangle.
    live: u32,
    /// For each ray, the sum of the signed crossings that the filter considers certain.
    sure: S::F32x16,
    /// The containment of each origin, based on the crossings that the resolver decided.
    settled: [Containment; RAYS],
    work: usize,
    counts: &'b mut Counts,
}

impl<S: Simd> Visit for Winding<'_, '_, S> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        let block = &self.tree.leaves[leaf].block;
        let reached = self.filter.along_in::<S>(&self.axis, block, self.along);
        self.work += LEAF + reached.count_ones() as usize;
        for lane in lanes_of(reached) {
            let maybe = self.along.maybe_in::<S>(lane, &self.beside) & self.live;
            if maybe == 0 {
                continue;
            }
            let hits = self.filter.lane_hits_in::<S>(&self.packet, block, lane, maybe, self.counts);
            let sure = <S::F32x16 as Lanes>::Mask::from_bits(hits.sure);
            let one = S::F32x16::splat(if hits.leaves { 1.0 } else { -1.0 });
            self.sure = self.sure + S::F32x16::select(sure, one, S::F32x16::splat(0.0));
            if hits.undecided != 0 {
                self.settle(hits.undecided, LeafSlot((8 * leaf + lane) as u32));
            }
        }
        let goes_on = self.live != 0 && !self.is_too_much();
        goes_on.then_some(f32::INFINITY)
    }
}

impl<'a, 'b, S: Simd> Winding<'a, 'b, S> {
    #[inline(always)]
    pub(super) fn new(
        tree: &'a Tree,
        filter: Filter<'a>,
        rays: (&'b [Ray], RayId),
        packet: PreparedPacket<'b, S, RAYS>,
        tube: &Tube<S>,
        along: &'b mut AlongAxis,
        counts: &'b mut Counts,
    ) -> Self {
        let axis = filter.axis(&tube.axis, tube.reach, tube.away);
        let (beside, live) = (tube.beside, (1 << rays.0.len()) - 1);
        let (sure, settled) = (S::F32x16::splat(0.0), [Containment::Outside; RAYS]);
        let work = 0;
        Self { tree, filter, rays, packet, axis, beside, along, live, sure, settled, work, counts }
    }
    /// Returns whether the beam takes too much work.
    #[inline(always)]
    fn is_too_much(&self) -> bool {
        self.work > BUDGET
    }

    /// Decides whether the rays that the filter leaves undecided cross the triangle in a slot.
    #[cold]
    #[inline(never)]
    fn settle(&mut self, undecided: u32, slot: LeafSlot) {
        let (triangle, resolver) = (self.tree.triangle_in(slot), self.filter.resolver());
        let (rays, first) = self.rays;
        let pair = |lane: usize| (rays[lane], triangle, (RayId(first.0 + lane as u32), slot));
        let mut elsewhere = undecided;
        for lane in lanes_of(undecided) {
            if resolver.starts_on(&rays[lane], &triangle, pair(lane).2) {
                self.settled[lane] = Containment::Surface;
                self.live &= !(1 << lane);
                elsewhere &= !(1 << lane);
            }
        }
        if elsewhere == 0 {
            return;
        }
        let [crossed, leaving] = resolver.crossings(elsewhere, pair);
        for lane in lanes_of(crossed) {
            self.settled[lane] = self.settled[lane].crossed(leaving >> lane & 1 != 0);
        }
    }

    /// Writes the containments, unless the beam took too much work. Returns whether they were
    /// written.
    #[inline(always)]
    pub(super) fn write(&self, containments: &mut [Containment]) -> bool {
        if self.is_too_much() {
            return false;
        }
        let mut sure = [0.0; RAYS];
        self.sure.store(&mut sure);
        for ((containment, settled), sure) in containments.iter_mut().zip(&self.settled).zip(sure) {
            *containment = settled.wound(sure as i32);
        }
        true
    }
}
