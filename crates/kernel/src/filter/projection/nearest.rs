//! The nearest hits of rays of one apex, and the test that finds them.

use super::frame::{Apex, Points, at};
use super::outline::Outline;
use super::settle::Settle;
use super::starts::Ranges;
use crate::filter::Counts;
use crate::simd::{Lanes, Mask, lanes_of};
use crate::{LeafSlot, RayId, Triangle};

/// The nearest hit so far of each of N rays, as bounds on its inverse depth.
///
/// ```
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::internal::{Frame, Nearest, OpenPairs, Outlines, Starts};
/// use intertri::{Counts, Filter, Mode, Ray, Triangle, TriangleBlock};
/// use intertri::simd::Vec3;
///
/// struct Leaf<'a>(Filter<'a>, &'a TriangleBlock<8>, &'a Frame);
/// impl WithSimd for Leaf<'_> {
///     type Output = Outlines;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Outlines {
///         self.0.outlines_in::<S>(self.1, None, self.2, 1.0)
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let (filter, triangles) = (Mode::certified().filter(), [at(5.0), at(3.0)]);
/// let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// let outlines = dispatch(Leaf(filter, &TriangleBlock::new(&triangles), &frame));
///
/// // A single ray. An f32 counts as one lane.
/// let ray = Ray::new([0.0; 3], [0.05, 0.05, 1.0]);
/// let points = frame.points(Vec3::<f32>::splat(ray.dir));
/// let ranges = filter.starts_in(&Starts::none(frame.apex()), &points, [ray.t_min; 2], true).ranges();
/// let mut nearest = Nearest::<f32, 1>::new(frame.apex(), &points, ray.t_max);
/// assert_eq!(nearest.triangles(), [Nearest::<f32, 1>::NOTHING]);
/// let mut open = OpenPairs::default();
/// for lane in 0..2 {
///     let outline = outlines.lane(lane);
///     assert!(nearest.maybe(&outline, &points, &ranges, 0b1));
///     let counts = &mut Counts::default();
///     nearest.take((&points, &ranges), &outline, (lane as u32, 0), 0b1, &mut open, counts);
/// }
/// // The filter leaves no pair open.
/// assert!(open.is_empty());
/// assert_eq!((nearest.hits(), nearest.triangles()), (0b1, [1]));
/// assert!((1.0 / nearest.least() - 3.0).abs() < 1e-3);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Nearest<F, const N: usize> {
    /// The lower bound on the inverse depth: a hit with a smaller inverse depth cannot become the
    /// nearest.
    s_lo: F,
    s_hi: F,
    /// The caller's number for the triangle, stored as the bits of a float.
    triangle: F,
    /// Bit i is set if lane i has a hit.
    hits: u32,
}

/// A triangle's forms, evaluated at each point.
struct Sample<F: Lanes> {
    /// The smallest weight, in units of its error bound.
    weight: F,
    /// The inverse depth.
    s: F,
    s_lo: F,
    s_hi: F,
    /// Whether the sign of D is certain.
    sure: F::Mask,
    /// Whether the triangle may be a nearer hit.
    maybe: F::Mask,
}

/// The verdict on each lane, with bounds on the inverse depth. A lane that is in neither `hit` nor
/// `undecided` is a miss.
#[derive(Clone, Copy)]
struct InverseDepths<F> {
    hit: u32,
    undecided: u32,
    s_lo: F,
    s_hi: F,
}

/// The maximum number of pairs.
const PAIRS: usize = 64;

/// The number of pairs that are settled together.
pub(super) const TOGETHER: usize = 16;

/// A pair that may be a hit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OpenPair {
    /// The ray's index in the bundle.
    pub(super) ray: u32,
    /// The caller's number for the triangle.
    pub(super) number: u32,
    /// Bounds on the inverse depth of a certain hit, which overlap those of the ray's nearest hit so
    /// far or of the far end of its interval. `None` for a pair that is undecided.
    pub(super) bounds: Option<[f32; 2]>,
}

/// Open pairs, in the order in which they were found.
#[derive(Clone, Copy, Debug)]
pub struct OpenPairs {
    pub(super) pairs: [OpenPair; PAIRS],
    pub(super) len: usize,
    /// Hits at edges. Rays that have the same remainder share an element.
    pub(super) met: [Met; PAIRS],
}

/// The edges on which a ray is known to meet the triangle in a slot, if not 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Met {
    pub(super) ray: RayId,
    pub(super) slot: LeafSlot,
    pub(super) edges: u8,
}

