//! The exact integers computed for a ray and a triangle.
//!
//! ```text
//!   A, B, C  corners relative to the origin   N₁ = B × C   N₂ = C × A   N₃ = A × B
//!   d        the direction                    U = d·N₁     V = d·N₂     W = d·N₃     T = A·N₁
//! ```

use core::cmp::Ordering;

use super::int::{Int, cross, dot};
use super::scale::{Dyadic, Scales};
use super::tier::{Tier, at_tier};
use crate::{RayOf, Scalar, TriangleOf};

/// A ray and a triangle with finite coordinates.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    /// The ray's origin, followed by the corners.
    points: [[Dyadic; 3]; 4],
    dir: [Dyadic; 3],
}

impl Pair {
    /// Collects the coordinates of a ray and a triangle, all of which must be finite.
    #[inline(always)]
    pub(super) fn new<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> Self {
        let [c1, c2, c3] = triangle.0;
        let points = [ray.origin, c1, c2, c3].map(Dyadic::vector);
        Self { points, dir: Dyadic::vector(ray.dir) }
    }

    /// Returns the scales of this pair.
    #[inline(always)]
    pub(super) fn scales(&self) -> Scales {
        Scales::of(&self.points, self.dir)
    }

    /// Returns the common scales of two pairs of the same ray.
    #[inline(always)]
    pub(super) fn scales_with(&self, other: &Self) -> Scales {
        let ([o, a, b, c], [_, d, e, f]) = (self.points, other.points);
        Scales::of(&[o, a, b, c, d, e, f], self.dir)
    }

    /// Returns the signs of T and D.
    #[inline(never)]
    pub(super) fn plane_signs(&self) -> (Ordering, Ordering) {
        let scales = self.scales();
        at_tier!(scales.tier(), plane_signs::<C, N, V>(self, scales))
    }
}

fn plane_signs<const C: usize, const N: usize, const V: usize>(
    pair: &Pair,
    scales: Scales,
) -> (Ordering, Ordering) {
    let numbers = Numbers::<C, N, V>::new(pair, scales);
    let [u, v, w] = numbers.edges();
    (numbers.volume().sign(), (u + v + w).sign())
}

/// The integers of a pair. Coordinates have C limbs, normals N = 2 C, and volumes V = 3 C.
pub(super) struct Numbers<const C: usize, const N: usize, const V: usize> {
    a: [Int<C>; 3],
    d: [Int<C>; 3],
    /// N₁, N₂, and N₃.
    pub(super) normals: [[Int<N>; 3]; 3],
}

impl<const C: usize, const N: usize, const V: usize> Numbers<C, N, V> {
    /// Converts a pair to integers at the given scales. C must be large enough for them.
    #[inline(always)]
    pub(super) fn new(pair: &Pair, scales: Scales) -> Self {
        let [origin, corners @ ..] = pair.points;
        let [a, b, c] = scales.points.relative(origin, corners);
        let normals = [cross(&b, &c), cross(&c, &a), cross(&a, &b)];
        Self { a, d: scales.dir.vector(pair.dir), normals }
    }

    /// Computes the edge volumes U, V, and W.
    #[inline(always)]
    pub(super) fn edges(&self) -> [Int<V>; 3] {
        let [n1, n2, n3] = &self.normals;
        [dot(&self.d, n1), dot(&self.d, n2), dot(&self.d, n3)]
    }

    /// Computes the volume T.
    #[inline(always)]
    pub(super) fn volume(&self) -> Int<V> {
        dot(&self.a, &self.normals[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::quotient::Quotient;

    /// Returns t, u, and v of a pair, all three of which must be positive.
    fn attributes((origin, dir, corners): ([f64; 3], [f64; 3], [[f64; 3]; 3])) -> [f64; 3] {
        let pair = &Pair::new(&RayOf::new(origin, dir), &TriangleOf(corners));
        let scales = pair.scales();
        let numbers = Numbers::<33, 66, 99>::new(pair, scales);
        let [u, v, w] = numbers.edges();
        let den = (u + v + w).size();
        let over = |num: Int<99>, exponent| Quotient::new(&num.size(), &den, exponent).to_f64();
        [over(numbers.volume(), scales.of_t()), over(v, 0), over(w, 0)]
    }

    /// 33 limbs are enough for any pair in f64, even if it combines the largest and smallest
    /// values.
    #[test]
    fn the_same_code_takes_f64() {
        let pair = |x: f64, tiny: f64| {
            let corners = [[0.0, 0.0, 4.0], [x, 0.0, 4.0], [0.0, x, 4.0]];
            ([0.25 * x, 0.125 * x, -3.0], [0.0, tiny, 1.0], corners)
        };
        let smallest = f64::from_bits(1);
        for x in [1.0, 1e-3, 2.0_f64.powi(1023)] {
            assert_eq!(attributes(pair(x, 0.0)), [7.0, 0.25, 0.125], "{x}");
            assert_eq!(attributes(pair(x, smallest)), [7.0, 0.25, 0.125], "{x}");
        }
        // Test a ray that starts one f64 step away from the plane, then one that starts as far away
        // as f64 allows.
        let mut near = pair(1.0, 0.0);
        near.0[2] = 4.0_f64.next_down();
        assert_eq!(attributes(near)[0], 4.0 - 4.0_f64.next_down());
        near.2.iter_mut().for_each(|corner| corner[2] = f64::MAX);
        assert_eq!(attributes(near)[0], f64::MAX);
    }
}
