//! The filter for rays that share an origin, after document D: what depends on the triangle and the
//! viewpoint is computed once, and then a ray costs three dot products.
//!
//! ```text
//!   with A = c1 - o:   D = n·d   V = (h5 × A)·d   W = (A × h4)·d   U = D - V - W   T = n·A
//!                                                                                    t = T / D
//! ```
//!
//! Each edge function is a linear form of the direction. The forms are computed in f64, turned by the
//! sign of T, so that a hit in front has all of them positive, and scaled by their common bound, which
//! thus becomes |d|. Bounds and proof: `docs/numerics/certified.md`.

use crate::lanes::{Lanes, Mask};
use crate::{Coefficients, Vec3};

use super::bound;
use super::filter::{Pencil, Verdict};

/// N triangles as they are seen from one origin, side by side.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Views<const N: usize> {
    u: [[f32; N]; 3],
    v: [[f32; N]; 3],
    w: [[f32; N]; 3],
    n: [[f32; N]; 3],
    num: [f32; N],
    num_err: [f32; N],
    doubtful: [f32; N],
    least: [f32; N],
    den_err: [f32; N],
    parallel: [f32; N],
    /// Those that something can hit from here.
    live: u32,
}

/// A triangle as it is seen from one origin.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Nothing seen from here can hit it.
    pub(super) never: bool,
    u: [f32; 3],
    v: [f32; 3],
    w: [f32; 3],
    n: [f32; 3],
    /// The numerator of t, positive; NaN where its sign is not sure.
    num: f32,
    num_err: f32,
    /// Within `|d|` times this the sum of U, V and W does not tell the sign of D.
    doubtful: f32,
    /// D must exceed `|d|` times this for anything to be decided.
    least: f32,
    /// Within `|d|` times this n·d is D.
    den_err: f32,
    /// D must exceed `least` and this not to be parallel.
    parallel: f32,
}

impl<const N: usize> Views<N> {
    /// What depends on the triangles and the origin.
    #[inline(always)]
    pub(super) fn new<D: Lanes<Scalar = f64>>(
        [c1, c2, c3]: &[[[f32; N]; 3]; 3],
        origin: [f32; 3],
        threshold: f64,
        live: u32,
    ) -> Self {
        let splat = D::splat;
        let (c1, c2, c3) = (Vec3::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3));
        let origin = Vec3::<D>::splat([origin[0].into(), origin[1].into(), origin[2].into()]);
        let Coefficients { a, h4, h5, n, v, w } = Coefficients::of([c1, c2, c3], origin);
        let (h6, t, u) = (c3 - c2, n.dot(a), n - v - w);

        // The bound of the forms, of the reference's noise, and of the origin's rounding.
        let (h, form) = (longest(h4, h5, h6), longest(u, v, w));
        let (away, normal) = (a.norm1(), Lanes::sqrt(n.dot(n)));
        let noise = splat(bound::NOISE.into()) * h * (away + h);
        let offset = splat(bound::ORIGIN.into()) * h * origin.norm1();
        let scale = splat(1.0) / (splat(bound::FORM.into()) * form + noise + offset);

        // In front of the triangle or behind, T has the same sign as D wherever it is hit.
        let num_err = splat(bound::NOISE.into()) * h * h * away;
        let turn = D::select(t.abs().gt(num_err), scale.flip(t), splat(f64::NAN));
        let hh = h * h * scale;
        let den_err = splat(bound::FORM.into()) * normal * scale + splat(bound::NOISE.into()) * hh;
        let least = splat(bound::GRAZING.into()) * hh;
        let parallel = splat(f64::from(bound::PARALLEL) * threshold) * normal * scale;

