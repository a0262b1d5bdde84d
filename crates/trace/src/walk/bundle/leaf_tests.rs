//! Processes several leaves at once for the rays of a bundle: lists the packets to test and the
//! triangles to test them against.
//!
//! ```text
//!   blocks ─► outlines ──► triangles in a group's window ──► packets that reach them ──► tests
//!     8      4 (one per two)     up to 64 per group                 up to 16 each         one list
//! ```
//!
//! Each arrow is one loop over all leaves, because the CPU would often mispredict a branch per
//! block or triangle.

use intertri::internal::{Outline, Outlines};
use intertri::simd::{Lanes, Simd};
use intertri::{Filter, LeafSlot};

use super::projection::{GROUPS, PACKETS, Projection};
use crate::tree::{Tree, far_to_near};
use crate::util::prefetch::Prefetch;

/// The maximum number of leaves to process at once.
pub(crate) const AT_ONCE: usize = 8;

/// The maximum number of triangles to process at once.
const TRIANGLES: usize = 8 * AT_ONCE;

/// The maximum number of pairs of a triangle and a group.
const PAIRS: usize = GROUPS * TRIANGLES;

/// The maximum number of tests.
const TESTS: usize = 16 * PAIRS;

/// A test of a packet against one of the listed triangles.
#[derive(Clone, Copy)]
pub(crate) struct PacketTest {
    pub(crate) packet: usize,
    /// The index of the pair of the triangle and the packet's group.
    pub(crate) number: usize,
}

/// The numbers of pairs and tests that have been listed.
#[derive(Clone, Copy, Default)]
pub(crate) struct ListedTests {
    /// For each group, the number of triangles paired with it.
    pub(crate) pairs: [usize; GROUPS],
    pub(crate) tests: usize,
}

/// Several leaves, and the tests to run on their triangles.
pub(crate) struct Leaves {
    /// The indices of the leaves.
    pub(crate) blocks: [u32; AT_ONCE],
    /// The outlines of the triangles, with two blocks per entry.
    outlines: [Outlines; AT_ONCE / 2],
    /// For each pair of a triangle and a group, the triangle's position among all blocks.
    places: [u8; PAIRS],
    /// The packet of each test. A write of eight entries may extend beyond the last test.
    packets: [u8; TESTS + 8],
    /// The pair index of each test, with the same number of spare entries.
    numbers: [u8; TESTS + 8],
}

impl Default for Leaves {
    fn default() -> Self {
        Self {
            blocks: [0; AT_ONCE],
            outlines: [Outlines::default(); AT_ONCE / 2],
            places: [0; PAIRS],
            packets: [0; TESTS + 8],
            numbers: [0; TESTS + 8],
        }
    }
}

impl Leaves {
    /// Lists the tests for the first `used` blocks. For each pair, appends the slot of its triangle
    /// to `seen`.
    #[inline(always)]
    pub(crate) fn list<S: Simd>(
        &mut self,
        (bvh, used): (&Tree, usize),
        (filter, projection): (&Filter<'_>, &Projection<S>),
        seen: &mut Vec<LeafSlot>,
        prefetch: &mut Prefetch<'_>,
    ) -> ListedTests {
        let Self { blocks, outlines, places, packets, numbers } = self;
        let blocks = &blocks[..used];
        for (two, outlines) in blocks.chunks(2).zip(&mut *outlines) {
            let (first, second) = (&bvh.leaves[two[0] as usize].block, two.get(1));
            let second = second.map(|&leaf| &bvh.leaves[leaf as usize].block);
            prefetch.lines(2);
            *outlines =
                filter.outlines_in::<S>(first, second, &projection.frame, projection.slowest);
        }
        let outlines = &outlines[..used.div_ceil(2)];

        let (mut listed, begin, mut known) = (ListedTests::default(), seen.len(), 0);
        seen.resize(begin + PAIRS, LeafSlot(0));
        for (number, group) in projection.groups.iter().enumerate() {
            if group.asked == 0 {
                continue;
            }
            let (mut inside, mut large) = (0_u64, 0_u64);
            for (i, outlines) in outlines.iter().enumerate() {
                let within = outlines.within(&group.window, group.least_of_all);
                inside |= u64::from(within) << (16 * i);
                large |= u64::from(outlines.larger::<S::F32x16>(group.large)) << (16 * i);
            }

            // List the packets that the triangles reach. For small triangles, the bounding
            // rectangle decides almost as well as the edges.
            let (first, windows) = (known, &group.windows);
            listed.pairs[number] = inside.count_ones() as usize;
            known += listed.pairs[number];
            let (by_edges, least) = (inside & large != 0, Lanes::load(&group.least));
            let pairs = seen[begin + first..begin + known].iter_mut().zip(&mut places[first..]);
            for (pair, (seen, to)) in (first..).zip(pairs) {
                prefetch.lines(1);
                let place = inside.trailing_zeros() as usize % TRIANGLES;
                // Clear the lowest set bit.
                inside &= inside.wrapping_sub(1);
                *to = place as u8;
                *seen = LeafSlot(8 * blocks[place / 8] + place as u32 % 8);
                let outline = outlines[place / 16].lane(place % 16);
                let reached =
                    if by_edges { outline.within(windows, least) } else { outline.near(windows) };
                let reached = reached & group.asked;
                for (half, first) in [(reached & 0xff, 0), (reached >> 8, 8)] {
                    let slots =
                        far_to_near(half, 0) + 0x0101_0101_0101_0101 * (16 * number + first) as u64;
                    let at = listed.tests;
                    // Always write eight entries. Only the entries set in the mask count, because
                    // the next write starts right after them.
                    packets[at..at + 8].copy_from_slice(&slots.to_le_bytes());
                    numbers[at..at + 8].fill(pair as u8);
                    listed.tests += half.count_ones() as usize;
                }
            }
        }
        seen.truncate(begin + known);
        listed
    }

    /// Returns the outlines of the triangles in the first `used` blocks of the last list.
    pub(crate) fn outlines(&self, used: usize) -> &[Outlines] {
        &self.outlines[..used.div_ceil(2)]
    }

    /// Returns the test at index i.
    #[inline(always)]
    pub(crate) fn test(&self, i: usize) -> PacketTest {
        let i = i % TESTS;
        PacketTest { packet: self.packets[i] as usize % PACKETS, number: self.numbers[i] as usize }
    }

    /// Returns the outline of a pair's triangle.
    #[inline(always)]
    pub(crate) fn outline(&self, number: usize) -> Outline {
        let place = self.places[number % PAIRS] as usize % TRIANGLES;
        self.outlines[place / 16].lane(place % 16)
    }

    /// Moves a test to index i, which must be at or before its current index.
    #[inline(always)]
    pub(crate) fn put(&mut self, i: usize, PacketTest { packet, number }: PacketTest) {
        // Avoid a bounds check, which would come between the loads of a test and their uses.
        let i = i % TESTS;
        (self.packets[i], self.numbers[i]) = (packet as u8, number as u8);
    }
}
