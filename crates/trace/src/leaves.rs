//! Some leaves at once, as the rays of a tile see them: which packets are tested against which of their
//! triangles.
//!
//! ```text
//!   packs ──► outlines ──► triangles in the window ──► packets that reach them ──► tests
//!     8          8               up to 64                  up to 16 each            a list
//! ```
//!
//! Each arrow is one loop over all of them, for how much is left of a single pack or triangle the CPU
//! cannot guess.

use intertri::lanes::{Lanes, Simd, prefetch};
use intertri::{Certified, Outline, Outlines, Windows};

use crate::bvh::Bvh;
use crate::screen::{PACKETS, Screen};
use crate::stack::far_to_near;

/// Leaves at once, at most.
pub(crate) const AT_ONCE: usize = 8;

/// Triangles and tests, at most.
const TRIANGLES: usize = 8 * AT_ONCE;
const TESTS: usize = PACKETS * TRIANGLES;

/// A test of a packet: whose, and of which of the triangles seen.
#[derive(Clone, Copy)]
pub(crate) struct Test {
    pub(crate) packet: usize,
    /// The number among those of these leaves.
    pub(crate) number: usize,
}

/// Leaves and what is to be tested of them.
pub(crate) struct Leaves {
    /// Their packs.
    pub(crate) packs: [u32; AT_ONCE],
    outlines: [Outlines; AT_ONCE],
    /// Of each triangle in the window its place among all of the packs.
    places: [u8; TRIANGLES],
    /// Of each test the packet and the triangle's number; what is written at once may stand beyond the
    /// last.
    packets: [u8; TESTS + 8],
    numbers: [u8; TESTS + 8],
}

impl Default for Leaves {
    fn default() -> Self {
        Self {
            packs: [0; AT_ONCE],
            outlines: [Outlines::default(); AT_ONCE],
            places: [0; TRIANGLES],
            packets: [0; TESTS + 8],
            numbers: [0; TESTS + 8],
        }
    }
}

impl Leaves {
    /// Lists the tests of the first `used` packs; `seen` grows by the places of their triangles in the
    /// window. Gives how many triangles and tests there are.
    #[inline(always)]
    pub(crate) fn list<S: Simd>(
        &mut self,
        (bvh, used): (&Bvh, usize),
        (mode, screen): (&Certified, &Screen<S>),
        (window, least_of_all, size): (&Windows<S::F32x8>, f32, [f32; 2]),
        (windows, least, part): (&Windows<S::F32x16>, &[f32; PACKETS], u32),
        seen: &mut Vec<u32>,
    ) -> (usize, usize) {
        let Self { packs, outlines, places, packets, numbers } = self;
        let (mut inside, mut large) = (0_u64, 0_u64);
        for (i, (&pack, outlines)) in packs[..used].iter().zip(&mut *outlines).enumerate() {
            let pack = pack as usize;
            *outlines = mode.outlines_in::<S>(&bvh.packs[pack], &screen.frame, screen.slowest);
            inside |= u64::from(outlines.within(window, least_of_all)) << (8 * i);
            large |= u64::from(outlines.larger::<S::F32x8>(size)) << (8 * i);
            prefetch(&bvh.indices[pack..][..1]);
        }

        // A list of the packets that reach them. Of small ones the rectangle tells nearly as much as the edges.
        let (first, triangles) = (seen.len(), inside.count_ones() as usize);
        seen.resize(first + triangles, 0);
        let (by_edges, least, mut tests) = (inside & large != 0, Lanes::load(least), 0);
        for (number, (seen, to)) in seen[first..].iter_mut().zip(&mut *places).enumerate() {
            let place = inside.trailing_zeros() as usize % TRIANGLES;
            inside &= inside.wrapping_sub(1);
            *to = place as u8;
            *seen = 8 * packs[place / 8] + place as u32 % 8;
            let outline = outlines[place / 8].lane(place % 8);
            let reached =
                if by_edges { outline.within(windows, least) } else { outline.near(windows) };
            let reached = reached & part;
            for (half, first) in [(reached & 0xff, 0), (reached >> 8, 8)] {
                let slots = far_to_near(half, 0) + 0x0101_0101_0101_0101 * first;
                packets[tests..tests + 8].copy_from_slice(&slots.to_le_bytes());
                numbers[tests..tests + 8].fill(number as u8);
                tests += half.count_ones() as usize;
            }
        }
        (triangles, tests)
    }

    /// The i-th test.
    #[inline(always)]
    pub(crate) fn test(&self, i: usize) -> Test {
        Test { packet: self.packets[i] as usize % PACKETS, number: self.numbers[i] as usize }
    }

    /// The outline of the triangle of that number.
    #[inline(always)]
    pub(crate) fn outline(&self, number: usize) -> Outline {
        let place = self.places[number % TRIANGLES] as usize % TRIANGLES;
        self.outlines[place / 8].lane(place % 8)
    }

    /// Puts a test to the i-th place, which comes before its own.
    #[inline(always)]
    pub(crate) fn put(&mut self, i: usize, Test { packet, number }: Test) {
        (self.packets[i], self.numbers[i]) = (packet as u8, number as u8);
    }
}
