//! Triangles on the screen.

use crate::lanes::{Lanes, Mask};
use crate::{Coefficients, Vec3};

use super::super::bound;
use super::{Frame, Points, Windows, at};

/// Eight triangles as the screen sees them, side by side.
///
/// A form is `f[0] + f[1] x + f[2] y`. The edges are scaled so that beyond ±1 their sign is sure.
///
/// ```
/// use intertri::lanes::{Lanes, Simd, WithSimd, dispatch};
/// use intertri::{Certified, Frame, Triangle, TrianglePack, Windows};
///
/// /// Which triangles of a pack may be hit through a window of the screen?
/// struct Leaf<'a>(&'a TrianglePack<8>, &'a Frame, [[f32; 2]; 2]);
/// impl WithSimd for Leaf<'_> {
///     type Output = (u32, u32);
///     #[inline(always)]
///     fn run<S: Simd>(self) -> (u32, u32) {
///         let Self(pack, frame, [lo, hi]) = self;
///         let splat = |[x, y]: [f32; 2]| [S::F32x8::splat(x), S::F32x8::splat(y)];
///         let outlines = Certified::default().outlines_in::<S>(pack, frame, 1.0);
///         outlines.within(&Windows::new(splat(lo), splat(hi)))
///     }
/// }
///
/// // One to the left and one to the right, five in front of the origin.
/// let at = |x| Triangle::new([x, 0.0, 5.0], [x + 1.0, 0.0, 5.0], [x, 1.0, 5.0]);
/// let pack = TrianglePack::new(&[at(-3.0), at(2.0)]);
/// let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// let (hit, plain) = dispatch(Leaf(&pack, &frame, [[-0.6, 0.0], [0.0, 0.2]]));
/// assert_eq!((hit, plain & 0b11), (0b01, 0b11));
/// ```
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Outlines {
    u: [[f32; 8]; 3],
    v: [[f32; 8]; 3],
    w: [[f32; 8]; 3],
    /// The inverse depth of the plane, positive in front; NaN where T is not known well enough.
    s: [[f32; 8]; 3],
    /// What s may be off by.
    err: [f32; 8],
    /// Up to this, in size, s tells nothing: a grazing ray.
    least: [f32; 8],
    /// Beyond this it is not parallel, either.
    parallel: [f32; 8],
    /// The rectangle that holds the triangle.
    lo: [[f32; 8]; 2],
    hi: [[f32; 8]; 2],
    /// Those that something can hit from here.
    live: u32,
}

/// A triangle as the screen sees it.
///
/// ```
/// use intertri::lanes::{Simd, WithSimd, dispatch};
/// use intertri::{Certified, Frame, Outline, Points, Triangle, TrianglePack, Windows};
///
/// struct Lane<'a>(&'a TrianglePack<8>, &'a Frame, usize);
/// impl WithSimd for Lane<'_> {
///     type Output = Outline;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Outline {
///         Certified::default().outlines_in::<S>(self.0, self.1, 1.0).lane(self.2)
///     }
/// }
///
/// let wall = Triangle::new([0.0, 0.0, 4.0], [1.0, 0.0, 4.0], [0.0, 1.0, 4.0]);
/// let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// let outline = dispatch(Lane(&TrianglePack::new(&[wall]), &frame, 0));
///
/// // Windows, one in each lane: one f32 is a lane, too.
/// assert_eq!(outline.within(&Windows::<f32>::new([0.0, 0.0], [0.1, 0.1])), 1);
/// assert_eq!(outline.within(&Windows::<f32>::new([0.5, 0.5], [0.6, 0.6])), 0);
///
/// // Beyond 1 the three edges are sure; the last number is one by the depth.
/// let point = Points { x: 0.05_f32, y: 0.05, z: 1.0 };
/// let ([u, v, w, inverse], off) = outline.at(&point);
/// assert!(u > 1.0 && v > 1.0 && w > 1.0 && (inverse - 0.25).abs() <= off);
/// // V grows to the right.
/// assert!(outline.v()[1] > 0.0);
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
    lo: [f32; 2],
    hi: [f32; 2],
}

impl Outlines {
    /// Eight triangles, `corners[k][axis][lane]` being of corner k+1; `slowest` is the smallest z of
    /// the rays.
    #[inline(always)]
    pub(in super::super) fn new<D: Lanes<Scalar = f64>, F: Lanes<Scalar = f32>>(
        [c1, c2, c3]: &[[[f32; 8]; 3]; 3],
        live: u32,
        frame: &Frame,
        slowest: f32,
        threshold: f64,
    ) -> Self {
        let splat = D::splat;
        let mut to = Self::NOTHING;

        // The triangle in the axes of the frame: its first corner and two edges.
        let origin = frame.origin;
        let origin = Vec3::<D>::splat([origin[0].into(), origin[1].into(), origin[2].into()]);
        let (c1, c2, c3) = (Vec3::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3));
        let (a, h4, h5) = (into(c1 - origin, frame), into(c2 - c1, frame), into(c3 - c1, frame));
        let Coefficients { n, v, w, .. } = Coefficients::along(a, h4, h5);
        let (u, t) = (n - v - w, n.dot_fused(a));