impl Default for OpenPairs {
    fn default() -> Self {
        Self { pairs: [OpenPair::default(); PAIRS], len: 0, met: [Met::default(); PAIRS] }
    }
}

impl OpenPairs {
    /// Returns whether there are no pairs.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns whether there may be no room for the pairs of another triangle and sixteen rays.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.len > PAIRS - TOGETHER
    }

    #[inline(always)]
    fn push(&mut self, pair: OpenPair) {
        self.pairs[self.len % PAIRS] = pair;
        self.len += 1;
    }
}

impl<F: Lanes<Scalar = f32>, const N: usize> Nearest<F, N> {
    /// The number that stands for a miss.
    pub const NOTHING: u32 = u32::MAX;

    /// Creates a record with no hits yet: any hit before `t_max` counts as nearer.
    #[inline(always)]
    pub fn new(apex: Apex, points: &Points<F>, t_max: F) -> Self {
        let (s_lo, s_hi) = apex.inverse(points.z, t_max);
        // The far end of the interval stands in for a hit: hits must have a larger inverse depth.
        Self { s_lo, s_hi, triangle: F::splat(f32::from_bits(Self::NOTHING)), hits: 0 }
    }

    /// Returns the smallest inverse depth at which a hit still counts.
    #[inline(always)]
    pub fn least(&self) -> F {
        self.s_lo
    }

    /// Returns a mask in which bit i is set if lane i has a hit.
    #[inline(always)]
    pub fn hits(&self) -> u32 {
        self.hits
    }

    /// Returns the caller's number for each ray's nearest triangle, or [`Nearest::NOTHING`] for a
    /// miss.
    #[inline(always)]
    pub fn triangles(&self) -> [u32; N] {
        // Avoid `map`, which would not be inlined.
        let (mut lanes, mut numbers) = ([0.0; N], [0; N]);
        self.triangle.store(&mut lanes);
        for (number, lane) in numbers.iter_mut().zip(&lanes) {
            *number = lane.to_bits();
        }
        numbers
    }

    /// Tests N rays against a triangle, with the caller's number for it, and stores each hit that is
    /// certainly nearer than the ray's nearest hit so far. Adds the pairs that may be hits to `open`,
    /// where lane i is the ray `first + i` of the bundle. Only the lanes in `live` take part; their
    /// points must be on the projection, and their intervals must not contain NaN. This method updates
    /// only `counts.undecided`; the caller updates `counts.tests`. Returns whether anything may have
    /// changed.
    #[inline(always)]
    pub fn take(
        &mut self,
        (points, ranges): (&Points<F>, &Ranges<F>),
        outline: &Outline,
        (number, first): (u32, usize),
        live: u32,
        open: &mut OpenPairs,
        counts: &mut Counts,
    ) -> bool {
        // Do not branch on whether there is a hit, because the branch would often be mispredicted.
        let found = self.test(outline, points, ranges, live);
        counts.undecided += u64::from(found.undecided.count_ones());
        self.offer(&found, (number, first), open);
        (found.hit | found.undecided) != 0
    }

