//! The closest hit so far of one ray: an interval of f32 where that decides, f64 where not, and the
//! resolver where rounded t are equal.

use core::cmp::Ordering;

use super::pairs::LanePairs;
use super::test::Found;
use crate::simd::{Lanes, Mask, lanes_of};

/// The closest hit so far of one ray.
///
/// `t_lo <= t <= t_hi` encloses the mode's t. Two hits are compared by these intervals, by their t in f64
/// only where the intervals meet, and exactly where those are equal; of equal t the lower index is
/// closer.
///
/// ```
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{Certified, ClosestHit, Counts, LaneQueries, Mode, Ray, Triangle, TriangleBlock};
///
/// struct Eight<'a, T>(T, &'a Ray, &'a [Triangle]);
/// impl<T: LaneQueries> WithSimd for Eight<'_, T> {
///     type Output = ClosestHit;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> ClosestHit {
///         let Self(test, ray, triangles) = self;
///         let (block, indices) = (TriangleBlock::new(triangles), [0, 1, 2, 3, 4, 5, 6, 7]);
///         let find = |place: u32| triangles[place as usize];
///         let (ray, mut closest) = (test.prepare_ray(ray), ClosestHit::new(ray.t_max));
///         let counts = &mut Counts::default();
///         test.closest_in::<S>(&ray, &block, &indices, 0, find, &mut closest, counts);
///         closest
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
/// let closest = dispatch(Eight(Certified::default().test(), &ray, &[at(5.0), at(3.0)]));
/// assert!(closest.is_hit() && 3.0 <= closest.t_hi() && closest.t_hi() < 3.001);
/// assert_eq!(closest.triangle(), Some((1, 1)));
/// assert_eq!(ClosestHit::new(9.0).triangle(), None);
/// assert_eq!(ClosestHit::NO_TRIANGLE, u32::MAX);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ClosestHit {
    /// t in f64, NaN while nobody has asked for it.
    pub(super) t: f64,
    pub(super) t_lo: f32,
    pub(super) t_hi: f32,
    /// The index of the triangle; [`ClosestHit::NO_TRIANGLE`] before the first hit.
    pub(super) triangle: u32,
    /// Where the caller finds the triangle again.
    pub(super) place: u32,
}

impl ClosestHit {
    /// The index that stands for no triangle.
    pub const NO_TRIANGLE: u32 = u32::MAX;

    /// No hit yet: whatever is closer than `t_max` is closest.
    #[inline(always)]
    pub fn new(t_max: f32) -> Self {
        Self {
            t: f64::from(t_max),
            t_lo: t_max,
            t_hi: t_max,
            triangle: Self::NO_TRIANGLE,
            place: 0,
        }
    }

    /// No hit yet, where of the far end only a number that is not beyond it is known, `sure`, and one that is not
    /// before it.
    #[inline(always)]
    pub(crate) fn before(sure: f32, t_max: f32) -> Self {
        Self { t_lo: sure, ..Self::new(t_max) }
    }

    /// No hit with a larger t can become the closest.
    #[inline(always)]
    pub fn t_hi(&self) -> f32 {
        self.t_hi
    }

    /// Whether there is a hit.
    #[inline(always)]
    pub fn is_hit(&self) -> bool {
        self.triangle != Self::NO_TRIANGLE
    }

    /// The index of the triangle, and where the caller put it.
    #[inline(always)]
    pub fn triangle(&self) -> Option<(u32, u32)> {
        self.is_hit().then_some((self.triangle, self.place))
    }

    /// Offers the hit of a lane, whose t is known.
    #[inline(always)]
    fn offer_known(&mut self, t: f64, new: (u32, u32), lane: usize, pairs: &impl LanePairs) {
        let (triangle, place) = new;
        let (t_lo, t_hi) = enclose(t);
        // Before the first hit there is nothing to compare with: the far end of the interval was.
        let closer = !self.is_hit()
            || t_hi < self.t_lo
            || t_lo <= self.t_hi && self.is_beaten_by(t, triangle, lane, pairs);
        if closer {
            *self = Self { t, t_lo, t_hi, triangle, place };
        }
    }

    /// Offers the hit of a lane, whose t lies in `t_lo..=t_hi`. It may lie beyond the far end of the ray.
    #[inline(always)]
    fn offer_near(
        &mut self,
        (t_lo, t_hi): (f32, f32),
        new: (u32, u32),
        lane: usize,
        pairs: &impl LanePairs,
    ) {
        if t_hi < self.t_lo {
            let (triangle, place) = new;
            *self = Self { t: f64::NAN, t_lo, t_hi, triangle, place };
        } else if t_lo <= self.t_hi {
            let t = if self.is_hit() { Some(pairs.t(lane)) } else { pairs.hit(lane) };
            if let Some(t) = t {
                self.offer_known(t, new, lane, pairs);
            }
        }
    }

