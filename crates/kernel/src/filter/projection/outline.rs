//! Projects triangles and finds the windows through which rays may hit them.

mod lanes;
mod parallel;
mod point;

use self::lanes::{load, sixteen, splat, three};
use super::frame::{Frame, Points, at};
use super::windows::Windows;
use crate::packet::TriangleBlock;
use crate::simd::{Lanes, Mask, Simd, Vec3};

/// Sixteen projected triangles, in lanes.
///
/// A linear form f has the value `f[0] + f[1] x + f[2] y` at the point (x, y). The edge forms are
/// scaled so that their sign is certain if they exceed 1 in magnitude.
///
/// ```
/// use intertri::simd::{Lanes, Simd, WithSimd, dispatch};
/// use intertri::internal::{Frame, Windows};
/// use intertri::{Mode, Triangle, TriangleBlock};
///
/// /// Finds which triangles of a block may be hit through a window of the projection.
/// struct Leaf<'a>(&'a TriangleBlock<8>, &'a Frame, [[f32; 2]; 2]);
/// impl WithSimd for Leaf<'_> {
///     type Output = u32;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> u32 {
///         let Self(block, frame, [lo, hi]) = self;
///         let splat = |[x, y]: [f32; 2]| [S::F32x16::splat(x), S::F32x16::splat(y)];
///         let outlines = Mode::certified().filter().outlines_in::<S>(block, None, frame, 1.0);
///         assert_eq!(outlines.larger::<S::F32x16>([0.1, 0.1]), 0b11);
///         assert_eq!(outlines.sizes::<S::F32x16>().1, 0b11);
///         outlines.within(&Windows::new(splat(lo), splat(hi)), 0.0)
///     }
/// }
///
/// // One triangle to the left and one to the right, both at a depth of five.
/// let at = |x| Triangle::new([x, 0.0, 5.0], [x + 1.0, 0.0, 5.0], [x, 1.0, 5.0]);
/// let block = TriangleBlock::new(&[at(-3.0), at(2.0)]);
/// let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// assert_eq!(dispatch(Leaf(&block, &frame, [[-0.6, 0.0], [0.0, 0.2]])), 0b01);
/// ```
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct Outlines {
    u: [[f32; 16]; 3],
    v: [[f32; 16]; 3],
    w: [[f32; 16]; 3],
    /// The inverse depth of the plane, positive in front; NaN if the sign of T or, for parallel
    /// rays, of D is not known.
    s: [[f32; 16]; 3],
    /// The error bound on s.
    err: [f32; 16],
    /// If |s| is at most this value, the ray grazes the plane, and nothing is decided.
    least: [f32; 16],
    /// If s exceeds this value, the ray is certainly not parallel to the plane.
    slanted: [f32; 16],
    /// The lowest x and y of a rectangle that contains the projected triangle.
    lo: [[f32; 16]; 2],
    /// The highest x and y of the rectangle.
    hi: [[f32; 16]; 2],
    /// The error bound by which the edge forms are divided.
    unit: [f32; 16],
    /// The inverse depth of the plane at infinity: 0 or, for parallel rays, `-∞`. Hits have larger
    /// inverse depths.
    horizon: f32,
    /// The lanes that contain triangles.
    live: u32,
}

