//! Finds the pixels that an outline covers, in integer arithmetic, so that each centre on a shared
//! edge belongs to exactly one facet.
//!
//! Corners are on a grid of fractions of a pixel. Where an edge crosses the centre line of a row,
//! it marks the first pixel whose centre is not to the left of the crossing:
//!
//! ```text
//!     row's centre line   . . .\. . . . . . . ./. . . .     . pixel centres
//!                               \             /             The edge on the left runs down: +1 from
//!                            +1  |1 1 1 1 1 1| -1           there on; the one on the right runs up: -1.
//! ```
//!
//! The running sum along the row is the outline's winding number at each centre: +1 inside an
//! outline that runs counter-clockwise (y up), -1 inside a clockwise outline, and 0 outside.
//!
//! **Ownership.** An edge applies to the rows with `top <= centre < bottom` and to the pixels with
//! `crossing <= centre`. This is the top-left rule: a centre exactly on an edge belongs to the
//! facet to its right, or to the facet below it if the edge is horizontal. Two facets that share an
//! edge use the same integers for the edge, with opposite signs. The windings of a closed surface
//! therefore add up to 0 at every centre, and every centre is covered equally often by front and
//! back facets. There are no gaps and no overlaps, however thin the facets are.

use crate::view::SUBPIXEL_BITS;

/// The height of a band: the number of rows that are drawn together.
pub(crate) const BAND: u32 = 16;

const PIXEL: i64 = 1 << SUBPIXEL_BITS;
const HALF: i64 = PIXEL / 2;

/// The crossings of an outline with each row of one band, as pairs of a pixel and +1 or -1.
#[derive(Default)]
pub(crate) struct Crossings {
    rows: [Vec<(u32, i32)>; BAND as usize],
}

/// Returns the first row (or column) whose centre is at or after a coordinate.
pub(crate) fn first_centre(x: i32) -> u32 {
    ((i64::from(x) - HALF + PIXEL - 1) >> SUBPIXEL_BITS).max(0) as u32
}

impl Crossings {
    /// Calls `span(row, from, to, winding)` for each run of pixels `from..to` with a nonzero
    /// winding number in the rows `top..bottom`, which are in one band.
    #[inline(always)]
    pub(crate) fn spans(
        &mut self,
        outline: &[[i32; 2]],
        (top, bottom): (u32, u32),
        mut span: impl FnMut(u32, u32, u32, i32),
    ) {
        let Some(&last) = outline.last() else { return };
        let mut from = last;
        for &to in outline {
            self.edge(from, to, (top, bottom));
            from = to;
        }

        for row in top..bottom {
            let crossings = &mut self.rows[(row - top) as usize];
            crossings.sort_unstable_by_key(|&(x, _)| x);
            let mut winding = 0;
            let mut from = 0;
            for &(x, step) in &*crossings {
                if winding != 0 && from < x {
                    span(row, from, x, winding);
                }
                winding += step;
                from = x;
            }
            crossings.clear();
        }
    }

