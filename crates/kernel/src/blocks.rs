//! One packet and triangle after another: all of a block are looked at before any is decided.

use crate::lanes::{Lanes, Mask, Simd};
use crate::mode::{Counts, Lane, Test, Width};
use crate::{Bests, Mode, Prepared, PreparedPacket, Triangle};

/// A triangle that a packet can be held against: prepared for rays from anywhere, or seen from one origin.
pub(crate) trait Target<M: Test, S: Simd, const N: usize>
where
    Lane<N>: Width,
{
    /// What a first look asks of rays.
    type Look: Copy;

    /// The same, computed.
    fn look(mode: &M, rays: &PreparedPacket<'_, M, S, N>) -> Self::Look;

    /// Whether a live ray may hit it: a first look, without a branch.
    fn maybe(&self, mode: &M, look: &Self::Look, live: <F<S, N> as Lanes>::Mask) -> bool;

    /// Offers its hits to the rays' bests, as [`Mode::packet_closest_in`].
    fn offer(
        &self,
        mode: &M,
        rays: &PreparedPacket<'_, M, S, N>,
        index: u32,
        find: &impl Fn(u32) -> Triangle,
        live: u32,
        bests: &mut Bests<F<S, N>, N>,
        counts: &mut Counts,
    );
}

impl<M: Test, S: Simd, const N: usize> Target<M, S, N> for Prepared<M>
where
    Lane<N>: Width,
{
    type Look = M::Look<F<S, N>>;

    #[inline(always)]
    fn look(mode: &M, rays: &PreparedPacket<'_, M, S, N>) -> Self::Look {
        mode.look(rays.lanes())
    }

    #[inline(always)]
    fn maybe(&self, mode: &M, look: &Self::Look, live: <F<S, N> as Lanes>::Mask) -> bool {
        mode.maybe(&self.constants, look, live)
    }

    #[inline(always)]
    fn offer(
        &self,
        mode: &M,
        rays: &PreparedPacket<'_, M, S, N>,
        index: u32,
        find: &impl Fn(u32) -> Triangle,
        live: u32,
        bests: &mut Bests<F<S, N>, N>,
        counts: &mut Counts,
    ) {
        mode.packet_closest_in(rays, self, (index, index), find, live, bests, counts);
    }
}

/// Offers the hits of N rays with one target after another to their bests; the i-th has index and place
/// `first + i`.
#[inline(always)]
pub(crate) fn closest_of<M: Test, S: Simd, T: Target<M, S, N>, const N: usize>(
    mode: &M,
    rays: &PreparedPacket<'_, M, S, N>,
    targets: &[T],
    first: u32,
    find: &impl Fn(u32) -> Triangle,
    live: u32,
    bests: &mut Bests<F<S, N>, N>,
    counts: &mut Counts,
) where
    Lane<N>: Width,
{
    let (look, lanes) = (T::look(mode, rays), Mask::from_bits(live));
    // A copy of its own stays in registers.
    let mut own = *bests;
    for (b, block) in targets.chunks(BLOCK).enumerate() {
        // Those that may be hit, gathered without a branch, so that no wrong guess of the CPU's costs the
        // time of many looks.
        let mut list = 0_u64;
        for (i, target) in block.iter().enumerate() {
            list |= u64::from(target.maybe(mode, &look, lanes)) << i;
        }
        counts.tests += u64::from(live.count_ones()) * block.len() as u64;

        // These are counted already.
        let mut few = Counts::default();
        while list != 0 {
            let i = list.trailing_zeros() as usize;
            list &= list - 1;
            let index = first + (b * BLOCK + i) as u32;
            block[i].offer(mode, rays, index, find, live, &mut own, &mut few);
        }
        counts.undecided += few.undecided;
    }
    *bests = own;
}

/// So many triangles make a block, one a bit.
const BLOCK: usize = 64;

/// N f32.
type F<S, const N: usize> = <Lane<N> as Width>::F<S>;
