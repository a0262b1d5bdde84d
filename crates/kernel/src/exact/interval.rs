//! The part of a ray that counts, by its bits: no setting of the CPU changes it.

use super::quotient::Quotient;
use crate::{RayOf, Scalar};

/// `near <= t < far`, of `t > 0`.
#[derive(Clone, Copy)]
pub(super) struct Interval<S> {
    near: S,
    far: S,
}

impl<S: Scalar> Interval<S> {
    /// A ray's, unless nothing lies in it.
    #[inline(always)]
    pub(super) fn of(ray: &RayOf<S>) -> Option<Self> {
        // Negative ones and zeros begin at 0.
        // Ranks are the bits without the sign, and those of a NaN lie above infinity's.
        let nan = ray.t_min.rank() > S::ENDLESS || ray.t_max.rank() > S::ENDLESS;
        let near = if ray.t_min.is_negative() { S::ZERO } else { ray.t_min };
        let some = !nan && !ray.t_max.is_negative() && near.rank() < ray.t_max.rank();
        some.then_some(Self { near, far: ray.t_max })
    }

    /// Whether a `t > 0` lies in it; the quotient is made where that is asked.
    #[inline(always)]
    pub(super) fn contains(self, t: impl FnOnce() -> Quotient) -> bool {
        let (from_0, endless) = (self.near.rank() == 0, self.far.rank() == S::ENDLESS);
        if from_0 && endless {
            return true;
        }
        let t = t();
        (from_0 || t.cmp_float(self.near).is_ge()) && (endless || t.cmp_float(self.far).is_lt())
    }
}
