//! The running best of a closest-hit search: an interval of f32 where that decides, f64 where not.

use crate::double::Tri;
use crate::lanes::{Lanes, Mask};
use crate::mode::{Found, Scalar, lanes_of};
use crate::{Hits, RayPacket, Triangle, Vec3};

/// The closest hit so far of one ray.
///
/// `t_lo <= t <= t_hi` encloses the reference's t. Two hits are compared by these intervals, and in
/// f64 only where the intervals meet; equal t go to the lower index.
///
/// ```
/// use intertri::lanes::{Simd, WithSimd, dispatch};
/// use intertri::{Best, Certified, Counts, Mode, Ray, Triangle, TrianglePack};
///
/// struct Eight<'a>(Certified, &'a Ray, &'a [Triangle]);
/// impl WithSimd for Eight<'_> {
///     type Output = Best;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Best {
///         let Self(mode, ray, triangles) = self;
///         let (pack, indices) = (TrianglePack::new(triangles), [0, 1, 2, 3, 4, 5, 6, 7]);
///         let find = |place: u32| triangles[place as usize];
///         let (ray, mut best) = (mode.prepare_ray(ray), Best::new(ray.t_max));
///         mode.closest_in::<S>(&ray, &pack, &indices, 0, find, &mut best, &mut Counts::default());
///         best
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
/// let best = dispatch(Eight(Certified::default(), &ray, &[at(5.0), at(3.0)]));
/// assert!(best.is_hit() && 3.0 <= best.t_hi() && best.t_hi() < 3.001);
/// assert_eq!(best.triangle(), Some((1, 1)));
/// assert_eq!(Best::new(9.0).triangle(), None);
/// assert_eq!(Best::NOTHING, u32::MAX);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Best {
    /// The exact t of the hit, NaN while nobody has asked for it.
    t: f64,
    t_lo: f32,
    t_hi: f32,
    /// The index of the triangle; [`Best::NOTHING`] before the first hit.
    triangle: u32,
    /// Where the caller finds the triangle again.
    place: u32,
}

impl Best {
    /// The index that stands for no triangle.
    pub const NOTHING: u32 = u32::MAX;

    /// No hit yet: whatever is closer than `t_max` is better.
    #[inline(always)]
    pub fn new(t_max: f32) -> Self {
        Self { t: f64::from(t_max), t_lo: t_max, t_hi: t_max, triangle: Self::NOTHING, place: 0 }
    }

    /// No hit with a larger t can become the best.
    #[inline(always)]
    pub fn t_hi(&self) -> f32 {
        self.t_hi
    }

    /// Whether there is a hit.
    #[inline(always)]
    pub fn is_hit(&self) -> bool {
        self.triangle != Self::NOTHING
    }

    /// The index of the triangle, and where the caller put it.
    #[inline(always)]
    pub fn triangle(&self) -> Option<(u32, u32)> {
        self.is_hit().then_some((self.triangle, self.place))
    }

    /// The exact t, where it is known.
    #[inline(always)]
    pub(crate) fn known_t(&self) -> Option<f64> {
        (!self.t.is_nan()).then_some(self.t)
    }

    /// Offers a hit whose t is known exactly. `exact` gives the t of the triangle in a place.
    #[inline(always)]
    pub(crate) fn offer_exact(
        &mut self,
        t: f64,
        triangle: u32,
        place: u32,
        exact: impl Fn(u32) -> f64,
    ) {
        let (t_lo, t_hi) = enclose(t);
        if t_lo > self.t_hi {
            return;
        }
        if t_hi >= self.t_lo && !self.is_after(t, triangle, exact) {
            return;
        }
        *self = Self { t, t_lo, t_hi, triangle, place };
    }

    /// Offers a hit whose t lies in `t_lo..=t_hi`. `exact` gives the t of the triangle in a place.
    #[inline(always)]
    pub(crate) fn offer(
        &mut self,
        (t_lo, t_hi): (f32, f32),
        triangle: u32,
        place: u32,
        exact: impl Fn(u32) -> f64,
    ) {
        if t_hi < self.t_lo {
            *self = Self { t: f64::NAN, t_lo, t_hi, triangle, place };
        } else if t_lo <= self.t_hi {
            let t = exact(place);
            self.offer_exact(t, triangle, place, exact);
        }
    }

