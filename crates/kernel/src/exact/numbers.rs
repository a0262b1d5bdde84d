//! The numbers of a ray and a triangle in integers, exactly.
//!
//! ```text
//!   A, B, C  the corners from the origin      N₁ = B × C   N₂ = C × A   N₃ = A × B
//!   d        the direction                    U = d·N₁     V = d·N₂     W = d·N₃     T = A·N₁
//! ```

use super::int::{Int, cross, dot};
use super::scale::{Float, Scale};
use super::tier::Tier;

/// A ray and a triangle as floats, all of them finite.
#[derive(Clone, Copy)]
pub(super) struct Pair<S> {
    pub(super) origin: [S; 3],
    pub(super) dir: [S; 3],
    pub(super) corners: [[S; 3]; 3],
}

/// What the points and the direction are multiples of.
#[derive(Clone, Copy)]
pub(super) struct Scales {
    points: Scale,
    dir: Scale,
}

impl<S: Float> Pair<S> {
    /// Of this pair.
    #[inline(always)]
    pub(super) fn scales(&self) -> Scales {
        let [c1, c2, c3] = self.corners;
        Scales { points: Scale::of(&[self.origin, c1, c2, c3]), dir: Scale::of(&[self.dir]) }
    }

    /// Of the ray and two triangles together.
    #[inline(always)]
    pub(super) fn scales_with(&self, [d1, d2, d3]: [[S; 3]; 3]) -> Scales {
        let [c1, c2, c3] = self.corners;
        let points = Scale::of(&[self.origin, c1, c2, c3, d1, d2, d3]);
        Scales { points, dir: Scale::of(&[self.dir]) }
    }
}

impl Scales {
    /// The first tier whose integers hold all of them.
    #[inline(always)]
    pub(super) fn tier(self) -> Tier {
        self.points.tier(self.dir)
    }

    /// What T/D in integers is to be multiplied with, as a power of two.
    #[inline(always)]
    pub(super) fn of_t(self) -> i32 {
        self.points.low - self.dir.low
    }
}

/// The numbers, whose coordinates have C limbs, normals N = 2 C and volumes V = 3 C.
pub(super) struct Numbers<const C: usize, const N: usize, const V: usize> {
    a: [Int<C>; 3],
    d: [Int<C>; 3],
    /// N₁, N₂ and N₃.
    pub(super) normals: [[Int<N>; 3]; 3],
}

impl<const C: usize, const N: usize, const V: usize> Numbers<C, N, V> {
    /// At these scales, which the limbs must hold.
    #[inline(always)]
    pub(super) fn new<S: Float>(pair: &Pair<S>, scales: Scales) -> Self {
        let o = scales.points.vector::<S, C>(pair.origin);
        let seen = |corner: [S; 3]| {
            let c = scales.points.vector(corner);
            [c[0] - o[0], c[1] - o[1], c[2] - o[2]]
        };
        let [a, b, c] = [seen(pair.corners[0]), seen(pair.corners[1]), seen(pair.corners[2])];
        let normals = [cross(&b, &c), cross(&c, &a), cross(&a, &b)];
        Self { a, d: scales.dir.vector(pair.dir), normals }
    }

    /// U, V and W.
    #[inline(always)]
    pub(super) fn edges(&self) -> [Int<V>; 3] {
        let [n1, n2, n3] = &self.normals;
        [dot(&self.d, n1), dot(&self.d, n2), dot(&self.d, n3)]
    }

    /// T.
    #[inline(always)]
    pub(super) fn volume(&self) -> Int<V> {
        dot(&self.a, &self.normals[0])
    }
}
