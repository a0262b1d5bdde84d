//! The frame onto which rays from one origin are projected, and the projected points.

use super::super::bound;
use crate::simd::Lanes;
use crate::simd::Vec3;

/// An origin and three axes, orthonormal up to f32 rounding.
///
/// ```
/// use intertri::internal::Frame;
/// use intertri::simd::Vec3;
/// // An f32 counts as one lane.
/// let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// let point = frame.points(Vec3::<f32>::splat([0.5, -1.0, 2.0]));
/// assert_eq!((point.x, point.y, point.z), (0.25, -0.5, 2.0));
/// assert_eq!((frame.depth()[2], frame.across()[1]), (1.0, [0.0, 1.0, 0.0]));
/// assert_eq!(frame.origin(), [0.0; 3]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub(super) origin: [f32; 3],
    pub(super) depth: [f32; 3],
    pub(super) right: [f32; 3],
    pub(super) up: [f32; 3],
    /// The dual axes. The dot product of a normal in the dual axes and a direction in the frame's
    /// axes equals the dot product of the original vectors.
    pub(super) dual: [[f64; 3]; 3],
    /// The maximum distance by which rays miss the origin.
    pub(super) off: f32,
    /// The maximum distance of the rays' points from the centre of the projection in x and y, plus
    /// `OFF_REACH`. The value is 0 if all rays pass through the origin.
    pub(super) reach: [f32; 2],
    /// The coefficients of the error bounds.
    pub(super) shares: Shares,
}

/// The coefficients of the error bounds that differ between f32 scenes and copies of f64 scenes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shares {
    /// Whether blocks contain copies, which have one corner and two edges instead of three corners.
    pub(super) copies: bool,
    /// The constant `SCREEN`, or `COPY_SCREEN` for copies.
    pub(super) screen: f32,
    /// The constant `EDGES`, or `COPY_EDGES` for copies.
    pub(super) edges: f32,
    /// The error of T, relative to `|A|₁ h²`.
    pub(super) plane: f32,
    /// For copies, `COPY_DEPTH`; otherwise 0.
    pub(super) depth: f32,
    /// For copies, `COPY_SLANT`; otherwise 0.
    pub(super) slant: f32,
    /// For copies, `COPY`, the displacement of a corner relative to its distance; otherwise 0.
    pub(super) copy: f32,
}

impl Shares {
    /// The coefficients for f32 scenes.
    const PLAIN: Self = Self {
        copies: false,
        screen: bound::SCREEN,
        edges: bound::EDGES,
        plane: bound::NOISE,
        depth: 0.0,
        slant: 0.0,
        copy: 0.0,
    };

    /// The coefficients for copies of f64 scenes.
    const COPIES: Self = Self {
        copies: true,
        screen: bound::COPY_SCREEN,
        edges: bound::COPY_EDGES,
        plane: bound::COPY_PLANE,
        depth: bound::COPY_DEPTH,
        slant: bound::COPY_SLANT,
        copy: bound::COPY,
    };
}

impl Frame {
    /// Creates a frame. No coordinate of the origin may exceed 2^30 in magnitude.
    pub fn new(origin: [f32; 3], depth: [f32; 3], right: [f32; 3], up: [f32; 3]) -> Self {
        // The dual basis is b × c, c × a, and a × b, divided by the determinant. For exactly
        // orthonormal axes, it consists of the axes themselves.
        let [a, b, c] = [depth, right, up].map(|axis| Vec3::<f64>::splat(axis.map(f64::from)));
        let dual = [b.cross(c), c.cross(a), a.cross(b)];
        let size = a.dot(dual[0]);
        let dual = dual.map(|axis| [axis.x / size, axis.y / size, axis.z / size]);
        let (off, reach, shares) = (0.0, [0.0; 2], Shares::PLAIN);
        Self { origin, depth, right, up, dual, off, reach, shares }
    }

    /// Adapts the frame to rays that miss the origin by at most `off`. Each ray must be parallel to
    /// a ray that starts at the origin, and its point must be within ±`reach` of the projection's
    /// centre in x and y. Use this method for rays *toward* a point that have been reversed to
    /// start at that point: because of rounding, they may slightly miss it. The test can determine
    /// whether a reversed ray hits, but not which hit is nearest, so do not query the resolver for
    /// its t. `docs/numerics/projection.md`, section 6, derives `off`.
    ///
    /// ```
    /// use intertri::internal::Frame;
    /// let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    /// assert_eq!((frame.off(), frame.passed_within(1e-6, [0.1, 0.2]).off()), (0.0, 1e-6));
    /// ```
    #[must_use]
    pub fn passed_within(self, off: f32, reach: [f32; 2]) -> Self {
        Self { off, reach: reach.map(|most| most + bound::OFF_REACH), ..self }
    }

