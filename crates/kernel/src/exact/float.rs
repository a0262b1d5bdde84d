//! The first tier: f64 in lanes, with a proven bound on the error of each number.
//!
//! ```text
//!   U = h6·(d × B)     h6 = c3 - c2           A number beyond its bound has its exact sign.
//!   V = h5·(A × d)     h5 = c3 - c1           A number with all products 0 is exactly 0.
//!   W = h4·(d × A)     h4 = c2 - c1           Two numbers with different signs mean a miss.
//!   T = A·(h4 × h5)        D = d·(h4 × h5)
//! ```
//!
//! `docs/numerics/exact.md`, sections 3 and 4, has the bounds and the proof.

use core::cmp::Ordering;

use crate::packet::RayLanes;
use crate::simd::{Lanes, Mask, Vec3};

/// `2^-53`, half an ulp of 1.
const HALF_ULP: f64 = f64::EPSILON / 2.0;

/// A bound on the error of U, V and W, relative to their permanents.
const EDGE: f64 = 8.0 * HALF_ULP;

/// A bound on the error of T and of D, relative to their permanents.
const VOLUME: f64 = 9.0 * HALF_ULP;

/// A bound on the error of a component of N₁, N₂, or N₃, relative to its permanent.
const NORMAL: f64 = 6.0 * HALF_ULP;

/// A bound on the error of T - t D, relative to the permanent of T plus t times the permanent of D.
const RANGE: f64 = 16.0 * HALF_ULP;

/// The relative widening of a quotient that covers the rounding of its two ends.
const WIDER: f64 = 8.0 * HALF_ULP;

/// The decisions made in f64 for each lane. A lane in none of the masks is undecided.
#[derive(Clone, Copy)]
pub struct Decided<M> {
    /// Certainly not a hit under either rule.
    pub miss: M,
    /// Certainly a hit under the closed rule.
    pub closed: M,
    /// Certainly a hit under both rules, because the ray hits no edge.
    pub inside: M,
    /// Whether T is positive, for hits.
    pub leaves: M,
    /// For hits, whether the ray certainly meets the line of the edge opposite each corner.
    pub edges: [M; 3],
}

/// The lanes in which each number is certainly positive, certainly negative, and certainly 0.
#[derive(Clone, Copy)]
pub(super) struct Signs<M> {
    /// The signs of U, V, W, and T.
    pub(super) volumes: [[M; 3]; 4],
    /// For hits, the signs of `t - t_min` and `t - t_max`.
    pub(super) ends: [[M; 3]; 2],
    /// Which of U, V, and W are 0, if their signs have been replaced.
    pub(super) edges: [M; 3],
}

impl<M: Mask> Signs<M> {
    /// Adds signs for the numbers whose signs were not known.
    #[inline(always)]
    pub(super) fn or(&self, more: &Self) -> Self {
        let mut all = *self;
        let more = more.volumes.iter().chain(&more.ends);
        for (known, more) in all.volumes.iter_mut().chain(&mut all.ends).zip(more) {
            let open = !(known[0] | known[1] | known[2]);
            for (known, more) in known.iter_mut().zip(more) {
                *known = *known | open & *more;
            }
        }
        all
    }

    /// Replaces each zero among U, V, and W by the sign that the *once* rule takes instead: that of
    /// the first nonzero component of N₁, N₂, or N₃. `normals` holds the signs of the components.
    #[inline(always)]
    pub(super) fn moved(&self, normals: &[[[M; 3]; 3]; 3]) -> Self {
        let mut all = *self;
        let [u, v, w, _] = &self.volumes;
        all.edges = [u[2] | self.edges[0], v[2] | self.edges[1], w[2] | self.edges[2]];
        // If all three are 0, D is 0, and the ray does not cross the plane in one point.
        let some = u[0] | u[1] | v[0] | v[1] | w[0] | w[1];
        for (sign, [x, y, z]) in all.volumes.iter_mut().zip(normals) {
            let zero = sign[2] & some;
            let over = x[0] | x[2] & (y[0] | y[2] & z[0]);
            let under = x[1] | x[2] & (y[1] | y[2] & z[1]);
            *sign = [sign[0] | zero & over, sign[1] | zero & under, sign[2] & !(over | under)];
        }
        all
    }

