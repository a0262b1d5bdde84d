//! Transforms rays to the units of a tree for the slab test.

use intertri::Ray;
use intertri::simd::{Lanes, Mask, Simd};

use super::matrix::{TreeRay, largest};
use crate::tree::Margin;
use crate::walk::single::{Slabs, octant};

/// In the slab test, the magnitude of every coordinate of the origin must be below this (2^49).
const FAR: f64 = (1_u64 << 49) as f64;

/// The length of the shortest direction allowed (2^-900). The longest allowed is the inverse.
const SHORT: f64 = f64::from_bits((1023 - 900) << 52);

/// Directions up to this length (2^40), and not shorter than its inverse, need no scaling.
const LONG: f64 = (1_u64 << 40) as f64;

impl<D: Lanes<Scalar = f64>> TreeRay<D> {
    /// Scales directions by powers of two if any is very long or short, because the error bounds of
    /// the slab test exclude extreme lengths. Returns the scaled rays, the factors that convert t to
    /// their units, and a mask of the rays that are in range for the slab test.
    #[inline(always)]
    pub(super) fn scaled(self) -> (Self, D, D::Mask) {
        let Self { origin, dir, room } = self;
        let splat = D::splat;
        // Test each axis separately, because `max` may hide a NaN.
        let (at, along, most) = (origin.abs(), dir.abs(), splat(1.0 / SHORT));
        let is_near = at.x.lt(splat(FAR)) & at.y.lt(splat(FAR)) & at.z.lt(splat(FAR));
        let is_bounded = along.x.le(most) & along.y.le(most) & along.z.le(most);
        let length = largest(dir);
        let is_sane = is_near & is_bounded & length.ge(splat(SHORT));
        let is_ordinary = length.ge(splat(1.0 / LONG)) & length.le(splat(LONG));
        // A predicted branch, because the slab test waits for the direction.
        if !(!is_ordinary).any() {
            return (self, splat(1.0), is_sane);
        }
        // Scaling by a power of two is exact.
        let unit = length.power();
        let dir = dir * (splat(1.0) / unit);
        (Self { origin, dir, room }, unit, is_sane)
    }
}

/// A ray in a tree's units. Its direction may be scaled by a power of two.
pub(super) struct TreeSlabs {
    pub(super) slabs: Slabs,
    pub(super) octant: usize,
    /// The power of two that converts the ray's t to the slabs' units.
    pub(super) unit: f64,
}

impl TreeSlabs {
    /// Returns `None` if the ray's values are too large or too small for the slab test.
    #[inline(always)]
    pub(super) fn new<S: Simd>(ray: TreeRay<f64>, reach: f32) -> Option<Self> {
        let (TreeRay { origin, dir, room }, unit, is_sane) = ray.scaled();
        if !is_sane {
            return None;
        }
        let scaled = Ray::new(
            [origin.x as f32, origin.y as f32, origin.z as f32],
            [dir.x as f32, dir.y as f32, dir.z as f32],
        );
        let room = (room as f32).next_up();
        let slabs = Slabs::new::<S>(&scaled, &Margin::new(reach, Some(room)))?;
        Some(Self { slabs, octant: octant(&scaled), unit })
    }
}

/// Multiplying a positive normal f32 by this moves it down by at least one ulp. For a subnormal
/// number, also subtract [`f32::MIN_POSITIVE`].
const DOWN: f32 = 1.0 - f32::EPSILON;

/// Multiplying a positive normal f32 by this moves it up by at least one ulp. For a subnormal
/// number, also add [`f32::MIN_POSITIVE`].
const UP: f32 = 1.0 + f32::EPSILON;

/// Converts a t to the slabs' units and rounds it down, but not below 0.
#[inline(always)]
pub(super) fn rounded_down(t: f64, unit: f64) -> f32 {
    lowered((t * unit) as f32)
}

/// Converts a t to the slabs' units and rounds it up. NaN stays NaN.
#[inline(always)]
pub(super) fn rounded_up(t: f64, unit: f64) -> f32 {
    raised((t * unit) as f32)
}

