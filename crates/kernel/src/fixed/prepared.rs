//! A triangle prepared for many tests: its constants are computed once.

use super::Triangle;
use super::edges::{cross_i64, f32s, i64s};

/// A triangle prepared for packets and blocks. Its integers are stored as f32, in which they are
/// exact: the filter reads them directly, and the integer lanes convert them.
///
/// ```
/// use intertri::fixed::{Bits, Grid, Prepared};
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let wall = Prepared::new(&grid.triangle_of([[0, 0, 5], [4, 0, 5], [0, 4, 5]])?);
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Prepared {
    /// The first corner.
    pub(super) c1: [f32; 3],
    /// The edge from the first to the second corner.
    pub(super) h4: [f32; 3],
    /// The edge from the first to the third corner.
    pub(super) h5: [f32; 3],
    /// `h4 x h5`, rounded. Used only by the filter.
    pub(super) n: [f32; 3],
    /// The longest component of the two edges.
    pub(super) longest: f32,
}

impl Prepared {
    /// The contents of an unused lane: a point, which no ray hits.
    pub(super) const NONE: Self =
        Self { c1: [0.0; 3], h4: [0.0; 3], h5: [0.0; 3], n: [0.0; 3], longest: 0.0 };

    /// Computes the constants of a triangle.
    #[inline]
    pub fn new(&Triangle([c1, c2, c3]): &Triangle) -> Self {
        let (h4, h5) = (minus(c2, c1), minus(c3, c1));
        let [x, y, z] = cross_i64(i64s(h4), i64s(h5));
        Self {
            c1: f32s(c1),
            h4: f32s(h4),
            h5: f32s(h5),
            n: [x as f32, y as f32, z as f32],
            longest: longest(h4).max(longest(h5)) as f32,
        }
    }
}

#[inline(always)]
pub(super) fn minus(a: [i32; 3], b: [i32; 3]) -> [i32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns the largest magnitude of any component.
#[inline(always)]
pub(super) fn longest(v: [i32; 3]) -> i32 {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}
