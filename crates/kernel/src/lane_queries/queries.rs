//! The filter's queries, for your own BVHs. Call them in loops that run under
//! [`WithSimd`](crate::simd::WithSimd).

use super::lane_pairs::{DecidedLanes, LanePairs, RayOnBlock, RaysOnTriangle};
use super::open_lanes::OpenLanes;
use super::{ClosestHit, ClosestHits};
use crate::exact::PairDecision;
use crate::filter::{Counts, Filter, Rays, Triangles, Verdicts};
use crate::filter::{PreparedPacket, PreparedRay, PreparedTriangle};
use crate::packet::{PacketHits, RayPacket, TriangleBlock};
use crate::simd::{Lane, Lanes, Mask, Simd, Width, lanes_of};
use crate::{Hit, LeafSlot, Ray, RayId, Triangle, TriangleId};

/// N f32 lanes at an instruction level.
type F32s<S, const N: usize> = <Lane<N> as Width>::F<S>;

/// Tests of one ray against N triangles: all hits, or the closest hit so far.
impl Filter<'_> {
    /// Finds all hits of one ray on N triangles.
    #[inline(always)]
    pub fn block_in<S: Simd, const N: usize>(
        &self,
        ray: &Ray,
        block: &TriangleBlock<N>,
        counts: &mut Counts,
    ) -> PacketHits<N>
    where
        Lane<N>: Width,
    {
        let PreparedRay { ray, id, lanes, .. } = &self.prepare_ray(ray);
        let (lanes, triangles) = (Rays::splat(lanes), Triangles::of_block(block, self.room()));
        let far = Lanes::splat(ray.t_max);
        let verdicts = self.test::<F32s<S, N>>(&triangles, &lanes, far, block.live(), counts);
        let (first, find) = (LeafSlot(0), |LeafSlot(slot)| block.triangle(slot as usize));
        let pairs = RayOnBlock { resolver: self.resolver(), ray, id: *id, block, first, find };
        all_hits(&verdicts, |_| self.sure_end(ray.t_max), &pairs)
    }

    /// Tests one ray against a block and updates the ray's closest hit. Lane i of the block has the
    /// index `indices[i]` and the slot `first + i`.
    ///
    /// ```
    /// use intertri::simd::{Simd, WithSimd, dispatch};
    /// use intertri::{ClosestHit, Counts, Filter, Hit, LeafSlot, Mode, Ray, Triangle, TriangleBlock};
    ///
    /// /// Finds the closest hit of a ray, eight triangles at a time.
    /// struct Loop<'a>(Filter<'a>, &'a Ray, &'a [Triangle]);
    /// impl WithSimd for Loop<'_> {
    ///     type Output = Option<Hit>;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> Option<Hit> {
    ///         let Self(filter, ray, triangles) = self;
    ///         let (prepared, mut closest) = (filter.prepare_ray(ray), ClosestHit::new(ray.t_max));
    ///         let find = |LeafSlot(slot)| triangles[slot as usize];
    ///         let mut counts = Counts::default();
    ///         for (i, eight) in (0..).step_by(8).zip(triangles.chunks(8)) {
    ///             let (block, first) = (TriangleBlock::new(eight), LeafSlot(i));
    ///             let indices = std::array::from_fn(|lane| i + lane as u32);
    ///             filter.closest_in::<S>(&prepared, &block, &indices, first, find, &mut closest, &mut counts);
    ///         }
    ///         filter.hit(ray, &closest, find)
    ///     }
    /// }
    ///
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let walls: Vec<Triangle> = (1..20).map(|i| at(20.0 - i as f32)).collect();
    /// let (mode, ray) = (Mode::exact(), Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]));
    /// assert_eq!(dispatch(Loop(mode.filter(), &ray, &walls)), mode.closest(&walls, &ray));
    /// ```
    #[inline(always)]
    pub fn closest_in<S: Simd>(
        &self,
        ray: &PreparedRay,
        block: &TriangleBlock<8>,
        indices: &[u32; 8],
        first: LeafSlot,
        find: impl Fn(LeafSlot) -> Triangle,
        closest: &mut ClosestHit,
        counts: &mut Counts,
    ) {
        let keep = |lanes| lanes;
        self.closest_among_in::<S>(ray, block, indices, first, find, keep, closest, counts);
    }

    /// Like [`Filter::closest_in`], but only for the triangles that a closure selects. If any lanes
    /// may be hits, `keep` is called with a mask of these lanes and returns the lanes to consider.
    ///
    /// ```
    /// use intertri::simd::{Simd, WithSimd, dispatch};
    /// use intertri::{ClosestHit, Counts, LeafSlot, Mode, Ray, Triangle, TriangleBlock, TriangleId};
    ///
    /// /// Finds the closest of two walls, ignoring the lanes in a mask.
    /// struct Without<'a>(u32, &'a Ray, &'a [Triangle; 2]);
    /// impl WithSimd for Without<'_> {
    ///     type Output = Option<TriangleId>;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> Self::Output {
    ///         let Self(skip, ray, walls) = self;
    ///         let (filter, block) = (Mode::exact().filter(), TriangleBlock::new(walls));
    ///         let (mut closest, counts) = (ClosestHit::new(ray.t_max), &mut Counts::default());
    ///         let (find, keep) = (|LeafSlot(slot)| walls[slot as usize], |lanes| lanes & !skip);
    ///         let (ray, indices, first) = (filter.prepare_ray(ray), [0, 1, 2, 3, 4, 5, 6, 7], LeafSlot(0));
    ///         filter.closest_among_in::<S>(&ray, &block, &indices, first, find, keep, &mut closest, counts);
    ///         closest.triangle().map(|(triangle, _)| triangle)
    ///     }
    /// }
    ///
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let (walls, ray) = ([at(3.0), at(5.0)], Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]));
    /// let without = [0b00, 0b01, 0b11].map(|skip| dispatch(Without(skip, &ray, &walls)));
    /// assert_eq!(without, [Some(TriangleId(0)), Some(TriangleId(1)), None]);
    /// ```
    #[inline(always)]
    pub fn closest_among_in<S: Simd>(
        &self,
        prepared: &PreparedRay,
        block: &TriangleBlock<8>,
        indices: &[u32; 8],
        first: LeafSlot,
        find: impl Fn(LeafSlot) -> Triangle,
        keep: impl FnOnce(u32) -> u32,
        closest: &mut ClosestHit,
        counts: &mut Counts,
    ) {
        let PreparedRay { ray, id, lanes, .. } = prepared;
        let live = prepared.live_lanes(block, counts);
        if live == 0 {
            return;
        }
        let (lanes, triangles) = (Rays::splat(lanes), Triangles::of_block(block, self.room()));
        // The filter treats any lane that is certainly beyond the closest hit so far as a miss.
        let far = Lanes::splat(closest.t_hi());
        let mut verdicts = self.test::<S::F32x8>(&triangles, &lanes, far, live, counts);
        // Return before calling `keep`: a leaf usually has no candidates, so selecting among them
        // would be wasted work.
        if verdicts.lanes() == 0 {
            return;
        }
        verdicts.keep(keep(verdicts.lanes()));
        let pairs = RayOnBlock { resolver: self.resolver(), ray, id: *id, block, first, find };
        closest.offer_block(&verdicts, indices, first, &pairs);
    }

    /// Returns the closest hit of a ray, with t and the weights.
    #[inline(always)]
    pub fn hit(
        &self,
        ray: &Ray,
        closest: &ClosestHit,
        find: impl Fn(LeafSlot) -> Triangle,
    ) -> Option<Hit> {
        let (triangle, slot) = closest.triangle()?;
        Some(self.resolver().hit_attributes(ray, &find(slot), triangle, (RayId(0), slot)))
    }

    /// Returns the initial record of a ray, with no hit yet.
    #[doc(hidden)]
    #[inline(always)]
    pub fn no_hit(&self, ray: &Ray) -> ClosestHit {
        ClosestHit::before(self.sure_end(ray.t_max), ray.t_max)
    }
}

