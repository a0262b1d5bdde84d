//! The nearest hits of rays from one origin, and the test that finds them.

use crate::lanes::{Lanes, Mask};
use crate::mode::{Counts, lanes_of};

use super::{Judge, Outline, Points, Ranges, at};

/// The nearest hit so far of each of N rays: an enclosure of its inverse depth.
///
/// ```
/// use intertri::lanes::{Simd, WithSimd, dispatch};
/// use intertri::{Certified, Counts, Frame, Nearest, Outlines, Ray, Replay, Starts};
/// use intertri::{Triangle, TrianglePack, Vec3};
///
/// struct Leaf<'a>(Certified, &'a TrianglePack<8>, &'a Frame);
/// impl WithSimd for Leaf<'_> {
///     type Output = Outlines;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Outlines {
///         self.0.outlines_in::<S>(self.1, None, self.2, 1.0)
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let (mode, triangles) = (Certified::default(), [at(5.0), at(3.0)]);
/// let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// let outlines = dispatch(Leaf(mode, &TrianglePack::new(&triangles), &frame));
///
/// // One ray; one f32 is a lane, too.
/// let ray = Ray::new([0.0; 3], [0.05, 0.05, 1.0]);
/// let points = frame.points(Vec3::<f32>::splat(ray.dir));
/// let ranges = mode.starts_in(&Starts::none(), &points, ray.t_min, true).ranges();
/// let mut nearest = Nearest::<f32, 1>::new(&points, ray.t_max);
/// assert_eq!(nearest.triangles(), [Nearest::<f32, 1>::NOTHING]);
/// let find = |triangle| triangles[triangle as usize];
/// let judge = Replay { mode: &mode, rays: &[ray], find, index: |triangle| triangle };
/// for lane in 0..2 {
///     let outline = outlines.lane(lane);
///     assert!(nearest.maybe(&outline, &points, &ranges, 0b1));
///     let numbers = (lane as u32, [0, 1].as_slice());
///     let counts = &mut Counts::default();
///     nearest.take((&points, &ranges), &outline, numbers, (0, &judge), 0b1, counts);
/// }
/// assert_eq!((nearest.hits(), nearest.triangles()), (0b1, [1]));
/// assert!((1.0 / nearest.least() - 3.0).abs() < 1e-3);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Nearest<F, const N: usize> {
    /// No hit with a smaller inverse depth can become the nearest.
    s_lo: F,
    s_hi: F,
    /// The caller's number of the triangle, as bits.
    triangle: F,
    /// Bit i is set where lane i has a hit.
    hits: u32,
}

/// What is seen of a triangle at each point.
struct Sample<F: Lanes> {
    /// The least of the weights, in units of their bound.
    weight: F,
    /// The inverse depth, and its enclosure.
    s: F,
    s_lo: F,
    s_hi: F,
    /// Whether the sign of D is sure.
    sure: F::Mask,
    /// Whether it may be a hit that is nearer.
    maybe: F::Mask,
}

/// What the bound says of each lane. A lane that is in neither mask is a miss.
#[derive(Clone, Copy)]
struct Verdict<F> {
    hit: u32,
    undecided: u32,
    s_lo: F,
    s_hi: F,
}

impl<F: Lanes<Scalar = f32>, const N: usize> Nearest<F, N> {
    /// The number that stands for no triangle.
    pub const NOTHING: u32 = u32::MAX;

    /// No hits yet: whatever is closer than `t_max` is nearer.
    #[inline(always)]
    pub fn new(points: &Points<F>, t_max: F) -> Self {
        let (s_lo, s_hi) = points.inverse(t_max);
        Self { s_lo, s_hi, triangle: F::splat(f32::from_bits(Self::NOTHING)), hits: 0 }
    }

    /// The least inverse depth at which a hit still counts.
    #[inline(always)]
    pub fn least(&self) -> F {
        self.s_lo
    }

    /// Bit i is set where lane i has a hit.
    #[inline(always)]
    pub fn hits(&self) -> u32 {
        self.hits
    }

    /// The caller's numbers of the triangles; [`Nearest::NOTHING`] where nothing is hit.
    #[inline(always)]
    pub fn triangles(&self) -> [u32; N] {
        // Not by `map`, which would not be inlined.
        let (mut lanes, mut numbers) = ([0.0; N], [0; N]);
        self.triangle.store(&mut lanes);
        for (number, lane) in numbers.iter_mut().zip(&lanes) {
            *number = lane.to_bits();
        }
        numbers
    }

