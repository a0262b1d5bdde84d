//! Counts the numbers that change when they are rounded to a scalar.

use crate::coordinate::Coordinate;

/// Rounding statistics: how many numbers were rounded because their scalar cannot represent them
/// exactly, and by how much.
///
/// ```
/// use intertri_scene::Rounding;
/// let mut rounding = Rounding::default();
/// let numbers: [f32; 3] = [0.5, 0.1, 1e7 + 0.25].map(|x| rounding.round(x));
/// assert_eq!(numbers, [0.5, 0.1, 1e7]);
/// assert_eq!((rounding.numbers, rounding.by_up_to), (2, 0.25));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounding {
    /// The count of rounded numbers.
    pub numbers: u64,
    /// The largest change to a number, which is infinite if a number was beyond the scalar's range.
    pub by_up_to: f64,
}

impl Rounding {
    /// Rounds `x` to the nearest value of a scalar, and counts the number if its value changes.
    pub fn round<S: Coordinate>(&mut self, x: f64) -> S {
        let nearest = S::nearest(x);
        let moved = (nearest.into() - x).abs();
        // NaN and infinities are the same in every scalar. They are not counted, because
        // subtracting them from themselves gives NaN.
        if moved > 0.0 {
            self.numbers += 1;
            self.by_up_to = self.by_up_to.max(moved);
        }
        nearest
    }
}