/// A projected triangle.
///
/// ```
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::internal::{Frame, Outline, Points, Windows};
/// use intertri::{Mode, Triangle, TriangleBlock};
///
/// struct Lane<'a>(&'a TriangleBlock<8>, &'a Frame, usize);
/// impl WithSimd for Lane<'_> {
///     type Output = Outline;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Outline {
///         Mode::certified().filter().outlines_in::<S>(self.0, None, self.1, 1.0).lane(self.2)
///     }
/// }
///
/// let wall = Triangle::new([0.0, 0.0, 4.0], [1.0, 0.0, 4.0], [0.0, 1.0, 4.0]);
/// let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// let outline = dispatch(Lane(&TriangleBlock::new(&[wall]), &frame, 0));
///
/// // Windows, one per lane; an f32 counts as one lane.
/// assert_eq!(outline.within(&Windows::<f32>::new([0.0, 0.0], [0.1, 0.1]), 0.0), 1);
/// assert_eq!(outline.within(&Windows::<f32>::new([0.5, 0.5], [0.6, 0.6]), 0.0), 0);
/// // The bounding rectangle is less precise: this window is beyond the slanted edge.
/// let beyond = Windows::<f32>::new([0.2, 0.2], [0.24, 0.24]);
/// assert_eq!((outline.near(&beyond), outline.within(&beyond, 0.0)), (1, 0));
///
/// // The signs of the three edges are certain above 1. The last number is the inverse depth.
/// let point = Points { x: 0.05_f32, y: 0.05, z: 1.0 };
/// let ([u, v, w, inverse], off) = outline.at(&point);
/// assert!(u > 1.0 && v > 1.0 && w > 1.0 && (inverse - 0.25).abs() <= off);
/// // The unit is the error bound of the edge forms.
/// assert!(outline.unit() > 0.0);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Outline {
    pub(super) u: [f32; 3],
    pub(super) v: [f32; 3],
    pub(super) w: [f32; 3],
    pub(super) s: [f32; 3],
    pub(super) err: f32,
    pub(super) least: f32,
    pub(super) slanted: f32,
    pub(super) horizon: f32,
    unit: f32,
    lo: [f32; 2],
    hi: [f32; 2],
}

impl Outlines {
    /// Projects the triangles in one or two blocks. `parallel` is the document's threshold divided
    /// by the smallest z of the rays, rounded up. `exact` means that all hits are known to be on
    /// their triangles.
    #[inline(always)]
    pub(in super::super) fn new<S: Simd>(
        first: &TriangleBlock<8>,
        second: Option<&TriangleBlock<8>>,
        frame: &Frame,
        parallel: f32,
        exact: bool,
    ) -> Self {
        let live = first.live() | second.map_or(0, |block| block.live() << 8);
        // Without a second block, the first block fills both halves, and `live` masks the copies.
        let blocks = [first, second.unwrap_or(first)];
        let Forms {
            edges: [u, v, w],
            unit,
            turn,
            sure,
            s,
            err,
            least,
            slanted,
            rectangle,
            horizon,
        } = match &frame.parallel {
            None => Forms::from_point::<S>(blocks, frame, parallel, exact),
            Some(limits) => Forms::along::<S>(blocks, frame, limits),
        };

        // Wherever a ray hits the triangle, T has the same sign as D. `turn` is the one that is the
        // same for all rays.
        let nothing = S::F32x16::splat(f32::NAN);
        let one = S::F32x16::splat(1.0);
        // If the sign is unknown, edges of different signs still prove a miss, provided that hits
        // are on their triangles.
        let unturned = if exact { one / unit } else { nothing };
        // One factor scales the edges to units of their bound and applies the sign. All three forms
        // are then positive for a hit, whichever way the triangle faces.
        let turn = S::F32x16::select(sure, (one / unit).flip(turn), unturned);
        let [inverse, along_x, along_y] = s;
        let inverse = S::F32x16::select(sure, inverse, nothing);
        let [(left, right), (down, up)] = rectangle;
        Self {
            u: three(u * turn),
            v: three(v * turn),
            w: three(w * turn),
            s: three(Vec3 { x: inverse, y: along_x, z: along_y }),
            err: sixteen(err),
            least: sixteen(least),
            slanted: sixteen(slanted),
            lo: [sixteen(left), sixteen(down)],
            hi: [sixteen(right), sixteen(up)],
            unit: sixteen(unit),
            horizon,
            live,
        }
    }

    /// Leaves out the triangles in some lanes.
    #[inline(always)]
    pub(crate) fn leave_out(&mut self, lanes: u32) {
        self.live &= !lanes;
    }