impl Filter<'_> {
    /// Returns the initial records of N rays, with no hits yet.
    #[doc(hidden)]
    #[inline(always)]
    pub fn no_hits<F: Lanes<Scalar = f32>, const N: usize>(
        &self,
        packet: &RayPacket<N>,
    ) -> ClosestHits<F, N> {
        ClosestHits::before(self.sure_ends(&packet.t_max), &packet.t_max)
    }
}

/// Tests of N rays against one triangle: all hits, which rays hit, or the closest hits so far.
impl Filter<'_> {
    /// Finds all hits of N rays on one triangle.
    #[inline(always)]
    pub fn packet_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, S, N>,
        triangle: &PreparedTriangle,
        counts: &mut Counts,
    ) -> PacketHits<N>
    where
        Lane<N>: Width,
    {
        let packet = rays.packet;
        let verdicts =
            self.test_packet(rays, triangle, Lanes::load(&packet.t_max), packet.live(), counts);
        let find = |_| *triangle.triangle();
        let pairs = self.rays_on(packet, triangle.triangle(), LeafSlot(0), find);
        all_hits(&verdicts, |lane| self.sure_end(packet.t_max[lane]), &pairs)
    }

    /// Finds which of N rays hit one triangle and returns them as bits. Unlike
    /// [`Filter::packet_in`], this function does not compute t in f64, which is slow for undecided
    /// pairs. Only the lanes in `live` take part.
    ///
    /// ```
    /// use intertri::simd::{Simd, WithSimd, dispatch};
    /// use intertri::{Counts, Mode, PreparedTriangle, Ray, RayPacket, Triangle};
    ///
    /// /// Finds the rays that a wall stops.
    /// struct Shadow<'a>(&'a RayPacket<8>, &'a Triangle);
    /// impl WithSimd for Shadow<'_> {
    ///     type Output = u32;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> u32 {
    ///         let (filter, mut counts) = (Mode::exact().filter(), Counts::default());
    ///         let rays = filter.prepare_packet_in::<S, 8>(self.0);
    ///         filter.packet_any_in(&rays, &PreparedTriangle::new(self.1), self.0.live(), &mut counts)
    ///     }
    /// }
    ///
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// // Rays inside, on the longest edge, and one f32 step outside that edge, and a ray that ends
    /// // at the wall.
    /// let ray = |y: f32| Ray::new([0.5, y, 0.0], [0.0, 0.0, 1.0]);
    /// let rays = [ray(0.25), ray(0.5), ray(0.5_f32.next_up()), ray(0.25).between(0.0, 5.0)];
    /// assert_eq!(dispatch(Shadow(&RayPacket::new(&rays), &wall)), 0b0011);
    /// ```
    #[inline(always)]
    pub fn packet_any_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, S, N>,
        triangle: &PreparedTriangle,
        live: u32,
        counts: &mut Counts,
    ) -> u32
    where
        Lane<N>: Width,
    {
        let packet = rays.packet;
        let verdicts = self.test_packet(rays, triangle, Lanes::load(&packet.t_max), live, counts);
        let find = |_| *triangle.triangle();
        let pairs = self.rays_on(packet, triangle.triangle(), LeafSlot(0), find);
        // A certain hit does not need an exact t if its interval of t ends before the far end of
        // the ray.
        let sure = verdicts.hit & verdicts.t_hi.lt(self.sure_ends(&packet.t_max)).bits();
        // The resolver decides the other lanes: undecided lanes, and hits whose interval of t
        // reaches the far end.
        let open = verdicts.lanes() & !sure;
        if open == 0 { sure } else { sure | pairs.meeting(open) }
    }

    /// Tests N rays against one triangle and updates the rays' closest hits. Only the lanes in
    /// `live` take part.
    ///
    /// ```
    /// use intertri::simd::{Lane, Simd, Width, WithSimd, dispatch};
    /// use intertri::{ClosestHits, Counts, Filter, LeafSlot, Mode, PreparedTriangle, Ray, RayPacket};
    /// use intertri::{Triangle, TriangleId};
    ///
    /// /// Finds what each of eight rays hits first, and where.
    /// struct Closest<'a>(Filter<'a>, &'a RayPacket<8>, &'a [Triangle]);
    /// impl WithSimd for Closest<'_> {
    ///     type Output = ([Option<TriangleId>; 8], [f64; 8]);
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> Self::Output {
    ///         let Self(filter, packet, triangles) = self;
    ///         let rays = filter.prepare_packet_in::<S, 8>(packet);
    ///         let find = |LeafSlot(slot)| triangles[slot as usize];
    ///         let (live, counts) = (packet.live(), &mut Counts::default());
    ///         let mut closest = ClosestHits::<<Lane<8> as Width>::F<S>, 8>::new(&packet.t_max);
    ///         for (i, triangle) in (0..).zip(triangles) {
    ///             let (triangle, names) = (PreparedTriangle::new(triangle), (TriangleId(i), LeafSlot(i)));
    ///             filter.packet_closest_in(&rays, &triangle, names, find, live, &mut closest, counts);
    ///         }
    ///         let triangle = |lane| closest.lane(lane).triangle().map(|(triangle, _)| triangle);
    ///         (std::array::from_fn(triangle), filter.hits_in(&rays, &closest, find).t)
    ///     }
    /// }
    ///
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let rays = [0.25, 0.5, 2.0].map(|x| Ray::new([x, 0.25, 0.0], [0.0, 0.0, 1.0]));
    /// let (packet, walls) = (RayPacket::new(&rays), [at(5.0), at(3.0), at(9.0)]);
    /// let (first, t) = dispatch(Closest(Mode::certified().filter(), &packet, &walls));
    /// assert_eq!(first[..3], [Some(TriangleId(1)), Some(TriangleId(1)), None]);
    /// assert_eq!(t[1], 3.0);
    /// ```
    #[inline(always)]
    pub fn packet_closest_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, S, N>,
        triangle: &PreparedTriangle,
        names: (TriangleId, LeafSlot),
        find: impl Fn(LeafSlot) -> Triangle,
        live: u32,
        closest: &mut ClosestHits<F32s<S, N>, N>,
        counts: &mut Counts,
    ) where
        Lane<N>: Width,
    {
        let verdicts = self.test_packet(rays, triangle, closest.t_hi(), live, counts);
        if verdicts.lanes() != 0 {
            let pairs = self.rays_on(rays.packet, triangle.triangle(), names.1, find);
            closest.offer(&verdicts, names, &pairs);
        }
    }

    /// Like [`Filter::packet_closest_in`], but for many triangles. Triangle i has index i and slot
    /// i.
    ///
    /// This is faster than testing the triangles one by one, because sixty-four triangles are
    /// prechecked before any of them is tested. Triangles that pass the precheck are recorded in a
    /// mask without a branch: one mispredicted branch takes as long as many prechecks.
    ///
    /// ```
    /// use intertri::simd::{Lane, Simd, Width, WithSimd, dispatch};
    /// use intertri::{ClosestHits, Counts, LeafSlot, Mode, PreparedTriangle, Ray, RayPacket, Triangle};
    ///
    /// /// Finds the t of each ray's closest hit.
    /// struct Depths<'a>(&'a RayPacket<8>, &'a [PreparedTriangle]);
    /// impl WithSimd for Depths<'_> {
    ///     type Output = [f64; 8];
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> [f64; 8] {
    ///         let Self(packet, triangles) = self;
    ///         let (filter, live, counts) = (Mode::exact().filter(), packet.live(), &mut Counts::default());
    ///         let rays = filter.prepare_packet_in::<S, 8>(packet);
    ///         let mut closest = ClosestHits::<<Lane<8> as Width>::F<S>, 8>::new(&packet.t_max);
    ///         filter.packet_closest_of_in(&rays, triangles, live, &mut closest, counts);
    ///         filter.hits_in(&rays, &closest, |LeafSlot(i)| *triangles[i as usize].triangle()).t
    ///     }
    /// }
    ///
    /// let wall = |i| Triangle::new([0.0, 0.0, i as f32], [1.0, 0.0, i as f32], [0.0, 1.0, i as f32]);
    /// let walls: Vec<_> = (1..100).rev().map(|i| PreparedTriangle::new(&wall(i))).collect();
    /// let rays = [0.25, 2.0].map(|x| Ray::new([x, 0.25, 0.5], [0.0, 0.0, 1.0]));
    /// assert_eq!(dispatch(Depths(&RayPacket::new(&rays), &walls))[..2], [0.5, f64::INFINITY]);
    /// ```
    #[inline(always)]
    pub fn packet_closest_of_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, S, N>,
        triangles: &[PreparedTriangle],
        live: u32,
        closest: &mut ClosestHits<F32s<S, N>, N>,
        counts: &mut Counts,
    ) where
        Lane<N>: Width,
    {
        let find = |LeafSlot(slot)| *triangles[slot as usize].triangle();
        // Local copies stay in registers. All tests are counted at the end.
        let (mut own, mut tested) = (*closest, Counts::default());
        let mut open = OpenLanes::new();
        for (first, some) in (0..).step_by(64).zip(triangles.chunks(64)) {
            let mut candidates = 0_u64;
            for (i, triangle) in some.iter().enumerate() {
                candidates |= u64::from(rays.may_hit(triangle, live)) << i;
            }
            while candidates != 0 {
                let number = candidates.trailing_zeros();
                // Clear the lowest set bit.
                candidates &= candidates - 1;
                let triangle = &some[number as usize];
                let verdicts = self.test_candidate(rays, triangle, own.t_hi(), live, &mut tested);
                if verdicts.lanes() != 0 {
                    let names = (TriangleId(first + number), LeafSlot(first + number));
                    let pairs = self.rays_on(rays.packet, triangle.triangle(), names.1, find);
                    own.offer(&Verdicts { undecided: 0, ..verdicts }, names, &pairs);
                    if open.add(verdicts.undecided, names) {
                        open.settle(self.resolver(), rays.packet, find, &mut own);
                    }
                }
            }
        }
        if !open.is_empty() {
            open.settle(self.resolver(), rays.packet, find, &mut own);
        }
        counts.tests += u64::from(live.count_ones()) * triangles.len() as u64;
        counts.undecided += tested.undecided;
        *closest = own;
    }

    /// Returns the closest hits of N rays with their t, computed together. A lane's bit is set if
    /// the lane's ray has a hit.
    #[inline(always)]
    pub fn hits_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, S, N>,
        closest: &ClosestHits<F32s<S, N>, N>,
        find: impl Fn(LeafSlot) -> Triangle,
    ) -> PacketHits<N>
    where
        Lane<N>: Width,
    {
        closest.hits::<<Lane<N> as Width>::D<S>>(self.resolver(), rays.packet, find)
    }

    /// Returns a packet's rays, paired with a triangle, for the resolver.
    #[inline(always)]
    fn rays_on<'a, P: Fn(LeafSlot) -> Triangle, const N: usize>(
        &'a self,
        packet: &'a RayPacket<N>,
        triangle: &'a Triangle,
        slot: LeafSlot,
        find: P,
    ) -> RaysOnTriangle<'a, P, N> {
        RaysOnTriangle { resolver: self.resolver(), packet, first: RayId(0), triangle, slot, find }
    }
}

