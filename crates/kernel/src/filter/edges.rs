//! The f32 intersection test and its error bounds, for rays from any origin.
//!
//! ```text
//!   A = c1 - o      R = A × d                     c3
//!   n = h4 × h5     den = n·d     num = n·A       /\       V > 0 inside h5
//!   V = h5·R        W = -h4·R                h5  /  \ h6   W > 0 inside h4
//!   U = den - V - W                             /____\     U > 0 inside h6
//!   t = num / den                             c1  h4  c2
//! ```
//!
//! V, W, and U divided by den are the weights of c2, c3, and c1. The test computes c1 relative to
//! the ray's origin first, so no precision is lost if the scene is far from the world's origin.
//! `docs/numerics/certified.md` has the bounds and the proof.

use crate::packet::{RayLanes, RayPacket, TriangleBlock};
use crate::simd::Vec3;
use crate::simd::{Lanes, Mask};
use crate::{Ray, Threshold, Triangle, TriangleOf};

use super::bound;
use super::longest_edge::longest_edge;
use super::room::Room;
use super::verdicts::Verdicts;

/// Triangles in lanes, with the values that the filter needs.
#[derive(Clone, Copy)]
pub struct Triangles<F> {
    pub(super) c1: Vec3<F>,
    /// `-h4`. Storing it negated saves a negation in every test.
    pub(super) minus_h4: Vec3<F>,
    pub(super) h5: Vec3<F>,
    pub(super) n: Vec3<F>,
    /// The longest edge, rounded up; NaN if the filter must not decide.
    pub(super) h: F,
    /// `h²`
    hh: F,
}

impl<F: Lanes<Scalar = f32>> Triangles<F> {
    /// Loads the N triangles in a block.
    #[inline(always)]
    pub(crate) fn of_block<const N: usize>(block: &TriangleBlock<N>, room: &Room) -> Self {
        // Do not use `map` here: it would be compiled without the level's instructions.
        let [c1, c2, c3] = block.corners();
        let corners = [Vec3::load(c1), Vec3::load(c2), Vec3::load(c3)];
        let h = F::load(block.longest_edges());
        if room.copies { Self::of_edges(corners, h) } else { Self::new(corners, h) }
    }

    /// Copies one triangle in a block to all lanes.
    #[inline(always)]
    pub(crate) fn of_lane<const N: usize>(
        block: &TriangleBlock<N>,
        lane: usize,
        room: &Room,
    ) -> Self {
        let [c1, c2, c3] = block.corners();
        let corners = [splat_lane(c1, lane), splat_lane(c2, lane), splat_lane(c3, lane)];
        let h = F::splat(block.longest_edges()[lane]);
        if room.copies { Self::of_edges(corners, h) } else { Self::new(corners, h) }
    }

    /// Copies one triangle to all lanes.
    #[inline(always)]
    pub(crate) fn splat(TriangleOf([c1, c2, c3]): &Triangle, h: f32) -> Self {
        Self::new([Vec3::splat(*c1), Vec3::splat(*c2), Vec3::splat(*c3)], F::splat(h))
    }

    /// Creates triangles from their corners and longest edges.
    #[inline(always)]
    pub(crate) fn new([c1, c2, c3]: [Vec3<F>; 3], h: F) -> Self {
        Self::of_edges([c1, c1 - c2, c3 - c1], h)
    }

    /// Creates triangles from their corners alone. The longest edges are computed in f32.
    #[inline(always)]
    pub(crate) fn of_corners([c1, c2, c3]: [Vec3<F>; 3]) -> Self {
        let (minus_h4, h5) = (c1 - c2, c3 - c1);
        Self::of_edges([c1, minus_h4, h5], longest_edge(c1, minus_h4, h5))
    }

    /// Creates triangles from a corner, the edges `-h4` and `h5`, and the longest edge of each.
    #[inline(always)]
    fn of_edges([c1, minus_h4, h5]: [Vec3<F>; 3], h: F) -> Self {
        Self { c1, minus_h4, h5, n: h5.cross_fused(minus_h4), h, hh: h * h }
    }
}

/// Copies a corner of one lane's triangle to all lanes.
#[inline(always)]
fn splat_lane<F: Lanes<Scalar = f32>, const N: usize>(
    [x, y, z]: &[[f32; N]; 3],
    lane: usize,
) -> Vec3<F> {
    Vec3 { x: F::splat(x[lane]), y: F::splat(y[lane]), z: F::splat(z[lane]) }
}

