//! Pictures in numpy arrays: finds their rows and gathers them tile by tile, as the library does
//! with rays in memory.

use intertri::RayOf;
use intertri_trace::internal::{Band, Block, LOWEST, TILE};

use crate::pool::workers;
use crate::scalar::Scalar;
use crate::source::Source;

/// Fewer rays are not treated as a picture.
const PICTURE: usize = 4 * TILE * TILE;

/// A band of a picture for the threads of this pool.
pub(crate) fn band(width: usize, pixels: usize) -> Band {
    Band::of_picture(width, pixels, workers())
}

/// Gathers the rays of a block in the band that begins with the ray `first`.
pub(crate) fn gather<S: Scalar>(
    block: &Block<'_>,
    (rays, first): (&Source<'_, S>, usize),
    gathered: &mut Vec<RayOf<S>>,
) {
    gathered.resize(block.pixels(), RayOf::new([S::default(); 3], [S::default(); 3]));
    for (row, begins) in block.rows() {
        let begins = begins.iter().map(|&begin| begin.into());
        rays.put((first + row.start, row.len()), begins, gathered);
    }
}

/// Prefetches the rays of the block that comes next.
pub(crate) fn prefetch_next<S: Scalar>(block: &Block<'_>, (rays, first): (&Source<'_, S>, usize)) {
    for row in block.next_rows() {
        rays.prefetch((first + row.start).min(rays.count)..(first + row.end).min(rays.count));
    }
}

/// The number of pixels in a row of the picture, from the caller's shape or from the directions.
/// Returns `None` if the rays have several origins, do not form rows, or skip triangles.
pub(crate) fn row_width<S: Scalar>(rays: &Source<'_, S>, width: usize) -> Option<usize> {
    // Tiles contain only rays, without triangles to skip.
    if rays.count < PICTURE || rays.skips() {
        return None;
    }
    let [origin, _] = rays.line(0);
    let shares = |i: usize| rays.line(i)[0] == origin;
    if !(1..16).all(|k| shares(k * (rays.count - 1) / 15)) {
        return None;
    }
    let width = if width > 1 { width } else { seen_width(rays)? };
    (width >= TILE && rays.count / width >= LOWEST).then_some(width)
}

/// Guesses the width of a picture from some rows: the direction jumps back at the end of each row.
fn seen_width<S: Scalar>(rays: &Source<'_, S>) -> Option<usize> {
    let step = |i: usize, j: usize| {
        let ([_, a], [_, b]) = (rays.line(i), rays.line(j));
        [0, 1, 2].map(|k| b[k] - a[k])
    };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let along = step(0, 1);
    let width = 1 + (1..rays.count / LOWEST).find(|&i| dot(step(i, i + 1), along) < 0.0)?;
    let rows = rays.count / width;
    let is_row = |row: usize| {
        let (first, last) = (row * width, row * width + width - 1);
        let across = step(first, last);
        let down = if row + 1 < rows { step(first, first + width) } else { [0.0; 3] };
        dot(across, along) > 0.0 && dot(down, down) < dot(across, across) / 4.0
    };
    (0..16).all(|k| is_row(k * (rows - 1) / 15)).then_some(width)
}

/// The rays of a square picture, in the order in which they are traced.
pub(crate) fn tiled<S: Scalar>(rays: &Source<'_, S>) -> Vec<RayOf<S>> {
    let side = rays.count.isqrt();
    let (mut tiled, mut gathered) = (Vec::with_capacity(side * side), Vec::new());
    let whole = Band::new(side.max(1), TILE);
    for first in (0..side * side).step_by(whole.pixels()) {
        let band = whole.within(side * side - first);
        for block in band.blocks() {
            gather(&block, (rays, first), &mut gathered);
            tiled.extend_from_slice(&gathered);
        }
    }
    tiled
}
