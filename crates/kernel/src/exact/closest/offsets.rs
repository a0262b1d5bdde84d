//! A triangle relative to a point, in integers.

use super::super::int::{Int, dot};
use super::super::scale::Scale;
use super::super::tier::Tier;
use crate::Scalar;

/// Calls a function that is generic over a scalar, and the limbs of coordinates and of their products of two,
/// three, four and six, with the widths of a tier.
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

/// The corners relative to the point, and the edges; coordinates have C limbs, their products N = 2 C.
pub(super) struct Offsets<const C: usize, const N: usize> {
    pub(super) corners: [[Int<C>; 3]; 3],
    /// From a to b, and from a to c.
    pub(super) sides: [[Int<C>; 3]; 2],
}

/// The scale of which all coordinates are multiples.
#[inline(always)]
pub(super) fn scale<S: Scalar>(point: [S; 3], [a, b, c]: [[S; 3]; 3]) -> Scale {
    Scale::of(&[point, a, b, c])
}

/// The first tier whose integers hold them.
#[inline(always)]
pub(super) fn tier(scale: Scale) -> Tier {
    scale.tier(scale)
}

impl<const C: usize, const N: usize> Offsets<C, N> {
    #[inline(always)]
    pub(super) fn new<S: Scalar>(scale: Scale, point: [S; 3], corners: [[S; 3]; 3]) -> Self {
        let p = scale.vector::<S, C>(point);
        let [a, b, c] = corners.map(|corner| minus(&scale.vector(corner), &p));
        // Differences of differences: the point cancels, and the edges are exact.
        Self { sides: [minus(&b, &a), minus(&c, &a)], corners: [a, b, c] }
    }

    /// The products of both sides with all corners: `ab·A, ac·A, ab·B, ac·B, ab·C, ac·C`.
    #[inline(always)]
    pub(super) fn along(&self) -> [Int<N>; 6] {
        let ([a, b, c], [ab, ac]) = (&self.corners, &self.sides);
        [dot(ab, a), dot(ac, a), dot(ab, b), dot(ac, b), dot(ab, c), dot(ac, c)]
    }

    /// The edge from a corner to the next.
    #[inline(always)]
    pub(super) fn edge(&self, from: usize) -> [Int<C>; 3] {
        minus(&self.corners[(from + 1) % 3], &self.corners[from])
    }
}

#[inline(always)]
fn minus<const C: usize>(a: &[Int<C>; 3], b: &[Int<C>; 3]) -> [Int<C>; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
