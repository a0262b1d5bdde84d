//! Traverses the hierarchy with beams, one after another.

use intertri::internal::AlongAxis;
use intertri::simd::{Simd, WithSimd};
use intertri::{Counts, Filter, Ray, RayId, RayPacket};

use super::tube::{RAYS, Tube};
use super::winding::Winding;
use crate::containment::Containment;
use crate::tree::Tree;
use crate::util::stop;
use crate::walk::single::{SlabLanes, TraversalScratch, Walk, octant};

/// The number of beams to skip after one that could not be formed or took too much work.
const PATIENCE: usize = 32;

/// Classifies the origins of rays. Rays with the same direction are traced as beams.
pub(crate) struct Beams<'a, 'b> {
    pub(crate) tree: &'a Tree,
    pub(crate) filter: Filter<'a>,
    pub(crate) rays: &'a [Ray],
    pub(crate) containments: &'b mut [Containment],
    pub(crate) counts: &'b mut Counts,
}

impl WithSimd for Beams<'_, '_> {
    /// The rays that were not traced.
    type Output = Vec<RayId>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<RayId> {
        let Self { tree, filter, rays, containments, counts } = self;
        let (mut left, mut wait) = (Vec::new(), 0);
        let (scratch, along) = (&mut *TraversalScratch::lend(tree), &mut AlongAxis::default());
        let chunks = rays.chunks(RAYS).zip(containments.chunks_mut(RAYS));
        for (i, (rays, containments)) in chunks.enumerate() {
            stop::heed();
            let first = (i * RAYS) as u32;
            let mut is_done = false;
            if wait > 0 {
                wait -= 1;
            } else {
                let packet = RayPacket::new(rays);
                if let Some(tube) = Tube::<S>::new(&packet, &tree.margin(filter.resolver())) {
                    let packet = filter.prepare_packet_in::<S, RAYS>(&packet);
                    let rays = (rays, RayId(first));
                    let mut winding =
                        Winding::new(tree, filter, rays, packet, &tube, along, counts);
                    let octant = octant(&tube.axis);
                    let interval = [tube.axis.t_min, tube.axis.t_max];
                    let unboxed = tree.first_unboxed(filter.resolver());
                    let walk = Walk::new(tree, octant, interval, unboxed);
                    walk.run::<S>(&SlabLanes::splat(&tube.slabs, octant), scratch, &mut winding);
                    is_done = winding.write(containments);
                }
                wait = if is_done { 0 } else { PATIENCE };
            }
            if !is_done {
                left.extend((first..).map(RayId).take(rays.len()));
            }
        }
        left
    }
}