/// Rays in lanes, with the values that the filter needs.
#[derive(Clone, Copy)]
pub struct Rays<F> {
    rays: RayLanes<F>,
    /// |d|₂, rounded up; NaN if the filter must not decide.
    len: F,
    /// `EDGE |d|₂`
    edge: F,
    /// The part of the edges' error bound that depends on the origin.
    off: F,
    /// `SLACK` times the part of A's error that does not depend on the length of A.
    num: F,
    /// `GRAZING |d|₂`
    grazing: F,
    /// `GRAZING_ADD |d|₂`
    grazing_add: F,
    /// `SLACK DEN |d|₂`
    den_err: F,
    /// A t above this value is certainly beyond the near end of the interval.
    above: F,
    /// A t below this value is certainly not beyond the near end of the interval.
    below: F,
}

impl<F: Lanes<Scalar = f32>> Rays<F> {
    /// Computes the constants of each lane's ray.
    #[inline(always)]
    pub(crate) fn new(rays: RayLanes<F>, threshold: Threshold, room: &Room) -> Self {
        let splat = F::splat;
        let (dir, org) = (rays.dir, rays.org.norm1());
        let len = dir.dot(dir).sqrt().mul_add(splat(bound::NORM_UP), splat(bound::NORM_ADD));

        // Within these limits, nothing overflows, and the bound covers underflow. Beyond them, the
        // length becomes NaN, so no comparison decides anything.
        let sane = org.le(splat(bound::LARGEST))
            & len.le(splat(bound::LARGEST))
            & len.ge(splat(bound::SHORTEST_DIR));
        let len = F::select(sane, len, splat(f32::NAN));
        // The distance by which a corner's copy may have moved relative to the origin's copy, apart
        // from a fraction of |A|. This is 0 unless the scene was given in f64 (f64.md, section 4).
        let copied = (org * splat(room.copied[0])).min(splat(room.copied[1]));
        // The part of an edge's bound that grows with the origin: the rounding of the reference's
        // hit point (`ORIGIN`), the rounding of copies, and the effect of underflow (`SMALL`,
        // `OFF_ADD`).
        let off = org.mul_add(splat(room.off[0]), copied + splat(room.off[1]));
        let off = len.mul_add(off, splat(bound::OFF_ADD));

        // The larger of t_min and the threshold. If t_min is NaN, so is the result, and nothing is
        // decided.
        let near = rays.t_min.mul_add(splat(room.near[0]), splat(room.near[1]));
        Self {
            rays,
            len,
            edge: len * splat(room.edge),
            off,
            num: copied.mul_add(splat(bound::SLACK), splat(room.num[1])),
            grazing: len * splat(room.grazing),
            grazing_add: len * splat(bound::GRAZING_ADD),
            den_err: len * splat(room.den),
            above: at_least(near, threshold.above),
            below: at_least(rays.t_min, threshold.below),
        }
    }

    /// Loads the N rays in a packet.
    #[inline(always)]
    pub(crate) fn of_packet<const N: usize>(
        packet: &RayPacket<N>,
        threshold: Threshold,
        room: &Room,
    ) -> Self {
        Self::new(RayLanes::of_packet(packet), threshold, room)
    }

    /// Copies one ray to all lanes.
    #[inline(always)]
    pub(crate) fn splat(one: &Rays<f32>) -> Self {
        Self {
            rays: RayLanes::splat(&one.rays),
            len: F::splat(one.len),
            edge: F::splat(one.edge),
            off: F::splat(one.off),
            num: F::splat(one.num),
            grazing: F::splat(one.grazing),
            grazing_add: F::splat(one.grazing_add),
            den_err: F::splat(one.den_err),
            above: F::splat(one.above),
            below: F::splat(one.below),
        }
    }
}

impl Rays<f32> {
    /// Computes the constants of one ray.
    #[inline(always)]
    pub(crate) fn of_ray(ray: &Ray, threshold: Threshold, room: &Room) -> Self {
        Self::new(RayLanes::of_ray(ray), threshold, room)
    }

    /// Widens the bound to cover all lines that have the ray's direction and pass within a distance
    /// of `off`.
    #[inline(always)]
    pub(super) fn passed_within(mut self, off: f32) -> Self {
        self.off += self.len * off;
        self
    }
}