    /// Offers the pair of a lane of which nothing is decided.
    #[inline(always)]
    fn offer_undecided(&mut self, new: (u32, u32), lane: usize, pairs: &impl LanePairs) {
        let (triangle, place) = new;
        // Where it touches the closest it has its t: then the index decides, and nobody need know t.
        if self.is_hit() && pairs.touch(lane, self.place) {
            if triangle < self.triangle && pairs.hit(lane).is_some() {
                (self.triangle, self.place) = (triangle, place);
            }
        } else if let Some(t) = pairs.hit(lane) {
            self.offer_known(t, new, lane, pairs);
        }
    }

    /// Offers what was found in a lane, whose triangle has that index and place.
    #[inline(always)]
    pub(super) fn offer_lane<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &mut self,
        found: &Found<F, D>,
        new: (u32, u32),
        lane: usize,
        pairs: &impl LanePairs,
    ) {
        if found.near >> lane & 1 != 0 {
            let (mut t_lo, mut t_hi) = ([0.0; 16], [0.0; 16]);
            found.t_lo.store(&mut t_lo);
            found.t_hi.store(&mut t_hi);
            self.offer_near((t_lo[lane], t_hi[lane]), new, lane, pairs);
        } else if found.exact >> lane & 1 == 0 {
            self.offer_undecided(new, lane, pairs);
        } else if let Some(t) = found.known_t(lane, pairs) {
            self.offer_known(t, new, lane, pairs);
        }
    }

    /// Offers what was found in a block of triangles; the i-th has the index `indices[i]` and the place
    /// `place + i`.
    #[inline(always)]
    pub(crate) fn offer_block<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &mut self,
        found: &Found<F, D>,
        indices: &[u32; 8],
        place: u32,
        pairs: &impl LanePairs,
    ) {
        if found.lanes() == 0 {
            return;
        }

        // Of those with an enclosure, the one that ends first and all that begin before that.
        let near = F::Mask::from_bits(found.near);
        let ends = F::select(near, found.t_hi, F::splat(f32::INFINITY));
        let (mut t_lo, mut t_hi) = ([0.0; 8], [0.0; 8]);
        found.t_lo.store(&mut t_lo);
        ends.store(&mut t_hi);
        let first = least(&t_hi);
        let rivals = (near & found.t_lo.le(F::splat(first))).bits();

        // Nearly always that is one, which surely wins.
        let doubtful = rivals & rivals.wrapping_sub(1) | found.exact | found.undecided;
        if doubtful == 0 && first < self.t_lo {
            let lane = rivals.trailing_zeros() as usize % 8;
            let (triangle, place) = (indices[lane], place + lane as u32);
            *self = Self { t: f64::NAN, t_lo: t_lo[lane], t_hi: first, triangle, place };
            return;
        }
        let (t_lo, t_hi) = (&t_lo, &t_hi);
        let mut t = [0.0; 8];
        if found.exact != 0 {
            found.t.store(&mut t);
        }
        let (near, exact) = (found.near, found.exact);
        let lanes = OneByOne { lanes: found.lanes(), near, exact, t_lo, t_hi, t: &t };
        self.offer_one_by_one(&lanes, |lane| (indices[lane], place + lane as u32), pairs);
    }

    /// Offers what was found in a row of triangles; the i-th has the index and the place `first + i`.
    #[inline(always)]
    pub(crate) fn offer_row<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &mut self,
        found: &Found<F, D>,
        first: u32,
        pairs: &impl LanePairs,
    ) {
        let (mut t_lo, mut t_hi, mut t) = ([0.0; 16], [0.0; 16], [0.0; 16]);
        found.t_lo.store(&mut t_lo);
        found.t_hi.store(&mut t_hi);
        found.t.store(&mut t);
        let (near, exact) = (found.near, found.exact);
        let lanes = OneByOne { lanes: found.lanes(), near, exact, t_lo: &t_lo, t_hi: &t_hi, t: &t };
        self.offer_one_by_one(&lanes, |lane| (first + lane as u32, first + lane as u32), pairs);
    }

    /// [`ClosestHit::offer_block`] where the enclosures do not tell. Out of line, for that keeps registers
    /// free where they do.
    #[inline(never)]
    fn offer_one_by_one(
        &mut self,
        found: &OneByOne<'_>,
        index_and_place: impl Fn(usize) -> (u32, u32),
        pairs: &impl LanePairs,
    ) {
        for lane in lanes_of(found.lanes) {
            let new = index_and_place(lane);
            if found.near >> lane & 1 != 0 {
                self.offer_near((found.t_lo[lane], found.t_hi[lane]), new, lane, pairs);
            } else if found.exact >> lane & 1 != 0 {
                self.offer_known(found.t[lane], new, lane, pairs);
            } else {
                self.offer_undecided(new, lane, pairs);
            }
        }
    }

    /// Whether a hit of a lane with this t and index comes before the closest so far.
    #[inline(always)]
    fn is_beaten_by(&mut self, t: f64, triangle: u32, lane: usize, pairs: &impl LanePairs) -> bool {
        if self.t.is_nan() {
            self.t = pairs.t_in(lane, self.place);
        }
        let order = if t == self.t { pairs.order(lane, self.place) } else { Ordering::Equal };
        t < self.t || t == self.t && order.then(triangle.cmp(&self.triangle)).is_lt()
    }
}

