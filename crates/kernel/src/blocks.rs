//! One packet and triangle after another: all of a block are looked at before any is decided.

use crate::lanes::Simd;
use crate::mode::{Counts, Lane, Test, Width};
use crate::{Bests, Mode, Prepared, PreparedPacket, Triangle};

/// A triangle that a packet can be held against: prepared for rays from anywhere, or seen from one origin.
pub(crate) trait Target<M: Test, S: Simd, const N: usize>
where
    Lane<N>: Width,
{
    /// Whether a live ray may hit it: a first look, without a branch.
    fn maybe(&self, mode: &M, rays: &PreparedPacket<'_, M, S, N>, live: u32) -> bool;

    /// Offers its hits to the rays' bests, as [`Mode::packet_closest_in`].
    fn offer(
        &self,
        mode: &M,
        rays: &PreparedPacket<'_, M, S, N>,
        index: u32,
        find: &impl Fn(u32) -> Triangle,
        live: u32,
        bests: &mut Bests<<Lane<N> as Width>::F<S>, N>,
        counts: &mut Counts,
    );
}

impl<M: Test, S: Simd, const N: usize> Target<M, S, N> for Prepared<M>
where
    Lane<N>: Width,
{
    #[inline(always)]
    fn maybe(&self, mode: &M, rays: &PreparedPacket<'_, M, S, N>, live: u32) -> bool {
        mode.maybe(&mode.one_triangle(&self.constants), rays.lanes(), live)
    }

    #[inline(always)]
    fn offer(
        &self,
        mode: &M,
        rays: &PreparedPacket<'_, M, S, N>,
        index: u32,
        find: &impl Fn(u32) -> Triangle,
        live: u32,
        bests: &mut Bests<<Lane<N> as Width>::F<S>, N>,
        counts: &mut Counts,
    ) {
        mode.packet_closest_in(rays, self, (index, index), find, live, bests, counts);
    }
}

/// Offers the hits of N rays with one target after another to their bests; the i-th has index and place
/// `first + i`.
#[inline(always)]
pub(crate) fn closest_of<M: Test, S: Simd, const N: usize>(
    mode: &M,
    rays: &PreparedPacket<'_, M, S, N>,
    targets: &[impl Target<M, S, N>],
    first: u32,
    find: &impl Fn(u32) -> Triangle,
    live: u32,
    bests: &mut Bests<<Lane<N> as Width>::F<S>, N>,
    counts: &mut Counts,
) where
    Lane<N>: Width,
{
    // A copy of its own stays in registers.
    let mut own = *bests;
    for (b, block) in targets.chunks(Shortlist::BLOCK).enumerate() {
        let mut list = Shortlist::new();
        for (i, target) in block.iter().enumerate() {
            list.put(i, target.maybe(mode, rays, live));
        }
        counts.tests += u64::from(live.count_ones()) * block.len() as u64;
        // These are counted already.
        let mut few = Counts::default();
        for i in list.places() {
            let index = first + (b * Shortlist::BLOCK + i) as u32;
            block[i].offer(mode, rays, index, find, live, &mut own, &mut few);
        }
        counts.undecided += few.undecided;
    }
    *bests = own;
}

/// The few of a block of triangles that may be hit, in their order: gathered without a branch, so that
/// no wrong guess of the CPU's costs the time of many tests.
struct Shortlist {
    of_block: [u8; Self::BLOCK],
    len: usize,
}

impl Shortlist {
    /// So many triangles make a block.
    const BLOCK: usize = 64;

    /// The list of nothing.
    #[inline(always)]
    fn new() -> Self {
        Self { of_block: [0; Self::BLOCK], len: 0 }
    }

    /// Puts the next triangle of the block on the list, or not.
    #[inline(always)]
    fn put(&mut self, next: usize, maybe: bool) {
        self.of_block[self.len % Self::BLOCK] = next as u8;
        self.len += usize::from(maybe);
    }

    /// Those on the list, as places in their block.
    #[inline(always)]
    fn places(&self) -> impl Iterator<Item = usize> {
        self.of_block[..self.len.min(Self::BLOCK)].iter().map(|&place| place.into())
    }
}