/// Returns the larger of each lane's value and `x`. NaN lanes stay NaN.
#[inline(always)]
pub(super) fn at_least<F: Lanes<Scalar = f32>>(lanes: F, x: f32) -> F {
    F::select(lanes.lt(F::splat(x)), F::splat(x), lanes)
}

impl<F: Copy> Rays<F> {
    #[inline(always)]
    pub(super) fn org(&self) -> Vec3<F> {
        self.rays.org
    }
    #[inline(always)]
    pub(super) fn dir(&self) -> Vec3<F> {
        self.rays.dir
    }
    #[inline(always)]
    pub(super) fn len(&self) -> F {
        self.len
    }
    #[inline(always)]
    pub(super) fn off(&self) -> F {
        self.off
    }
}

/// The edge functions of a ray and a triangle.
#[derive(Clone, Copy)]
pub(super) struct Edges<F> {
    a: Vec3<F>,
    pub(super) den: F,
    pub(super) v: F,
    pub(super) w: F,
    pub(super) u: F,
    /// The filter decides only if the magnitude of `den` exceeds this value. If the ray's `len` or
    /// the triangle's `h` is NaN, this value is also NaN, so that the filter does not decide.
    least: F,
}

impl<F: Lanes<Scalar = f32>> Edges<F> {
    #[inline(always)]
    pub(super) fn new(tri: &Triangles<F>, of: &Rays<F>) -> Self {
        // Translate to the origin first, so that large offsets of the scene cancel before any
        // multiplication.
        let a = tri.c1 - of.rays.org;
        let r = a.cross_fused(of.rays.dir);
        let den = tri.n.dot_fused(of.rays.dir);
        let v = tri.h5.dot_fused(r);
        let w = tri.minus_h4.dot_fused(r);
        // V, W, and U sum to `den`, so the third edge costs two subtractions instead of a dot
        // product. U inherits the errors of V and W, so its bound is twice as large as theirs.
        Self { a, den, v, w, u: (den - v) - w, least: tri.hh.mul_add(of.grazing, of.grazing_add) }
    }

    /// Returns the lanes in which the ray is far enough from grazing that the sign of `den` is
    /// certain and the reference's noise is small.
    #[inline(always)]
    pub(super) fn sure(&self) -> F::Mask {
        self.den.abs().gt(self.least)
    }

    /// Returns the weights V, W, and U times the sign of `den`. They are positive inside the
    /// triangle, whichever side the ray comes from.
    #[inline(always)]
    pub(super) fn weights(&self) -> [F; 3] {
        [self.v.flip(self.den), self.w.flip(self.den), self.u.flip(self.den)]
    }

    /// Returns the bound on the errors of V and W. The bound on the error of U is twice as large.
    #[inline(always)]
    pub(super) fn bound(&self, tri: &Triangles<F>, of: &Rays<F>) -> F {
        // `EDGE |d|₂ h (|A|₁ + NEAR h) + h off`: section 2 of certified.md.
        tri.h * of.edge.mul_add(tri.h.mul_add(F::splat(bound::NEAR), self.a.norm1()), of.off)
    }

    /// Returns separate bounds for V, W, and U, which are tighter than [`Edges::bound`] but take
    /// several times as long to compute.
    #[inline(always)]
    pub(super) fn sharp_bounds(&self, tri: &Triangles<F>, of: &Rays<F>, room: &Room) -> [F; 3] {
        let splat = F::splat;

        // The permanents: the sums of the magnitudes of all products.
        let (a, d) = (self.a.abs(), of.rays.dir.abs());
        let (h4, h5) = (tri.minus_h4.abs(), tri.h5.abs());
        let q = a.permanents(d);
        let (v, w) = (h5.dot_fused(q), h4.dot_fused(q));
        // U is computed from `den`, V, and W, so its permanent is the sum of their permanents.
        let u = v + w + h4.permanents(h5).dot_fused(d);

        // The reference's noise, or the rounding of copies.
        let noise = of.len * splat(room.sharp_away[0]);
        let noise = tri.h * noise.mul_add(self.a.norm1() + tri.h, of.off);
        let [sharp, sharp_u] = [splat(room.sharp[0]), splat(room.sharp[1])];
        [v.mul_add(sharp, noise), w.mul_add(sharp, noise), u.mul_add(sharp_u, noise)]
    }