    /// Makes every decision that the signs allow.
    #[inline(always)]
    pub(super) fn decide(&self) -> Decided<M> {
        let [u, v, w, t] = self.volumes;
        let (over, under) = (u[0] | v[0] | w[0], u[1] | v[1] | w[1]);
        // Is the plane behind the origin, or does it contain the origin?
        let miss = over & under | t[2] | over & t[1] | under & t[0];
        // Is the point inside all edges, or on one of them?
        let sure = (over & t[0] | under & t[1]) & !miss;
        let (u_sure, v_sure, w_sure) = (u[0] | u[1], v[0] | v[1], w[0] | w[1]);
        let inside = sure & u_sure & v_sure & w_sure;
        let closed = sure & (u_sure | u[2]) & (v_sure | v[2]) & (w_sure | w[2]);
        // The near end belongs to the interval, and the far end does not.
        let [near, far] = self.ends;
        let (within, out) = ((near[0] | near[2]) & far[1], near[1] | far[0] | far[2]);
        let range = within & !out;
        Decided {
            miss: miss | closed & out,
            closed: closed & range,
            inside: inside & range,
            leaves: t[0],
            edges: [u[2] | self.edges[0], v[2] | self.edges[1], w[2] | self.edges[2]],
        }
    }
}

/// Bounds on the errors of U, V, W, and T, and on those of `T - t_min D` and `T - t_max D`.
pub(super) type Bounds<D> = ([D; 4], [D; 2]);

/// A value, and the sum of the magnitudes of all products that make it up.
#[derive(Clone, Copy)]
struct Sum<D> {
    value: D,
    permanent: D,
}

impl<D: Lanes<Scalar = f64>> Sum<D> {
    /// Computes `x·(y × z)`.
    #[inline(always)]
    fn volume(x: Vec3<D>, y: Vec3<D>, z: Vec3<D>) -> Self {
        // Each rounding error is at most a fraction of one of these products, so their sum bounds
        // the total error.
        let permanent = y.abs().permanents(z.abs()).dot_fused(x.abs());
        Self { value: y.cross_fused(z).dot_fused(x), permanent }
    }

    /// Returns a bound on the error of the value, given the bound relative to the permanent.
    #[inline(always)]
    fn error(&self, bound: f64) -> D {
        self.permanent * D::splat(bound)
    }

    /// Returns the magnitude of the value.
    #[inline(always)]
    fn abs(self) -> Self {
        Self { value: self.value.abs(), ..self }
    }

    /// Returns the lanes in which the value is certainly positive, certainly negative, and
    /// certainly 0.
    #[inline(always)]
    fn signs(&self, bound: f64) -> [D::Mask; 3] {
        let bound = self.error(bound);
        // Nothing underflows here, so if a permanent is 0, every product has a factor that is
        // exactly 0.
        let nothing = self.permanent.le(D::splat(0.0));
        [self.value.gt(bound), self.value.lt(-bound), nothing]
    }
}

/// Makes every decision that the bounds allow. The input must satisfy `input::is_plain`.
/// Non-finite input never results in a hit.
#[inline(always)]
pub fn decide<D: Lanes<Scalar = f64>>(
    corners: [Vec3<D>; 3],
    rays: &RayLanes<D>,
) -> Decided<D::Mask> {
    decide_with_t(corners, rays).0
}

/// Like [`decide`], but also returns bounds on t for hits. If the error of D may exceed D, there is
/// no upper bound, and the second number is infinite, NaN, or below the first one. The bounds hold
/// only if no quotient underflows or overflows.
#[inline(always)]
pub fn decide_with_t<D: Lanes<Scalar = f64>>(
    corners: [Vec3<D>; 3],
    rays: &RayLanes<D>,
) -> (Decided<D::Mask>, [D; 2]) {
    decide_refined(corners, rays, |_, _, _| None)
}