/// Sixteen rays with consecutive ids, some of which take part in a test.
pub struct NumberedPacket<'a, 'b, S: Simd> {
    /// The rays.
    pub packet: &'a PreparedPacket<'b, S, 16>,
    /// The id of the first ray.
    pub first: RayId,
    /// The rays that take part, one bit each.
    pub live: u32,
}

impl<S: Simd> NumberedPacket<'_, '_, S> {
    /// Tests the rays against the triangle in a lane of a block and updates the rays' closest hits.
    #[inline(always)]
    pub fn offer_hits_with(
        &self,
        (block, lane): (&TriangleBlock<8>, usize),
        names: (TriangleId, LeafSlot),
        find: impl Fn(LeafSlot) -> Triangle,
        filter: &Filter<'_>,
        closest: &mut ClosestHits<F32s<S, 16>, 16>,
        counts: &mut Counts,
    ) {
        let &Self { packet, first, live } = self;
        let of_lane = Triangles::of_lane(block, lane, filter.room());
        let verdicts = filter.test(&of_lane, &packet.lanes, closest.t_hi(), live, counts);
        if verdicts.lanes() != 0 {
            let (resolver, packet, triangle) =
                (filter.resolver(), packet.packet, &block.triangle(lane));
            let pairs = RaysOnTriangle { resolver, packet, first, triangle, slot: names.1, find };
            closest.offer(&verdicts, names, &pairs);
        }
    }
}