    /// Applies the sharp bounds. Returns the lanes that no edge proves to be misses, and the lanes
    /// that all edges together prove to be hits, provided that [`Edges::sure`] is set.
    #[inline(always)]
    fn sharper(&self, tri: &Triangles<F>, of: &Rays<F>, room: &Room) -> (F::Mask, F::Mask) {
        let [v_bound, w_bound, u_bound] = self.sharp_bounds(tri, of, room);
        let [v, w, u] = self.weights();
        let outside = v.lt(-v_bound) | w.lt(-w_bound) | u.lt(-u_bound);
        let inside = v.gt(v_bound) & w.gt(w_bound) & u.gt(u_bound);
        (!(self.sure() & outside), inside)
    }
}

/// The t at which a ray meets a triangle's plane, as a quotient with error bounds.
#[derive(Clone, Copy)]
pub(super) struct PlaneHit<F> {
    /// The numerator, multiplied by the sign of `den`.
    pub(super) num: F,
    /// `SLACK` times the error bound on the numerator.
    pub(super) num_err: F,
    /// The absolute value of the denominator.
    den: F,
    /// `SLACK` times the error bound on the denominator.
    pub(super) den_err: F,
}

impl<F: Lanes<Scalar = f32>> PlaneHit<F> {
    #[inline(always)]
    pub(super) fn new(tri: &Triangles<F>, of: &Rays<F>, edges: &Edges<F>, room: &Room) -> Self {
        let splat = F::splat;
        let share = edges.a.norm1().mul_add(splat(room.num[0]), of.num);
        Self {
            num: tri.n.dot_fused(edges.a).flip(edges.den),
            num_err: tri.hh.mul_add(share, splat(bound::TINY)),
            den: edges.den.abs(),
            den_err: tri.hh.mul_add(of.den_err, splat(bound::TINY)),
        }
    }

    /// Returns the lanes whose t is certainly outside the interval: above `far` or below the near
    /// end. This test is enough for most lanes and does not require a division.
    #[inline(always)]
    pub(super) fn out_of_range(&self, of: &Rays<F>, far: F) -> F::Mask {
        let Self { num, num_err, den, den_err } = *self;
        // num / den > far, with both sides multiplied by the positive den.
        let beyond = num.gt(far.mul_add(den + den_err, num_err));
        // `den - den_err` is positive if the sign of `den` is certain, because `GRAZING` exceeds
        // `SLACK DEN`.
        let before = num.lt(of.below.mul_add(den - den_err, -num_err));
        beyond | before
    }

    /// Returns lower and upper bounds on t.
    #[inline(always)]
    pub(super) fn enclosure(&self) -> (F, F) {
        enclose(self.num, self.num_err, self.den, self.den_err)
    }

    /// Returns a tighter bound on the numerator's error, which takes several times as long to
    /// compute.
    #[inline(always)]
    pub(super) fn sharp_num_err(
        tri: &Triangles<F>,
        of: &Rays<F>,
        edges: &Edges<F>,
        room: &Room,
    ) -> F {
        let splat = F::splat;
        let (a1, hh) = (edges.a.norm1(), tri.hh);
        let perm = tri.minus_h4.abs().permanents(tri.h5.abs()).dot_fused(edges.a.abs());
        // The terms for underflow are tiny. They are only added to, never multiplied on their own,
        // because a product that is subnormal takes a CPU about a hundred cycles.
        let tiny = (hh + a1).mul_add(splat(bound::TINY), splat(bound::TINY));
        let noise = (hh * a1).mul_add(splat(bound::NUM_NOISE), tiny);
        let copied = a1.mul_add(splat(room.sharp_away[1]), of.num * splat(1.0 / bound::SLACK));
        perm.mul_add(splat(bound::SHARP_NUM), hh.mul_add(copied, noise))
    }

    /// Returns lower and upper bounds on t, using the tighter bound on the numerator's error.
    #[inline(always)]
    pub(super) fn sharper(
        &self,
        tri: &Triangles<F>,
        of: &Rays<F>,
        edges: &Edges<F>,
        room: &Room,
    ) -> (F, F) {
        let num_err = Self::sharp_num_err(tri, of, edges, room) * F::splat(bound::SLACK);
        enclose(self.num, num_err, self.den, self.den_err)
    }
}