    /// Finds which of the triangles a ray through the window may hit at an inverse depth of at
    /// least `nearest`.
    #[inline(always)]
    pub fn within<F: Lanes<Scalar = f32>>(&self, window: &Windows<F>, nearest: f32) -> u32 {
        let lo = [F::load(&self.lo[0]), F::load(&self.lo[1])];
        let hi = [F::load(&self.hi[0]), F::load(&self.hi[1])];
        let bounds = [F::load(&self.err), F::load(&self.least)];
        let depths = Depths::new(window, load(&self.s), bounds, self.horizon);
        let edges = [load(&self.u), load(&self.v), load(&self.w)];
        let mut missed = depths.missed(F::splat(nearest)) | depths.plain & outside(window, edges);
        // s[0] is NaN if T is too small for its sign to be known.
        let edge_on = !F::load(&self.s[0]).le(F::splat(f32::INFINITY));
        if edge_on.bits() & self.live != 0 {
            missed = missed | edge_on & apart(window, edges);
        }
        (window.reached(lo, hi) & !missed).bits() & self.live
    }

    /// Finds which triangles have a bounding rectangle that is larger than `size` in x or y.
    #[inline(always)]
    pub fn larger<F: Lanes<Scalar = f32>>(&self, size: [f32; 2]) -> u32 {
        let ([x, y], _) = self.sizes::<F>();
        (x.gt(F::splat(size[0])) | y.gt(F::splat(size[1]))).bits() & self.live
    }

    /// Returns the widths and heights of the bounding rectangles and the lanes that contain
    /// triangles. A size is 0 in lanes without a triangle, and infinite if the rectangle is
    /// unknown.
    #[inline(always)]
    pub fn sizes<F: Lanes<Scalar = f32>>(&self) -> ([F; 2], u32) {
        let (live, none) = (F::Mask::from_bits(self.live), F::splat(0.0));
        let (x, y) = (F::load(&self.hi[0]), F::load(&self.hi[1]));
        let (x, y) = (x - F::load(&self.lo[0]), y - F::load(&self.lo[1]));
        ([F::select(live, x, none), F::select(live, y, none)], self.live)
    }

    /// Returns the outline in lane `i`.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Outline {
        Outline {
            u: [self.u[0][i], self.u[1][i], self.u[2][i]],
            v: [self.v[0][i], self.v[1][i], self.v[2][i]],
            w: [self.w[0][i], self.w[1][i], self.w[2][i]],
            s: [self.s[0][i], self.s[1][i], self.s[2][i]],
            err: self.err[i],
            least: self.least[i],
            slanted: self.slanted[i],
            unit: self.unit[i],
            horizon: self.horizon,
            lo: [self.lo[0][i], self.lo[1][i]],
            hi: [self.hi[0][i], self.hi[1][i]],
        }
    }
}

impl Outline {
    /// Computes the values that the test uses at points: U, V, and W in units of their bound, the
    /// inverse depth, and the error bound on the inverse depth. Tests use this function to check
    /// the bounds.
    #[inline(always)]
    pub fn at<F: Lanes<Scalar = f32>>(&self, points: &Points<F>) -> ([F; 4], f32) {
        let values = [self.u, self.v, self.w, self.s];
        (
            [
                at(values[0], points),
                at(values[1], points),
                at(values[2], points),
                at(values[3], points),
            ],
            self.err,
        )
    }

    /// Returns whether the apex is so close to the triangle's plane that its side of the plane is
    /// unknown.
    #[inline(always)]
    pub(super) fn is_edge_on(&self) -> bool {
        self.s[0].is_nan()
    }

    /// Returns the error bound by which the edge forms are divided.
    pub fn unit(&self) -> f32 {
        self.unit
    }

