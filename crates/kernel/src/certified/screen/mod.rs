//! Rays from one origin as points of a screen: what they have in common, taken to its end.
//!
//! ```text
//!        up                     a ray of direction d is the point (x, y) = (d·right, d·up) / d·depth;
//!         │   ╱ depth           U, V, W and D of document D, divided by d·depth, are linear in x and
//!         │ ╱   · (x, y)        y, and D / T = 1 / (t d·depth) is, too: no division, as in a z-buffer
//!         o───── right
//! ```
//!
//! So a triangle costs a ray two multiply-adds an edge, and one outline of a triangle can be held
//! against a whole window of the screen. Bounds and proof: `docs/numerics/screen.md`.

mod judge;
mod nearest;
mod outline;

use crate::lanes::Lanes;
use crate::{Threshold, Vec3};

use super::bound;
use super::filter::at_least;

pub use judge::{Judge, Replay};
pub use nearest::Nearest;
pub use outline::{Outline, Outlines};

/// An origin and three axes through it, of length 1 and at right angles but for the rounding of f32.
///
/// ```
/// use intertri::{Frame, Vec3};
/// // One f32 is a lane, too.
/// let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// let point = frame.points(Vec3::<f32>::splat([0.5, -1.0, 2.0]));
/// assert_eq!((point.x, point.y, point.z), (0.25, -0.5, 2.0));
/// assert_eq!((frame.depth()[2], frame.across()[1]), (1.0, [0.0, 1.0, 0.0]));
/// assert_eq!(frame.origin(), [0.0; 3]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    origin: [f32; 3],
    depth: [f32; 3],
    right: [f32; 3],
    up: [f32; 3],
    /// The axes in which a normal's components make the same product with a direction's in those
    /// above.
    dual: [[f64; 3]; 3],
    /// How far from the origin rays may pass.
    off: f32,
    /// How far from the middle of the screen, in x and y, those may lie that do, and `OFF_REACH` more.
    reach: [f32; 2],
}

impl Frame {
    /// A frame. No coordinate of the origin may exceed 2^30.
    pub fn new(origin: [f32; 3], depth: [f32; 3], right: [f32; 3], up: [f32; 3]) -> Self {
        let [a, b, c] = [depth, right, up].map(|axis| Vec3::<f64>::splat(axis.map(f64::from)));
        let dual = [b.cross(c), c.cross(a), a.cross(b)];
        let size = a.dot(dual[0]);
        let dual = dual.map(|axis| [axis.x / size, axis.y / size, axis.z / size]);
        Self { origin, depth, right, up, dual, off: 0.0, reach: [0.0; 2] }
    }

    /// The same frame for rays that pass the origin at a distance of up to `off`, each parallel to one that
    /// starts there, all of them at points of the screen within ±`reach` in x and y: rays *toward* a point
    /// that they miss by rounding alone, turned round, with t counted backwards. Then only what they hit is
    /// known, not which hit is nearest: the [`Judge`] of such rays must not be asked for t. What `off` must be
    /// is derived in `docs/numerics/screen.md`, section 6.
    ///
    /// ```
    /// use intertri::Frame;
    /// let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    /// assert_eq!((frame.off(), frame.passed_within(1e-6, [0.1, 0.2]).off()), (0.0, 1e-6));
    /// ```
    #[must_use]
    pub fn passed_within(self, off: f32, reach: [f32; 2]) -> Self {
        Self { off, reach: reach.map(|most| most + bound::OFF_REACH), ..self }
    }

    /// The origin.
    pub fn origin(&self) -> [f32; 3] {
        self.origin
    }

    /// How far from the origin rays may pass.
    pub fn off(&self) -> f32 {
        self.off
    }

    /// The axis along which depth is measured.
    pub fn depth(&self) -> [f32; 3] {
        self.depth
    }

    /// The axes across.
    pub fn across(&self) -> [[f32; 3]; 2] {
        [self.right, self.up]
    }

    /// Where directions meet the screen.
    #[inline(always)]
    pub fn points<F: Lanes<Scalar = f32>>(&self, dir: Vec3<F>) -> Points<F> {
        let z = dir.dot_fused(Vec3::splat(self.depth));
        let recip = F::splat(1.0) / z;
        let x = dir.dot_fused(Vec3::splat(self.right)) * recip;
        let y = dir.dot_fused(Vec3::splat(self.up)) * recip;
        Points { x, y, z }
    }
}

/// Rays as points of the screen.
///
/// ```
/// use intertri::Points;
/// // The bounds hold near the middle of the screen.
/// let point = |x| Points { x, y: 0.0, z: 1.0_f32 };
/// assert!(point(0.2).on_screen() && !point(1e3).on_screen() && !point(f32::NAN).on_screen());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Points<F> {
    /// To the right.
    pub x: F,
    /// Upwards.
    pub y: F,
    /// The depth that a unit of t makes.
    pub z: F,
}

