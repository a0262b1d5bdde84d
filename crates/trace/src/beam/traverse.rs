//! The walk of one beam after another.

use intertri::internal::{AlongAxis, Filter};
use intertri::simd::{Simd, WithSimd};
use intertri::{Counts, LaneQueries, Ray, RayPacket};

use super::tube::{RAYS, Tube};
use super::winding::Winding;
use crate::place::Place;
use crate::single::{Kept, SlabLanes, Walk, octant};
use crate::stop;
use crate::tree::Tree;

/// Where one was too much work, the next are not tried: so many.
const PATIENCE: usize = 32;

/// Finds where rays start, those that go the same way as beams.
pub(crate) struct Beams<'a, 'b> {
    pub(crate) bvh: &'a Tree,
    pub(crate) test: Filter<'a>,
    pub(crate) rays: &'a [Ray],
    pub(crate) places: &'b mut [Place],
    pub(crate) counts: &'b mut Counts,
}

impl WithSimd for Beams<'_, '_> {
    /// The numbers of the rays that are left.
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<u32> {
        let Self { bvh, test, rays, places, counts } = self;
        let (mut left, mut wait) = (Vec::new(), 0);
        let (kept, along) = (&mut *Kept::lend(bvh), &mut AlongAxis::default());
        for (i, (rays, places)) in rays.chunks(RAYS).zip(places.chunks_mut(RAYS)).enumerate() {
            stop::heed();
            let first = (i * RAYS) as u32;
            let mut is_done = false;
            if wait > 0 {
                wait -= 1;
            } else {
                let packet = RayPacket::new(rays);
                if let Some(tube) = Tube::<S>::new(&packet, &bvh.margin(test.resolver())) {
                    let packet = test.prepare_packet_in::<S, RAYS>(&packet);
                    let rays = (rays, first);
                    let mut winding = Winding::new(bvh, test, rays, packet, &tube, along, counts);
                    let octant = octant(&tube.axis);
                    let walk = Walk {
                        bvh,
                        octant,
                        t_min: tube.axis.t_min,
                        far: tube.axis.t_max,
                        shortens: false,
                        unboxed: bvh.first_unboxed(test.resolver()),
                        closest: false,
                    };
                    walk.run::<S>(&SlabLanes::splat(&tube.slabs, octant), kept, &mut winding);
                    is_done = winding.write(places);
                }
                wait = if is_done { 0 } else { PATIENCE };
            }
            if !is_done {
                left.extend((first..).take(rays.len()));
            }
        }
        left
    }
}
