//! The nearest hits of rays from one origin, and the test that finds them.

use crate::double::Plane;
use crate::lanes::{Lanes, Mask};
use crate::mode::lanes_of;
use crate::{Ray, Triangle};

use super::{Outline, Points, Ranges, at};

/// The nearest hit so far of each of N rays: an enclosure of its inverse depth.
///
/// ```
/// use intertri::lanes::{Simd, WithSimd, dispatch};
/// use intertri::{Certified, Counts, Frame, Nearest, Outlines, Ray, Starts, Triangle};
/// use intertri::{TrianglePack, Vec3};
///
/// struct Leaf<'a>(Certified, &'a TrianglePack<8>, &'a Frame);
/// impl WithSimd for Leaf<'_> {
///     type Output = Outlines;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Outlines {
///         self.0.outlines_in::<S>(self.1, self.2, 1.0)
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
/// let mut nearest = Nearest::<f32, 1>::new(&points, &[ray.t_max]);
/// assert_eq!(nearest.triangles(), [Nearest::<f32, 1>::NOTHING]);
/// for triangle in 0..2 {
///     mode.outline_closest_in(
///         (&points, &ranges),
///         (&outlines.lane(triangle as usize), false),
///         triangle,
///         |_lane| ray,
///         |triangle| triangles[triangle as usize],
///         |triangle| triangle,
///         0b1,
///         &mut nearest,
///         &mut Counts::default(),
///     );
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

/// What the bound says of each lane. A lane that is in neither mask is a miss.
#[derive(Clone, Copy)]
pub(in super::super) struct Verdict<F> {
    pub(in super::super) hit: u32,
    pub(in super::super) undecided: u32,
    s_lo: F,
    s_hi: F,
}

impl<F: Lanes<Scalar = f32>, const N: usize> Nearest<F, N> {
    /// The number that stands for no triangle.
    pub const NOTHING: u32 = u32::MAX;

    /// No hits yet: whatever is closer than `t_max` is nearer.
    #[inline(always)]
    pub fn new(points: &Points<F>, t_max: &[f32; N]) -> Self {
        let (s_lo, s_hi) = points.inverse(F::load(t_max));
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

    /// Which of the live rays hit a triangle surely, and which perhaps. `plain` says that D is sure
    /// and positive. `None` where all miss.
    #[inline(always)]
    pub(in super::super) fn test(
        &self,
        outline: &Outline,
        plain: bool,
        points: &Points<F>,
        ranges: &Ranges<F>,
        live: u32,
    ) -> Option<Verdict<F>> {
        // The least of the weights; below -1 a sure miss, if the sign of D is sure.
        let weight = at(outline.u, points).min(at(outline.v, points)).min(at(outline.w, points));
        let outside = weight.lt(F::splat(-1.0));
        if plain && (!outside).bits() & live == 0 {
            return None;
        }

        // The plane's inverse depth, negative where the ray goes away from it.
        let s = at(outline.s, points);
        let sure = s.abs().gt(F::splat(outline.least));
        let maybe = !(sure & (outside | s.lt(F::splat(0.0))));
        let err = F::splat(outline.err);
        let (s_lo, s_hi) = (s - err, s + err);
        let out_of_range = sure & (s_lo.gt(ranges.near_hi) | s_hi.lt(self.s_lo));
        let maybe = maybe & !out_of_range;
        if maybe.bits() & live == 0 {
            return None;
        }

        // A hit, if nothing is in doubt.
        let inside = weight.gt(F::splat(1.0))
            & s.gt(F::splat(outline.parallel))
            & s_hi.lt(ranges.near_lo)
            & s_lo.gt(F::splat(0.0));
        let hit = (sure & maybe & inside).bits() & live;
        Some(Verdict { hit, undecided: maybe.bits() & live & !hit, s_lo, s_hi })
    }

    /// Offers what a test found: `exact` holds the t of the lanes in `replayed`. `find` gives a
    /// triangle by its number, `index` its index, which breaks ties.
    #[inline(always)]
    pub(in super::super) fn offer(
        &mut self,
        found: &Verdict<F>,
        (replayed, exact): (u32, &[f64; N]),
        triangle: u32,
        points: &Points<F>,
        ray: impl Fn(usize) -> Ray,
        find: impl Fn(u32) -> Triangle,
        index: impl Fn(u32) -> u32,
    ) {
        // Where the enclosures tell, all lanes at once.
        let bits = f32::from_bits(triangle);
        let wins = F::Mask::from_bits(found.hit) & found.s_lo.gt(self.s_hi);
        self.s_lo = F::select(wins, found.s_lo, self.s_lo);
        self.s_hi = F::select(wins, found.s_hi, self.s_hi);
        self.triangle = F::select(wins, F::splat(bits), self.triangle);
        self.hits |= wins.bits();

        // The others one by one, by their exact t.
        let rest = (found.hit & !wins.bits()) | replayed;
        if rest == 0 {
            return;
        }
        let (mut lo, mut hi, mut number) = ([0.0; N], [0.0; N], [0.0; N]);
        let (mut new_lo, mut new_hi, mut z) = ([0.0; N], [0.0; N], [0.0; N]);
        self.s_lo.store(&mut lo);
        self.s_hi.store(&mut hi);
        self.triangle.store(&mut number);
        found.s_lo.store(&mut new_lo);
        found.s_hi.store(&mut new_hi);
        points.z.store(&mut z);
        let (mut new, mut old) = (None, None);
        for lane in lanes_of(rest) {
            let ray = ray(lane);
            let t = |plane: &mut Option<(u32, Plane)>, triangle| {
                let known = plane.filter(|(number, _)| *number == triangle);
                let (_, seen) =
                    known.unwrap_or_else(|| (triangle, Plane::new(&find(triangle), ray.origin)));
                *plane = Some((triangle, seen));
                seen.t(ray.dir)
            };
            let known = replayed >> lane & 1 != 0;
            let at = if known { exact[lane] } else { t(&mut new, triangle) };
            let nearer = if self.hits >> lane & 1 == 0 {
                at < f64::from(ray.t_max)
            } else {
                let other = number[lane].to_bits();
                let best = t(&mut old, other);
                at < best || (at == best && index(triangle) < index(other))
            };
            if nearer {
                let one = Points { x: 0.0, y: 0.0, z: z[lane] };
                let enclosure =
                    if known { one.inverse(at as f32) } else { (new_lo[lane], new_hi[lane]) };
                (lo[lane], hi[lane]) = enclosure;
                number[lane] = bits;
                self.hits |= 1 << lane;
            }
        }
        self.s_lo = F::load(&lo);
        self.s_hi = F::load(&hi);
        self.triangle = F::load(&number);
    }
}
