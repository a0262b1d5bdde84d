//! Projects triangles and finds the windows through which rays may hit them.

mod lanes;

use self::lanes::{around, halves, into, load, minus, sixteen, splat, three};
use super::super::bound;
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
    /// The inverse depth of the plane, positive in front; NaN if T is not known accurately enough.
    s: [[f32; 16]; 3],
    /// The error bound on s.
    err: [f32; 16],
    /// If |s| is at most this value, the ray grazes the plane, and nothing is decided.
    least: [f32; 16],
    /// If s exceeds this value, the ray is certainly not parallel to the plane.
    parallel: [f32; 16],
    /// The lowest x and y of a rectangle that contains the projected triangle.
    lo: [[f32; 16]; 2],
    /// The highest x and y of the rectangle.
    hi: [[f32; 16]; 2],
    /// The error bound by which the edge forms are divided.
    unit: [f32; 16],
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
    pub(super) parallel: f32,
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
        let planes = Planes::new::<S>(blocks, frame);
        let corners = Corners::new::<S>(blocks, frame);
        let sizes = Sizes::of(&planes, corners.a.norm1(), frame, parallel);
        let [(left, right), (down, up)] = corners.rectangle(planes.turn, frame, exact);
        let ([u, v, w], unit) = corners.edges(frame);

        // Wherever a ray hits the triangle, T has the same sign as D.
        let sure = planes.is_sure(corners.a.norm1(), sizes.size, frame);
        let nothing = S::F32x16::splat(f32::NAN);
        let one = S::F32x16::splat(1.0);
        // If the sign of T is unknown, edges of different signs still prove a miss, provided that
        // hits are on their triangles.
        let unturned = if exact { one / unit } else { nothing };
        // One factor scales the edges to units of their bound and applies the sign of T. All three
        // forms are then positive for a hit in front of the origin, whichever way the triangle
        // faces.
        let turn = S::F32x16::select(sure, (one / unit).flip(planes.turn), unturned);
        let [inverse, along_x, along_y] = planes.s;
        let inverse = S::F32x16::select(sure, inverse, nothing);
        Self {
            u: three(u * turn),
            v: three(v * turn),
            w: three(w * turn),
            s: three(Vec3 { x: inverse, y: along_x, z: along_y }),
            err: sixteen(sizes.err),
            least: sixteen(sizes.least),
            parallel: sixteen(sizes.parallel),
            lo: [sixteen(left), sixteen(down)],
            hi: [sixteen(right), sixteen(up)],
            unit: sixteen(unit),
            live,
        }
    }

    /// Finds which of the triangles a ray through the window may hit at an inverse depth of at
    /// least `nearest`.
    #[inline(always)]
    pub fn within<F: Lanes<Scalar = f32>>(&self, window: &Windows<F>, nearest: f32) -> u32 {
        let lo = [F::load(&self.lo[0]), F::load(&self.lo[1])];
        let hi = [F::load(&self.hi[0]), F::load(&self.hi[1])];
        let depths = Depths::new(window, load(&self.s), F::load(&self.err), F::load(&self.least));
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
            parallel: self.parallel[i],
            unit: self.unit[i],
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

    /// Returns whether the origin is so close to the triangle's plane that its side of the plane is
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

        let (err, least) = (F::splat(self.err), F::splat(self.least));
        let depths = Depths::new(windows, splat(self.s), err, least);
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
    fn new(windows: &Windows<F>, s: [F; 3], err: F, least: F) -> Self {
        let ((lo, hi), twice) = (windows.range(s), least + least);
        Self { most: hi + (err + err), behind: hi.lt(-twice), plain: lo.gt(twice) }
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

/// The planes of sixteen triangles, computed in f64.
struct Planes<F> {
    /// The inverse depth, 1 / depth = D / T, as a form.
    s: [F; 3],
    /// `h^2 / |T|`
    q: F,
    /// The magnitude of N, with the sign of T.
    turn: F,
}

impl<F: Lanes<Scalar = f32>> Planes<F> {
    #[inline(always)]
    fn new<S: Simd<F32x16 = F>>(blocks: [&TriangleBlock<8>; 2], frame: &Frame) -> Self {
        let (mut s, mut q, mut normal) = ([[0.0; 16]; 3], [0.0; 16], [0.0; 16]);
        for (half, block) in blocks.into_iter().enumerate() {
            let [c1, c2, c3] = block.corners();
            let c1 = Vec3::<S::F64x8>::load_f32(c1);
            let (c2, c3) = (Vec3::load_f32(c2), Vec3::load_f32(c3));
            // A block of copies contains a corner, `-h4`, and `h5`; `h5 × -h4` is `h4 × h5`.
            let n = if frame.shares.copies {
                c3.cross_fused(c2)
            } else {
                (c2 - c1).cross_fused(c3 - c1)
            };
            let [x, y, z] = frame.origin;
            // Compute T and n in f64, because the inverse depth decides which of two triangles is
            // nearer (projection.md, section 3).
            let t = n.dot_fused(c1 - Vec3::splat([x.into(), y.into(), z.into()]));
            let recip = S::F64x8::splat(1.0) / t;
            // In the dual axes, N·(M d) equals n·d, although the frame's own axes are orthogonal
            // only up to rounding.
            let n = into(n, &frame.dual);
            let to = 8 * half;
            (n.x * recip).store_f32(&mut s[0][to..]);
            (n.y * recip).store_f32(&mut s[1][to..]);
            (n.z * recip).store_f32(&mut s[2][to..]);
            let h = S::F64x8::load_f32(block.longest_edges());
            (h * h * recip.abs()).store_f32(&mut q[to..]);
            n.norm1().flip(t).store_f32(&mut normal[to..]);
        }
        Self { s: load(&s), q: F::load(&q), turn: F::load(&normal) }
    }

    /// Returns the lanes in which the sign of T is known, for triangles at a distance of `away`
    /// from the origin.
    #[inline(always)]
    fn is_sure(&self, away: F, size: F, frame: &Frame) -> F::Mask {
        // For rays that miss the origin, T changes by `|s|₁ off` relative to itself; for rays
        // through it, `off` is 0.
        let off = size * frame.off_at(away) * F::splat(bound::OFF_PLANE);
        // The sign of T is known if its total error is less than T; 0.99 leaves a margin for the
        // rounding of this sum.
        (self.q * away).mul_add(F::splat(frame.shares.plane), off).lt(F::splat(0.99))
    }
}

/// The error of the inverse depth, and the limits that follow from it.
struct Sizes<F> {
    size: F,
    err: F,
    least: F,
    parallel: F,
}

impl<F: Lanes<Scalar = f32>> Sizes<F> {
    #[inline(always)]
    fn of(Planes { s, q, .. }: &Planes<F>, away: F, frame: &Frame, parallel: f32) -> Self {
        let (splat, q) = (F::splat, *q);
        let size = s[0].abs() + s[1].abs() + s[2].abs();
        let off = frame.off_at(away);
        let [x, y] = frame.reach;
        // The largest |s| on the part of the projection that rays reach. The errors of offset rays
        // and copies depend only on the values of s there.
        let most = s[2].abs().mul_add(splat(y), s[1].abs().mul_add(splat(x), s[0].abs()));
        let share = most.mul_add(off * splat(bound::OFF_DEPTH), splat(bound::DEPTH));
        // `DEPTH |s|₁ + LOST q`, plus `OFF_DEPTH off |s|₁ most` for rays that miss the origin
        // (projection.md, sections 3 and 6).
        let err = size.mul_add(share, q * splat(bound::LOST));
        let shares = &frame.shares;
        let err = if shares.copies {
            let slant = (away * most).mul_add(splat(shares.slant), splat(shares.depth));
            q.mul_add(slant, err)
        } else {
            err
        };
        // Below this, the ray grazes the plane, and the sign of D is unknown:
        // `GRAZING LEAN q + SCREEN |s|₁`.
        let least = size.mul_add(splat(shares.screen), q * splat(bound::GRAZING * bound::LEAN));
        let parallel = size.mul_add(splat(parallel), least);
        Self { size, err, least, parallel }
    }
}

/// The corners and edges of sixteen triangles in the axes of a frame.
struct Corners<F> {
    a: Vec3<F>,
    b: Vec3<F>,
    c: Vec3<F>,
    h4: Vec3<F>,
    h5: Vec3<F>,
    h6: Vec3<F>,
    /// The longest edge.
    h: F,
}

impl<F: Lanes<Scalar = f32>> Corners<F> {
    #[inline(always)]
    fn new<S: Simd<F32x16 = F>>(blocks: [&TriangleBlock<8>; 2], frame: &Frame) -> Self {
        let ([a1, a2, a3], [b1, b2, b3]) = (blocks[0].corners(), blocks[1].corners());
        let (c1, c2, c3) = (halves::<S>(a1, b1), halves::<S>(a2, b2), halves::<S>(a3, b3));
        let h = S::halves(blocks[0].longest_edges(), blocks[1].longest_edges());
        let axes = [frame.depth, frame.right, frame.up];
        if frame.shares.copies {
            // A block of copies contains a corner and the edges -h4 and h5.
            let (a, minus_h4) = (into(c1 - Vec3::splat(frame.origin), &axes), into(c2, &axes));
            let (h5, h6) = (into(c3, &axes), into(c3 + c2, &axes));
            let (h4, b, c) = (minus(minus_h4), a - minus_h4, a + h5);
            return Self { a, b, c, h4, h5, h6, h };
        }
        let (a, h4) = (into(c1 - Vec3::splat(frame.origin), &axes), into(c2 - c1, &axes));
        let (h5, h6) = (into(c3 - c1, &axes), into(c3 - c2, &axes));
        Self { a, b: a + h4, c: a + h5, h4, h5, h6, h }
    }

    /// Returns the bounding rectangles of triangles in front of the origin, widened by the errors
    /// of the corners and of the reference.
    #[inline(always)]
    fn rectangle(&self, turn: F, frame: &Frame, exact: bool) -> [(F, F); 2] {
        let (splat, &Self { a, b, c, h, .. }) = (F::splat, self);
        let away = a.norm1();
        //        ┌──────────────┐
        //        │     ╱╲       │   The box around the projected corners, widened on all sides by `room`:
        //        │   ╱    ╲     │   how far a hit may be outside its triangle, plus the error of the
        //        │ ╱________╲   │   corners, divided by the least depth (projection.md, section 4).
        //        └──────────────┘
        let nearest = a.x.min(b.x).min(c.x);
        let apart = splat(frame.distance() * bound::ROOM_AWAY);
        let apart = frame.off_at(away).mul_add(splat(bound::OFF_ROOM), apart);
        let room = h.mul_add(splat(bound::ROOM), away.mul_add(splat(bound::CORNER), apart));
        // A corner that is behind the origin, or nearly so, may project to any point. Such a
        // triangle has no bounding rectangle and is tested against every packet.
        let mut known = nearest.gt(room * splat(8.0))
            & nearest.gt(splat(bound::SHORTEST_DIR))
            & away.lt(splat(bound::LARGEST));
        if !exact {
            // The reference may accept points outside a thin triangle.
            known = known & (h * h).lt(turn.abs() * splat(bound::THIN));
        }
        let one = splat(1.0);
        let (ra, rb, rc) = (one / a.x, one / b.x, one / c.x);
        let room = room.mul_add(ra.max(rb).max(rc), splat(bound::ROOM_SCREEN));
        let (x, y) = ([a.y * ra, b.y * rb, c.y * rc], [a.z * ra, b.z * rb, c.z * rc]);
        [around(x, room, known), around(y, room, known)]
    }

    /// Returns the edges as forms, and the error bound on these forms.
    #[inline(always)]
    fn edges(&self, frame: &Frame) -> ([Vec3<F>; 3], F) {
        let (splat, &Self { a, b, h4, h5, h6, h, .. }) = (F::splat, self);
        // Each form is the normal of the plane through the origin and an edge. Its sign shows on
        // which side of the edge a ray passes.
        let (u, v, w) = (b.cross_fused(h6), h5.cross_fused(a), a.cross_fused(h4));
        let form = u.norm1().max(v.norm1()).max(w.norm1());
        let (away, apart) = (a.norm1(), splat(frame.distance() * bound::ORIGIN * bound::LEAN));
        let apart = frame.off_at(away).mul_add(splat(bound::OFF_EDGE), apart);
        let noise = (away + h).mul_add(splat(frame.shares.edges), apart);
        ([u, v, w], form.mul_add(splat(frame.shares.screen), noise * h))
    }
}

#[cfg(all(test, feature = "std"))]
mod tests;