/// Returns lower and upper bounds on t, given its numerator, its positive denominator, and `SLACK`
/// times the error bound on each. After the division, the three products with the reciprocal can be
/// computed in parallel.
#[inline(always)]
pub(super) fn enclose<F: Lanes<Scalar = f32>>(num: F, num_err: F, den: F, den_err: F) -> (F, F) {
    let recip = F::splat(1.0) / den;
    let t = num * recip;
    // err = |t| share + rest: `share` collects the relative errors, and `rest` the absolute errors.
    let share = den_err.mul_add(recip, F::splat(bound::ROUND));
    let rest = num_err.mul_add(recip, F::splat(bound::TINY));
    let err = t.abs().mul_add(share, rest);
    (t - err, t + err)
}

impl<F: Lanes<Scalar = f32>> Edges<F> {
    /// Decides every lane for which the error bound allows a decision. A lane whose t certainly
    /// exceeds `far` counts as a miss.
    #[inline(always)]
    pub(super) fn decide(
        &self,
        tri: &Triangles<F>,
        of: &Rays<F>,
        far: F,
        live: u32,
        (threshold, room): (Threshold, &Room),
    ) -> Verdicts<F> {
        let splat = F::splat;
        let Self { den, least, .. } = *self;
        let sure = self.sure();

        // Only the smallest weight matters. U's bound is twice that of V and W, so U is halved.
        // Rounding preserves the sign of a sum, so the sign bit alone is the result of the
        // comparison.
        let bound = self.bound(tri, of);
        let [v, w, u] = self.weights();
        let edge = v.min(w).min(u * splat(0.5));
        let outside = if F::N == 1 {
            // For a single lane, avoid the minimum, which would be a branch in WebAssembly.
            (v + bound).or_sign(w + bound).or_sign(u * splat(0.5) + bound).negative()
        } else {
            (edge + bound).negative()
        };
        // Most triangles are rejected by an edge. With four lanes or fewer, all lanes are often
        // outside, so return early. With eight lanes or more, usually at least one lane is not
        // outside, and the branch would cost more than it saves.
        if F::N <= 4 && !(!(sure & outside)).any() {
            return Verdicts::miss();
        }

        // Does the ray meet the plane within its interval?
        let plane = PlaneHit::new(tri, of, self, room);
        let out_of_range = plane.out_of_range(of, far);
        let maybe = (!(sure & (outside | out_of_range))).bits() & live;
        if maybe == 0 {
            return Verdicts::miss();
        }

        // A lane is a hit if it certainly passes the parallel test, the range test, and the edge
        // tests.
        let (t_lo, t_hi) = plane.enclosure();
        // `least` accounts for the error of `den` itself. The other term comes from the document's
        // test `|vd| > Threshold`, multiplied by an upper bound on the normal's length
        // (certified.md, section 4).
        let parallel = splat(threshold.near * (bound::PARALLEL * bound::AREA));
        let parallel = tri.hh.mul_add(parallel, least);
        let slanted = den.abs().gt(parallel) & t_hi.lt(splat(f32::INFINITY));
        let mut hit = (slanted & t_lo.gt(of.above) & edge.gt(bound)).bits() & maybe;
        let mut undecided = maybe & !hit;
        if undecided != 0 {
            // Make a last attempt with tighter bounds, which take several times as long to compute.
            // Most of these lanes contain rays that pass near an edge, or rays that start on the
            // triangle and therefore have a t near 0.
            let (t_lo, t_hi) = plane.sharper(tri, of, self, room);
            let in_range = !(sure & (t_hi.lt(of.below) | t_lo.gt(far)));
            let clear = slanted & in_range & t_lo.gt(of.above);
            let (maybe, inside) = self.sharper(tri, of, room);
            let mut maybe = maybe & in_range;
            if room.exact {
                // Two weights of different signs mean a miss, even if the sign of the denominator
                // is unknown.
                let most = v.max(w).max(u * splat(0.5));
                maybe = maybe & !(edge.lt(-bound) & most.gt(bound));
            }
            hit |= (maybe & clear & inside).bits() & undecided;
            undecided &= maybe.bits() & !hit;
        }
        Verdicts { hit, undecided, leaves: hit & !den.negative().bits(), t_lo, t_hi }
    }
}

#[cfg(all(test, feature = "std"))]
mod tests;
