//! The frame onto which rays from one origin are projected, and the rays as its points.

use super::super::bound;
use crate::simd::Lanes;
use crate::simd::Vec3;

/// An origin and three axes through it, of length 1 and at right angles but for the rounding of f32.
///
/// ```
/// use intertri::internal::Frame;
/// use intertri::simd::Vec3;
/// // One f32 is a lane, too.
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
    /// The axes in which a normal's components make the same product with a direction's in those
    /// above.
    pub(super) dual: [[f64; 3]; 3],
    /// How far from the origin rays may pass.
    pub(super) off: f32,
    /// How far from the middle of the projection, in x and y, those may lie that do, and `OFF_REACH` more.
    pub(super) reach: [f32; 2],
    /// What bounds are made of.
    pub(super) shares: Shares,
}

/// The shares of the bounds that differ between what is given in f32 and copies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shares {
    /// Whether blocks hold copies: a corner and two edges, not three corners.
    pub(super) copies: bool,
    /// `SCREEN`
    pub(super) screen: f32,
    /// `EDGES`
    pub(super) edges: f32,
    /// What T is uncertain by, relative to `|A|₁ h²`.
    pub(super) plane: f32,
    /// `COPY_DEPTH`
    pub(super) depth: f32,
    /// `COPY_SLANT`
    pub(super) slant: f32,
    /// `COPY`: how far corners are elsewhere, relative to how far they are away.
    pub(super) copy: f32,
}

impl Shares {
    /// Of what is given in f32.
    const PLAIN: Self = Self {
        copies: false,
        screen: bound::SCREEN,
        edges: bound::EDGES,
        plane: bound::NOISE,
        depth: 0.0,
        slant: 0.0,
        copy: 0.0,
    };

    /// Of copies.
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
    /// A frame. No coordinate of the origin may exceed 2^30.
    pub fn new(origin: [f32; 3], depth: [f32; 3], right: [f32; 3], up: [f32; 3]) -> Self {
        let [a, b, c] = [depth, right, up].map(|axis| Vec3::<f64>::splat(axis.map(f64::from)));
        let dual = [b.cross(c), c.cross(a), a.cross(b)];
        let size = a.dot(dual[0]);
        let dual = dual.map(|axis| [axis.x / size, axis.y / size, axis.z / size]);
        let (off, reach, shares) = (0.0, [0.0; 2], Shares::PLAIN);
        Self { origin, depth, right, up, dual, off, reach, shares }
    }

    /// The same frame for rays that pass the origin at a distance of up to `off`, each parallel to one that
    /// starts there, all of them at points of the projection within ±`reach` in x and y: rays *toward* a point
    /// that they miss by rounding alone, turned round, with t counted backwards. Then only what they hit is
    /// known, not which hit is nearest: the resolver must not be asked for t of such rays. What `off` must be
    /// is derived in `docs/numerics/projection.md`, section 6.
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

    /// The same frame for copies of what is given in f64 (`docs/numerics/f64.md`, section 6).
    #[must_use]
    pub(in super::super) fn of_copies(self) -> Self {
        Self { shares: Shares::COPIES, ..self }
    }

    /// The origin.
    pub fn origin(&self) -> [f32; 3] {
        self.origin
    }

    /// How far from the origin rays may pass.
    pub fn off(&self) -> f32 {
        self.off
    }

    /// The same as triangles see it that are `away` from there.
    #[inline(always)]
    pub(super) fn off_at<F: Lanes<Scalar = f32>>(&self, away: F) -> F {
        away.mul_add(F::splat(self.shares.copy), F::splat(self.off))
    }

    /// How far the origin is from the world's.
    pub(super) fn distance(&self) -> f32 {
        self.origin.iter().fold(0.0, |sum, x| sum + x.abs())
    }

    /// The axis along which depth is measured.
    pub fn depth(&self) -> [f32; 3] {
        self.depth
    }

    /// The axes across.
    pub fn across(&self) -> [[f32; 3]; 2] {
        [self.right, self.up]
    }

    /// Where directions meet the projection.
    #[inline(always)]
    pub fn points<F: Lanes<Scalar = f32>>(&self, dir: Vec3<F>) -> Points<F> {
        let z = dir.dot_fused(Vec3::splat(self.depth));
        let recip = F::splat(1.0) / z;
        let x = dir.dot_fused(Vec3::splat(self.right)) * recip;
        let y = dir.dot_fused(Vec3::splat(self.up)) * recip;
        Points { x, y, z }
    }
}

/// Rays as points of the projection.
///
/// ```
/// use intertri::internal::Points;
/// // The bounds hold near the middle of the projection.
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
    pub(super) fn inverse(&self, t: F) -> (F, F) {
        let least = F::splat(bound::SHORTEST_T);
        let s = F::splat(1.0) / (t.max(least) * self.z);
        let s_hi = s * F::splat(1.0 + bound::INVERSE);
        let s_hi = F::select(t.lt(least), F::splat(f32::INFINITY), s_hi);
        (s * F::splat(1.0 - bound::INVERSE), s_hi)
    }
}

/// A form at points of the projection.
#[inline(always)]
pub(super) fn at<F: Lanes<Scalar = f32>>(form: [f32; 3], points: &Points<F>) -> F {
    let [one, x, y] = [F::splat(form[0]), F::splat(form[1]), F::splat(form[2])];
    y.mul_add(points.y, x.mul_add(points.x, one))
}
