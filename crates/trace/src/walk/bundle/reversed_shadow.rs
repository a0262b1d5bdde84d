//! Reversed shadow rays: rays toward one point, such as a light, are traced backward from that
//! point.
//!
//! ```text
//!   o ────────► d          o ◄──────── -d
//!      o ─────► L     ─►      o ◄───── L      t' = τ - t
//!   o ────────►            o ◄────────
//! ```
//!
//! Because of rounding, each ray misses L slightly. All bounds are widened accordingly, as derived
//! in `docs/numerics/projection.md`, section 6. Whether a ray hits anything then agrees with the
//! reference implementation. The position of the hit is not computed.

use intertri::simd::{Lanes, Mask};
use intertri::{Ray, Threshold};

/// A ray does not count as ending at the point if it misses the point by more than this fraction of
/// the sum of the point's largest coordinate and its distance from the ray's origin: 2^-20.
const APART: f32 = 1.0 / (1 << 20) as f32;

/// The part of a ray's miss distance that is due to rounding, as a fraction of the ray's length:
/// 4u. For a copy, it is 8u.
const ROUNDING: f32 = 4.0 / (1 << 24) as f32;

/// The maximum amount by which the interval of a copy extends beyond that of the original ray, as a
/// fraction of the t at which the ray reaches the point: 4u.
const ENDS: f32 = 4.0 / (1 << 24) as f32;

/// The interval of a copy must begin no later than this fraction of the t at which the ray reaches
/// the point, so that rounding its start hardly changes the remaining interval (f64.md, section 6).
const BEGINS: f32 = 1.0 / 8.0;

/// A bound on the length of a ray and on the coordinates of its ends (2^30). The length must also
/// exceed the inverse of this bound.
const LARGEST: f32 = (1 << 30) as f32;

/// The point at which rays end.
#[derive(Clone, Copy)]
pub(crate) struct CommonEnd {
    pub(crate) point: [f32; 3],
    /// Whether rays reach the point at their far ends instead of at t = 1.
    at_far: bool,
    /// The largest t at which hits do not count.
    threshold: f32,
}

impl CommonEnd {
    /// Estimates, from three rays, the point at which rays appear to end.
    #[inline(always)]
    pub(crate) fn of(rays: &[Ray], threshold: Threshold) -> Option<Self> {
        let [first, second, .., last] = rays else { return None };
        let threshold = threshold.get() as f32;
        for at_far in [false, true] {
            let tau = |ray: &Ray| if at_far { ray.t_max } else { 1.0 };
            let end = |ray: &Ray| [0, 1, 2].map(|k| ray.origin[k] + tau(ray) * ray.dir[k]);
            let point = end(first);
            // Three rays are enough for an estimate; `off` later measures the distance by which
            // every ray misses the point.
            let ends_there = |ray: &Ray| {
                let (apart, way) = (apart(end(ray), point), apart(ray.origin, point));
                ray.t_max <= tau(ray) && apart <= APART * (largest(point) + way)
            };
            if ends_there(first) && ends_there(second) && ends_there(last) {
                return Some(Self { point, at_far, threshold });
            }
        }
        None
    }
}

/// Returns the largest magnitude of a coordinate.
fn largest([x, y, z]: [f32; 3]) -> f32 {
    x.abs().max(y.abs()).max(z.abs())
}

/// Returns the largest distance between two points along an axis.
fn apart(a: [f32; 3], b: [f32; 3]) -> f32 {
    largest([a[0] - b[0], a[1] - b[1], a[2] - b[2]])
}

/// A mask of all sixteen lanes.
const ALL: u32 = 0xffff;

/// Reverses rays, sixteen at a time.
pub(crate) struct Reversal<F: Lanes> {
    end: CommonEnd,
    /// The largest distance from the point to the origin of a ray, along each axis.
    way: [F; 3],
    /// The largest distance by which the end of a ray misses the point, along each axis.
    off: [F; 3],
    /// The sum of the distances by which rays miss the point. Unlike a maximum, it preserves NaN.
    sum: F,
    shortest: F,
    sane: F::Mask,
    /// Whether the rays are copies of f64 rays.
    copies: bool,
}

impl<F: Lanes<Scalar = f32>> Reversal<F> {
    #[inline(always)]
    pub(crate) fn new(end: CommonEnd, copies: bool) -> Self {
        let (zero, sane) = (F::splat(0.0), F::Mask::from_bits(ALL));
        let shortest = F::splat(f32::INFINITY);
        Self { end, way: [zero; 3], off: [zero; 3], sum: zero, shortest, sane, copies }
    }

    /// Reverses rays, given as lanes of origins with `t_min` and directions with `t_max`. Also
    /// returns the `t_min` beyond which a hit is certain to count.
    #[inline(always)]
    pub(crate) fn reverse(&mut self, [origin, dir]: [[F; 4]; 2]) -> ([[F; 4]; 2], F) {
        let CommonEnd { point, at_far, threshold } = self.end;
        let ([.., t_min], [x, y, z, t_max]) = (origin, dir);
        let tau = if at_far { t_max } else { F::splat(1.0) };

        // Measure the distance by which rays miss the point. A sum preserves NaN, which a maximum
        // may lose.
        for k in 0..3 {
            let way = origin[k] - F::splat(point[k]);
            let off = dir[k].mul_add(tau, way).abs();
            // Track the maximum over all rays so far, lane by lane; `off` reduces it at the end.
            (self.way[k], self.off[k]) = (self.way[k].max(way.abs()), self.off[k].max(off));
            self.sum = self.sum + off;
        }
        self.shortest = self.shortest.min(tau);

        // Hits within the threshold are now beyond the far end. Reversing must not make any
        // interval empty.
        let start = F::select(t_min.lt(F::splat(threshold)), F::splat(threshold), t_min);
        let (near, far) = (tau - t_max, tau - start);
        let (before, after) = (t_min.lt(t_max), near.lt(far));
        self.sane = self.sane & t_max.le(tau) & ((before & after) | !(before | after));
        let mut sure = near;
        if self.copies {
            self.sane = self.sane & (start.le(tau * F::splat(BEGINS)) | !before);
            sure = near + tau * F::splat(ENDS);
        }
        ([[origin[0], origin[1], origin[2], near], [-x, -y, -z, far]], sure)
    }

    /// Returns the largest distance by which a ray misses the point, or `None` if a ray goes
    /// elsewhere or extends beyond the point, or if values are too large or too small.
    #[inline(always)]
    pub(crate) fn off(&self) -> Option<f32> {
        let Self { end: CommonEnd { point, threshold, .. }, way, off, sum, shortest, sane, .. } =
            self;
        let (way, off) = (length(way), length(off));
        let far_out = largest(*point) + way;
        let sane = sane.bits() & ALL == ALL
            && sum.le(F::splat(f32::MAX)).bits() & ALL == ALL
            && shortest.ge(F::splat(4.0 * threshold)).bits() & ALL == ALL
            && off <= 2.0 * APART * far_out
            && way > 1.0 / LARGEST
            && far_out < LARGEST;
        let rounding = if self.copies { 2.0 * ROUNDING } else { ROUNDING };
        sane.then_some(off * 1.001 + rounding * way)
    }
}

/// Returns the length of the vector formed by the largest lane along each axis.
#[inline(always)]
fn length<F: Lanes<Scalar = f32>>(v: &[F; 3]) -> f32 {
    let mut sum = 0.0;
    for lanes in v {
        let mut numbers = [0.0_f32; 16];
        lanes.store(&mut numbers);
        let most = numbers.into_iter().fold(0.0, f32::max);
        sum += most * most;
    }
    sum.sqrt()
}