/// What was found in the lanes of a block, to be looked at one by one.
struct OneByOne<'a> {
    lanes: u32,
    near: u32,
    exact: u32,
    t_lo: &'a [f32],
    t_hi: &'a [f32],
    t: &'a [f64],
}

impl<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> Found<F, D> {
    /// t of a lane, if it is a hit and not one of those of which an enclosure is known.
    #[inline(always)]
    pub(crate) fn known_t(&self, lane: usize, pairs: &impl LanePairs) -> Option<f64> {
        if self.exact >> lane & 1 != 0 {
            let mut t = [0.0; 16];
            self.t.store(&mut t);
            Some(t[lane])
        } else {
            pairs.hit(lane)
        }
    }
}

/// The smallest of eight.
#[inline(always)]
fn least(of: &[f32; 8]) -> f32 {
    let less = |a: f32, b: f32| if b < a { b } else { a };
    let [a, b, c, d, e, f, g, h] = *of;
    less(less(less(a, e), less(b, f)), less(less(c, g), less(d, h)))
}

/// The two neighbouring f32 around a t.
#[inline(always)]
fn enclose(t: f64) -> (f32, f32) {
    let near = t as f32;
    let (near64, t_lo, t_hi) = (f64::from(near), near.next_down(), near.next_up());
    (if near64 > t { t_lo } else { near }, if near64 < t { t_hi } else { near })
}

#[cfg(test)]
mod tests {
    use core::cmp::Ordering;

    use super::{ClosestHit, LanePairs, enclose};
    use crate::resolve::Resolver;
    use crate::{Ray, Triangle};

    /// Hits with these t, of a ray that ends at 1; the place is the number.
    struct At(f32, Vec<f64>);

    impl LanePairs for At {
        fn resolver(&self) -> Resolver<'_> {
            Resolver::Document(0.0)
        }
        fn ray(&self, _: usize) -> Ray {
            Ray::new([0.0; 3], [0.0; 3])
        }
        fn triangle(&self, _: usize) -> Triangle {
            Triangle([[0.0; 3]; 3])
        }
        fn numbers(&self, _: usize) -> (u32, u32) {
            (0, 0)
        }
        fn find(&self, _: u32) -> Triangle {
            Triangle([[0.0; 3]; 3])
        }
        fn hit(&self, lane: usize) -> Option<f64> {
            Some(self.1[lane]).filter(|&t| t < f64::from(self.0))
        }
        fn t(&self, lane: usize) -> f64 {
            self.1[lane]
        }
        fn t_in(&self, _: usize, place: u32) -> f64 {
            self.1[place as usize]
        }
        fn order(&self, _: usize, _: u32) -> Ordering {
            Ordering::Equal
        }
        fn touch(&self, _: usize, _: u32) -> bool {
            false
        }
    }

    #[test]
    fn an_enclosure_is_tight() {
        for t in [0.0, 1.0, 0.1, 1e-300, 1e300, -0.3, f64::from(f32::MAX) * (1.0 + 1e-9)] {
            let (lo, hi) = enclose(t);
            assert!(f64::from(lo) <= t && t <= f64::from(hi), "{lo} {t} {hi}");
            assert!(lo == hi || lo.next_up() == hi);
        }
    }

    #[test]
    fn the_lower_index_wins_a_tie_in_any_order() {
        let t = [2.0, 1.0, 1.0, 1.0 + 1e-12];
        let pairs = At(f32::INFINITY, t.to_vec());
        for order in [[0, 1, 2, 3], [3, 2, 1, 0], [2, 0, 3, 1], [1, 3, 0, 2]] {
            let mut closest = ClosestHit::new(f32::INFINITY);
            for i in order {
                let wide = (t[i as usize] as f32 - 0.1, t[i as usize] as f32 + 0.1);
                closest.offer_near(wide, (i, i), i as usize, &pairs);
            }
            assert_eq!(closest.triangle(), Some((1, 1)), "{order:?}");
        }
    }

    #[test]
    fn the_far_end_is_open() {
        let mut closest = ClosestHit::new(1.0);
        closest.offer_near((0.9, 1.1), (0, 0), 0, &At(1.0, vec![1.0]));
        assert_eq!(closest.triangle(), None);
        closest.offer_near((0.9, 1.1), (0, 0), 0, &At(1.0, vec![1.0 - 1e-12]));
        assert_eq!(closest.triangle(), Some((0, 0)));
    }
}