    /// Finds which of the live rays hit the triangle in a slot, at any distance, without storing
    /// anything. The rays must not be reversed. Otherwise, this is like [`Nearest::take`].
    #[inline(always)]
    pub fn hit_by<T: Fn(LeafSlot) -> Triangle, I: Fn(LeafSlot) -> u32>(
        &self,
        (points, ranges): (&Points<F>, &Ranges<F>),
        outline: &Outline,
        slot: LeafSlot,
        (first, settle): (usize, &Settle<'_, T, I>),
        live: u32,
        counts: &mut Counts,
    ) -> u32 {
        let found = self.test(outline, points, ranges, live);
        counts.undecided += u64::from(found.undecided.count_ones());

        // A hit whose bounds reach the end of its ray may be beyond that end, so the resolver
        // settles it as well.
        let mut hits = found.hit & found.s_lo.gt(self.s_hi).bits();
        let open = (found.hit & !hits) | found.undecided;
        if open != 0 {
            hits |= settle.meeting(slot, first, open);
        }
        hits
    }

    /// Returns whether a live ray may have a nearer hit on the triangle, using a quick test without
    /// branches. If so, call [`Nearest::take`].
    #[inline(always)]
    pub fn maybe(
        &self,
        outline: &Outline,
        points: &Points<F>,
        ranges: &Ranges<F>,
        live: u32,
    ) -> bool {
        self.sample(outline, points, ranges).maybe.bits() & live != 0
    }

    /// Finds which of the live rays certainly hit a triangle, and which may hit it.
    #[inline(always)]
    fn test(
        &self,
        outline: &Outline,
        points: &Points<F>,
        ranges: &Ranges<F>,
        live: u32,
    ) -> InverseDepths<F> {
        let Sample { weight, s, s_lo, s_hi, sure, maybe } = self.sample(outline, points, ranges);

        // A lane is a hit if it certainly passes all tests.
        let inside = weight.gt(F::splat(1.0))
            & s.gt(F::splat(outline.slanted))
            & s_hi.lt(ranges.near_lo)
            & s_lo.gt(F::splat(outline.horizon));
        let hit = (sure & maybe & inside).bits() & live;
        InverseDepths { hit, undecided: maybe.bits() & live & !hit, s_lo, s_hi }
    }

    /// Evaluates a triangle's forms at the points, and finds which rays may hit it.
    #[inline(always)]
    fn sample(&self, outline: &Outline, points: &Points<F>, ranges: &Ranges<F>) -> Sample<F> {
        // If the smallest weight is below -1 and the sign of D is certain, the lane is a certain
        // miss.
        let [u, v, w] = [at(outline.u, points), at(outline.v, points), at(outline.w, points)];
        let weight = u.min(v).min(w);
        let outside = weight.lt(F::splat(-1.0));

        // The inverse depth of the plane, negative if the ray leads away from it.
        let s = at(outline.s, points);
        let sure = s.abs().gt(F::splat(outline.least));
        let err = F::splat(outline.err);
        // The nearer the plane, the larger s. `near_hi` is the near end of the interval, and
        // `self.s_lo` belongs to the nearest hit so far.
        let (s_lo, s_hi) = (s - err, s + err);
        let out_of_range = s_lo.gt(ranges.near_hi) | s_hi.lt(self.s_lo);
        let mut maybe = !(sure & (outside | s.lt(F::splat(outline.horizon)) | out_of_range));
        if outline.is_edge_on() {
            // Two weights of different signs mean a miss, even if the sign of D is unknown.
            maybe = maybe & !(outside & u.max(v).max(w).gt(F::splat(1.0)));
        }
        Sample { weight, s, s_lo, s_hi, sure, maybe }
    }

    /// Stores each hit on a triangle that is certainly nearer than the ray's nearest hit so far. Other
    /// pairs that may be hits are left open.
    #[inline(always)]
    fn offer(
        &mut self,
        found: &InverseDepths<F>,
        (number, first): (u32, usize),
        open: &mut OpenPairs,
    ) {
        // First update all lanes in which the new bounds are entirely in front of the old bounds,
        // without a loop.
        let wins = F::Mask::from_bits(found.hit) & found.s_lo.gt(self.s_hi);
        self.s_lo = F::select(wins, found.s_lo, self.s_lo);
        self.s_hi = F::select(wins, found.s_hi, self.s_hi);
        self.triangle = F::select(wins, F::splat(f32::from_bits(number)), self.triangle);
        self.hits |= wins.bits();

        // In the other lanes, the bounds overlap, or the hit is undecided.
        let rest = (found.hit & !wins.bits()) | found.undecided;
        if rest == 0 {
            return;
        }
        let (mut s_lo, mut s_hi) = ([0.0; N], [0.0; N]);
        found.s_lo.store(&mut s_lo);
        found.s_hi.store(&mut s_hi);
        for lane in lanes_of(rest) {
            let bounds = found.hit >> lane & 1 != 0;
            let bounds = bounds.then_some([s_lo[lane], s_hi[lane]]);
            open.push(OpenPair { ray: (first + lane) as u32, number, bounds });
        }
    }

    /// Returns bounds on the inverse depth of the nearest hit of the ray in a lane, and its triangle's
    /// number, or [`Nearest::NOTHING`].
    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> ([f32; 2], u32) {
        let (mut s_lo, mut s_hi, mut number) = ([0.0; N], [0.0; N], [0.0; N]);
        self.s_lo.store(&mut s_lo);
        self.s_hi.store(&mut s_hi);
        self.triangle.store(&mut number);
        ([s_lo[lane], s_hi[lane]], number[lane].to_bits())
    }

    /// Stores the nearest hit of the ray in a lane.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, [s_lo, s_hi]: [f32; 2], number: u32) {
        let only = F::Mask::from_bits(1 << lane);
        self.s_lo = F::select(only, F::splat(s_lo), self.s_lo);
        self.s_hi = F::select(only, F::splat(s_hi), self.s_hi);
        self.triangle = F::select(only, F::splat(f32::from_bits(number)), self.triangle);
        self.hits |= 1 << lane;
    }
}