    /// Takes the hits of N rays with the triangle `seen[number]`, where they are nearer. Only the lanes
    /// in `live` take part, which must be on the screen and have no NaN in their interval. The judge, who
    /// knows lane i as the ray `first + i`, settles what the bound leaves open. Only undecided tests are
    /// counted: the caller knows how many its windows decided. Whether anything may have changed.
    #[inline(always)]
    pub fn take<J: Judge>(
        &mut self,
        (points, ranges): (&Points<F>, &Ranges<F>),
        outline: &Outline,
        (number, seen): (u32, &[u32]),
        (first, judge): (usize, &J),
        live: u32,
        counts: &mut Counts,
    ) -> bool {
        // Without a branch on whether there is anything: the CPU could not guess it.
        let found = self.test(outline, points, ranges, live);
        counts.undecided += u64::from(found.undecided.count_ones());
        self.offer(&found, (number, seen), points, (first, judge));
        (found.hit | found.undecided) != 0
    }

    /// Whether a live ray may hit a triangle where that is nearer: a first look without a branch, after
    /// which [`Nearest::take`] is asked.
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

    /// Which of the live rays hit a triangle surely, and which perhaps.
    #[inline(always)]
    fn test(
        &self,
        outline: &Outline,
        points: &Points<F>,
        ranges: &Ranges<F>,
        live: u32,
    ) -> Verdict<F> {
        let Sample { weight, s, s_lo, s_hi, sure, maybe } = self.sample(outline, points, ranges);

        // A hit, if nothing is in doubt.
        let inside = weight.gt(F::splat(1.0))
            & s.gt(F::splat(outline.parallel))
            & s_hi.lt(ranges.near_lo)
            & s_lo.gt(F::splat(0.0));
        let hit = (sure & maybe & inside).bits() & live;
        Verdict { hit, undecided: maybe.bits() & live & !hit, s_lo, s_hi }
    }

    /// Where the rays may hit a triangle.
    #[inline(always)]
    fn sample(&self, outline: &Outline, points: &Points<F>, ranges: &Ranges<F>) -> Sample<F> {
        // The least of the weights; below -1 a sure miss, if the sign of D is sure.
        let weight = at(outline.u, points).min(at(outline.v, points)).min(at(outline.w, points));
        let outside = weight.lt(F::splat(-1.0));

        // The plane's inverse depth, negative where the ray goes away from it.
        let s = at(outline.s, points);
        let sure = s.abs().gt(F::splat(outline.least));
        let err = F::splat(outline.err);
        let (s_lo, s_hi) = (s - err, s + err);
        let out_of_range = s_lo.gt(ranges.near_hi) | s_hi.lt(self.s_lo);
        let maybe = !(sure & (outside | s.lt(F::splat(0.0)) | out_of_range));
        Sample { weight, s, s_lo, s_hi, sure, maybe }
    }

    /// Offers what a test found of the triangle `seen[number]`.
    #[inline(always)]
    fn offer<J: Judge>(
        &mut self,
        found: &Verdict<F>,
        (number, seen): (u32, &[u32]),
        points: &Points<F>,
        (first, judge): (usize, &J),
    ) {
        // Where the enclosures tell, all lanes at once.
        let bits = f32::from_bits(number);
        let wins = F::Mask::from_bits(found.hit) & found.s_lo.gt(self.s_hi);
        self.s_lo = F::select(wins, found.s_lo, self.s_lo);
        self.s_hi = F::select(wins, found.s_hi, self.s_hi);
        self.triangle = F::select(wins, F::splat(bits), self.triangle);
        self.hits |= wins.bits();

        // The others one by one, by their exact t.
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
        let triangle = seen[number as usize];
        let (mut new, mut old) = (None, None);
        for lane in lanes_of(rest) {
            let ray = first + lane;
            // A ray without a hit may have its far end here; one with a hit only has to compare.
            let is_hit = self.hits >> lane & 1 != 0;
            let sure = found.hit >> lane & 1 != 0;
            let at = if sure && is_hit {
                exact_t(judge, &mut new, triangle, ray)
            } else if let Some(at) = judge.hit(triangle, ray) {
                at
            } else {
                continue;
            };
            if is_hit {
                let other = seen[numbers[lane].to_bits() as usize];
                let best = exact_t(judge, &mut old, other, ray);
                if !(at < best || (at == best && judge.index(triangle) < judge.index(other))) {
                    continue;
                }
            }
            let one = Points { x: 0.0, y: 0.0, z: z[lane] };
            (lo[lane], hi[lane]) =
                if sure { (new_lo[lane], new_hi[lane]) } else { one.inverse(J::rounded(at)) };
            numbers[lane] = bits;
            self.hits |= 1 << lane;
        }
        self.s_lo = F::load(&lo);
        self.s_hi = F::load(&hi);
        self.triangle = F::load(&numbers);
    }
}

/// t of a ray and a triangle that it is known to hit; `last` is the triangle that was asked for last.
#[inline(always)]
fn exact_t<J: Judge>(
    judge: &J,
    last: &mut Option<(u32, J::Seen)>,
    triangle: u32,
    ray: usize,
) -> J::T {
    let seen = match *last {
        Some((number, seen)) if number == triangle => seen,
        _ => judge.see(triangle),
    };
    *last = Some((triangle, seen));
    judge.t(&seen, ray)
}
