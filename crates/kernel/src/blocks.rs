//! One packet and triangle after another: all of a block are looked at before any is decided.

use crate::lanes::{Mask, Simd};
use crate::mode::{Counts, Lane, Test, Width};
use crate::{Bests, Mode, Prepared, PreparedPacket, Triangle};

/// Offers the hits of N rays with one triangle after another to their bests; the i-th has index and place
/// `first + i`.
#[inline(always)]
pub(crate) fn closest_of<M: Test, S: Simd, const N: usize>(
    mode: &M,
    rays: &PreparedPacket<'_, M, S, N>,
    triangles: &[Prepared<M>],
    first: u32,
    find: &impl Fn(u32) -> Triangle,
    live: u32,
    bests: &mut Bests<F<S, N>, N>,
    counts: &mut Counts,
) where
    Lane<N>: Width,
{
    let (look, lanes) = (mode.look(rays.lanes()), Mask::from_bits(live));
    // A copy of its own stays in registers.
    let mut own = *bests;
    for (b, block) in triangles.chunks(BLOCK).enumerate() {
        // Those that may be hit, gathered without a branch, so that no wrong guess of the CPU's costs the
        // time of many looks.
        let mut list = 0_u64;
        for (i, triangle) in block.iter().enumerate() {
            list |= u64::from(mode.maybe(&triangle.constants, &look, lanes)) << i;
        }
        counts.tests += u64::from(live.count_ones()) * block.len() as u64;

        // These are counted already.
        let mut few = Counts::default();
        while list != 0 {
            let i = list.trailing_zeros() as usize;
            list &= list - 1;
            let index = first + (b * BLOCK + i) as u32;
            let at = (index, index);
            mode.packet_closest_in(rays, &block[i], at, find, live, &mut own, &mut few);
        }
        counts.undecided += few.undecided;
    }
    *bests = own;
}

/// So many triangles make a block, one a bit.
const BLOCK: usize = 64;

/// N f32.
type F<S, const N: usize> = <Lane<N> as Width>::F<S>;