/// Like [`rounded_down`], but for sixteen values of t, each with its own factor.
#[inline(always)]
pub(super) fn all_rounded_down<S: Simd>(t: &[f64; 16], unit: &[f64; 16]) -> S::F32x16 {
    lowered(in_f32::<S>(t, unit))
}

/// Like [`rounded_up`], but for sixteen values of t, each with its own factor.
#[inline(always)]
pub(super) fn all_rounded_up<S: Simd>(t: &[f64; 16], unit: &[f64; 16]) -> S::F32x16 {
    raised(in_f32::<S>(t, unit))
}

/// Rounds down by at least one ulp, but not below 0.
#[inline(always)]
fn lowered<F: Lanes<Scalar = f32>>(t: F) -> F {
    let finite = t.min(F::splat(f32::MAX));
    (finite * F::splat(DOWN) - F::splat(f32::MIN_POSITIVE)).max(F::splat(0.0))
}

/// Rounds up by at least one ulp. Negative values need not be rounded, because hits have no
/// negative t.
#[inline(always)]
fn raised<F: Lanes<Scalar = f32>>(t: F) -> F {
    t * F::splat(UP) + F::splat(f32::MIN_POSITIVE)
}

#[inline(always)]
fn in_f32<S: Simd>(t: &[f64; 16], unit: &[f64; 16]) -> S::F32x16 {
    let mut rounded = [0.0; 16];
    for first in [0, 8] {
        let t = S::F64x8::load(&t[first..]) * S::F64x8::load(&unit[first..]);
        t.store_f32(&mut rounded[first..]);
    }
    S::F32x16::load(&rounded)
}

#[cfg(test)]
mod tests {
    use intertri::simd::{Lanes, Level, Simd, WithSimd};

    use super::{all_rounded_down, all_rounded_up, rounded_down, rounded_up};

    struct Both([f64; 16], [f64; 16]);

    impl WithSimd for Both {
        type Output = [[f32; 16]; 2];
        #[inline(always)]
        fn run<S: Simd>(self) -> [[f32; 16]; 2] {
            let mut both = [[0.0; 16]; 2];
            all_rounded_down::<S>(&self.0, &self.1).store(&mut both[0]);
            all_rounded_up::<S>(&self.0, &self.1).store(&mut both[1]);
            both
        }
    }

    #[test]
    fn ends_are_rounded_outward() {
        let (least, most) = (f32::from_bits(1), f32::MAX);
        let some = [0.0, least, f32::MIN_POSITIVE, 0.7, 1.0, 1.0_f32.next_down(), 3e30, most];
        for t in some {
            // Try values of t that round to this f32 or to an adjacent one.
            let (below, above) = (f64::from(t.next_down()), f64::from(t.next_up()));
            let near = [f64::from(t), 0.5 * (below.max(0.0) + f64::from(t)), above.min(1e300)];
            for (unit, t) in [1.0, 0.125, 1024.0].iter().flat_map(|u| near.map(|t| (*u, t / u))) {
                let exact = t * unit;
                let (down, up) = (rounded_down(t, unit), rounded_up(t, unit));
                assert!(f64::from(down) <= exact && f64::from(up) >= exact, "{t} {unit}");
                assert!(down < up && down >= 0.0, "{t} {unit}");
                for level in Level::all() {
                    let [downs, ups] = level.run(Both([t; 16], [unit; 16]));
                    let numbers = downs.into_iter().chain(ups);
                    for (i, x) in numbers.enumerate() {
                        let alone = if i < 16 { down } else { up };
                        assert_eq!(x, alone, "{}: {t} {unit}", level.name());
                    }
                }
            }
        }
        assert_eq!(rounded_down(f64::NEG_INFINITY, 1.0), 0.0);
        assert_eq!(rounded_up(f64::INFINITY, 1.0), f32::INFINITY);
        assert!(rounded_up(f64::NAN, 1.0).is_nan());
    }
}
