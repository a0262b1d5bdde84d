//! What winds around the points where the rays of a beam start: the crossings at the leaves.

use intertri::internal::exact::Side;
use intertri::internal::{AlongAxis, Axis, Filter};
use intertri::simd::{Lanes, Mask, Simd, Vec3};
use intertri::{Counts, PreparedPacket, Ray};

use super::tube::{RAYS, Tube};
use crate::across::lanes_of;
use crate::place::Place;
use crate::single::Visit;
use crate::tree::Tree;

/// So much work, and rays are faster one by one: in triangles that the tube reaches.
const BUDGET: usize = 256;

/// So much work is a leaf.
const LEAF: usize = 4;

/// The rays of a beam on their way.
pub(super) struct Winding<'a, 'b, S: Simd> {
    bvh: &'a Tree,
    test: Filter<'a>,
    /// The rays, and the number of the first.
    rays: (&'b [Ray], u32),
    packet: PreparedPacket<'b, Filter<'a>, S, RAYS>,
    axis: Axis,
    beside: Vec3<S::F32x16>,
    along: &'b mut AlongAxis,
    /// Those that are on no triangle so far.
    live: u32,
    /// What the filter is sure of, and the resolver.
    sure: S::F32x16,
    settled: [Place; RAYS],
    work: usize,
    counts: &'b mut Counts,
}

impl<S: Simd> Visit for Winding<'_, '_, S> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        let block = &self.bvh.leaves[leaf].block;
        let reached = self.test.along_in::<S>(&self.axis, block, self.along);
        self.work += LEAF + reached.count_ones() as usize;
        for lane in lanes_of(reached) {
            let maybe = self.along.maybe_in::<S>(lane, &self.beside) & self.live;
            if maybe == 0 {
                continue;
            }
            let hits = self.test.lane_hits_in::<S>(&self.packet, block, lane, maybe, self.counts);
            let sure = <S::F32x16 as Lanes>::Mask::from_bits(hits.sure);
            let one = S::F32x16::splat(if hits.leaves { 1.0 } else { -1.0 });
            self.sure = self.sure + S::F32x16::select(sure, one, S::F32x16::splat(0.0));
            if hits.undecided != 0 {
                self.settle(hits.undecided, (8 * leaf + lane) as u32);
            }
        }
        let goes_on = self.live != 0 && !self.is_too_much();
        goes_on.then_some(f32::INFINITY)
    }
}

impl<'a, 'b, S: Simd> Winding<'a, 'b, S> {
    #[inline(always)]
    pub(super) fn new(
        bvh: &'a Tree,
        test: Filter<'a>,
        rays: (&'b [Ray], u32),
        packet: PreparedPacket<'b, Filter<'a>, S, RAYS>,
        tube: &Tube<S>,
        along: &'b mut AlongAxis,
        counts: &'b mut Counts,
    ) -> Self {
        let axis = test.axis(&tube.axis, tube.reach, tube.away);
        let (beside, live) = (tube.beside, (1 << rays.0.len()) - 1);
        let (sure, settled) = (S::F32x16::splat(0.0), [Place::Outside; RAYS]);
        let work = 0;
        Self { bvh, test, rays, packet, axis, beside, along, live, sure, settled, work, counts }
    }
    /// Whether it is too much work for a beam.
    #[inline(always)]
    fn is_too_much(&self) -> bool {
        self.work > BUDGET
    }

    /// The rays that the filter leaves undecided with the triangle in a place.
    #[cold]
    #[inline(never)]
    fn settle(&mut self, undecided: u32, place: u32) {
        let (triangle, resolver) = (self.bvh.triangle_in(place), self.test.resolver());
        let (rays, first) = self.rays;
        for lane in lanes_of(undecided) {
            let (ray, numbers) = (&rays[lane], (first + lane as u32, place));
            let settled = &mut self.settled[lane];
            if resolver.starts_on(ray, &triangle, numbers) {
                *settled = Place::Surface;
                self.live &= !(1 << lane);
            } else if let Some(side) = resolver.crossing(ray, &triangle, numbers) {
                *settled = settled.crossed(side == Side::Leaves);
            }
        }
    }

    /// Writes where the rays start, unless that was too much work; whether it was not.
    #[inline(always)]
    pub(super) fn write(&self, places: &mut [Place]) -> bool {
        if self.is_too_much() {
            return false;
        }
        let mut sure = [0.0; RAYS];
        self.sure.store(&mut sure);
        for ((place, settled), sure) in places.iter_mut().zip(&self.settled).zip(sure) {
            *place = settled.wound(sure as i32);
        }
        true
    }
}
