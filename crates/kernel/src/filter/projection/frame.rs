//! The frame onto which rays of one apex are projected, and the projected points.

use super::super::bound;
use crate::simd::Lanes;
use crate::simd::Vec3;

/// An origin and three axes at right angles, up to f32 rounding. Their lengths are 1 unless the rays are
/// parallel.
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
    /// The limits of the rays, if they are parallel.
    pub(super) parallel: Option<Parallel>,
    /// The axes of the world along which the direction of parallel rays is 0, a bit each.
    level_axes: u8,
}

/// Limits of parallel rays that are projected along their direction (projection.md, section 7).
#[derive(Clone, Copy, Debug)]
pub struct Parallel {
    /// The length of the direction.
    pub length: f32,
    /// The number of units of x and y per unit of length.
    pub scale: f32,
    /// The largest depth of an origin, in units of t.
    pub deep: f32,
    /// The largest distance of an origin from the frame's origin.
    pub away: f32,
    /// The sign of the depth of the rays' direction: -1 if they are traced backward.
    pub forward: f32,
}

/// The point through which the lines of all rays pass.
#[derive(Clone, Copy, Debug)]
pub enum Apex {
    /// A point of space.
    Finite,
    /// A point at infinity: the rays are parallel. `off` bounds the errors of the depths at which they
    /// start, and of the ends of copies, in units of t.
    AtInfinity {
        /// The bound.
        off: f32,
    },
}

impl Apex {
    /// Returns lower and upper bounds on the inverse depth at t of a ray with the given z. If the
    /// apex is at infinity, depths are measured in units of t, and the inverse depth stands for the
    /// negative depth: as in the other case, the larger it is, the nearer the point.
    #[inline(always)]
    pub(super) fn inverse<F: Lanes<Scalar = f32>>(self, z: F, t: F) -> (F, F) {
        match self {
            Self::Finite => {
                let least = F::splat(bound::SHORTEST_T);
                // The rounding error of a subnormal product exceeds `INVERSE`, so a tiny t counts as
                // unknown.
                let s = F::splat(1.0) / (t.max(least) * z);
                let s_hi = s * F::splat(1.0 + bound::INVERSE);
                let s_hi = F::select(t.lt(least), F::splat(f32::INFINITY), s_hi);
                (s * F::splat(1.0 - bound::INVERSE), s_hi)
            }
            Self::AtInfinity { off } => {
                let s = -(z + t);
                // An infinite t has an infinite depth, without an error.
                let size = s.abs().min(F::splat(f32::MAX));
                let err = size.mul_add(F::splat(bound::ALONG), F::splat(off));
                (s - err, s + err)
            }
        }
    }
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
    /// The coefficients for parallel rays.
    pub(super) along: SharesAlong,
}

/// The coefficients of the error bounds for parallel rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct SharesAlong {
    /// The constant `EDGES_ALONG`, or `COPY_EDGES_ALONG` for copies.
    pub(super) edges: f32,
    /// The constant `LOST_ALONG`, or `COPY_LOST_ALONG` for copies.
    pub(super) lost: f32,
    /// The constant `ROOM_ALONG`, or `COPY_ROOM_ALONG` for copies.
    pub(super) room: f32,
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
        along: SharesAlong {
            edges: bound::EDGES_ALONG,
            lost: bound::LOST_ALONG,
            room: bound::ROOM_ALONG,
        },
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
        along: SharesAlong {
            edges: bound::COPY_EDGES_ALONG,
            lost: bound::COPY_LOST_ALONG,
            room: bound::COPY_ROOM_ALONG,
        },
    };
}

impl Frame {
    /// Sets the axes along which the direction of the rays is 0 ([`Filter::level_axes`]).
    ///
    /// [`Filter::level_axes`]: crate::Filter::level_axes
    pub fn level_along(self, level_axes: u8) -> Self {
        Self { level_axes, ..self }
    }

    /// Returns the axes along which the direction of the rays is 0.
    #[inline(always)]
    pub(crate) fn level_axes(&self) -> u8 {
        self.level_axes
    }

    /// Creates a frame. No coordinate of the origin may exceed 2^30 in magnitude.
    pub fn new(origin: [f32; 3], depth: [f32; 3], right: [f32; 3], up: [f32; 3]) -> Self {
        // The dual basis is b × c, c × a, and a × b, divided by the determinant. For exactly
        // orthonormal axes, it consists of the axes themselves.
        let [a, b, c] = [depth, right, up].map(|axis| Vec3::<f64>::splat(axis.map(f64::from)));
        let dual = [b.cross(c), c.cross(a), a.cross(b)];
        let size = a.dot(dual[0]);
        let dual = dual.map(|axis| [axis.x / size, axis.y / size, axis.z / size]);
        let (off, reach, shares) = (0.0, [0.0; 2], Shares::PLAIN);
        Self { origin, depth, right, up, dual, off, reach, shares, parallel: None, level_axes: 0 }
    }