        // Without an area, or not finite, it is never hit.
        let finite =
            normal.gt(splat(0.0)) & normal.lt(splat(f64::INFINITY)) & away.lt(splat(f64::INFINITY));
        let mut views = Self { live: finite.bits() & live, ..Self::NOTHING };
        store(u, turn, &mut views.u);
        store(v, turn, &mut views.v);
        store(w, turn, &mut views.w);
        store(n, turn, &mut views.n);
        (t * turn).store_f32(&mut views.num);
        (num_err * scale).store_f32(&mut views.num_err);
        (least + splat(4.0)).store_f32(&mut views.doubtful);
        (least + den_err).store_f32(&mut views.least);
        den_err.store_f32(&mut views.den_err);
        parallel.store_f32(&mut views.parallel);
        views
    }

    const NOTHING: Self = Self {
        u: [[0.0; N]; 3],
        v: [[0.0; N]; 3],
        w: [[0.0; N]; 3],
        n: [[0.0; N]; 3],
        num: [0.0; N],
        num_err: [0.0; N],
        doubtful: [0.0; N],
        least: [0.0; N],
        den_err: [0.0; N],
        parallel: [0.0; N],
        live: 0,
    };

    /// The view in a lane.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> View {
        let vec3 = |v: &[[f32; N]; 3]| [v[0][i], v[1][i], v[2][i]];
        View {
            never: self.live >> i & 1 == 0,
            u: vec3(&self.u),
            v: vec3(&self.v),
            w: vec3(&self.w),
            n: vec3(&self.n),
            num: self.num[i],
            num_err: self.num_err[i],
            doubtful: self.doubtful[i],
            least: self.least[i],
            den_err: self.den_err[i],
            parallel: self.parallel[i],
        }
    }

    /// Which of the triangles some ray of a beam may hit; the others surely none does.
    #[inline(always)]
    pub fn in_beam<F: Lanes<Scalar = f32>>(&self, beam: &Beams<F>) -> u32 {
        let (u, v, w) = (Vec3::load(&self.u), Vec3::load(&self.v), Vec3::load(&self.w));
        beam.may_hit(u, v, w, F::load(&self.doubtful)).bits() & self.live
    }
}

impl View {
    /// The beams of which some ray may hit the triangle; of the others surely none does.
    #[inline(always)]
    pub fn beams<F: Lanes<Scalar = f32>>(&self, beams: &Beams<F>) -> u32 {
        let (u, v, w) = (Vec3::splat(self.u), Vec3::splat(self.v), Vec3::splat(self.w));
        beams.may_hit(u, v, w, F::splat(self.doubtful)).bits()
    }
}

/// Rays that share an origin, bundled: a box around the directions of each bundle.
#[derive(Clone, Copy, Debug)]
pub struct Beams<F> {
    middle: Vec3<F>,
    half: Vec3<F>,
    /// The largest |d|₂.
    len: F,
}

impl<F: Lanes<Scalar = f32>> Beams<F> {
    /// As many bundles as there are lanes: `dirs[i][axis][lane]` is the direction of ray i of the
    /// bundle in a lane. Every length must lie between 2^-40 and 2^40.
    #[inline(always)]
    pub fn new<const N: usize>(dirs: &[[[f32; N]; 3]]) -> Self {
        let first = Vec3::<F>::load(&dirs[0]);
        let (mut lo, mut hi, mut square) = (first, first, F::splat(0.0));
        for dir in dirs {
            let d = Vec3::<F>::load(dir);
            lo = Vec3 { x: lo.x.min(d.x), y: lo.y.min(d.y), z: lo.z.min(d.z) };
            hi = Vec3 { x: hi.x.max(d.x), y: hi.y.max(d.y), z: hi.z.max(d.z) };
            square = square.max(d.dot(d));
        }
        let half = F::splat(0.5);
        let len = square.sqrt().mul_add(F::splat(bound::NORM_UP), F::splat(bound::NORM_ADD));
        Self { middle: (lo + hi) * half, half: (hi - lo) * half, len }
    }

    /// The bundle of all bundles.
    #[inline(always)]
    pub fn all<G: Lanes<Scalar = f32>>(&self) -> Beams<G> {
        let (lo, hi) = (self.middle - self.half, self.middle + self.half);
        let least = |x: F| fold(x, f32::INFINITY, f32::min);
        let most = |x: F| fold(x, f32::NEG_INFINITY, f32::max);
        let (lo, hi) =
            ([least(lo.x), least(lo.y), least(lo.z)], [most(hi.x), most(hi.y), most(hi.z)]);
        let (lo, hi) = (Vec3::<G>::splat(lo), Vec3::splat(hi));
        let half = G::splat(0.5);
        Beams { middle: (lo + hi) * half, half: (hi - lo) * half, len: G::splat(most(self.len)) }
    }

