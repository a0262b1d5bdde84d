//! The part of a ray that counts, by its bits: no setting of the CPU changes it.

use super::quotient::Quotient;
use crate::Ray;

const SIGN: u32 = 1 << 31;
const ENDLESS: u32 = f32::INFINITY.to_bits();

/// `near <= t < far`, of `t > 0`.
#[derive(Clone, Copy)]
pub(super) struct Interval {
    near: f32,
    far: f32,
}

impl Interval {
    /// A ray's, unless nothing lies in it.
    #[inline(always)]
    pub(super) fn of(ray: &Ray) -> Option<Self> {
        let (near, far) = (ray.t_min.to_bits(), ray.t_max.to_bits());
        // Negative ones, zeros and the NaN among them.
        let nan = (near & !SIGN) > ENDLESS;
        let near = if near & SIGN != 0 { 0 } else { near };
        // Positive ones are in the order of their bits, a NaN above infinity and what has a sign above all.
        let some = !nan && near < far && far <= ENDLESS;
        some.then_some(Self { near: f32::from_bits(near), far: f32::from_bits(far) })
    }

    /// Whether a `t > 0` lies in it; the quotient is made where that is asked.
    #[inline(always)]
    pub(super) fn contains(self, t: impl FnOnce() -> Quotient) -> bool {
        let (from_0, endless) = (self.near.to_bits() == 0, self.far.to_bits() == ENDLESS);
        if from_0 && endless {
            return true;
        }
        let t = t();
        (from_0 || t.cmp_float(self.near).is_ge()) && (endless || t.cmp_float(self.far).is_lt())
    }
}
