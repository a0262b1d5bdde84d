//! Tests a packet's rays at the leaves: finds the closest hit of each ray, or whether it hits
//! anything.

use intertri::internal::{NumberedPacket, prefetch};
use intertri::simd::{Lanes, Mask, Simd};
use intertri::{ClosestHits, Counts, Filter, LeafSlot, PreparedPacket, Ray, RayId};

use super::traverse::{RAYS, VisitTogether};
use crate::selection::closest_in_leaf;
use crate::tree::Tree;
use crate::util::lane_ops::lanes_of;

/// The rays of a packet, which search for their closest hits or, with `ANY`, for any hits.
pub(super) struct LeafTests<'a, 'b, S: Simd, const ANY: bool> {
    tree: &'a Tree,
    filter: Filter<'a>,
    /// The rays, and the ID of the first ray.
    rays: (&'b [Ray], RayId),
    packet: PreparedPacket<'b, S, RAYS>,
    /// A mask of the rays that are still searching for a hit.
    live: u32,
    pub(super) closest: ClosestHits<S::F32x16, RAYS>,
    /// With `ANY`, a mask of the rays that hit something.
    pub(super) hit: u32,
    counts: &'b mut Counts,
}

impl<S: Simd, const ANY: bool> VisitTogether<S::F32x16> for LeafTests<'_, '_, S, ANY> {
    #[inline(always)]
    fn far(&self) -> S::F32x16 {
        let live = <S::F32x16 as Lanes>::Mask::from_bits(self.live);
        S::F32x16::select(live, self.closest.t_hi(), S::F32x16::splat(f32::NAN))
    }

    #[inline(always)]
    fn prefetch(&self, leaf: usize) {
        prefetch(&self.tree.leaves[leaf..][..1]);
    }

    #[inline(always)]
    fn visit(&mut self, leaf: usize, reaching: <S::F32x16 as Lanes>::Mask) {
        let (reaching, triangles) = (reaching.bits(), self.tree.leaves[leaf].block.live());
        // Fill the lanes with the triangles or the rays, whichever are more numerous.
        if reaching.count_ones() < triangles.count_ones() {
            for lane in lanes_of(reaching) {
                self.test_ray(leaf, lane);
            }
        } else {
            for lane in lanes_of(triangles) {
                // A large triangle often ends the search of all rays.
                if ANY && self.live & reaching == 0 {
                    break;
                }
                self.test_triangle(leaf, lane, reaching);
            }
        }
    }
}

impl<'a, 'b, S: Simd, const ANY: bool> LeafTests<'a, 'b, S, ANY> {
    #[inline(always)]
    pub(super) fn new(
        (tree, filter): (&'a Tree, Filter<'a>),
        rays: (&'b [Ray], RayId),
        packet: PreparedPacket<'b, S, RAYS>,
        closest: ClosestHits<S::F32x16, RAYS>,
        counts: &'b mut Counts,
    ) -> Self {
        Self { tree, filter, rays, packet, live: 0, closest, hit: 0, counts }
    }

    /// Starts a search with the given rays.
    #[inline(always)]
    pub(super) fn begin(&mut self, rays: u32) {
        self.live = rays;
    }

    /// Tests the ray in a lane against the triangles of a leaf. Returns the t beyond which hits of
    /// the ray no longer count.
    #[inline(always)]
    fn test_ray(&mut self, leaf: usize, lane: usize) -> f32 {
        let Self { tree, ref filter, rays: (rays, first), .. } = *self;
        let ray = filter.prepare_numbered(&rays[lane], RayId(first.0 + lane as u32));
        let before = self.closest.lane(lane);
        let mut closest = before;
        closest_in_leaf::<S>(&None, tree, filter, &ray, leaf, &mut closest, self.counts);
        if closest.triangle() != before.triangle() {
            self.closest.set(lane, &closest);
            if ANY {
                self.hit |= 1 << lane;
                self.live &= !self.hit;
            }
        }
        closest.t_hi()
    }

    /// Tests the given rays against the triangle in a lane of a leaf.
    #[inline(always)]
    fn test_triangle(&mut self, leaf: usize, lane: usize, rays: u32) {
        let Self { tree, filter, ref packet, .. } = *self;
        let live = rays & self.live;
        let block = &tree.leaves[leaf].block;
        let slot = LeafSlot((8 * leaf + lane) as u32);
        if ANY {
            let hits = filter.lane_hits_in::<S>(packet, block, lane, live, self.counts);
            let settled = if hits.undecided != 0 { self.settle(hits.undecided, slot) } else { 0 };
            self.hit |= hits.sure | settled;
            self.live &= !self.hit;
        } else {
            let (names, find) = ((tree.index_of(slot), slot), |slot| tree.triangle_in(slot));
            let rays = NumberedPacket { packet, first: self.rays.1, live };
            let closest = &mut self.closest;
            rays.offer_hits_with((block, lane), names, find, &filter, closest, self.counts);
        }
    }

    /// Returns a mask of the undecided rays that hit the triangle in a slot.
    #[cold]
    #[inline(never)]
    fn settle(&self, undecided: u32, slot: LeafSlot) -> u32 {
        let (triangle, resolver, (rays, first)) =
            (self.tree.triangle_in(slot), self.filter.resolver(), self.rays);
        let pair = |lane| (rays[lane], triangle, (RayId(first.0 + lane as u32), slot));
        resolver.meeting(undecided, pair)
    }
}
