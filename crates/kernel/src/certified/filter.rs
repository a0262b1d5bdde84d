//! The f32 filter: what the bound decides, for rays and triangles of any origin.
//!
//! ```text
//!   A = c1 - o      R = d × A                     c3
//!   n = h4 × h5     den = n·d     num = n·A       /\       V > 0 inside of h5
//!   V = -h5·R       W = h4·R                 h5  /  \ h6   W > 0 inside of h4
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
    h4: Vec3<F>,
    h5: Vec3<F>,
    n: Vec3<F>,
    /// The longest edge, rounded up.
    h: F,
}

impl<F: Lanes<Scalar = f32>> Triangles<F> {
    /// N triangles.
    #[inline(always)]
    pub(crate) fn of_pack<const N: usize>(pack: &TrianglePack<N>) -> Self {
        let [c1, c2, c3] = pack.corners().each_ref().map(Vec3::load);
        let (h4, h5) = (c2 - c1, c3 - c1);
        Self { c1, h4, h5, n: h4.cross_fused(h5), h: F::load(pack.longest_edges()) }
    }

    /// One triangle for all lanes.
    #[inline(always)]
    pub(crate) fn splat(one: &Triangles<f32>) -> Self {
        let vec3 = |v: Vec3<f32>| Vec3::splat([v.x, v.y, v.z]);
        Self {
            c1: vec3(one.c1),
            h4: vec3(one.h4),
            h5: vec3(one.h5),
            n: vec3(one.n),
            h: F::splat(one.h),
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
    /// |d|₂, rounded up.
    len: F,
    /// The part of the bound that is the origin's.
    off: F,
    /// A t beyond this is large enough, a t under that is not.
    above: F,
    below: F,
}

impl<F: Lanes<Scalar = f32>> Rays<F> {
    /// Computes a ray's constants, lane by lane.
    #[inline(always)]
    pub(crate) fn new(rays: RayLanes<F>, threshold: f64) -> Self {
        let dir = rays.dir;
        let len = dir.dot(dir).sqrt().mul_add(F::splat(bound::NORM_UP), F::splat(bound::NORM_ADD));
        let off = rays.org.norm1().mul_add(F::splat(bound::ORIGIN), F::splat(bound::SMALL));

        // The larger of t_min and Threshold; a NaN in t_min stays, and decides nothing.
        let threshold = threshold as f32;
        let at_least = |x: f32| F::select(rays.t_min.lt(F::splat(x)), F::splat(x), rays.t_min);
        Self {
            rays,
            len,
            off: len.mul_add(off, F::splat(bound::TINY)),
            above: at_least(threshold.next_up()),
            below: at_least(threshold.next_down()),
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

/// The edge functions with the bound that they share.
#[derive(Clone, Copy)]
pub(super) struct Edges<F> {
    a: Vec3<F>,
    a1: F,
    pub(super) den: F,
    pub(super) minus_v: F,
    pub(super) w: F,
    pub(super) u: F,
    /// Beyond this the sign of V, W and `U_SCALE` U is sure.
    pub(super) edge: F,
    /// |d|₂h², which bounds `den`.
    span: F,
    /// What `den` must exceed for anything to be decided.
    least: F,
}

impl<F: Lanes<Scalar = f32>> Edges<F> {
    #[inline(always)]
    pub(super) fn new(tri: &Triangles<F>, of: &Rays<F>) -> Self {
        let splat = F::splat;
        let Rays { rays, len, off, .. } = *of;
        let a = tri.c1 - rays.org;
        let r = rays.dir.cross_fused(a);
        let den = tri.n.dot_fused(rays.dir);
        let minus_v = tri.h5.dot_fused(r);
        let w = tri.h4.dot_fused(r);
        let u = den + minus_v - w;

        let a1 = a.norm1();
        let reach = tri.h.mul_add(splat(bound::NEAR), a1);
        let edge =
            tri.h.mul_add((len * splat(bound::EDGE)).mul_add(reach, off), splat(bound::TINY));
        let span = len * tri.h * tri.h;
        let least = span.mul_add(splat(bound::GRAZING), splat(bound::TINY));
        Self { a, a1, den, minus_v, w, u, edge, span, least }
    }

    /// Far enough from grazing for the sign of `den` to be sure and the reference's noise small? An
    /// infinity or a NaN in any of V, W, den makes U one, and then the product NaN: not sure.
    #[inline(always)]
    pub(super) fn sure(&self) -> F::Mask {
        self.den.abs().gt(self.u.mul_add(F::splat(0.0), self.least))
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
    pub(super) fn new(tri: &Triangles<F>, edges: &Edges<F>) -> Self {
        let splat = F::splat;
        let Edges { a, a1, den, span, .. } = *edges;
        let num = tri.n.dot_fused(a).flip(den);
        let recip = splat(1.0) / den.abs();
        let t = num * recip;
        let num_err = ((a1 + splat(bound::SMALL)) * tri.h * tri.h)
            .mul_add(splat(bound::NUM), splat(bound::TINY));
        let den_err = span.mul_add(splat(bound::DEN), splat(bound::TINY));
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

/// Decides what the bound lets it decide. A lane whose t surely exceeds `far` is a miss, too.
/// `None` where every live lane is a miss already by its edges, as nearly always.
#[inline(always)]
pub(crate) fn filter<F: Lanes<Scalar = f32>>(
    tri: &Triangles<F>,
    of: &Rays<F>,
    far: F,
    live: u32,
    threshold: f64,
) -> Option<Verdict<F>> {
    let splat = F::splat;
    let edges = Edges::new(tri, of);
    let Edges { den, minus_v, w, u, edge, least, .. } = edges;
    let sure = edges.sure();

    // The weights, positive inside whichever side the ray comes from; the least of them decides.
    let weight = (-minus_v).flip(den).min(w.flip(den)).min((u * splat(bound::U_SCALE)).flip(den));
    let maybe = !(sure & weight.lt(-edge));
    if maybe.bits() & live == 0 {
        return None;
    }

    // Is the plane where hits count?
    let Plane { t_lo, t_hi, .. } = Plane::new(tri, &edges);
    let out_of_range = sure & (t_hi.lt(of.below) | t_lo.gt(far));

    // A hit, if nothing is in doubt: not the edges, not the parallel test, not the range.
    let parallel = tri.n.norm1() * splat(threshold as f32 * bound::PARALLEL) + least;
    let inside = weight.gt(edge)
        & den.abs().gt(parallel)
        & t_lo.gt(of.above)
        & t_hi.lt(splat(f32::INFINITY));
    let hit = (sure & maybe & inside & !out_of_range).bits() & live;
    let undecided = (maybe & !out_of_range).bits() & live & !hit;
    Some(Verdict { hit, undecided, t_lo, t_hi })
}