    /// Records where an edge crosses the rows.
    #[inline(always)]
    fn edge(&mut self, from: [i32; 2], to: [i32; 2], (top, bottom): (u32, u32)) {
        // Both facets at an edge must do the same arithmetic, so always start at the upper end.
        let (high, low, step) = if from[1] < to[1] { (from, to, 1) } else { (to, from, -1) };
        let first = first_centre(high[1]).max(top);
        let end = first_centre(low[1]).min(bottom);
        if first >= end {
            return;
        }

        // The crossing is at x = high.x + (centre - high.y) * dx / dy, and its pixel is the ceiling
        // of (x - HALF) / PIXEL. Compute this ceiling as a quotient, with a remainder, of integers
        // below 2^62.
        let dx = i64::from(low[0]) - i64::from(high[0]);
        let dy = i64::from(low[1]) - i64::from(high[1]);
        let below = i64::from(first) * PIXEL + HALF - i64::from(high[1]);
        let divisor = PIXEL * dy;
        let dividend = below * dx + (i64::from(high[0]) - HALF) * dy + (divisor - 1);
        let mut x = dividend.div_euclid(divisor);
        if end - first == 1 {
            self.rows[(first - top) as usize].push((x as u32, step));
            return;
        }
        let mut rest = dividend.rem_euclid(divisor);

        // From row to row, the crossing moves by dx / dy pixels.
        let x_step = dx.div_euclid(dy);
        let rest_step = dx.rem_euclid(dy) * PIXEL;
        for row in first..end {
            self.rows[(row - top) as usize].push((x as u32, step));
            x += x_step;
            rest += rest_step;
            if rest >= divisor {
                rest -= divisor;
                x += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn windings(outline: &[[i32; 2]], width: u32, height: u32) -> Vec<i32> {
        let mut sums = vec![0; (width * height) as usize];
        let mut crossings = Crossings::default();
        for top in (0..height).step_by(BAND as usize) {
            let rows = (top, (top + BAND).min(height));
            crossings.spans(outline, rows, |row, from, to, winding| {
                for x in from..to {
                    sums[(row * width + x) as usize] += winding;
                }
            });
        }
        sums
    }

    fn random(state: &mut u64, limit: i32) -> i32 {
        *state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((*state >> 33) % (limit as u64 + 1)) as i32
    }

    #[test]
    fn a_square_owns_its_top_and_left_edges() {
        // The square's corners are pixel centres. It covers 2×2 pixels, not 3×3.
        let p = |x: i32, y: i32| [x * (1 << 16) + (1 << 15), y * (1 << 16) + (1 << 15)];
        let square = [p(1, 1), p(1, 3), p(3, 3), p(3, 1)];
        let sums = windings(&square, 5, 20);
        let covered: Vec<_> = (0..100).filter(|&i| sums[i] == 1).collect();
        assert_eq!(covered, [6, 7, 11, 12]);
        assert!(sums.iter().all(|&w| w == 0 || w == 1));
    }

    #[test]
    fn crossings_are_those_of_whole_number_cross_products() {
        // Compute document B's test in i128, with the ownership rule for centres on edges.
        let mut state = 7;
        let (width, height) = (40_u32, 40_u32);
        for round in 0..400 {
            // Coarse coordinates put corners and edges exactly on centres.
            let grid = [1, 1 << 13, 1 << 15][round % 3];
            let mut corner = || [0, 1].map(|_| random(&mut state, (40 << 16) / grid) * grid);
            let outline = [corner(), corner(), corner()];
            let sums = windings(&outline, width, height);
            for y in 0..height {
                for x in 0..width {
                    let p = [x, y].map(|c| i128::from(c) * (1 << 16) + (1 << 15));
                    let mut winding = 0;
                    for k in 0..3 {
                        let [a, b] = [outline[k], outline[(k + 1) % 3]].map(|c| c.map(i128::from));
                        let (a, b, sign) = if a[1] < b[1] { (a, b, 1) } else { (b, a, -1) };
                        let side = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
                        if a[1] <= p[1] && p[1] < b[1] && side <= 0 {
                            winding += sign;
                        }
                    }
                    assert_eq!(sums[(y * width + x) as usize], winding, "{outline:?} at {x}, {y}");
                }
            }
        }
    }

    #[test]
    fn a_cut_up_square_is_covered_once() {
        // A square is divided into a fan of slivers around an inner point. Together, the slivers
        // must cover each pixel centre in the square exactly once.
        let mut state = 3;
        for _ in 0..50 {
            let side = 32 << 16;
            let mut rim: Vec<[i32; 2]> = (0..60).map(|_| [random(&mut state, side), 0]).collect();
            rim.sort_unstable();
            rim.insert(0, [0, 0]);
            rim.push([side, 0]);
            rim.extend([[side, side], [0, side], [0, 0]]);
            let inner = [random(&mut state, side), random(&mut state, side)];
            let mut total = vec![0; 32 * 32];
            for pair in rim.windows(2) {
                for (sum, w) in total.iter_mut().zip(windings(&[pair[0], pair[1], inner], 32, 32)) {
                    *sum += w;
                    assert!(w <= 0, "every sliver must run clockwise");
                }
            }
            assert!(total.iter().all(|&w| w == -1));
        }
    }
}