    /// Finds the windows that the triangle's bounding rectangle reaches.
    #[inline(always)]
    pub fn near<F: Lanes<Scalar = f32>>(&self, windows: &Windows<F>) -> u32 {
        let lo = [F::splat(self.lo[0]), F::splat(self.lo[1])];
        let hi = [F::splat(self.hi[0]), F::splat(self.hi[1])];
        windows.reached(lo, hi).bits()
    }

    /// Finds the windows through which a ray may hit the triangle at an inverse depth of at least
    /// the window's `nearest`.
    #[inline(always)]
    pub fn within<F: Lanes<Scalar = f32>>(&self, windows: &Windows<F>, nearest: F) -> u32 {
        let lo = [F::splat(self.lo[0]), F::splat(self.lo[1])];
        let hi = [F::splat(self.hi[0]), F::splat(self.hi[1])];
        let reached = windows.reached(lo, hi);

        let bounds = [F::splat(self.err), F::splat(self.least)];
        let depths = Depths::new(windows, splat(self.s), bounds, self.horizon);
        let edges = [splat(self.u), splat(self.v), splat(self.w)];
        let missed = if self.is_edge_on() {
            apart(windows, edges)
        } else {
            depths.missed(nearest) | depths.plain & outside(windows, edges)
        };
        (reached & !missed).bits()
    }
}

/// The inverse depths of triangles in windows: many triangles in one window, or one triangle in
/// many windows.
struct Depths<F: Lanes> {
    /// An upper bound on the inverse depth for all rays through the window.
    most: F,
    /// Lanes in which the inverse depth is certainly negative for every ray: the plane is behind
    /// all rays.
    behind: F::Mask,
    /// Lanes in which the inverse depth is certainly positive for every ray.
    plain: F::Mask,
}

impl<F: Lanes<Scalar = f32>> Depths<F> {
    #[inline(always)]
    fn new(windows: &Windows<F>, s: [F; 3], [err, least]: [F; 2], horizon: f32) -> Self {
        let ((lo, hi), twice, horizon) = (windows.range(s), least + least, F::splat(horizon));
        let (behind, plain) = (hi.lt(horizon - twice), lo.gt(horizon + twice));
        Self { most: hi + (err + err), behind, plain }
    }

    /// Returns the lanes in which the plane is behind every ray or too far away.
    #[inline(always)]
    fn missed(&self, nearest: F) -> F::Mask {
        self.behind | self.most.lt(nearest)
    }
}

/// Returns the lanes in which the whole window is outside at least one edge, provided that D is
/// certainly positive.
#[inline(always)]
fn outside<F: Lanes<Scalar = f32>>(windows: &Windows<F>, [u, v, w]: [[F; 3]; 3]) -> F::Mask {
    let highest = windows.range(u).1.min(windows.range(v).1).min(windows.range(w).1);
    highest.lt(F::splat(-2.0))
}

/// Returns the lanes in which the whole window is on the negative side of one edge and on the
/// positive side of another, and therefore outside the triangle.
#[inline(always)]
fn apart<F: Lanes<Scalar = f32>>(windows: &Windows<F>, [u, v, w]: [[F; 3]; 3]) -> F::Mask {
    let lowest = windows.range(u).0.max(windows.range(v).0).max(windows.range(w).0);
    outside(windows, [u, v, w]) & lowest.gt(F::splat(2.0))
}

/// The forms of sixteen triangles and their error bounds, before they are scaled.
struct Forms<F: Lanes> {
    /// U, V, and W.
    edges: [Vec3<F>; 3],
    /// The error bound of the edges.
    unit: F,
    /// The sign of T or, for parallel rays, of D.
    turn: F,
    /// The lanes in which this sign is known.
    sure: F::Mask,
    /// The inverse depth.
    s: [F; 3],
    err: F,
    least: F,
    slanted: F,
    /// The smallest and largest x, and the smallest and largest y.
    rectangle: [(F, F); 2],
    horizon: f32,
}

#[cfg(all(test, feature = "std"))]
mod tests;
