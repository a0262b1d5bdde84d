//! Finds the principal axis of a bundle, which is the direction in which its rays spread most.
//!
//! ```text
//!   ┌──────────┐
//!   │      . ∙ │          ┌──────────┐     Seen from a light, a slanted surface looks like a
//!   │  . ∙ '   │   ──►    │ ∙ ∙ ∙ ∙  │     sliver. Rectangles along the axes of the sliver
//!   │ ∙ '      │          └──────────┘     contain little else.
//!   └──────────┘
//! ```

use intertri::simd::Lanes;

use crate::util::lane_ops::total;

/// Sums of directions and of their products, relative to one of the directions to reduce rounding
/// errors.
pub(crate) struct Spread<F> {
    about: [f32; 3],
    count: usize,
    sum: [F; 3],
    /// The sums of products of components: `squares[i][k]` for i <= k.
    squares: [[F; 3]; 3],
}

impl<F: Lanes<Scalar = f32>> Spread<F> {
    /// Creates empty sums. The directions added later should be close to `dir`.
    #[inline(always)]
    pub(crate) fn about(dir: [f32; 3]) -> Self {
        let zero = F::splat(0.0);
        Self { about: dir, count: 0, sum: [zero; 3], squares: [[zero; 3]; 3] }
    }

    /// Adds directions.
    #[inline(always)]
    pub(crate) fn add(&mut self, dirs: [F; 3]) {
        let mut off = dirs;
        for k in 0..3 {
            // Subtract one of the directions, because a small spread would be lost in sums of large
            // squares.
            off[k] = dirs[k] - F::splat(self.about[k]);
            self.sum[k] = self.sum[k] + off[k];
        }
        for i in 0..3 {
            for k in i..3 {
                self.squares[i][k] = off[i].mul_add(off[k], self.squares[i][k]);
            }
        }
        self.count += F::N;
    }

    /// Returns the axis of greatest spread in the image plane, if the directions spread at least
    /// twice as far along this axis as across it. Returns `None` if there is no such axis, or if it
    /// nearly coincides with `right` or `up`.
    #[inline(always)]
    pub(crate) fn principal_axis(&self, [right, up]: [[f32; 3]; 2]) -> Option<[f32; 3]> {
        // Compute the sums of x x, x y, and y y relative to the mean, where x and y are the
        // components along `right` and `up`.
        let sum = [total(self.sum[0]), total(self.sum[1]), total(self.sum[2])];
        let count = self.count as f32;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for i in 0..3 {
            for k in 0..3 {
                let about = sum[i] * sum[k] / count;
                let square = total(self.squares[i.min(k)][i.max(k)]) - about;
                xx += square * right[i] * right[k];
                xy += square * right[i] * up[k];
                yy += square * up[i] * up[k];
            }
        }

        // No axis is needed if the spread is almost aligned with `right` or `up`, and none can be
        // found if it is not finite.
        if 16.0 * xy * xy <= xx * yy || !(xx + yy).is_finite() {
            return None;
        }
        // Compute twice the eigenvalues of the symmetric matrix [xx xy; xy yy].
        let root = ((xx - yy) * (xx - yy) + 4.0 * xy * xy).sqrt();
        let (most, least) = (xx + yy + root, xx + yy - root);
        let [x, y] =
            if xx > yy { [most - 2.0 * yy, 2.0 * xy] } else { [2.0 * xy, most - 2.0 * xx] };
        (most > 4.0 * least).then(|| [0, 1, 2].map(|k| x * right[k] + y * up[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::Spread;

    #[test]
    fn the_axis_is_found_where_there_is_one() {
        let axis = |dirs: &[[f32; 3]]| {
            let mut spread = Spread::<f32>::about(dirs[0]);
            for &dir in dirs {
                spread.add(dir);
            }
            spread.principal_axis([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        };
        let line =
            |x: f32, y: f32| (0..9).map(|i| [i as f32 * x, i as f32 * y, 5.0]).collect::<Vec<_>>();

        // The slope is 2, whatever the position and length of the directions.
        let [x, y, z] = axis(&line(0.1, 0.2)).unwrap();
        assert!((y - 2.0 * x).abs() < 1e-4 * y.abs() && z == 0.0, "{x} {y} {z}");
        let far: Vec<_> =
            line(0.01, 0.02).iter().map(|d| [d[0] + 100.0, d[1], d[2] * d[1]]).collect();
        let [x, y, z] = axis(&far).unwrap();
        assert!((y - 2.0 * x).abs() < 1e-2 * y.abs() && z == 0.0, "{x} {y} {z}");

        // The spread is already parallel to an axis, or it is the same in all directions.
        assert_eq!(axis(&line(0.1, 0.0)), None);
        assert_eq!(axis(&line(0.0, 0.3)), None);
        assert_eq!(
            axis(&[[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [-1.0, -1.0, 1.0]]),
            None
        );
        assert_eq!(axis(&[[f32::NAN; 3]; 4]), None);
    }
}