/// Like [`decide_with_t`], but `refine` may replace the signs by better ones. It receives the
/// decisions and signs so far, and bounds on the errors: a number whose sign is not known is at most
/// twice its bound.
#[inline(always)]
pub(super) fn decide_refined<D: Lanes<Scalar = f64>>(
    [c1, c2, c3]: [Vec3<D>; 3],
    rays: &RayLanes<D>,
    refine: impl FnOnce(&Decided<D::Mask>, &Signs<D::Mask>, Bounds<D>) -> Option<Signs<D::Mask>>,
) -> (Decided<D::Mask>, [D; 2]) {
    let (org, dir, t_min, t_max) = (rays.org, rays.dir, rays.t_min, rays.t_max);
    let (a, b) = (c1 - org, c2 - org);
    let (h4, h5, h6) = (c2 - c1, c3 - c1, c3 - c2);

    // In nearly all cases, two edges decide.
    let u = Sum::volume(h6, dir, b);
    let v = Sum::volume(h5, a, dir);
    let w = Sum::volume(h4, dir, a);
    let (u_signs, v_signs, w_signs) = (u.signs(EDGE), v.signs(EDGE), w.signs(EDGE));
    let over = u_signs[0] | v_signs[0] | w_signs[0];
    let miss = over & (u_signs[1] | v_signs[1] | w_signs[1]);
    let none = D::Mask::from_bits(0);
    // Few lanes get this far, so T and the interval are only computed if at least one does.
    if !(!miss).any() {
        let decided = Decided { miss, closed: none, inside: none, leaves: none, edges: [none; 3] };
        return (decided, [D::splat(0.0); 2]);
    }

    // D = U + V + W, but the permanents of U, V and W grow with the distance of the origin, and that
    // of d·(h4 × h5) does not.
    let (normal, products) = (h4.cross_fused(h5), h4.abs().permanents(h5.abs()));
    let t = Sum { value: normal.dot_fused(a), permanent: products.dot_fused(a.abs()) };
    let den = Sum { value: normal.dot_fused(dir), permanent: products.dot_fused(dir.abs()) };

    // Test the interval: compare T with its ends times D.
    let (num, den) = (t.abs(), den.abs());
    let (near, near_err) = beyond(&num, &den, t_min);
    let (far, far_err) = beyond(&num, &den, t_max);
    // For hits, t > 0, so negative ends and ends at 0 or at infinity need no comparison, which might be
    // undecided. The error bounds hold only for positive ends.
    let (open, endless) = (t_min.le(D::splat(0.0)), t_max.ge(D::splat(f64::INFINITY)));
    let empty = t_max.le(D::splat(0.0));
    let ends = [
        [near[0] | open, near[1] & !open, none],
        [far[0] | empty, far[1] & !empty | endless, none],
    ];

    let volumes = [u_signs, v_signs, w_signs, t.signs(VOLUME)];
    let signs = Signs { volumes, ends, edges: [none; 3] };
    let mut decided = signs.decide();
    let bounds = [u.error(EDGE), v.error(EDGE), w.error(EDGE), t.error(VOLUME)];
    if let Some(better) = refine(&decided, &signs, (bounds, [near_err, far_err])) {
        decided = better.decide();
    }
    (decided, quotient_bounds(&num, &den))
}

/// The signs of the components of N₁ = B × C, N₂ = C × A, and N₃ = A × B, and bounds on their errors.
#[derive(Clone, Copy)]
pub(super) struct NormalSigns<D: Lanes> {
    pub(super) signs: [[[D::Mask; 3]; 3]; 3],
    pub(super) bounds: [[D; 3]; 3],
}