    /// Offers what was found in a pack of triangles; the i-th has the index `indices[i]` and the place
    /// `place + i`.
    #[inline(always)]
    pub(crate) fn offer_pack<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &mut self,
        found: &Found<F, D>,
        indices: &[u32; 8],
        place: u32,
        scalar: &impl Scalar,
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
        for lane in lanes_of(found.lanes()) {
            found.offer(lane, self, indices[lane], place + lane as u32, scalar);
        }
    }

    /// Whether a hit with this t and index comes before the best, compared in f64.
    #[inline(always)]
    fn is_after(&mut self, t: f64, triangle: u32, exact: impl Fn(u32) -> f64) -> bool {
        if self.t.is_nan() {
            self.t = exact(self.place);
        }
        // Before the first hit `t` is the open end of the interval, and no index comes before it.
        t < self.t || (t == self.t && triangle < self.triangle && self.is_hit())
    }
}

/// The best of each of N rays, side by side.
///
/// ```
/// use intertri::Bests;
/// // Of four rays that nothing has been offered to yet; one f32 is a lane, too.
/// let bests = Bests::<f32, 1>::new(&[9.0]);
/// assert_eq!(bests.t_hi(), 9.0);
/// assert!(!bests.lane(0).is_hit());
/// ```
#[derive(Clone, Copy)]
pub struct Bests<F, const N: usize> {
    t_lo: F,
    t_hi: F,
    /// Indices and places by their bits, for whole registers of them to be selected.
    triangle: F,
    place: F,
    /// The exact t of the lanes whose bit is set in `known`.
    t: [f64; N],
    known: u32,
}

impl<F: Lanes<Scalar = f32>, const N: usize> Bests<F, N> {
    /// No hits yet; see [`Best::new`].
    #[inline(always)]
    pub fn new(t_max: &[f32; N]) -> Self {
        let t = F::load(t_max);
        Self {
            t_lo: t,
            t_hi: t,
            triangle: F::splat(f32::from_bits(Best::NOTHING)),
            place: F::splat(f32::from_bits(0)),
            t: t_max.map(f64::from),
            known: u32::MAX,
        }
    }

    /// See [`Best::t_hi`].
    #[inline(always)]
    pub fn t_hi(&self) -> F {
        self.t_hi
    }

