//! The order in which rays are traced: pixels that come in rows go tile by tile.
//!
//! Rays of one origin are fastest where 1024 in a row make a narrow cone. Rows of pixels are flat fans, so they
//! are taken as tiles of 32 by 32 instead, in Z-order. No answer depends on it.

use crate::scalar::Scalar;
use crate::source::Source;

/// Pixels a side of a tile.
pub(crate) const TILE: usize = 32;

/// Fewer rays are no picture.
const PICTURE: usize = 4 * TILE * TILE;

/// How many pixels the rows of a picture have: as the caller's shape says, or as the directions show.
/// `None` where rays are not of one origin or come in no rows.
pub(crate) fn row_width<S: Scalar>(rays: &Source<'_, S>, width: usize) -> Option<usize> {
    if rays.count < PICTURE {
        return None;
    }
    let [origin, _] = rays.line(0);
    let shares = |i: usize| rays.line(i)[0] == origin;
    if !(1..16).all(|k| shares(k * (rays.count - 1) / 15)) {
        return None;
    }
    let width = if width > 1 { width } else { seen_width(rays)? };
    (width >= TILE && rays.count / width >= TILE / 4).then_some(width)
}

/// How long rows are, as far as a look at some of them tells: after so many rays the direction jumps back, time
/// and again.
fn seen_width<S: Scalar>(rays: &Source<'_, S>) -> Option<usize> {
    let step = |i: usize, j: usize| {
        let ([_, a], [_, b]) = (rays.line(i), rays.line(j));
        [0, 1, 2].map(|k| b[k] - a[k])
    };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let along = step(0, 1);
    let width = 1 + (1..rays.count - 1).find(|&i| dot(step(i, i + 1), along) < 0.0)?;
    let rows = rays.count / width;
    if rows < 2 {
        return None;
    }
    let is_row = |row: usize| {
        let (first, last) = (row * width, row * width + width - 1);
        let across = step(first, last);
        let down = if row + 1 < rows { step(first, first + width) } else { [0.0; 3] };
        dot(across, along) > 0.0 && dot(down, down) < dot(across, across) / 4.0
    };
    (0..16).all(|k| is_row(k * (rows - 1) / 15)).then_some(width)
}

/// The pixels of a tile in Z-order: their x and y.
pub(crate) fn z_order() -> [(u8, u8); TILE * TILE] {
    let even = |n: usize| (0..5).map(|bit| (n >> (2 * bit) & 1) << bit).sum::<usize>() as u8;
    std::array::from_fn(|n| (even(n), even(n >> 1)))
}

/// The numbers of all rays of some rows, counted from the first, whole tiles in Z-order first, then what
/// is left at the ends.
pub(crate) fn tiled(width: usize, count: usize) -> Vec<u32> {
    let rows = count / width;
    let mut order = Vec::with_capacity(count);
    let z = z_order();
    let (across, down) = (width / TILE, rows / TILE);
    for tile in 0..across * down {
        let (x, y) = (tile % across * TILE, tile / across * TILE);
        order.extend(
            z.iter().map(|&(i, j)| ((y + usize::from(j)) * width + x + usize::from(i)) as u32),
        );
    }
    // Rows that are too few for a tile, by upright strips, then the right end of the others.
    for x in (0..width).step_by(TILE) {
        let end = (x + TILE).min(width);
        let first = if end - x == TILE { down * TILE } else { 0 };
        for y in first..rows {
            order.extend((x..end).map(|x| (y * width + x) as u32));
        }
    }
    order.extend((rows * width..count).map(|i| i as u32));
    order
}
