//! Settles the pairs of a bundle that the filter leaves open. They are collected over several triangles,
//! so that they can be settled side by side.

use super::frame::Points;
use super::nearest::{Met, Nearest, OpenPair, OpenPairs, TOGETHER};
use super::settle::{Settle, Settled};
use crate::exact::PairDecision;
use crate::simd::Lanes;
use crate::{LeafSlot, RayId, Triangle};

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
            let (behind, undecided) = self.triage(open, nearest, seen, settle, any);
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
                let mut is_tie = false;
                let bounds = match bounds {
                    Some(bounds) if before.is_some() => bounds,
                    bounds => match settle.settle(one, ray, before, decisions[i]) {
                        Settled::Behind => continue,
                        Settled::Tie => {
                            is_tie = true;
                            [s_lo, s_hi]
                        }
                        Settled::Hit { t_lo, t_hi } => {
                            bounds.unwrap_or_else(|| [inverse(t_hi).0, inverse(t_lo).1])
                        }
                    },
                };

                // The larger the inverse depth, the nearer the hit. If the bounds overlap, the exact
                // order decides.
                if let Some(before) = before
                    && !is_tie
                    && bounds[0] <= s_hi
                    && (bounds[1] < s_lo || !settle.is_before(ray, one, before, &mut kept))
                {
                    continue;
                }
                nearest[ray / N].set(ray % N, bounds, number);
                if let PairDecision::Hit { edges: edges @ 1.., .. } = decisions[i] {
                    self.met[ray % self.met.len()] = Met { ray: settle.id(ray), slot: one, edges };
                }
            }
        }
        self.len = 0;
    }

    /// Returns which of up to sixteen pairs cannot be the ray's nearest hit, whether or not they are
    /// hits, and which of the others are undecided.
    #[inline(always)]
    fn triage<F, const N: usize, T, I>(
        &self,
        open: &[OpenPair],
        nearest: &[Nearest<F, N>],
        seen: &[LeafSlot],
        settle: &Settle<'_, T, I>,
        any: bool,
    ) -> (u32, u32)
    where
        F: Lanes<Scalar = f32>,
        T: Fn(LeafSlot) -> Triangle,
        I: Fn(LeafSlot) -> u32,
    {
        let slot = |number: u32| seen[number as usize];
        let (mut behind, mut undecided) = (0_u32, 0_u32);
        for (i, &OpenPair { ray, number, bounds }) in open.iter().enumerate() {
            let ray = ray as usize;
            let (_, other) = nearest[ray / N].lane(ray % N);
            let is_hit = other != Nearest::<F, N>::NOTHING;
            // Walls and floors can often be ordered without arithmetic. So can triangles with a higher
            // index that have the edge or the corner at which the ray meets the nearest one.
            let comes_later = || {
                let (one, nearest) = (slot(number), slot(other));
                settle.is_behind_by_coordinates(ray, one, nearest)
                    || (self.edges_met(ray, settle.id(ray), nearest))
                        .is_some_and(|edges| settle.is_later_at(ray, (nearest, edges), one))
            };
            let is_behind = is_hit && (any || bounds.is_none() && comes_later());
            behind |= u32::from(is_behind) << i;
            // A certain hit without another one may still be beyond the far end of its ray.
            undecided |= u32::from(!is_behind && (bounds.is_none() || !is_hit)) << i;
        }
        (behind, undecided)
    }

    /// Returns the edges on which a ray, given by its index in the bundle and its id, is known to meet the
    /// triangle in a slot, if any.
    #[inline(always)]
    fn edges_met(&self, ray: usize, id: RayId, slot: LeafSlot) -> Option<u8> {
        let met = &self.met[ray % self.met.len()];
        (met.edges != 0 && (met.ray, met.slot) == (id, slot)).then_some(met.edges)
    }
}