impl<F: Lanes<Scalar = f32>> Points<F> {
    /// Which of them are near enough to the middle, and of a sane length, for the bounds to hold.
    #[inline(always)]
    pub fn on_screen(&self) -> F::Mask {
        let edge = F::splat(bound::SCREEN_EDGE);
        self.x.abs().le(edge)
            & self.y.abs().le(edge)
            & self.z.ge(F::splat(bound::SHORTEST_DIR))
            & self.z.le(F::splat(bound::LARGEST))
    }

    /// An enclosure of `1 / (t z)`.
    #[inline(always)]
    fn inverse(&self, t: F) -> (F, F) {
        let s = F::splat(1.0) / (t * self.z);
        (s * F::splat(1.0 - bound::INVERSE), s * F::splat(1.0 + bound::INVERSE))
    }
}

/// Where rays begin to look for hits, as depths: lane by lane of any number of packets.
///
/// ```
/// use intertri::{Certified, Points, Ranges, Starts};
/// let points = Points { x: 0.0_f32, y: 0.0, z: 1.0 };
/// let starts = Certified::default().starts_in(&Starts::none(), &points, 2.0, true);
/// let from_two_on: Ranges<f32> = starts.ranges();
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Starts<F> {
    /// Beyond this a hit of any of them is far enough.
    last: F,
    /// Before this no hit is.
    first: F,
}

impl<F: Lanes<Scalar = f32>> Starts<F> {
    /// Of no ray.
    #[inline(always)]
    pub fn none() -> Self {
        Self { last: F::splat(0.0), first: F::splat(f32::INFINITY) }
    }

    /// With the live rays of one more packet, which look beyond `Threshold` and `t_min`.
    #[inline(always)]
    pub(super) fn and(
        &self,
        points: &Points<F>,
        t_min: F,
        live: F::Mask,
        threshold: Threshold,
    ) -> Self {
        // Not so small that products are subnormal: those take the CPU a hundred times as long.
        let above = at_least(t_min, threshold.above.max(bound::SMALL));
        let below = at_least(t_min, threshold.below.max(0.0));
        Self {
            last: F::select(live, self.last.max(above * points.z), self.last),
            first: F::select(live, self.first.min(below * points.z), self.first),
        }
    }

    /// The same as inverse depths.
    #[inline(always)]
    pub fn ranges(&self) -> Ranges<F> {
        let (zero, one) = (F::splat(0.0), F::splat(1.0));
        let near_hi = one / self.first * F::splat(1.0 + bound::INVERSE);
        Ranges {
            near_lo: one / self.last * F::splat(1.0 - bound::INVERSE),
            near_hi: F::select(self.first.gt(zero), near_hi, F::splat(f32::INFINITY)),
        }
    }
}

/// The near ends of rays, as inverse depths.
///
/// ```
/// use intertri::{Ranges, Starts};
/// let of_no_ray: Ranges<f32> = Starts::none().ranges();
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Ranges<F> {
    /// Below this a hit is far enough.
    near_lo: F,
    /// Above this it is not.
    near_hi: F,
}

/// Rectangles of the screen.
///
/// ```
/// use intertri::Windows;
/// // From (0, 0) to (0.5, 0.25); four, eight or sixteen with as many lanes.
/// let window = Windows::<f32>::new([0.0, 0.0], [0.5, 0.25]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Windows<F> {
    lo: [F; 2],
    hi: [F; 2],
    middle: [F; 2],
    half: [F; 2],
}

impl<F: Lanes<Scalar = f32>> Windows<F> {
    /// From the smallest and largest x and y.
    #[inline(always)]
    pub fn new(lo: [F; 2], hi: [F; 2]) -> Self {
        let half = F::splat(0.5);
        Self {
            lo,
            hi,
            middle: [(lo[0] + hi[0]) * half, (lo[1] + hi[1]) * half],
            half: [(hi[0] - lo[0]) * half, (hi[1] - lo[1]) * half],
        }
    }

    /// The largest and smallest value of linear forms in the windows.
    #[inline(always)]
    fn range(&self, form: [F; 3]) -> (F, F) {
        let [one, x, y] = form;
        let middle = y.mul_add(self.middle[1], x.mul_add(self.middle[0], one));
        let reach = y.abs().mul_add(self.half[1], x.abs() * self.half[0]);
        (middle - reach, middle + reach)
    }

    /// Which windows an outline that fills `lo..=hi` reaches.
    #[inline(always)]
    fn reached(&self, lo: [F; 2], hi: [F; 2]) -> F::Mask {
        self.lo[0].le(hi[0]) & lo[0].le(self.hi[0]) & self.lo[1].le(hi[1]) & lo[1].le(self.hi[1])
    }
}

/// A form at points of the screen.
#[inline(always)]
fn at<F: Lanes<Scalar = f32>>(form: [f32; 3], points: &Points<F>) -> F {
    let [one, x, y] = outline::splat::<F>(form);
    y.mul_add(points.y, x.mul_add(points.x, one))
}