        // The rectangle: from corners in front, with room for what the reference may be off by.
        let h6 = h5 - h4;
        let hh = h4.dot_fused(h4).max(h5.dot_fused(h5)).max(h6.dot_fused(h6));
        let (h, normal) = (hh.sqrt(), n.dot_fused(n).sqrt());
        let (away, far_off) = (a.norm1(), origin.norm1());
        let (b, c) = (a + h4, a + h5);
        let nearest = a.x.min(b.x).min(c.x);
        let room = h.mul_add(splat(bound::ROOM), (away + far_off) * splat(bound::ROOM_AWAY));
        let known = hh.lt(normal * splat(bound::THIN))
            & nearest.gt(room * splat(8.0))
            & nearest.gt(splat(bound::SHORTEST_DIR.into()))
            & away.lt(splat(bound::LARGEST.into()));
        let room = D::select(known, room / nearest, splat(f64::INFINITY));
        to.rectangle::<D, F>([a, b, c], room);

        // The bound of the edges: of the forms, of the reference's noise, of the origin's rounding.
        let form = u.dot_fused(u).max(v.dot_fused(v)).max(w.dot_fused(w)).sqrt();
        let noise = (away + h).mul_add(
            h * splat(f64::from(bound::NOISE) * bound::LEAN),
            h * far_off * splat(f64::from(bound::ORIGIN) * bound::LEAN),
        );
        let scale = splat(1.0) / form.mul_add(splat(bound::SCREEN), noise);

        // In front of the triangle or behind, T has the same sign as D wherever it is hit.
        let sure = t.abs().gt(hh * away * splat(bound::NOISE.into()));
        let turn = D::select(sure, scale.flip(t), splat(f64::NAN));
        store_form(u, turn, &mut to.u);
        store_form(v, turn, &mut to.v);
        store_form(w, turn, &mut to.w);

        // 1 / depth = D / T.
        let recip = splat(1.0) / t;
        let size = recip.abs();
        store_form(n, D::select(sure, recip, splat(f64::NAN)), &mut to.s);
        let lost = hh * splat(bound::LOST);
        (normal.mul_add(splat(bound::DEPTH), lost) * size).store_f32(&mut to.err);
        let grazing = splat(f64::from(bound::GRAZING) * bound::LEAN);
        let least = normal.mul_add(splat(bound::SCREEN), hh * grazing) * size;
        let parallel = splat(f64::from(bound::PARALLEL) * threshold / f64::from(slowest));
        least.store_f32(&mut to.least);
        (parallel * normal).mul_add(size, least).store_f32(&mut to.parallel);

        // What is not finite is never hit. (No area here may be some area in other axes.)
        let limit = splat(f64::INFINITY);
        let finite = normal.lt(limit) & away.lt(limit);
        to.live = finite.bits() & live;
        to
    }

    /// The rectangles around the corners, with `room` on all sides.
    #[inline(always)]
    fn rectangle<D: Lanes<Scalar = f64>, F: Lanes<Scalar = f32>>(
        &mut self,
        corners: [Vec3<D>; 3],
        room: D,
    ) {
        let mut numbers = [[0.0; 8]; 10];
        let [a, b, c] = corners;
        store_three(a, &mut numbers[0..3]);
        store_three(b, &mut numbers[3..6]);
        store_three(c, &mut numbers[6..9]);
        room.store_f32(&mut numbers[9]);
        let [a, b, c] =
            [project::<F>(&numbers[0..3]), project(&numbers[3..6]), project(&numbers[6..9])];
        let room = F::load(&numbers[9]) + F::splat(bound::ROOM_SCREEN);
        let everywhere = F::splat(f32::INFINITY);
        let known = room.lt(everywhere);
        for k in 0..2 {
            let (lo, hi) = (a[k].min(b[k]).min(c[k]) - room, a[k].max(b[k]).max(c[k]) + room);
            F::select(known, lo, -everywhere).store(&mut self.lo[k]);
            F::select(known, hi, everywhere).store(&mut self.hi[k]);
        }
    }

    const NOTHING: Self = Self {
        u: [[0.0; 8]; 3],
        v: [[0.0; 8]; 3],
        w: [[0.0; 8]; 3],
        s: [[0.0; 8]; 3],
        err: [0.0; 8],
        least: [0.0; 8],
        parallel: [0.0; 8],
        lo: [[0.0; 8]; 2],
        hi: [[0.0; 8]; 2],
        live: 0,
    };

    /// Which of the triangles some ray through the window may hit; and which of them no ray through
    /// it grazes, and none has behind it.
    #[inline(always)]
    pub fn within<F: Lanes<Scalar = f32>>(&self, window: &Windows<F>) -> (u32, u32) {
        let lo = [F::load(&self.lo[0]), F::load(&self.lo[1])];
        let hi = [F::load(&self.hi[0]), F::load(&self.hi[1])];
        let form = (load(&self.u), load(&self.v), load(&self.w));
        let (missed, plain) = missed(window, form, load(&self.s), F::load(&self.least));
        ((window.reached(lo, hi) & !missed).bits() & self.live, plain.bits())
    }

    /// The outline in a lane.
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
            lo: [self.lo[0][i], self.lo[1][i]],
            hi: [self.hi[0][i], self.hi[1][i]],
        }
    }
}

