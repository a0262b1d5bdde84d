//! The f32 filter: what the bound decides, for rays and triangles of any origin.
//!
//! ```text
//!   A = c1 - o      R = A × d                     c3
//!   n = h4 × h5     den = n·d     num = n·A       /\       V > 0 inside of h5
//!   V = h5·R        W = -h4·R                h5  /  \ h6   W > 0 inside of h4
//!   U = den - V - W                             /____\     U > 0 inside of h6
//!   t = num / den                             c1  h4  c2
//! ```
//!
//! V, W, U over den are the weights of c2, c3, c1. The translation comes first, so large offsets
//! cost nothing. Bounds and proof: `docs/numerics/certified.md`.

use crate::lanes::{Lanes, Mask};
use crate::packet::RayLanes;
use crate::{Ray, Triangle, TrianglePack, Vec3};

use super::bound;

/// Triangles as lanes, with what the filter asks of them.
#[derive(Clone, Copy)]
pub struct Triangles<F> {
    c1: Vec3<F>,
    /// `-h4`, which saves a change of sign.
    minus_h4: Vec3<F>,
    h5: Vec3<F>,
    n: Vec3<F>,
    /// The longest edge, rounded up; NaN where the filter must not decide.
    h: F,
    /// `NEAR h`
    near: F,
    /// `GRAZING h²`, and a little.
    grazing: F,
}

impl<F: Lanes<Scalar = f32>> Triangles<F> {
    /// N triangles.
    #[inline(always)]
    pub(crate) fn of_pack<const N: usize>(pack: &TrianglePack<N>) -> Self {
        // Not by `map`, which would be compiled without the level's instructions.
        let [c1, c2, c3] = pack.corners();
        let (c1, c2, c3) = (Vec3::load(c1), Vec3::load(c2), Vec3::load(c3));
        let (minus_h4, h5, h) = (c1 - c2, c3 - c1, F::load(pack.longest_edges()));
        Self {
            c1,
            minus_h4,
            h5,
            n: h5.cross_fused(minus_h4),
            h,
            near: h * F::splat(bound::NEAR),
            grazing: (h * h).mul_add(F::splat(bound::GRAZING), F::splat(bound::GRAZING_ADD)),
        }
    }

    /// One triangle for all lanes.
    #[inline(always)]
    pub(crate) fn splat(one: &Triangles<f32>) -> Self {
        let vec3 = |v: Vec3<f32>| Vec3::splat([v.x, v.y, v.z]);
        Self {
            c1: vec3(one.c1),
            minus_h4: vec3(one.minus_h4),
            h5: vec3(one.h5),
            n: vec3(one.n),
            h: F::splat(one.h),
            near: F::splat(one.near),
            grazing: F::splat(one.grazing),
        }
    }
}

impl Triangles<f32> {
    /// One triangle.
    pub(crate) fn one(triangle: &Triangle) -> Self {
        Self::of_pack(&TrianglePack::<1>::new(core::slice::from_ref(triangle)))
    }
}

/// Rays as lanes, with what the filter asks of them.
#[derive(Clone, Copy)]
pub struct Rays<F> {
    rays: RayLanes<F>,
    /// |d|₂, rounded up; NaN where the filter must not decide.
    len: F,
    /// `-EDGE |d|₂`
    minus_edge: F,
    /// The part of the bound that is the origin's, negative.
    minus_off: F,
    /// A t beyond this is large enough, a t under that is not.
    above: F,
    below: F,
}

impl<F: Lanes<Scalar = f32>> Rays<F> {
    /// Computes a ray's constants, lane by lane.
    #[inline(always)]
    pub(crate) fn new(rays: RayLanes<F>, threshold: f64) -> Self {
        let splat = F::splat;
        let (dir, org) = (rays.dir, rays.org.norm1());
        let len = dir.dot(dir).sqrt().mul_add(splat(bound::NORM_UP), splat(bound::NORM_ADD));

        // Within these limits nothing overflows, and what underflows is in the bound.
        let sane = org.le(splat(bound::LARGEST))
            & len.le(splat(bound::LARGEST))
            & len.ge(splat(bound::SHORTEST_DIR));
        let len = F::select(sane, len, splat(f32::NAN));
        let off = org.mul_add(splat(bound::ORIGIN), splat(bound::SMALL));

        // The larger of t_min and Threshold; a NaN in t_min stays, and decides nothing.
        let threshold = threshold as f32;
        Self {
            rays,
            len,
            minus_edge: len * splat(-bound::EDGE),
            minus_off: -len.mul_add(off, splat(bound::OFF_ADD)),
            above: at_least(rays.t_min, threshold.next_up()),
            below: at_least(rays.t_min, threshold.next_down()),
        }
    }

    /// N different rays.
    #[inline(always)]
    pub(crate) fn of_packet<const N: usize>(packet: &crate::RayPacket<N>, threshold: f64) -> Self {
        Self::new(RayLanes::of_packet(packet), threshold)
    }

    /// One ray for all lanes.
    #[inline(always)]
    pub(crate) fn of_ray(ray: &Ray, threshold: f64) -> Self {
        Self::new(RayLanes::of_ray(ray), threshold)
    }
}

/// The larger of lanes and a number; where a lane is NaN, NaN.
#[inline(always)]
pub(super) fn at_least<F: Lanes<Scalar = f32>>(lanes: F, x: f32) -> F {
    F::select(lanes.lt(F::splat(x)), F::splat(x), lanes)
}

