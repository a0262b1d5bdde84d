//! One packet of rays against many triangles: all of sixty-four are prechecked before any is tested.
//!
//! Which of them pass is written into a list of bits without a branch, so that no mispredicted branch
//! costs the time of many prechecks.

use super::closest_hits::ClosestHits;
use super::test::Counts;

/// Triangles in sixty-fours, as one packet is held against them.
pub(crate) trait Candidates<F, const N: usize> {
    /// How many sixty-fours there are, the last of which may have fewer.
    fn groups(&self) -> usize;
    /// Those of a group that some ray may hit, a bit each, and of how many.
    fn precheck(&self, group: usize) -> (u64, usize);
    /// Offers the hits with the i-th triangle to the closest.
    fn offer(&self, i: usize, closest: &mut ClosestHits<F, N>, counts: &mut Counts);
}

/// Offers the hits of the packet's `live` rays to their closest.
#[inline(always)]
pub(crate) fn closest_of<F: Copy, const N: usize>(
    candidates: &impl Candidates<F, N>,
    live: u32,
    closest: &mut ClosestHits<F, N>,
    counts: &mut Counts,
) {
    // A copy of its own stays in registers; all tests are counted at once.
    let (mut own, mut few) = (*closest, Counts::default());
    for group in 0..candidates.groups() {
        let (mut list, tests) = candidates.precheck(group);
        counts.tests += u64::from(live.count_ones()) * tests as u64;
        while list != 0 {
            let i = list.trailing_zeros() as usize;
            list &= list - 1;
            candidates.offer(64 * group + i, &mut own, &mut few);
        }
    }
    counts.undecided += few.undecided;
    *closest = own;
}
