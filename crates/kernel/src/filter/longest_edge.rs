//! Upper bounds on the longest edges of triangles, computed in f32.
//!
//! A block of triangles stores the longest edge of each triangle, computed in f64. A triangle that
//! is tested only once does not need that precision: any upper bound on its longest edge is valid.
//! `docs/numerics/certified.md`, section 11, has the proof.

use crate::packet::SHORTEST;
use crate::simd::{Lanes, Vec3};

use super::bound;

/// Returns an upper bound on the longest edge, at least [`SHORTEST`], or NaN if a corner is so far
/// from the origin that f32 must not decide. The arguments are the first corner and the two edges
/// at this corner, `-h4` and `h5`.
#[inline(always)]
pub(super) fn longest_edge<F: Lanes<Scalar = f32>>(
    c1: Vec3<F>,
    minus_h4: Vec3<F>,
    h5: Vec3<F>,
) -> F {
    let splat = F::splat;
    let (length, sane) = if F::N <= 4 {
        // With few lanes, a square root is too expensive. The sum of two norms is cheaper, and no
        // edge is longer than this sum.
        let sum = minus_h4.norm1() + h5.norm1();
        (sum, (c1.norm1() + sum).le(splat(bound::LARGEST)))
    } else {
        let squares = |v: Vec3<F>| v.dot_fused(v);
        let (a, b, c) = (squares(minus_h4), squares(h5), squares(h5 + minus_h4));
        // The sum is too large or NaN if any of its terms is.
        let sum = squares(c1) + a + (b + c);
        (a.max(b).max(c).sqrt(), sum.le(splat(bound::LARGEST * bound::LARGEST)))
    };
    let longest = length.mul_add(splat(bound::NORM_UP), splat(SHORTEST));
    F::select(sane, longest, splat(f32::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Level, Simd, WithSimd};

    /// Computes the bound on one triangle's longest edge twice: in lanes, returning the first lane,
    /// and as a scalar.
    struct Measured([[f32; 3]; 3]);

    impl WithSimd for Measured {
        type Output = [f32; 2];
        #[inline(always)]
        fn run<S: Simd>(self) -> [f32; 2] {
            let first = |lanes: S::F32s| {
                let mut numbers = [0.0; 16];
                lanes.store(&mut numbers);
                numbers[0]
            };
            let [c1, c2, c3] = self.0.map(Vec3::splat);
            let [p1, p2, p3] = self.0.map(Vec3::<f32>::splat);
            [first(longest_edge(c1, c1 - c2, c3 - c1)), longest_edge(p1, p1 - p2, p3 - p1)]
        }
    }

    /// Tests coordinates of all kinds in all corners: the bound must hold, must not be much too
    /// large, and must be NaN where f32 cannot decide.
    #[test]
    fn no_edge_is_longer_than_its_bound() {
        let numbers = [0.0, -0.0, 1e-45, 3e-20, 1.0, 1.000_000_1, -3.7, 1e9, 1e12, -1e12];
        let wild = [2e12, 1e19, -1e30, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX];
        let all: Vec<f32> = numbers.into_iter().chain(wild).collect();
        for i in 0..9 * all.len() * all.len() {
            let mut corners = [[0.0, 0.1, 0.2], [1.0, 0.3, 0.1], [0.4, 2.0, 0.7_f32]];
            if i % 2 == 0 {
                // Use nearly equal coordinates, so that their differences suffer from
                // cancellation.
                corners = corners.map(|c| c.map(|x| 1.0 + 1e-7 * x));
            }
            corners.as_flattened_mut()[i % 9] = all[i / 9 % all.len()];
            corners.as_flattened_mut()[(i + 4) % 9] = all[i / 9 / all.len()];

            let edges = [0, 1, 2].map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let d = [0, 1, 2].map(|i| f64::from(a[i]) - f64::from(b[i]));
                (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
            });
            let longest = edges[0].max(edges[1]).max(edges[2]);
            let sane = corners.as_flattened().iter().all(|x| x.abs() <= 1e12);
            let far = !corners.as_flattened().iter().all(|x| x.abs() < 1.2e12);
            for level in Level::all() {
                let [lanes, one] = level.run(Measured(corners));
                let wide = if level == Level::PORTABLE { 3.5 } else { 1.000_01 };
                for (h, most) in [(lanes, wide), (one, 3.5)] {
                    let at = || format!("{h:e} of {corners:?}, {}", level.name());
                    assert!(!far || h.is_nan(), "{}", at());
                    assert!(h.is_nan() || f64::from(h) > longest && h >= SHORTEST, "{}", at());
                    // The sum of the norms of the edges and of the corner may exceed
                    // `bound::LARGEST` even if each of them is below it.
                    let near = corners.as_flattened().iter().all(|x| x.abs() <= 1e9);
                    let limit = longest * most + 2.0 * f64::from(SHORTEST);
                    assert!(!(sane && near) || f64::from(h) <= limit, "{}", at());
                }
            }
        }
    }
}
