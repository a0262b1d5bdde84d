//! A ray's interval, tested on its bits, so that no CPU setting can affect the result.

use super::quotient::Quotient;
use crate::{RayOf, Scalar};

/// The interval `near <= t < far`, for `t > 0`.
#[derive(Clone, Copy)]
pub(super) struct Interval<S> {
    near: S,
    far: S,
}

impl<S: Scalar> Interval<S> {
    /// Returns the interval of a ray, or `None` if it is empty.
    #[inline(always)]
    pub(super) fn of(ray: &RayOf<S>) -> Option<Self> {
        // A negative or zero start becomes 0. Ranks are the bits without the sign; the rank of NaN
        // is above that of infinity.
        let nan = ray.t_min.rank() > S::ENDLESS || ray.t_max.rank() > S::ENDLESS;
        let near = if ray.t_min.is_negative() { S::ZERO } else { ray.t_min };
        let some = !nan && !ray.t_max.is_negative() && near.rank() < ray.t_max.rank();
        some.then_some(Self { near, far: ray.t_max })
    }

    /// Returns whether the interval contains t, which must be positive. The quotient is computed
    /// only if it has to be compared with an end.
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
