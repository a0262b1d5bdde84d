//! The corners and edges of a triangle relative to a point, in integers.

use super::super::int::{Int, dot};
use super::super::scale::Scale;
use super::super::tier::Tier;
use crate::Scalar;

/// Calls a function with the widths of a tier. The function is generic over a scalar and over the
/// numbers of limbs of coordinates and of products of two, three, four, six and ten coordinates.
macro_rules! at_widths {
    ($s:ty, $tier:expr, $f:ident($($arg:expr),*)) => {
        match $tier {
            Tier::Float | Tier::Narrow => $f::<$s, 1, 2, 3, 4, 6, 10>($($arg),*),
            Tier::Middle => $f::<$s, 2, 4, 6, 8, 12, 20>($($arg),*),
            Tier::Widest if const { is_f64::<$s>() } => {
                $f::<$s, 33, 66, 99, 132, 198, 330>($($arg),*)
            }
            Tier::Wide | Tier::Widest => $f::<$s, 5, 10, 15, 20, 30, 50>($($arg),*),
        }
    };
}
pub(super) use at_widths;

/// The corners relative to the point, and the edges. Coordinates have C limbs, and their products
/// have N = 2 C.
pub(super) struct Offsets<const C: usize, const N: usize> {
    pub(super) corners: [[Int<C>; 3]; 3],
    /// The edges from a to b and from a to c.
    pub(super) sides: [[Int<C>; 3]; 2],
}

/// Returns the scale in whose units all coordinates are integers.
#[inline(always)]
pub(super) fn scale<S: Scalar>(point: [S; 3], [a, b, c]: [[S; 3]; 3]) -> Scale {
    Scale::of(&[point, a, b, c])
}

/// Returns the first tier whose integers are wide enough for this scale.
#[inline(always)]
pub(super) fn tier(scale: Scale) -> Tier {
    scale.tier(scale)
}

impl<const C: usize, const N: usize> Offsets<C, N> {
    #[inline(always)]
    pub(super) fn new<S: Scalar>(scale: Scale, point: [S; 3], corners: [[S; 3]; 3]) -> Self {
        let p = scale.vector::<S, C>(point);
        let [a, b, c] = corners.map(|corner| minus(&scale.vector(corner), &p));
        // The point cancels out of these differences of differences, which leaves the exact edges.
        Self { sides: [minus(&b, &a), minus(&c, &a)], corners: [a, b, c] }
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
        minus(&self.corners[(from + 1) % 3], &self.corners[from])
    }
}

#[inline(always)]
fn minus<const C: usize>(a: &[Int<C>; 3], b: &[Int<C>; 3]) -> [Int<C>; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