impl<D: Lanes<Scalar = f64>> NormalSigns<D> {
    #[inline(always)]
    pub(super) fn new([c1, c2, c3]: [Vec3<D>; 3], org: Vec3<D>) -> Self {
        let (a, b, c) = (c1 - org, c2 - org, c3 - org);
        let none = D::Mask::from_bits(0);
        let mut all = Self { signs: [[[none; 3]; 3]; 3], bounds: [[D::splat(0.0); 3]; 3] };
        for (i, (p, q)) in [(b, c), (c, a), (a, b)].into_iter().enumerate() {
            let (n, size) = (p.cross_fused(q), p.abs().permanents(q.abs()));
            let components = [(n.x, size.x), (n.y, size.y), (n.z, size.z)];
            for (k, (value, permanent)) in components.into_iter().enumerate() {
                let sum = Sum { value, permanent };
                (all.signs[i][k], all.bounds[i][k]) = (sum.signs(NORMAL), sum.error(NORMAL));
            }
        }
        all
    }
}

/// Returns the lanes in which the triangle is perpendicular to an axis and the ray runs parallel to
/// its plane. D is then 0, and the ray does not hit the triangle. This case is common for walls and
/// floors. All volumes may be 0 in this case, which only integers could prove.
#[inline(always)]
pub(super) fn runs_along<D: Lanes<Scalar = f64>>(dir: Vec3<D>, [a, b, c]: [Vec3<D>; 3]) -> D::Mask {
    let zero = D::splat(0.0);
    let x = dir.x.abs().le(zero) & a.x.le(b.x) & b.x.le(c.x) & c.x.le(a.x);
    let y = dir.y.abs().le(zero) & a.y.le(b.y) & b.y.le(c.y) & c.y.le(a.y);
    let z = dir.z.abs().le(zero) & a.z.le(b.z) & b.z.le(c.z) & c.z.le(a.z);
    x | y | z
}

/// Returns bounds on `num / den`, both of which must be positive. If the error of `den` may be as
/// large as `den`, there is no upper bound, and the second number is negative or infinite.
#[inline(always)]
fn quotient_bounds<D: Lanes<Scalar = f64>>(num: &Sum<D>, den: &Sum<D>) -> [D; 2] {
    let (num_err, den_err) = (num.error(VOLUME), den.error(VOLUME));
    let lo = (num.value - num_err) / (den.value + den_err);
    let hi = (num.value + num_err) / (den.value - den_err);
    [lo * D::splat(1.0 - WIDER), hi * D::splat(1.0 + WIDER)]
}

/// Returns bounds on the t at which a ray's line meets a triangle's plane, if f64 is certain that T
/// and D are not 0 and have the same sign, so that t is positive. The input must satisfy
/// `input::is_plain`. The bounds hold only if no quotient underflows or overflows.
#[inline(always)]
pub(super) fn bounds_on_t(
    [c1, c2, c3]: [Vec3<f64>; 3],
    org: Vec3<f64>,
    dir: Vec3<f64>,
) -> Option<[f64; 2]> {
    let (a, h4, h5) = (c1 - org, c2 - c1, c3 - c1);
    let (normal, products) = (h4.cross_fused(h5), h4.abs().permanents(h5.abs()));
    let num = Sum { value: normal.dot_fused(a), permanent: products.dot_fused(a.abs()) };
    let den = Sum { value: normal.dot_fused(dir), permanent: products.dot_fused(dir.abs()) };
    let ([t_over, t_under, _], [d_over, d_under, _]) = (num.signs(VOLUME), den.signs(VOLUME));
    (t_over && d_over || t_under && d_under).then(|| quotient_bounds(&num.abs(), &den.abs()))
}

/// Returns the signs of T and D, if f64 is certain of both. The bound for T also holds for D =
/// d·(h4 × h5).
#[inline(always)]
pub(super) fn plane_signs(
    [c1, c2, c3]: [Vec3<f64>; 3],
    org: Vec3<f64>,
    dir: Vec3<f64>,
) -> Option<(Ordering, Ordering)> {
    let (a, h4, h5) = (c1 - org, c2 - c1, c3 - c1);
    let sign = |x| {
        let [over, under, zero] = Sum::volume(x, h4, h5).signs(VOLUME).map(Mask::any);
        let order = if over { Ordering::Greater } else { Ordering::Less };
        if zero { Some(Ordering::Equal) } else { (over || under).then_some(order) }
    };
    Some((sign(a)?, sign(dir)?))
}