    /// Creates a frame for rays with the direction `dir`, whose hits are exact. Points within
    /// `1 / (2 scale)` of the frame's origin along `right`, and across it, are on the projection.
    /// `deep` limits the depths at which rays start. `right` must be perpendicular to `dir`, up to
    /// rounding. If `forward` is -1 instead of 1, rays are traced backward, from infinity to their
    /// origins: the direction and every t change their signs. `docs/numerics/projection.md`, section
    /// 7, has the limits of these numbers.
    ///
    /// ```
    /// use intertri::internal::Frame;
    /// use intertri::simd::Vec3;
    /// let frame = Frame::parallel([0.0; 3], ([0.0, 0.0, 2.0], 1.0), [1.0, 0.0, 0.0], 0.25, 8.0);
    /// let point = frame.origins(Vec3::<f32>::splat([1.0, -2.0, 3.0]));
    /// // Along the direction, one unit of t is a distance of two.
    /// assert_eq!((point.x, point.y, point.z), (0.25, -0.5, 1.5));
    /// ```
    pub fn parallel(
        origin: [f32; 3],
        (dir, forward): ([f32; 3], f32),
        right: [f32; 3],
        scale: f32,
        deep: f32,
    ) -> Self {
        // In f64, the axes are perpendicular to the direction up to rounding that is negligible in
        // f32. The dual of the depth axis is the direction itself.
        let dir = dir.map(|x| forward * x);
        let [d, right] = [dir, right].map(|v| Vec3::<f64>::splat(v.map(f64::from)));
        let square = d.dot(d);
        let right = right - d * (right.dot(d) / square);
        let right = right * (1.0 / right.dot(right).sqrt());
        let up = d.cross(right) * (1.0 / square.sqrt());
        let (scale64, each) = (f64::from(scale), |v: Vec3<f64>| [v.x, v.y, v.z]);
        let dual = [d, right * (1.0 / scale64), up * (1.0 / scale64)].map(each);
        let axes = [d * (1.0 / square), right * scale64, up * scale64];
        let [depth, right, up] = axes.map(|axis| each(axis).map(|x| x as f32));
        let length = square.sqrt() as f32;
        let away = bound::ACROSS / scale + deep * length;
        let parallel = Some(Parallel { length, scale, deep, away, forward });
        let (off, reach, shares) = (0.0, [0.0; 2], Shares::PLAIN);
        Self { origin, depth, right, up, dual, off, reach, shares, parallel, level_axes: 0 }
    }

    /// Returns the apex of the frame's rays.
    #[inline(always)]
    pub fn apex(&self) -> Apex {
        match self.parallel {
            None => Apex::Finite,
            Some(Parallel { away, length, .. }) => {
                Apex::AtInfinity { off: bound::BEGIN * away / length }
            }
        }
    }

    /// Returns the limits of parallel rays.
    pub fn parallel_rays(&self) -> Option<Parallel> {
        self.parallel
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

    /// Projects the origins of parallel rays to points. z is the depth at which a ray starts, in
    /// units of t.
    #[inline(always)]
    pub fn origins<F: Lanes<Scalar = f32>>(&self, origin: Vec3<F>) -> Points<F> {
        let from = origin - Vec3::splat(self.origin);
        // Without a closure, which would not be inlined.
        let x = from.dot_fused(Vec3::splat(self.right));
        let y = from.dot_fused(Vec3::splat(self.up));
        let z = from.dot_fused(Vec3::splat(self.depth));
        Points { x, y, z }
    }

    /// Returns the lanes for which the bounds hold: the point is near enough to the centre of the
    /// projection, and the direction is neither too long nor too short or, for parallel rays, the
    /// origin is not too far away.
    #[inline(always)]
    pub fn on_screen<F: Lanes<Scalar = f32>>(&self, points: &Points<F>) -> F::Mask {
        let edge = F::splat(bound::SCREEN_EDGE);
        let across = points.x.abs().le(edge) & points.y.abs().le(edge);
        match self.parallel {
            None => {
                across
                    & points.z.ge(F::splat(bound::SHORTEST_DIR))
                    & points.z.le(F::splat(bound::LARGEST))
            }
            Some(Parallel { deep, .. }) => across & points.z.abs().le(F::splat(deep)),
        }
    }
}

/// Rays as points on the projection.
///
/// ```
/// use intertri::internal::{Frame, Points};
/// // The error bounds hold near the centre of the projection.
/// let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// let on_screen = |x| frame.on_screen(&Points { x, y: 0.0, z: 1.0_f32 });
/// assert!(on_screen(0.2) && !on_screen(1e3) && !on_screen(f32::NAN));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Points<F> {
    /// The coordinate along the right axis.
    pub x: F,
    /// The coordinate along the up axis.
    pub y: F,
    /// The depth per unit of t or, for parallel rays, the depth at which the ray starts.
    pub z: F,
}

/// Evaluates a linear form at points on the projection.
#[inline(always)]
pub(super) fn at<F: Lanes<Scalar = f32>>(form: [f32; 3], points: &Points<F>) -> F {
    let [one, x, y] = [F::splat(form[0]), F::splat(form[1]), F::splat(form[2])];
    y.mul_add(points.y, x.mul_add(points.x, one))
}
