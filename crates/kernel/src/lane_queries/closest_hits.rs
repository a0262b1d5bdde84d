//! The closest hits of N rays so far, in lanes.

use super::closest_hit::{ClosestHit, OneByOne, unknown};
use super::lane_pairs::{DecidedLanes, LanePairs};
use crate::document::Tri;
use crate::exact;
use crate::filter::Verdicts;
use crate::packet::{PacketHits, RayPacket};
use crate::resolve::{Resolver, SEVERAL};
use crate::simd::Vec3;
use crate::simd::{Lanes, Mask, lanes_of};
use crate::{LeafSlot, RayId, Triangle, TriangleId, TriangleOf};

/// The closest hit so far of each of N rays, in lanes.
///
/// ```
/// use intertri::ClosestHits;
/// // A ray without any hits yet. An f32 counts as one lane.
/// let closest = ClosestHits::<f32, 1>::new(&[9.0]);
/// assert_eq!(closest.t_hi(), 9.0);
/// assert!(!closest.lane(0).is_hit());
/// ```
#[derive(Clone, Copy)]
pub struct ClosestHits<F, const N: usize> {
    t_lo: F,
    t_hi: F,
    /// Indices and slots are stored as the bits of floats, so that whole registers can be selected.
    triangle: F,
    slot: F,
    /// t in the lanes whose bit is set in `known`.
    t: [f64; N],
    known: u32,
}

impl<F: Lanes<Scalar = f32>, const N: usize> ClosestHits<F, N> {
    /// Creates a record with no hits yet. See [`ClosestHit::new`].
    #[inline(always)]
    pub fn new(t_max: &[f32; N]) -> Self {
        let t = F::load(t_max);
        Self {
            t_lo: t,
            t_hi: t,
            triangle: F::splat(f32::from_bits(TriangleId::NONE.0)),
            slot: F::splat(f32::from_bits(0)),
            t: t_max.map(f64::from),
            known: u32::MAX,
        }
    }

    /// Creates a record with no hits yet. See [`ClosestHit::before`].
    #[inline(always)]
    pub(crate) fn before(sure: F, t_max: &[f32; N]) -> Self {
        Self { t_lo: sure, ..Self::new(t_max) }
    }

    /// See [`ClosestHit::t_hi`].
    #[inline(always)]
    pub fn t_hi(&self) -> F {
        self.t_hi
    }