    /// Adapts the frame to copies of f64 originals (`docs/numerics/f64.md`, section 6).
    #[must_use]
    pub(in super::super) fn of_copies(self) -> Self {
        Self { shares: Shares::COPIES, ..self }
    }

    /// Returns the origin of the frame.
    pub fn origin(&self) -> [f32; 3] {
        self.origin
    }

    /// Returns the maximum distance by which rays miss the origin.
    pub fn off(&self) -> f32 {
        self.off
    }

    /// Returns the maximum distance by which rays miss the origin, relative to triangles at a
    /// distance of `away`.
    #[inline(always)]
    pub(super) fn off_at<F: Lanes<Scalar = f32>>(&self, away: F) -> F {
        away.mul_add(F::splat(self.shares.copy), F::splat(self.off))
    }

    /// Returns the distance between the frame's origin and the world's origin, in the 1-norm.
    pub(super) fn distance(&self) -> f32 {
        self.origin.iter().fold(0.0, |sum, x| sum + x.abs())
    }

    /// Returns the axis along which depth is measured.
    pub fn depth(&self) -> [f32; 3] {
        self.depth
    }

    /// Returns the two axes perpendicular to the depth axis.
    pub fn across(&self) -> [[f32; 3]; 2] {
        [self.right, self.up]
    }

    /// Projects directions to points.
    #[inline(always)]
    pub fn points<F: Lanes<Scalar = f32>>(&self, dir: Vec3<F>) -> Points<F> {
        let z = dir.dot_fused(Vec3::splat(self.depth));
        // One division serves both coordinates. Multiplying by the reciprocal rounds once more,
        // which `SCREEN` covers.
        let recip = F::splat(1.0) / z;
        let x = dir.dot_fused(Vec3::splat(self.right)) * recip;
        let y = dir.dot_fused(Vec3::splat(self.up)) * recip;
        Points { x, y, z }
    }
}

/// Rays as points on the projection.
///
/// ```
/// use intertri::internal::Points;
/// // The error bounds hold near the centre of the projection.
/// let point = |x| Points { x, y: 0.0, z: 1.0_f32 };
/// assert!(point(0.2).on_screen() && !point(1e3).on_screen() && !point(f32::NAN).on_screen());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Points<F> {
    /// The coordinate along the right axis.
    pub x: F,
    /// The coordinate along the up axis.
    pub y: F,
    /// The depth per unit of t.
    pub z: F,
}

impl<F: Lanes<Scalar = f32>> Points<F> {
    /// Returns the lanes for which the bounds hold: the point is near enough to the centre, and the
    /// direction is neither too long nor too short.
    #[inline(always)]
    pub fn on_screen(&self) -> F::Mask {
        let edge = F::splat(bound::SCREEN_EDGE);
        self.x.abs().le(edge)
            & self.y.abs().le(edge)
            & self.z.ge(F::splat(bound::SHORTEST_DIR))
            & self.z.le(F::splat(bound::LARGEST))
    }

    /// Returns lower and upper bounds on `1 / (t z)`.
    #[inline(always)]
    pub(super) fn inverse(&self, t: F) -> (F, F) {
        let least = F::splat(bound::SHORTEST_T);
        // The rounding error of a subnormal product exceeds `INVERSE`, so a tiny t counts as
        // unknown.
        let s = F::splat(1.0) / (t.max(least) * self.z);
        let s_hi = s * F::splat(1.0 + bound::INVERSE);
        let s_hi = F::select(t.lt(least), F::splat(f32::INFINITY), s_hi);
        (s * F::splat(1.0 - bound::INVERSE), s_hi)
    }
}

/// Evaluates a linear form at points on the projection.
#[inline(always)]
pub(super) fn at<F: Lanes<Scalar = f32>>(form: [f32; 3], points: &Points<F>) -> F {
    let [one, x, y] = [F::splat(form[0]), F::splat(form[1]), F::splat(form[2])];
    y.mul_add(points.y, x.mul_add(points.x, one))
}