    /// Whether some ray of a bundle may hit the triangle with these forms.
    #[inline(always)]
    fn may_hit(&self, u: Vec3<F>, v: Vec3<F>, w: Vec3<F>, doubtful: F) -> F::Mask {
        let Self { middle, half, len } = *self;
        let (um, vm, wm) = (u.dot_fused(middle), v.dot_fused(middle), w.dot_fused(middle));
        let (ur, vr, wr) = (u.reach(half), v.reach(half), w.reach(half));

        // The largest value of each form, and the smallest of their sum.
        let largest = (um + ur).min(vm + vr).min(wm + wr);
        let sum = (um + vm + wm).abs() - (ur + vr + wr);
        let sure = sum.gt(len * (doubtful + F::splat(12.0)));
        !(sure & largest.lt(len * F::splat(-5.0)))
    }
}

/// One number from all lanes.
#[inline(always)]
fn fold<F: Lanes<Scalar = f32>>(lanes: F, first: f32, f: fn(f32, f32) -> f32) -> f32 {
    let mut numbers = [first; 16];
    lanes.store(&mut numbers[..F::N]);
    numbers.into_iter().fold(first, f)
}

/// The length of the longest of three vectors.
#[inline(always)]
fn longest<D: Lanes>(a: Vec3<D>, b: Vec3<D>, c: Vec3<D>) -> D {
    a.dot(a).max(b.dot(b)).max(c.dot(c)).sqrt()
}

/// A form in f64, scaled, turned and rounded.
#[inline(always)]
fn store<D: Lanes<Scalar = f64>, const N: usize>(x: Vec3<D>, turn: D, to: &mut [[f32; N]; 3]) {
    let [a, b, c] = to;
    (x.x * turn).store_f32(a);
    (x.y * turn).store_f32(b);
    (x.z * turn).store_f32(c);
}

/// The three forms of rays that start at the origin of a view.
#[derive(Clone, Copy)]
pub(super) struct Forms<F> {
    dir: Vec3<F>,
    len: F,
    /// The least of U, V and W.
    weight: F,
    /// The size of their sum, which is D but for rounding.
    sum: F,
}

impl<F: Lanes<Scalar = f32>> Forms<F> {
    /// Three dot products.
    #[inline(always)]
    pub(super) fn new(view: &View, of: &Pencil<F>) -> Self {
        let Pencil { dir, len, .. } = *of;
        let u = dir.dot_fused(Vec3::splat(view.u));
        let v = dir.dot_fused(Vec3::splat(view.v));
        let w = dir.dot_fused(Vec3::splat(view.w));
        Self { dir, len, weight: u.min(v).min(w), sum: (u + v + w).abs() }
    }

    /// Whether every live lane is surely a miss by its edges, as nearly always.
    #[inline(always)]
    pub(super) fn all_miss(&self, view: &View, live: u32) -> bool {
        let sure = self.sum.gt(self.len * F::splat(view.doubtful));
        (!(sure & self.weight.lt(-self.len))).bits() & live == 0
    }

    /// As [`super::filter::Edges::decide`]; `None` where every lane is a miss after all.
    #[inline(always)]
    pub(super) fn decide(
        &self,
        view: &View,
        of: &Pencil<F>,
        far: F,
        live: u32,
    ) -> Option<Verdict<F>> {
        let splat = F::splat;
        let Self { dir, len, weight, .. } = *self;

        // The sum of three is not as sharp as a dot product of its own. Below zero the ray goes away
        // from the triangle.
        let den = dir.dot_fused(Vec3::splat(view.n));
        let den_abs = den.abs();
        let sure = den_abs.gt(len * splat(view.least));
        let maybe = !(sure & (weight.lt(-len) | den.lt(splat(0.0))));
        if maybe.bits() & live == 0 {
            return None;
        }

        // The plane's t and its enclosure.
        let recip = splat(1.0) / den_abs;
        let t = splat(view.num) * recip;
        let err = t.mul_add(len * splat(view.den_err), splat(view.num_err)) * recip;
        let round = t.mul_add(splat(bound::ROUND), splat(bound::TINY));
        let err = err.mul_add(splat(bound::SLACK), round);
        let (t_lo, t_hi) = (t - err, t + err);
        let out_of_range = sure & (t_hi.lt(of.below) | t_lo.gt(far));

        // A hit, if nothing is in doubt.
        let inside = weight.gt(len)
            & den.gt(len.mul_add(splat(view.least), splat(view.parallel)))
            & t_lo.gt(of.above)
            & t_hi.lt(splat(f32::INFINITY));
        let hit = (sure & maybe & inside & !out_of_range).bits() & live;
        let undecided = (maybe & !out_of_range).bits() & live & !hit;
        Some(Verdict { hit, undecided, t_lo, t_hi })
    }
}
