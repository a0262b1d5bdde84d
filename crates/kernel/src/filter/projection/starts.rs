//! The near ends of the rays' intervals, as depths on the projection.

use super::super::bound;
use super::super::edges::at_least;
use super::frame::{Apex, Points};
use crate::Threshold;
use crate::simd::Lanes;

/// For each lane, the depths at which the intervals of rays from one or more packets begin.
///
/// ```
/// use intertri::internal::{Apex, Points, Ranges, Starts};
/// use intertri::Mode;
/// let points = Points { x: 0.0_f32, y: 0.0, z: 1.0 };
/// let filter = Mode::certified().filter();
/// let starts = filter.starts_in(&Starts::none(Apex::Finite), &points, [2.0; 2], true);
/// let from_two_on: Ranges<f32> = starts.ranges();
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Starts<F> {
    apex: Apex,
    /// A hit beyond this depth is certainly past the near ends of all rays.
    last: F,
    /// A hit before this depth is certainly too near for all rays.
    first: F,
}

impl<F: Lanes<Scalar = f32>> Starts<F> {
    /// Returns the starts of an empty set of rays.
    #[inline(always)]
    pub fn none(apex: Apex) -> Self {
        let last = match apex {
            Apex::Finite => 0.0,
            Apex::AtInfinity { .. } => f32::NEG_INFINITY,
        };
        Self { apex, last: F::splat(last), first: F::splat(f32::INFINITY) }
    }

    /// Adds the live rays of another packet. The hits of these rays must be beyond `threshold` and
    /// the near end. `t_min` is a lower bound on the near end, and `sure` is an upper bound.
    #[inline(always)]
    pub(in super::super) fn with(
        &self,
        points: &Points<F>,
        [t_min, sure]: [F; 2],
        live: F::Mask,
        threshold: Threshold,
    ) -> Self {
        let [last, first] = match self.apex {
            // Avoid subnormal products: their rounding error exceeds `INVERSE`, and some CPUs take a
            // hundred times as long to compute them.
            Apex::Finite => {
                let least = F::splat(bound::SHORTEST_T);
                let above = at_least(sure, threshold.above.max(bound::SHORTEST_T));
                let below = at_least(t_min, threshold.below.max(0.0));
                let below = F::select(below.lt(least), F::splat(0.0), below);
                [above * points.z, below * points.z]
            }
            Apex::AtInfinity { .. } => [points.z + sure, points.z + t_min],
        };
        Self {
            apex: self.apex,
            last: F::select(live, self.last.max(last), self.last),
            first: F::select(live, self.first.min(first), self.first),
        }
    }

    /// Converts the starts to inverse depths.
    #[inline(always)]
    pub fn ranges(&self) -> Ranges<F> {
        let (zero, one) = (F::splat(0.0), F::splat(1.0));
        if let Apex::AtInfinity { .. } = self.apex {
            let (near_lo, _) = self.apex.inverse(self.last, zero);
            let (_, near_hi) = self.apex.inverse(self.first, zero);
            return Ranges { near_lo, near_hi };
        }
        // If a ray's interval begins at its origin, `first` is 0, and no inverse depth is too
        // large.
        let near_hi = one / self.first * F::splat(1.0 + bound::INVERSE);
        Ranges {
            near_lo: one / self.last * F::splat(1.0 - bound::INVERSE),
            near_hi: F::select(self.first.gt(zero), near_hi, F::splat(f32::INFINITY)),
        }
    }
}

/// The near ends of the rays' intervals, as inverse depths.
///
/// ```
/// use intertri::internal::{Apex, Ranges, Starts};
/// let of_no_ray: Ranges<f32> = Starts::none(Apex::Finite).ranges();
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Ranges<F> {
    /// A hit with a smaller inverse depth is certainly past the near ends of all rays.
    pub(super) near_lo: F,
    /// A hit with a larger inverse depth is certainly too near for all rays.
    pub(super) near_hi: F,
}
