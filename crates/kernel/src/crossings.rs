//! Crossings: where a ray passes through a mesh, with each edge and corner counted once.

use crate::Hit;

/// A ray's crossing of a triangle.
///
/// ```
/// use intertri::{Mode, Ray, Triangle};
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let crossings = Mode::exact().crossings(&[wall], &Ray::new([0.25, 0.5, 0.0], [0.0, 0.0, 2.0]));
/// assert_eq!((crossings[0].hit.t, crossings[0].leaves), (2.5, true));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The hit at the crossing.
    pub hit: Hit,
    /// Whether the ray crosses the triangle in the direction of its normal. If so, it leaves a mesh
    /// whose corners run counter-clockwise as seen from outside.
    pub leaves: bool,
}

/// The number of times that a ray crosses a mesh.
///
/// ```
/// use intertri::Crossings;
/// use intertri::fixed::{Bits, Fixed, Grid, blocks};
/// // Through the front of one wall and the back of another.
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let (front, back) = ([[0, 0, 5], [4, 0, 5], [0, 4, 5]], [[0, 0, 9], [0, 4, 9], [4, 0, 9]]);
/// let walls = blocks(&[grid.triangle_of(front)?, grid.triangle_of(back)?]);
/// let crossings = Fixed::default().crossings(&walls, &grid.ray_of([1, 1, 0], [0, 0, 1])?);
/// assert_eq!(crossings, Crossings { signed: 0, unsigned: 2 });
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crossings {
    /// The number of crossings in the direction of the normal, minus the number against it. In a
    /// closed mesh whose corners run counter-clockwise as seen from outside, this is 1 for a ray
    /// from inside and 0 for a ray from outside.
    pub signed: i64,
    /// The number of crossings.
    pub unsigned: u64,
}

impl Crossings {
    /// Counts one more crossing, at which the ray leaves the mesh if `leaves` is true, and
    /// otherwise enters it.
    ///
    /// ```
    /// let mut crossings = intertri::Crossings::default();
    /// crossings.add(true);
    /// crossings.add(false);
    /// assert_eq!((crossings.signed, crossings.unsigned), (0, 2));
    /// ```
    #[inline]
    pub fn add(&mut self, leaves: bool) {
        self.signed += if leaves { 1 } else { -1 };
        self.unsigned += 1;
    }
}
