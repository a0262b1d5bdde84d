//! The triangles that rays skip.

use intertri::{Hit, Mode};
use intertri_trace::{Bvh, Query};

use crate::scalar::Scalar;

/// The triangles that rays skip. Every ray has the same number of entries; an entry of -1 skips
/// nothing.
#[derive(Clone, Copy)]
pub(crate) struct Skip<'a> {
    pub(crate) numbers: &'a [i32],
    pub(crate) each: usize,
}

impl Skip<'_> {
    /// Skips nothing.
    pub(crate) const NONE: Self = Self { numbers: &[], each: 0 };
}

/// Runs a query in which each ray ignores the triangles that it skips.
pub(crate) fn without<S: Scalar, A>(
    bvh: &Bvh<S>,
    mode: Mode,
    skip: Skip<'_>,
    ask: impl FnOnce(&mut Query<'_, S>) -> A,
) -> A {
    let query = S::in_mode(bvh.query(), mode);
    if skip.numbers.iter().all(|&number| number < 0) {
        return ask(&mut { query });
    }
    let hits = skip.numbers.iter().map(|&number| Hit { triangle: number as u32, ..Hit::MISS });
    let hits: Vec<Hit> = hits.collect();
    let lists: Vec<&[Hit]> = hits.chunks(skip.each).collect();
    ask(&mut query.skip(&lists))
}