/// Returns the sign of D, which is the sign of the direction's component along the normal, or
/// `Equal` if the bound does not decide. The input must satisfy `input::is_plain`.
#[inline(always)]
pub(super) fn facing([c1, c2, c3]: [Vec3<f64>; 3], dir: Vec3<f64>) -> Ordering {
    // D is T with the direction in place of A. The direction is exact.
    let [over, under, _] = Sum::volume(dir, c2 - c1, c3 - c1).signs(VOLUME);
    over.cmp(&under)
}

/// Returns whether a ray's line certainly misses the line through two points or, if the points
/// coincide, misses that point. The input must satisfy `input::is_plain`.
#[inline(always)]
pub(super) fn passes([p, q]: [Vec3<f64>; 2], org: Vec3<f64>, dir: Vec3<f64>) -> bool {
    let (a, h) = (p - org, q - p);
    let [over, under, _] = Sum::volume(h, a, dir).signs(EDGE);
    if h.norm1() > 0.0 {
        return over || under;
    }
    let (moment, size) = (a.cross_fused(dir).abs(), a.abs().permanents(dir.abs()));
    let beyond = |x: f64, size: f64| x > EDGE * size;
    beyond(moment.x, size.x) || beyond(moment.y, size.y) || beyond(moment.z, size.z)
}

/// Returns the lanes in which `num / den` is certainly beyond an end of the interval, those in which it
/// is certainly before that end, and the bound on the error of `num - end * den`. The end must be
/// positive.
#[inline(always)]
fn beyond<D: Lanes<Scalar = f64>>(num: &Sum<D>, den: &Sum<D>, end: D) -> ([D::Mask; 2], D) {
    // num / den < end, multiplied by the positive den.
    let gap = num.value - end * den.value;
    let bound = end.mul_add(den.permanent, num.permanent) * D::splat(RANGE);
    ([gap.gt(bound), gap.lt(-bound)], bound)
}

#[cfg(test)]
mod tests {
    use super::NormalSigns;
    use crate::exact::test_numbers::random;
    use crate::simd::Vec3;

    /// Returns the error of a component of N₁ as a fraction of its bound, for corners and an origin
    /// whose coordinates are integers up to 2^53. Their differences may need another digit.
    fn share([b, c, o]: [[i64; 3]; 3]) -> f64 {
        let vec3 = |p: [i64; 3]| Vec3::<f64>::splat(p.map(|x| x as f64));
        let bound = NormalSigns::new([vec3(o), vec3(b), vec3(c)], vec3(o)).bounds[0][0];
        let (q, r) = (vec3(b) - vec3(o), vec3(c) - vec3(o));
        let minus = |p: [i64; 3]| [0, 1, 2].map(|k| i128::from(p[k]) - i128::from(o[k]));
        let ([_, y, z], [_, other_y, other_z]) = (minus(b), minus(c));
        let truth = y * other_z - z * other_y;
        // Both with fused operations and without them.
        let [one, other] = [q.cross_fused(r).x, q.y * r.z - q.z * r.y];
        let off = |x: f64| (x as i128 - truth).abs() as f64;
        if bound > 0.0 { off(one).max(off(other)) / bound } else { 0.0 }
    }

    /// Attacks the bound on the components of normals, by changing the worst coordinates found so
    /// far. A bound of half the size would be exceeded.
    #[test]
    fn components_of_normals_are_within_their_bound() {
        const LIMIT: i64 = 1 << 53;
        let mut random = random();
        let mut worst = (0.0, [[0; 3]; 3]);
        for i in 0..2_000_000 {
            let is_new = i % 200_000 < 50_000;
            let size = if is_new { 2.0 * LIMIT as f64 } else { (60.0 * (random() + 0.5)).exp2() };
            let from = if is_new { [[0; 3]; 3] } else { worst.1 };
            let moved = from
                .map(|p: [i64; 3]| p.map(|x| (x + (size * random()) as i64).clamp(-LIMIT, LIMIT)));
            let share = share(moved);
            if share > worst.0 {
                worst = (share, moved);
            }
        }
        assert!(0.5 < worst.0 && worst.0 <= 1.0, "{worst:?}");
    }
}