impl<F: Copy> Rays<F> {
    #[inline(always)]
    pub(super) fn dir(&self) -> Vec3<F> {
        self.rays.dir
    }
    #[inline(always)]
    pub(super) fn len(&self) -> F {
        self.len
    }
    #[inline(always)]
    pub(super) fn above(&self) -> F {
        self.above
    }
    #[inline(always)]
    pub(super) fn below(&self) -> F {
        self.below
    }
}

/// The edge functions with the bound that they share.
#[derive(Clone, Copy)]
pub(super) struct Edges<F> {
    a: Vec3<F>,
    a1: F,
    pub(super) den: F,
    pub(super) v: F,
    pub(super) w: F,
    pub(super) u: F,
    /// Below this a weight is surely negative, above its opposite surely positive. NaN, which decides
    /// nothing, where the ray's `len` or the triangle's `h` is.
    pub(super) minus_bound: F,
    /// What `den` must exceed for anything to be decided.
    least: F,
}

impl<F: Lanes<Scalar = f32>> Edges<F> {
    #[inline(always)]
    pub(super) fn new(tri: &Triangles<F>, of: &Rays<F>) -> Self {
        let Rays { rays, len, minus_edge, minus_off, .. } = *of;
        let a = tri.c1 - rays.org;
        let r = a.cross_fused(rays.dir);
        let den = tri.n.dot_fused(rays.dir);
        let v = tri.h5.dot_fused(r);
        let w = tri.minus_h4.dot_fused(r);
        let u = (den - v) - w;

        let a1 = a.norm1();
        let minus_bound = tri.h * minus_edge.mul_add(a1 + tri.near, minus_off);
        Self { a, a1, den, v, w, u, minus_bound, least: len * tri.grazing }
    }

    /// Far enough from grazing for the sign of `den` to be sure and the reference's noise small?
    #[inline(always)]
    pub(super) fn sure(&self) -> F::Mask {
        self.den.abs().gt(self.least)
    }

    /// The least of the weights, positive inside whichever side the ray comes from.
    #[inline(always)]
    fn weight(&self) -> F {
        let u = self.u * F::splat(bound::U_SCALE);
        self.v.flip(self.den).min(self.w.flip(self.den)).min(u.flip(self.den))
    }
}

/// Where the ray meets the plane, with what bounds it.
#[derive(Clone, Copy)]
pub(super) struct Plane<F> {
    /// The numerator, with the sign of `den` in it; t is this over |den|.
    pub(super) num: F,
    pub(super) num_err: F,
    pub(super) den_err: F,
    pub(super) t_lo: F,
    pub(super) t_hi: F,
}

impl<F: Lanes<Scalar = f32>> Plane<F> {
    #[inline(always)]
    pub(super) fn new(tri: &Triangles<F>, of: &Rays<F>, edges: &Edges<F>) -> Self {
        let splat = F::splat;
        let Edges { a, a1, den, .. } = *edges;
        let num = tri.n.dot_fused(a).flip(den);
        let recip = splat(1.0) / den.abs();
        let t = num * recip;
        let hh = tri.h * tri.h;
        let num_err =
            ((a1 + splat(bound::SMALL)) * hh).mul_add(splat(bound::NUM), splat(bound::TINY));
        let den_err = (of.len * hh).mul_add(splat(bound::DEN), splat(bound::TINY));
        let err = t.abs().mul_add(den_err, num_err) * recip;
        let rounding = t.abs().mul_add(splat(bound::ROUND), splat(bound::TINY));
        let err = err.mul_add(splat(bound::SLACK), rounding);
        Self { num, num_err, den_err, t_lo: t - err, t_hi: t + err }
    }
}

/// What the bound says of each lane. A lane that is in neither mask is a miss.
#[derive(Clone, Copy)]
pub(crate) struct Verdict<F> {
    /// A hit, but for the far end of the interval.
    pub(crate) hit: u32,
    /// Undecided: to be replayed in f64.
    pub(crate) undecided: u32,
    /// Where [`Verdict::hit`]: an enclosure of the reference's t.
    pub(crate) t_lo: F,
    /// See [`Verdict::t_lo`].
    pub(crate) t_hi: F,
}

impl<F: Lanes<Scalar = f32>> Edges<F> {
    /// Whether every live lane is surely a miss by its edges, as nearly always.
    #[inline(always)]
    pub(super) fn all_miss(&self, live: u32) -> bool {
        (!(self.sure() & self.weight().lt(self.minus_bound))).bits() & live == 0
    }

    /// Decides what the bound lets it decide. A lane whose t surely exceeds `far` is a miss, too.
    #[inline(always)]
    pub(super) fn decide(
        &self,
        tri: &Triangles<F>,
        of: &Rays<F>,
        far: F,
        live: u32,
        threshold: f64,
    ) -> Verdict<F> {
        let splat = F::splat;
        let Self { den, minus_bound, least, .. } = *self;
        let (sure, weight) = (self.sure(), self.weight());
        let maybe = !(sure & weight.lt(minus_bound));

        // Is the plane where hits count?
        let Plane { t_lo, t_hi, .. } = Plane::new(tri, of, self);
        let out_of_range = sure & (t_hi.lt(of.below) | t_lo.gt(far));

        // A hit, if nothing is in doubt: not the edges, not the parallel test, not the range.
        let parallel = tri.n.norm1().mul_add(splat(threshold as f32 * bound::PARALLEL), least);
        let inside = weight.gt(-minus_bound)
            & den.abs().gt(parallel)
            & t_lo.gt(of.above)
            & t_hi.lt(splat(f32::INFINITY));
        let hit = (sure & maybe & inside & !out_of_range).bits() & live;
        let undecided = (maybe & !out_of_range).bits() & live & !hit;
        Verdict { hit, undecided, t_lo, t_hi }
    }
}