/// Finds the hits among the lanes, with their t. Hits must be before the far end of the interval.
#[inline(always)]
fn all_hits<F: Lanes<Scalar = f32>, const N: usize>(
    verdicts: &Verdicts<F>,
    t_max: impl Fn(usize) -> f32,
    pairs: &impl LanePairs,
) -> PacketHits<N> {
    let mut hits = PacketHits { bits: 0, t: [f64::INFINITY; N] };
    let mut t_hi = [0.0; N];
    verdicts.t_hi.store(&mut t_hi);
    let decided = DecidedLanes::of(verdicts.undecided, pairs);
    for lane in lanes_of(verdicts.lanes()) {
        // A certain hit before the far end needs only its t. Any other lane may still be a miss.
        let is_sure = verdicts.hit >> lane & 1 != 0 && t_hi[lane] < t_max(lane);
        let t = match decided.get(lane) {
            _ if is_sure => Some(pairs.t(lane)),
            Some(PairDecision::Miss) => None,
            Some(PairDecision::Hit { .. }) => Some(pairs.t(lane)),
            Some(PairDecision::HitAt(t)) => Some(t),
            None => pairs.hit(lane),
        };
        if let Some(t) = t {
            hits.bits |= 1 << lane;
            hits.t[lane] = t;
        }
    }
    hits
}
