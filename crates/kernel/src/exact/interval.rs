//! A ray's interval, tested on its bits, so that no CPU setting can affect the result.

use super::quotient::Quotient;
use super::scale::Dyadic;
use crate::{RayOf, Scalar};

/// The interval `near <= t < far`, for `t > 0`.
#[derive(Clone, Copy)]
pub(super) struct Interval {
    /// `None` if it is 0.
    near: Option<Dyadic>,
    /// `None` if it is infinite.
    far: Option<Dyadic>,
}

impl Interval {
    /// Returns the interval of a ray, or `None` if it is empty.
    #[inline(always)]
    pub(super) fn of<S: Scalar>(ray: &RayOf<S>) -> Option<Self> {
        // A negative or zero start becomes 0. Ranks are the bits without the sign; the rank of NaN
        // is above that of infinity.
        let nan = ray.t_min.rank() > S::ENDLESS || ray.t_max.rank() > S::ENDLESS;
        let near = if ray.t_min.is_negative() { S::ZERO } else { ray.t_min };
        let some = !nan && !ray.t_max.is_negative() && near.rank() < ray.t_max.rank();
        // The near end is below the far end, so it is finite, and the far end is not 0.
        let end = |x: S| (x.rank() != 0 && x.is_finite()).then(|| Dyadic::of(x));
        some.then(|| Self { near: end(near), far: end(ray.t_max) })
    }

    /// Returns whether the interval contains t, which must be positive. The quotient is computed
    /// only if it has to be compared with an end.
    #[inline(always)]
    pub(super) fn contains(self, t: impl FnOnce() -> Quotient) -> bool {
        let Self { near, far } = self;
        if near.is_none() && far.is_none() {
            return true;
        }
        let t = t();
        near.is_none_or(|near| t.cmp_number(near).is_ge())
            && far.is_none_or(|far| t.cmp_number(far).is_lt())
    }
}