impl Outline {
    /// What the test computes at points: U, V, W in units of their bound, the inverse depth, and what
    /// that may be off by. For who wants to check the bounds.
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

    /// The coefficients of V, in units of its bound.
    pub fn v(&self) -> [f32; 3] {
        self.v
    }

    /// The windows through which some ray may hit the triangle.
    #[inline(always)]
    pub fn within<F: Lanes<Scalar = f32>>(&self, windows: &Windows<F>) -> u32 {
        let lo = [F::splat(self.lo[0]), F::splat(self.lo[1])];
        let hi = [F::splat(self.hi[0]), F::splat(self.hi[1])];
        let reached = windows.reached(lo, hi).bits();

        // Of a small triangle the rectangle says enough.
        if reached.count_ones() <= 2 {
            return reached;
        }
        let form = (splat(self.u), splat(self.v), splat(self.w));
        let (missed, _) = missed(windows, form, splat(self.s), F::splat(self.least));
        reached & !missed.bits()
    }
}

/// Triangles against windows, either of them the same in all lanes: where an edge or the plane says
/// that no ray can hit, and where D is sure and positive for all rays.
#[inline(always)]
fn missed<F: Lanes<Scalar = f32>>(
    windows: &Windows<F>,
    (u, v, w): ([F; 3], [F; 3], [F; 3]),
    s: [F; 3],
    least: F,
) -> (F::Mask, F::Mask) {
    let (s_lo, s_hi) = windows.range(s);
    let twice = least + least;
    let (plain, behind) = (s_lo.gt(twice), s_hi.lt(-twice));
    let highest = windows.range(u).1.min(windows.range(v).1).min(windows.range(w).1);
    (behind | (plain & highest.lt(F::splat(-2.0))), plain)
}

/// Vectors in the axes of a frame: depth, right, up.
#[inline(always)]
fn into<D: Lanes<Scalar = f64>>(v: Vec3<D>, frame: &Frame) -> Vec3<D> {
    let Frame { depth: a, right: b, up: c, .. } = frame;
    Vec3 {
        x: v.dot_fused(Vec3::splat([a[0].into(), a[1].into(), a[2].into()])),
        y: v.dot_fused(Vec3::splat([b[0].into(), b[1].into(), b[2].into()])),
        z: v.dot_fused(Vec3::splat([c[0].into(), c[1].into(), c[2].into()])),
    }
}

/// A form in f64, scaled and rounded.
#[inline(always)]
fn store_form<D: Lanes<Scalar = f64>>(f: Vec3<D>, scale: D, to: &mut [[f32; 8]; 3]) {
    (f.x * scale).store_f32(&mut to[0]);
    (f.y * scale).store_f32(&mut to[1]);
    (f.z * scale).store_f32(&mut to[2]);
}

#[inline(always)]
fn store_three<D: Lanes<Scalar = f64>>(v: Vec3<D>, to: &mut [[f32; 8]]) {
    v.x.store_f32(&mut to[0]);
    v.y.store_f32(&mut to[1]);
    v.z.store_f32(&mut to[2]);
}

/// Points in the axes of a frame as points of the screen.
#[inline(always)]
fn project<F: Lanes<Scalar = f32>>(point: &[[f32; 8]]) -> [F; 2] {
    let recip = F::splat(1.0) / F::load(&point[0]);
    [F::load(&point[1]) * recip, F::load(&point[2]) * recip]
}

#[inline(always)]
fn load<F: Lanes<Scalar = f32>>(form: &[[f32; 8]; 3]) -> [F; 3] {
    [F::load(&form[0]), F::load(&form[1]), F::load(&form[2])]
}

#[inline(always)]
pub(super) fn splat<F: Lanes<Scalar = f32>>(form: [f32; 3]) -> [F; 3] {
    [F::splat(form[0]), F::splat(form[1]), F::splat(form[2])]
}
