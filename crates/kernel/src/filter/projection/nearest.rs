//! The nearest hits of rays of one apex, and the test that finds them.

use super::frame::{Apex, Points, at};
use super::outline::Outline;
use super::settle::{Settle, Settled};
use super::starts::Ranges;
use crate::filter::Counts;
use crate::simd::{Lanes, Mask, lanes_of};
use crate::{LeafSlot, Triangle};

/// The nearest hit so far of each of N rays, as bounds on its inverse depth.
///
/// ```
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::internal::{Frame, Nearest, Outlines, Settle, Starts};
/// use intertri::{Counts, Mode, Ray};
/// use intertri::{Filter, LeafSlot, RayId, Triangle, TriangleBlock};
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
/// let find = |LeafSlot(slot)| triangles[slot as usize];
/// let (rays, resolver) = ([ray], filter.resolver());
/// let (apex, index) = (frame.apex(), |LeafSlot(slot)| slot);
/// let settle = Settle { resolver, apex, rays: &rays, first: RayId(0), find, index, reversed: false };
/// for lane in 0..2 {
///     let outline = outlines.lane(lane);
///     assert!(nearest.maybe(&outline, &points, &ranges, 0b1));
///     let numbers = (lane as u32, [LeafSlot(0), LeafSlot(1)].as_slice());
///     let counts = &mut Counts::default();
///     nearest.take((&points, &ranges), &outline, numbers, (0, &settle), 0b1, counts);
/// }
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

    /// Tests N rays against the triangle `seen[number]` and stores each hit that is nearer than the
    /// ray's nearest hit so far. Only the lanes in `live` take part; their points must be on the
    /// projection, and their intervals must not contain NaN. `settle` decides the undecided lanes,
    /// in which lane i is the ray `first + i` of `settle.rays`. This method updates only
    /// `counts.undecided`; the caller updates `counts.tests`. Returns whether anything may have
    /// changed.
    #[inline(always)]
    pub fn take<T: Fn(LeafSlot) -> Triangle, I: Fn(LeafSlot) -> u32>(
        &mut self,
        (points, ranges): (&Points<F>, &Ranges<F>),
        outline: &Outline,
        (number, seen): (u32, &[LeafSlot]),
        (first, settle): (usize, &Settle<'_, T, I>),
        live: u32,
        counts: &mut Counts,
    ) -> bool {
        // Do not branch on whether there is a hit, because the branch would often be mispredicted.
        let found = self.test(outline, points, ranges, live);
        counts.undecided += u64::from(found.undecided.count_ones());
        self.offer(&found, (number, seen), points, (first, settle));
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
        for lane in lanes_of((found.hit & !hits) | found.undecided) {
            hits |= u32::from(settle.meets(slot, first + lane)) << lane;
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

    /// Stores each hit on the triangle `seen[number]` that is nearer than the ray's nearest hit so
    /// far.
    #[inline(always)]
    fn offer<T: Fn(LeafSlot) -> Triangle, I: Fn(LeafSlot) -> u32>(
        &mut self,
        found: &InverseDepths<F>,
        (number, seen): (u32, &[LeafSlot]),
        points: &Points<F>,
        (first, settle): (usize, &Settle<'_, T, I>),
    ) {
        // First update all lanes in which the new bounds are entirely in front of the old bounds,
        // without a loop.
        let bits = f32::from_bits(number);
        let wins = F::Mask::from_bits(found.hit) & found.s_lo.gt(self.s_hi);
        self.s_lo = F::select(wins, found.s_lo, self.s_lo);
        self.s_hi = F::select(wins, found.s_hi, self.s_hi);
        self.triangle = F::select(wins, F::splat(bits), self.triangle);
        self.hits |= wins.bits();

        // In the other lanes, the bounds overlap, or the hit is undecided. Settle these lanes one
        // by one, by their exact t.
        let rest = (found.hit & !wins.bits()) | found.undecided;
        if rest == 0 {
            return;
        }
        let (mut lo, mut hi, mut numbers) = ([0.0; N], [0.0; N], [0.0; N]);
        let (mut new_lo, mut new_hi, mut z) = ([0.0; N], [0.0; N], [0.0; N]);
        self.s_lo.store(&mut lo);
        self.s_hi.store(&mut hi);
        self.triangle.store(&mut numbers);
        found.s_lo.store(&mut new_lo);
        found.s_hi.store(&mut new_hi);
        points.z.store(&mut z);
        let slot = seen[number as usize];
        let mut kept = [None; 2];
        for lane in lanes_of(rest) {
            let ray = first + lane;
            // If the ray has no hit yet, the result may depend on the ray's far end. Otherwise,
            // only the order of the two hits matters.
            let is_hit = self.hits >> lane & 1 != 0;
            let sure = found.hit >> lane & 1 != 0;
            let other = is_hit.then(|| seen[numbers[lane].to_bits() as usize]);

            // Find bounds on the inverse depth.
            let inverse = |t| settle.apex.inverse(z[lane], t);
            let mut bounds = (new_lo[lane], new_hi[lane]);
            if !(sure && is_hit) {
                match settle.settle(slot, ray, other) {
                    Settled::Behind => continue,
                    Settled::Tie => {
                        numbers[lane] = bits;
                        continue;
                    }
                    Settled::Hit { .. } if sure => {}
                    Settled::Hit { t_lo, t_hi } => {
                        bounds = (inverse(t_hi).0, inverse(t_lo).1);
                    }
                }
            }

            // The larger the inverse depth, the nearer the hit. If the bounds overlap, the exact
            // order decides.
            if let Some(other) = other
                && bounds.0 <= hi[lane]
                && (bounds.1 < lo[lane] || !settle.is_before(ray, slot, other, &mut kept))
            {
                continue;
            }
            (lo[lane], hi[lane]) = bounds;
            numbers[lane] = bits;
            self.hits |= 1 << lane;
        }
        self.s_lo = F::load(&lo);
        self.s_hi = F::load(&hi);
        self.triangle = F::load(&numbers);
    }
}
