//! Triangles as they are seen from the origin of a packet's rays, as its candidates.

use super::beam::Beam;
use super::decided::found;
use super::edges::Rays;
use super::shared_origin::{Forms, SharedOriginBlock};
use crate::Triangle;
use crate::intersect::{Candidates, ClosestHits, Counts, RaysOnTriangle};
use crate::packet::RayPacket;
use crate::resolve::Resolver;
use crate::simd::{Lane, Mask, Simd, Width};

/// Blocks of eight, every one but the last full.
pub(super) struct SharedOriginList<'a, S: Simd, P, const N: usize>
where
    Lane<N>: Width,
{
    pub(super) resolver: Resolver<'a>,
    pub(super) packet: &'a RayPacket<N>,
    pub(super) rays: &'a Rays<<Lane<N> as Width>::F<S>>,
    pub(super) beam: Beam,
    pub(super) blocks: &'a [SharedOriginBlock],
    /// Index and place of the i-th triangle are this and i.
    pub(super) first: u32,
    pub(super) find: P,
    pub(super) live: u32,
}

impl<S: Simd, P: Fn(u32) -> Triangle, const N: usize> Candidates<<Lane<N> as Width>::F<S>, N>
    for SharedOriginList<'_, S, P, N>
where
    Lane<N>: Width,
{
    #[inline(always)]
    fn groups(&self) -> usize {
        self.blocks.len().div_ceil(8)
    }

    /// Those that the beam may reach.
    #[inline(always)]
    fn precheck(&self, group: usize) -> (u64, usize) {
        let blocks = &self.blocks[8 * group..];
        let (mut list, mut tests) = (0_u64, 0);
        for (k, eight) in blocks.iter().take(8).enumerate() {
            list |= u64::from(self.beam.maybe::<S::F32x8>(eight)) << (8 * k);
            tests += eight.live.count_ones() as usize;
        }
        (list, tests)
    }

    #[inline(always)]
    fn offer(
        &self,
        i: usize,
        closest: &mut ClosestHits<<Lane<N> as Width>::F<S>, N>,
        counts: &mut Counts,
    ) {
        let Self { resolver, packet, rays, blocks, first, ref find, live, .. } = *self;
        let seen = &blocks[i / 8].each[i % 8];
        let forms = Forms::new(seen, rays);
        if forms.maybe(seen).bits() & live == 0 {
            return;
        }
        if let Some(decided) = forms.decide(seen, rays, closest.t_hi(), live) {
            let found = found::<_, <Lane<N> as Width>::D<S>>(&decided, counts);
            let at = (first + i as u32, first + i as u32);
            let (place, triangle) = (first + i as u32, &seen.triangle);
            let pairs = RaysOnTriangle { resolver, packet, first: 0, triangle, place, find };
            closest.offer(&found, at, &pairs);
        }
    }
}
