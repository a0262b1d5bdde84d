//! The corners and edges of a triangle relative to a point, in integers.

use super::super::int::{Int, difference, dot};
use super::super::scale::{Dyadic, Scale};
use crate::{Scalar, TriangleOf};

/// Calls a function with the widths of a tier. The function is generic over the numbers of limbs of
/// coordinates and of products of two, three, four, six and ten coordinates.
macro_rules! at_widths {
    ($tier:expr, $f:ident($($arg:expr),*)) => {
        match $tier {
            Tier::Float | Tier::Narrow => $f::<1, 2, 3, 4, 6, 10>($($arg),*),
            Tier::Middle => $f::<2, 4, 6, 8, 12, 20>($($arg),*),
            Tier::Wide => $f::<5, 10, 15, 20, 30, 50>($($arg),*),
            Tier::Widest => $f::<33, 66, 99, 132, 198, 330>($($arg),*),
        }
    };
}
pub(super) use at_widths;

/// A point, followed by the corners of a triangle.
pub(super) type Points = [[Dyadic; 3]; 4];

/// Collects the coordinates of a point and a triangle, all of which must be finite.
#[inline(always)]
pub(super) fn points<S: Scalar>(point: [S; 3], triangle: &TriangleOf<S>) -> Points {
    let [a, b, c] = triangle.0;
    [point, a, b, c].map(Dyadic::vector)
}

/// The corners relative to the point, and the edges. Coordinates have C limbs, and their products
/// have N = 2 C.
pub(super) struct Offsets<const C: usize, const N: usize> {
    pub(super) corners: [[Int<C>; 3]; 3],
    /// The edges from a to b and from a to c.
    pub(super) sides: [[Int<C>; 3]; 2],
}

impl<const C: usize, const N: usize> Offsets<C, N> {
    #[inline(always)]
    pub(super) fn new(scale: Scale, points: Points) -> Self {
        let [point, corners @ ..] = points;
        let [a, b, c] = scale.relative(point, corners);
        // The point cancels out of these differences of differences, which leaves the exact edges.
        Self { sides: [difference(&b, &a), difference(&c, &a)], corners: [a, b, c] }
    }

    /// Returns the dot products of both edges with all corners:
    /// `ab·A, ac·A, ab·B, ac·B, ab·C, ac·C`.
    #[inline(always)]
    pub(super) fn along(&self) -> [Int<N>; 6] {
        let ([a, b, c], [ab, ac]) = (&self.corners, &self.sides);
        [dot(ab, a), dot(ac, a), dot(ab, b), dot(ac, b), dot(ab, c), dot(ac, c)]
    }

    /// Returns the edge from a corner to the next.
    #[inline(always)]
    pub(super) fn edge(&self, from: usize) -> [Int<C>; 3] {
        difference(&self.corners[(from + 1) % 3], &self.corners[from])
    }
}
