//! What the filter says of each lane.

use crate::intersect::{Counts, Found};
use crate::simd::Lanes;

/// What the bound says of each lane. A lane that is in neither mask is a miss.
#[derive(Clone, Copy)]
pub(crate) struct Decided<F> {
    /// A hit, but for the far end of the interval.
    pub(crate) hit: u32,
    /// Undecided: to be resolved.
    pub(crate) undecided: u32,
    /// Where [`Decided::hit`]: an enclosure of the reference's t.
    pub(crate) t_lo: F,
    /// See [`Decided::t_lo`].
    pub(crate) t_hi: F,
}

/// What is known of the lanes: a sure hit keeps its enclosure of t, for who needs the bits asks for them.
#[inline(always)]
pub(super) fn found<F: Copy, D: Lanes<Scalar = f64>>(
    decided: &Decided<F>,
    counts: &mut Counts,
) -> Found<F, D> {
    let Decided { hit, undecided, t_lo, t_hi } = *decided;
    counts.undecided += u64::from(undecided.count_ones());
    Found { near: hit, exact: 0, undecided, t_lo, t_hi, t: D::splat(0.0) }
}
