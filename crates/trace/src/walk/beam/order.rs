//! Sorts points so that lines through successive points are close together.
//!
//! ```text
//!   ╷ │ ╵ │      Strips of the plane perpendicular to the direction run alternately up and down.
//!   │ │ │ │      Each is as wide as the stretch that sixteen of its points occupy.
//!   ╵ │ ╷ │
//! ```

use std::mem::replace;

use super::tube::ProjectionPlane;
use crate::util::crowd::crowd;
use crate::util::memory::{NoMemory, zeros};
use crate::util::threads;

/// The approximate number of points in each row of a strip.
const ROW: usize = 2;

/// The minimum number of points that a thread processes per task.
const LEAST: usize = 1 << 12;

/// Returns the indices of the points, ordered so that lines through successive points are close
/// together.
pub(crate) fn order<P: Copy + Into<f64> + Sync>(
    points: &[[P; 3]],
    dir: [f64; 3],
) -> Result<Vec<u32>, NoMemory> {
    let (strips, count) = (Strips::of(points, dir), points.len());
    let mut cells = zeros(count)?;
    threads::write(&mut cells, LEAST, |i| strips.cell(points[i]));

    // Count the points in each cell and turn the counts into start offsets. Placing the points then
    // advances the start offsets to end offsets.
    let mut ends = zeros::<u32>(strips.cells())?;
    for &cell in &cells {
        ends[cell as usize] += 1;
    }
    let mut begin = 0;
    for end in &mut ends {
        begin += replace(end, begin);
    }
    let mut order = zeros(count)?.into_vec();
    for (i, &cell) in (0..).zip(&cells) {
        let at = &mut ends[cell as usize];
        order[*at as usize] = i;
        *at += 1;
    }
    Ok(order)
}

/// A rectangle that is divided into strips, each of which is divided into rows.
struct Strips {
    across: ProjectionPlane,
    lo: [f64; 2],
    scale: [f64; 2],
    /// The index of the last strip, and the index of the last row in a strip.
    last: [u32; 2],
}

impl Strips {
    /// Creates the strips for a set of points.
    fn of<P: Copy + Into<f64>>(points: &[[P; 3]], dir: [f64; 3]) -> Self {
        let across = ProjectionPlane::new(dir);
        let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            let at = across.place(point.map(Into::into));
            for k in 0..2 {
                if at[k].is_finite() {
                    lo[k] = lo[k].min(at[k]);
                    hi[k] = hi[k].max(at[k]);
                }
            }
        }
        // A few points far away would make all other points share a cell. Limit the rectangle to
        // the surroundings of most points; the others go to the cells at its sides.
        let most = crowd(points.iter().map(|&point| {
            let [a, b] = across.place(point.map(Into::into));
            [a, b, 0.0]
        }));
        for k in 0..2 {
            let size = most[1][k] - most[0][k];
            if size > 0.0 {
                lo[k] = lo[k].max(most[0][k] - 0.5 * size);
                hi[k] = hi[k].min(most[1][k] + 0.5 * size);
            }
        }
        let [width, height] = [0, 1].map(|k| (hi[k] - lo[k]).max(f64::MIN_POSITIVE));
        // If points are extremely far apart, a width may be infinite and the ratio NaN. In that
        // case, use the maximum.
        let some = |count: f64, most: f64| count.ceil().min(most).max(1.0);
        let count = points.len() as f64;
        let strips = some((count / 16.0 * (width / height)).sqrt(), 4096.0);
        let rows = some(count / (ROW as f64 * strips), 65536.0);
        let last = [strips as u32 - 1, rows as u32 - 1];
        Self { across, lo, scale: [strips / width, rows / height], last }
    }

    fn cells(&self) -> usize {
        (self.last[0] as usize + 1) * (self.last[1] as usize + 1)
    }

    /// Returns the cell of a point.
    #[inline(always)]
    fn cell<P: Copy + Into<f64>>(&self, point: [P; 3]) -> u32 {
        let at = self.across.place(point.map(Into::into));
        // NaN is converted to 0.
        let cell = |k: usize| (((at[k] - self.lo[k]) * self.scale[k]) as u32).min(self.last[k]);
        let (strip, row) = (cell(0), cell(1));
        // Go up one strip and down the next, so that successive points are neighbours in the plane.
        let row = if strip % 2 == 0 { row } else { self.last[1] - row };
        strip * (self.last[1] + 1) + row
    }
}

#[cfg(test)]
mod tests {
    use super::order;
    use crate::util::test_numbers::random;

    /// Checks that every point occurs exactly once, and that successive points are close in the
    /// plane perpendicular to the direction, even if one point is not finite, one is very far away,
    /// and two coincide.
    #[test]
    fn neighbours_are_close_across_the_direction() {
        let mut random = random();
        let dir = [0.5, 0.3, 0.8];
        let mut points: Vec<[f32; 3]> = (0..40_000).map(|_| [0; 3].map(|_| random())).collect();
        points[7] = [f32::NAN, 0.0, f32::INFINITY];
        points[9] = points[8];
        points[11] = [f32::MAX, -f32::MAX, 0.0];
        let order = order(&points, dir).unwrap();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..40_000));

        let across = |i: u32| {
            let [x, y, z] = points[i as usize].map(f64::from);
            [x - z * dir[0] / dir[2], y - z * dir[1] / dir[2]]
        };
        let apart = |pair: &[u32]| {
            let (a, b) = (across(pair[0]), across(pair[1]));
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        let near = order.windows(2).filter(|pair| apart(pair) < 0.05).count();
        assert!(near > 39_900, "{near}");
    }

    /// Tests small numbers of points that coincide or whose distances are too large to be finite.
    #[test]
    fn any_points_have_an_order() {
        for count in [0, 1, 2, 17] {
            let far = |i: usize| {
                [1.7e308, 0.0, -1.7e308].map(|x| if i.is_multiple_of(2) { x } else { -x })
            };
            let same = |x: f64| vec![[x; 3]; count];
            for points in [same(1.0), same(f64::NAN), (0..count).map(far).collect()] {
                for dir in [[0.0, -1.0, 0.0], [0.5, 0.3, 0.8]] {
                    let mut order = order(&points, dir).unwrap();
                    order.sort_unstable();
                    assert!(order.into_iter().eq(0..count as u32));
                }
            }
        }
    }
}