    /// The best of a lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Best {
        // Each lane by its number: what is indexed by a variable cannot stay in registers.
        let mut t = f64::NAN;
        for i in 0..N {
            if i == lane && self.known >> i & 1 != 0 {
                t = self.t[i];
            }
        }
        Best {
            t,
            t_lo: get::<F, N>(self.t_lo, lane),
            t_hi: get::<F, N>(self.t_hi, lane),
            triangle: get::<F, N>(self.triangle, lane).to_bits(),
            place: get::<F, N>(self.place, lane).to_bits(),
        }
    }

    /// The hits with their exact t; see [`Mode::hits_in`](crate::Mode::hits_in).
    #[inline(always)]
    pub(crate) fn hits<D: Lanes<Scalar = f64>>(
        &self,
        rays: &RayPacket<N>,
        find: impl Fn(u32) -> Triangle,
    ) -> Hits<N> {
        let (mut index, mut place) = ([0.0; N], [0.0; N]);
        self.triangle.store(&mut index);
        self.place.store(&mut place);

        // The triangles whose t nobody has asked for yet.
        let (mut bits, mut unknown) = (0, 0);
        let mut corners = [[[0.0; N]; 3]; 3];
        for lane in 0..N {
            if index[lane].to_bits() == Best::NOTHING {
                continue;
            }
            bits |= 1 << lane;
            if self.known >> lane & 1 == 0 {
                unknown |= 1 << lane;
                let Triangle(triangle) = find(place[lane].to_bits());
                for (to, from) in corners.iter_mut().zip(&triangle) {
                    for (to, from) in to.iter_mut().zip(from) {
                        to[lane] = *from;
                    }
                }
            }
        }

        // All of them at once.
        let mut hits = Hits { bits, t: self.t };
        if unknown != 0 {
            let [c1, c2, c3] = &corners;
            let corners = [Vec3::<D>::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
            let mut t = [0.0; N];
            Tri::new(corners)
                .t(Vec3::load_f32(&rays.origin), Vec3::load_f32(&rays.dir))
                .store(&mut t);
            for (lane, (to, t)) in hits.t.iter_mut().zip(t).enumerate() {
                *to = if unknown >> lane & 1 != 0 { t } else { *to };
            }
        }
        hits
    }

    /// Changes the best of a lane.
    #[inline(always)]
    fn set(&mut self, lane: usize, best: &Best) {
        let at = F::Mask::from_bits(1 << lane);
        let put = |x: f32, old| F::select(at, F::splat(x), old);
        self.t_lo = put(best.t_lo, self.t_lo);
        self.t_hi = put(best.t_hi, self.t_hi);
        self.triangle = put(f32::from_bits(best.triangle), self.triangle);
        self.place = put(f32::from_bits(best.place), self.place);
        for i in 0..N {
            self.t[i] = if i == lane { best.t } else { self.t[i] };
        }
        self.known = self.known & !(1 << lane) | u32::from(!best.t.is_nan()) << lane;
    }

    /// Offers to each lane what was found there.
    #[inline(always)]
    pub(crate) fn offer<D: Lanes<Scalar = f64>>(
        &mut self,
        found: &Found<F, D>,
        triangle: u32,
        place: u32,
        scalar: &impl Scalar,
    ) {
        // Where the enclosures tell, all lanes at once, and without a branch.
        let wins = F::Mask::from_bits(found.near) & found.t_hi.lt(self.t_lo);
        self.t_lo = F::select(wins, found.t_lo, self.t_lo);
        self.t_hi = F::select(wins, found.t_hi, self.t_hi);
        self.triangle = F::select(wins, F::splat(f32::from_bits(triangle)), self.triangle);
        self.place = F::select(wins, F::splat(f32::from_bits(place)), self.place);
        self.known &= !wins.bits();

        // The others one by one.
        for lane in lanes_of(found.lanes() & !wins.bits()) {
            let mut best = self.lane(lane);
            found.offer(lane, &mut best, triangle, place, scalar);
            self.set(lane, &best);
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

/// One of N lanes.
#[inline(always)]
fn get<F: Lanes<Scalar = f32>, const N: usize>(lanes: F, lane: usize) -> f32 {
    let mut all = [0.0; N];
    lanes.store(&mut all);
    all[lane]
}

impl<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> Found<F, D> {
    /// Offers what was found in a lane to a best.
    #[inline(always)]
    pub(crate) fn offer(
        &self,
        lane: usize,
        best: &mut Best,
        triangle: u32,
        place: u32,
        scalar: &impl Scalar,
    ) {
        let exact = |place| scalar.exact_t(lane, place);
        if self.near >> lane & 1 != 0 {
            let (mut t_lo, mut t_hi) = ([0.0; 16], [0.0; 16]);
            self.t_lo.store(&mut t_lo);
            self.t_hi.store(&mut t_hi);
            best.offer((t_lo[lane], t_hi[lane]), triangle, place, exact);
        } else if let Some(t) = self.known_t(lane, scalar) {
            best.offer_exact(t, triangle, place, exact);
        }
    }

    /// The exact t of a lane, if it is a hit and not one of those of which an enclosure is known.
    #[inline(always)]
    pub(crate) fn known_t(&self, lane: usize, scalar: &impl Scalar) -> Option<f64> {
        if self.exact >> lane & 1 != 0 {
            let mut t = [0.0; 16];
            self.t.store(&mut t);
            Some(t[lane])
        } else {
            scalar.replay(lane)
        }
    }
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
    use super::{Best, enclose};

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
        for order in [[0, 1, 2, 3], [3, 2, 1, 0], [2, 0, 3, 1], [1, 3, 0, 2]] {
            let mut best = Best::new(f32::INFINITY);
            for i in order {
                let wide = (t[i as usize] as f32 - 0.1, t[i as usize] as f32 + 0.1);
                best.offer(wide, i, i, |place| t[place as usize]);
            }
            assert_eq!(best.triangle(), Some((1, 1)), "{order:?}");
        }
    }

    #[test]
    fn the_far_end_is_open() {
        let mut best = Best::new(1.0);
        best.offer_exact(1.0, 0, 0, |_| 1.0);
        assert_eq!(best.triangle(), None);
        best.offer((0.9, 1.1), 0, 0, |_| 1.0);
        assert_eq!(best.triangle(), None);
        best.offer((0.9, 1.1), 0, 0, |_| 1.0 - 1e-12);
        assert_eq!(best.triangle(), Some((0, 0)));
    }
}
