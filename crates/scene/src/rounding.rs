//! Counts numbers that a scalar cannot hold.

use crate::coordinate::Coordinate;

/// How many numbers were rounded because their scalar does not hold them, and how far that moved them.
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
    /// How many numbers were rounded.
    pub numbers: u64,
    /// The farthest that one of them moved; infinite where one was beyond the scalar's range.
    pub by_up_to: f64,
}

impl Rounding {
    /// The number of a scalar that is nearest to `x`: counted if that is not `x` itself.
    pub fn round<S: Coordinate>(&mut self, x: f64) -> S {
        let nearest = S::nearest(x);
        let moved = (nearest.into() - x).abs();
        // A NaN or an infinity is the same in every scalar; the difference is NaN then.
        if moved > 0.0 {
            self.numbers += 1;
            self.by_up_to = self.by_up_to.max(moved);
        }
        nearest
    }
}
