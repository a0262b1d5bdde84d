//! Settles the pairs of a bundle that the filter leaves open. They are collected over several triangles,
//! so that they can be settled side by side.

use super::frame::Points;
use super::nearest::{Nearest, OpenPair, OpenPairs, TOGETHER};
use super::settle::{Settle, Settled};
use crate::simd::Lanes;
use crate::{LeafSlot, Triangle};

impl OpenPairs {
    /// Settles all pairs, stores the hits that are nearer than the nearest hits so far, and removes the
    /// pairs. N rays of the bundle are in each element of `nearest` and `points`, and `seen` has the
    /// slots of the triangles. With `any`, the pairs of rays with a hit are ignored.
    #[inline(always)]
    pub fn settle<F, const N: usize, T, I>(
        &mut self,
        (nearest, points): (&mut [Nearest<F, N>], &[Points<F>]),
        seen: &[LeafSlot],
        settle: &Settle<'_, T, I>,
        any: bool,
    ) where
        F: Lanes<Scalar = f32>,
        T: Fn(LeafSlot) -> Triangle,
        I: Fn(LeafSlot) -> u32,
    {
        let slot = |number: u32| seen[number as usize];
        let mut kept = [None; 2];
        for open in self.pairs[..self.len].chunks(TOGETHER) {
            // If the triangle is behind the ray's nearest hit so far, it does not matter whether it is
            // hit. Walls and floors can often be ordered without arithmetic.
            let (mut behind, mut undecided) = (0_u32, 0_u32);
            for (i, &OpenPair { ray, number, bounds }) in open.iter().enumerate() {
                let ray = ray as usize;
                let (_, other) = nearest[ray / N].lane(ray % N);
                let is_hit = other != Nearest::<F, N>::NOTHING;
                let is_behind = is_hit
                    && (any
                        || bounds.is_none()
                            && settle.is_behind_by_coordinates(ray, slot(number), slot(other)));
                behind |= u32::from(is_behind) << i;
                // A certain hit without another one may still be beyond the far end of its ray.
                undecided |= u32::from(!is_behind && (bounds.is_none() || !is_hit)) << i;
            }
            let decisions = settle.decide(
                undecided,
                #[inline(always)]
                |i| (slot(open[i].number), open[i].ray as usize),
            );

            for (i, &OpenPair { ray, number, bounds }) in open.iter().enumerate() {
                let ray = ray as usize;
                let ([s_lo, s_hi], other) = nearest[ray / N].lane(ray % N);
                let other = (other != Nearest::<F, N>::NOTHING).then_some(other);
                if behind >> i & 1 != 0 || any && other.is_some() {
                    continue;
                }
                let (one, before) = (slot(number), other.map(slot));

                // Find bounds on the inverse depth.
                let inverse = |t| {
                    let mut z = [0.0; N];
                    points[ray / N].z.store(&mut z);
                    settle.apex.inverse(z[ray % N], t)
                };
                let bounds = match bounds {
                    Some(bounds) if before.is_some() => bounds,
                    bounds => match settle.settle(one, ray, before, decisions[i]) {
                        Settled::Behind => continue,
                        Settled::Tie => {
                            nearest[ray / N].set(ray % N, [s_lo, s_hi], number);
                            continue;
                        }
                        Settled::Hit { t_lo, t_hi } => {
                            bounds.unwrap_or_else(|| [inverse(t_hi).0, inverse(t_lo).1])
                        }
                    },
                };

                // The larger the inverse depth, the nearer the hit. If the bounds overlap, the exact
                // order decides.
                if let Some(before) = before
                    && bounds[0] <= s_hi
                    && (bounds[1] < s_lo || !settle.is_before(ray, one, before, &mut kept))
                {
                    continue;
                }
                nearest[ray / N].set(ray % N, bounds, number);
            }
        }
        self.len = 0;
    }
}
