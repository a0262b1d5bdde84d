//! Axis-aligned bounding boxes.
//!
//! Corners have four lanes instead of three, so that a union takes two vector instructions. The
//! fourth lane is unused.

use bytemuck::Zeroable;
use intertri::Triangle;

/// The closed box `lo <= p <= hi`. Building a box from a triangle and joining boxes do not round.
#[derive(Clone, Copy, Debug, PartialEq, Zeroable)]
#[repr(C, align(16))]
pub(crate) struct Aabb {
    pub lo: [f32; 4],
    pub hi: [f32; 4],
}

impl Aabb {
    /// The empty box. The union of this box and another is the other box.
    pub(crate) const EMPTY: Self = Self { lo: [f32::INFINITY; 4], hi: [f32::NEG_INFINITY; 4] };

    /// Returns the box of a triangle, or `None` if a corner is not finite; such a triangle is never
    /// hit.
    pub(crate) fn of(triangle: &Triangle) -> Option<Self> {
        let [a, b, c] = triangle.0.map(|p| [p[0], p[1], p[2], 0.0]);
        // Zero times NaN or infinity is NaN, and a sum that includes NaN is NaN.
        let sum: f32 = triangle.0.iter().flatten().map(|x| x * 0.0).sum();
        (sum == 0.0).then(|| Self { lo: min(min(a, b), c), hi: max(max(a, b), c) })
    }

    /// Returns the box padded by `by` on every side.
    pub(crate) fn padded(self, by: f32) -> Self {
        // The padding and the sum are both rounded. Moving each of them outward by one ulp covers
        // the errors.
        let by = by.next_up();
        Self { lo: self.lo.map(|x| (x - by).next_down()), hi: self.hi.map(|x| (x + by).next_up()) }
    }

    /// Returns whether all sides are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.lo.iter().chain(&self.hi).all(|x| x.is_finite())
    }

    /// Returns the box, with every subnormal side moved outward to 0 or to the smallest normal
    /// number. A box inside another one stays inside it.
    #[inline(always)]
    pub(crate) fn without_subnormal_sides(&self) -> Self {
        // Test the bits, because the CPU may be set to read subnormal numbers as 0.
        let least = f32::MIN_POSITIVE.to_bits();
        let is_subnormal = |x: f32| (1..least).contains(&(x.to_bits() << 1 >> 1));
        let lower = |x: f32| if x.is_sign_negative() { -f32::MIN_POSITIVE } else { 0.0 };
        let upper = |x: f32| if x.is_sign_negative() { 0.0 } else { f32::MIN_POSITIVE };
        Self {
            lo: self.lo.map(|x| if is_subnormal(x) { lower(x) } else { x }),
            hi: self.hi.map(|x| if is_subnormal(x) { upper(x) } else { x }),
        }
    }

    /// Extends this box to contain another one.
    #[inline(always)]
    pub(crate) fn join(&mut self, other: &Self) {
        self.lo = min(self.lo, other.lo);
        self.hi = max(self.hi, other.hi);
    }

    /// Returns twice the centre of the box, in units of `1 / scale`.
    #[inline(always)]
    pub(crate) fn centre(&self, scale: f32) -> [f32; 4] {
        let (a, b, s) = (self.lo, self.hi, scale);
        [a[0] * s + b[0] * s, a[1] * s + b[1] * s, a[2] * s + b[2] * s, 0.0]
    }

    /// Returns half the surface area in units of `1 / scale²`; infinite for the empty box.
    #[inline(always)]
    pub(crate) fn half_area(&self, scale: f32) -> f32 {
        let (a, b, s) = (self.lo, self.hi, scale);
        let d = [b[0] * s - a[0] * s, b[1] * s - a[1] * s, b[2] * s - a[2] * s];
        // xy + xz + yz is half the surface area.
        d[0] * (d[1] + d[2]) + d[1] * d[2]
    }

    /// Returns a power of two that scales the longest side to about 1, so that no area overflows or
    /// underflows, whatever the scene's unit of length. For a box that is tiny relative to its
    /// distance from the coordinate origin, the scale is smaller, so that coordinates do not
    /// overflow either.
    pub(crate) fn scale(&self) -> f32 {
        let side = |k: usize| self.hi[k] as f64 - self.lo[k] as f64;
        let away =
            |k: usize| self.hi[k].abs().max(self.lo[k].abs()) as f64 * 100_f64.exp2().recip();
        let size = (0..3).map(|k| side(k).max(away(k))).fold(1e-300, f64::max);
        size.log2().floor().clamp(-126.0, 126.0).exp2().recip() as f32
    }
}

// `min` and `max` use comparisons instead of `f32::min` and `f32::max`: a comparison takes one
// instruction, and NaN does not occur. If two values are equal (zeros of either sign), the later
// value wins, which keeps the operation associative.
#[inline(always)]
fn min(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|k| if a[k] < b[k] { a[k] } else { b[k] })
}

#[inline(always)]
fn max(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|k| if a[k] > b[k] { a[k] } else { b[k] })
}