    /// Returns the closest hit in a lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> ClosestHit {
        // Access every lane with a constant index, because a variable index would spill the
        // registers to memory.
        let mut t = unknown(0);
        for i in 0..N {
            if i == lane && self.known >> i & 1 != 0 {
                t = self.t[i];
            }
        }
        ClosestHit {
            t,
            t_lo: get::<F, N>(self.t_lo, lane),
            t_hi: get::<F, N>(self.t_hi, lane),
            triangle: TriangleId(get::<F, N>(self.triangle, lane).to_bits()),
            slot: LeafSlot(get::<F, N>(self.slot, lane).to_bits()),
        }
    }

    /// Returns the indices of all lanes' triangles, or [`TriangleId::NONE`], and their slots.
    #[doc(hidden)]
    #[inline(always)]
    pub fn triangles(&self) -> ([TriangleId; N], [LeafSlot; N]) {
        // Avoid `map`, which would not be inlined.
        let (mut triangle, mut slot) = ([0.0; N], [0.0; N]);
        self.triangle.store(&mut triangle);
        self.slot.store(&mut slot);
        let (mut ids, mut slots) = ([TriangleId::NONE; N], [LeafSlot(0); N]);
        for lane in 0..N {
            ids[lane] = TriangleId(triangle[lane].to_bits());
            slots[lane] = LeafSlot(slot[lane].to_bits());
        }
        (ids, slots)
    }

    /// Returns the closest hits of all lanes.
    #[inline(always)]
    pub(super) fn lanes(&self) -> [ClosestHit; N] {
        let mut all = [[0.0; N]; 4];
        for (row, lanes) in all.iter_mut().zip([self.t_lo, self.t_hi, self.triangle, self.slot]) {
            lanes.store(row);
        }
        let [t_lo, t_hi, triangle, slot] = all;
        core::array::from_fn(
            #[inline(always)]
            |i| ClosestHit {
                t: if self.known >> i & 1 != 0 { self.t[i] } else { unknown(0) },
                t_lo: t_lo[i],
                t_hi: t_hi[i],
                triangle: TriangleId(triangle[i].to_bits()),
                slot: LeafSlot(slot[i].to_bits()),
            },
        )
    }

    /// Returns the hits with their t. See [`Filter::hits_in`](crate::Filter::hits_in).
    #[inline(always)]
    pub(crate) fn hits<D: Lanes<Scalar = f64>>(
        &self,
        resolver: Resolver<'_>,
        rays: &RayPacket<N>,
        find: impl Fn(LeafSlot) -> Triangle,
    ) -> PacketHits<N> {
        let (mut index, mut slot) = ([0.0; N], [0.0; N]);
        self.triangle.store(&mut index);
        self.slot.store(&mut slot);

        // Load the triangles whose t is not known yet.
        let (mut bits, mut unknown) = (0, 0);
        // The corners stay 0 in lanes whose t is known; the results for these lanes are not used.
        let mut corners = [[[0.0; N]; 3]; 3];
        for lane in 0..N {
            if index[lane].to_bits() == TriangleId::NONE.0 {
                continue;
            }
            bits |= 1 << lane;
            if self.known >> lane & 1 == 0 {
                unknown |= 1 << lane;
                let TriangleOf(triangle) = find(LeafSlot(slot[lane].to_bits()));
                for (to, from) in corners.iter_mut().zip(&triangle) {
                    for (to, from) in to.iter_mut().zip(from) {
                        to[lane] = *from;
                    }
                }
            }
        }

        let mut hits = PacketHits { bits, t: self.t };
        match resolver {
            _ if unknown == 0 => {}
            _ => {
                // Compute all lanes at once, with the document's operations or exactly. Then
                // compute the uncertain lanes one by one.
                let [c1, c2, c3] = &corners;
                let corners = [Vec3::<D>::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
                let (org, dir) = (Vec3::load_f32(&rays.origin), Vec3::load_f32(&rays.dir));
                let (t, sure) = match resolver {
                    Resolver::Document(_) => (Tri::new(corners).t(org, dir), u32::MAX),
                    Resolver::Originals(_) => (D::splat(0.0), 0),
                    Resolver::Exact(_) => exact::t_in(corners, org, dir),
                };
                let mut lanes = [0.0; N];
                t.store(&mut lanes);
                for (lane, (to, t)) in hits.t.iter_mut().zip(lanes).enumerate() {
                    *to = if unknown >> lane & 1 != 0 { t } else { *to };
                }
                for lane in lanes_of(unknown & !sure) {
                    let (id, slot) = (RayId(lane as u32), LeafSlot(slot[lane].to_bits()));
                    hits.t[lane] = resolver.t(&rays.ray(lane), &find(slot), (id, slot));
                }
            }
        }
        hits
    }

    /// Sets the closest hit in a lane.
    #[doc(hidden)]
    #[inline(always)]
    pub fn set(&mut self, lane: usize, closest: &ClosestHit) {
        // Select in all lanes, because writing an element with a variable index would spill the
        // registers to memory.
        let at = F::Mask::from_bits(1 << lane);
        let put = |x: f32, old| F::select(at, F::splat(x), old);
        self.t_lo = put(closest.t_lo, self.t_lo);
        self.t_hi = put(closest.t_hi, self.t_hi);
        self.triangle = put(f32::from_bits(closest.triangle.0), self.triangle);
        self.slot = put(f32::from_bits(closest.slot.0), self.slot);
        for i in 0..N {
            self.t[i] = if i == lane { closest.t } else { self.t[i] };
        }
        self.known = self.known & !(1 << lane) | u32::from(!closest.t.is_nan()) << lane;
    }

    /// Offers the filter's verdicts on one triangle, which has the given index and slot, to all
    /// lanes.
    #[inline(always)]
    pub(crate) fn offer(
        &mut self,
        verdicts: &Verdicts<F>,
        (triangle, slot): (TriangleId, LeafSlot),
        pairs: &impl LanePairs,
    ) {
        // Where the intervals decide, update all lanes at once, without a branch.
        let wins = F::Mask::from_bits(verdicts.hit) & verdicts.t_hi.lt(self.t_lo);
        self.t_lo = F::select(wins, verdicts.t_lo, self.t_lo);
        self.t_hi = F::select(wins, verdicts.t_hi, self.t_hi);
        self.triangle = F::select(wins, F::splat(f32::from_bits(triangle.0)), self.triangle);
        self.slot = F::select(wins, F::splat(f32::from_bits(slot.0)), self.slot);
        self.known &= !wins.bits();

        // Process the other lanes one by one. Reading and writing a single lane takes as long as
        // doing so for all of them.
        let others = verdicts.lanes() & !wins.bits();
        if others.count_ones() < SEVERAL {
            for lane in lanes_of(others) {
                let mut closest = self.lane(lane);
                closest.offer_lane(verdicts, (triangle, slot), lane, pairs);
                self.set(lane, &closest);
            }
        } else {
            let (mut t_lo, mut t_hi) = ([0.0; N], [0.0; N]);
            verdicts.t_lo.store(&mut t_lo);
            verdicts.t_hi.store(&mut t_hi);
            let mut all = self.lanes();
            let others = OneByOne { lanes: others, hit: verdicts.hit, t_lo: &t_lo, t_hi: &t_hi };
            offer_to_each(&mut all, &others, (triangle, slot), pairs);
            self.set_all(&all);
        }
    }

    /// Sets the closest hits of all lanes.
    #[inline(always)]
    pub(super) fn set_all(&mut self, all: &[ClosestHit; N]) {
        let (mut rows, mut known) = ([[0.0; N]; 4], 0);
        for (i, closest) in all.iter().enumerate() {
            (rows[0][i], rows[1][i]) = (closest.t_lo, closest.t_hi);
            rows[2][i] = f32::from_bits(closest.triangle.0);
            rows[3][i] = f32::from_bits(closest.slot.0);
            self.t[i] = closest.t;
            known |= u32::from(!closest.t.is_nan()) << i;
        }
        let [t_lo, t_hi, triangle, slot] = &rows;
        (self.t_lo, self.t_hi) = (F::load(t_lo), F::load(t_hi));
        (self.triangle, self.slot) = (F::load(triangle), F::load(slot));
        self.known = known;
    }
}

/// Offers the verdicts on one triangle to the lanes that they concern. The function is out of line
/// to keep registers free for the common case.
#[cold]
#[inline(never)]
fn offer_to_each<const N: usize>(
    all: &mut [ClosestHit; N],
    verdicts: &OneByOne<'_>,
    names: (TriangleId, LeafSlot),
    pairs: &impl LanePairs,
) {
    let decided = DecidedLanes::of(verdicts.lanes & !verdicts.hit, pairs);
    for lane in lanes_of(verdicts.lanes) {
        all[lane].offer_one(verdicts, &decided, names, lane, pairs);
    }
}

/// Reads one of N lanes.
#[inline(always)]
fn get<F: Lanes<Scalar = f32>, const N: usize>(lanes: F, lane: usize) -> f32 {
    let mut all = [0.0; N];
    lanes.store(&mut all);
    all[lane]
}
