//! Arranges rows of pixels in tiles, in which they are faster to trace.
//!
//! Rays with a common origin are fastest to trace if 1024 consecutive rays form a narrow cone, but
//! a row of pixels forms a flat fan. Therefore, each block of rows is read row by row, four pixels
//! at a time, and its rays are copied to their places in tiles:
//!
//! ```text
//!   32 rows of 128 pixels            32×32 tiles           4×4 packets in Z-order
//!   ──────────────────────►       ┌────┬────┬────┬────┐       0  1  4  5
//!   ──────────────────────►  ──►  │  0 │  1 │  2 │  3 │       2  3  6  7
//!   ──────────────────────►       └────┴────┴────┴────┘       8  9 12 13
//! ```
//!
//! Memory is read and written in long runs, and a block fits in the L2 cache. Tiling does not
//! affect the results.

use std::borrow::Cow;
use std::ops::Range;

use intertri::internal::prefetch_early;

/// The side of a tile in pixels.
pub const TILE: usize = 32;

/// The side of a packet in pixels.
const PACKET: usize = 4;

/// The number of pixels in a row that are copied at a time.
const ACROSS: usize = 4 * TILE;

/// The minimum number of bands per thread. Several bands per thread let all threads finish at about
/// the same time.
const BANDS: usize = 4;

/// The minimum number of rows in a band of an image.
pub const LOWEST: usize = TILE / 4;

/// Rows of pixels that are traced together.
#[derive(Clone)]
pub struct Band {
    /// The width of a row in pixels.
    width: usize,
    rows: usize,
    whole: BlockOrder,
    right: BlockOrder,
}

/// The order in which a block's pixels are gathered. For each row, it lists where each group of
/// four pixels starts among the gathered rays.
#[derive(Clone)]
struct BlockOrder {
    width: usize,
    height: usize,
    begins: Vec<u16>,
}

/// A block: several columns of a band.
#[derive(Clone, Copy)]
pub struct Block<'a> {
    /// The index of the block's first pixel in the band.
    first: usize,
    /// The width of the band's rows in pixels.
    row: usize,
    order: &'a BlockOrder,
}

impl Band {
    /// Creates a band of an image whose rows have this width. The band is as tall as a tile, unless
    /// that leaves too few bands for the threads.
    pub fn of_picture(width: usize, pixels: usize, threads: usize) -> Self {
        let mut rows = TILE;
        // Use shorter bands if there are too few to keep all threads busy.
        while rows > LOWEST && pixels / (width * rows) < BANDS * threads {
            rows /= 2;
        }
        Self::new(width, rows)
    }

    /// Creates a band with this width in pixels and at most [`TILE`] rows.
    pub fn new(width: usize, rows: usize) -> Self {
        let right = BlockOrder::new(width % ACROSS, rows);
        Self { width, rows, whole: BlockOrder::new(width.min(ACROSS), rows), right }
    }

    /// Returns the number of pixels in the band.
    pub fn pixels(&self) -> usize {
        self.width * self.rows
    }

    /// Returns the number of rows in the band.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns this band or, if it has more pixels than `pixels`, a shorter band with as many whole
    /// rows as fit in that number.
    pub fn within(&self, pixels: usize) -> Cow<'_, Self> {
        if pixels < self.pixels() {
            Cow::Owned(Self::new(self.width, pixels / self.width))
        } else {
            Cow::Borrowed(self)
        }
    }

    /// Iterates over the blocks of the band, from left to right.
    pub fn blocks(&self) -> impl Iterator<Item = Block<'_>> {
        (0..self.width).step_by(ACROSS).map(|first| {
            let order = if first + ACROSS <= self.width { &self.whole } else { &self.right };
            Block { first, row: self.width, order }
        })
    }
}

impl BlockOrder {
    fn new(width: usize, height: usize) -> Self {
        let fours = width.div_ceil(PACKET);
        let mut begins = vec![0; fours * height];
        let mut next = 0;
        for tile in 0..width.div_ceil(TILE) {
            for (i, j) in z_order() {
                let x = tile * TILE + i * PACKET;
                if x < width {
                    for y in (j * PACKET..height).take(PACKET) {
                        begins[y * fours + x / PACKET] = next;
                        next += PACKET.min(width - x) as u16;
                    }
                }
            }
        }
        Self { width, height, begins }
    }
}

/// Returns the x and y of a tile's packets in Z-order.
fn z_order() -> [(usize, usize); (TILE / PACKET).pow(2)] {
    // The bits of n belong alternately to x and y.
    let even = |n: usize| (0..3).map(|bit| (n >> (2 * bit) & 1) << bit).sum();
    std::array::from_fn(|n| (even(n), even(n >> 1)))
}

impl Block<'_> {
    /// Returns the number of pixels in the block.
    pub fn pixels(&self) -> usize {
        self.order.width * self.order.height
    }

    /// Iterates over the rows of the block. Each item is the range of the row's pixels in the band,
    /// and where the row's groups of four begin among the gathered rays.
    pub fn rows(&self) -> impl Iterator<Item = (Range<usize>, &[u16])> {
        let BlockOrder { width, ref begins, .. } = *self.order;
        let rows = begins.chunks_exact(width.div_ceil(PACKET).max(1));
        rows.enumerate().map(move |(y, begins)| {
            let first = self.first + y * self.row;
            (first..first + width, begins)
        })
    }

    /// Iterates over the groups of four in a row. Each item is where the group begins among the
    /// gathered rays, and how many rays it has.
    pub fn fours(&self, row: usize) -> impl Iterator<Item = (usize, usize)> {
        let BlockOrder { width, ref begins, .. } = *self.order;
        let fours = width.div_ceil(PACKET);
        let begins = begins[row * fours..(row + 1) * fours].iter();
        begins
            .zip((0..width).step_by(PACKET))
            .map(move |(&begin, x)| (begin.into(), PACKET.min(width - x)))
    }

    /// Copies the rays of the block tile by tile. The slice `rays` begins at the start of the band.
    pub(super) fn gather<R: Copy>(&self, rays: &[R], gathered: &mut Vec<R>) {
        gathered.resize(self.pixels(), rays[0]);
        for (row, begins) in self.rows() {
            let (fours, rest) = rays[row].as_chunks::<PACKET>();
            for (four, &begin) in fours.iter().zip(begins) {
                // Copy four rays at a time, because a packet's row is contiguous both in the
                // image and in the tile.
                gathered[begin.into()..][..PACKET].copy_from_slice(four);
            }
            if let Some(&begin) = begins.last() {
                gathered[begin.into()..].iter_mut().zip(rest).for_each(|(to, ray)| *to = *ray);
            }
        }
    }

    /// Iterates over the rows of the next block, in this band or in the band below. The rows may be
    /// outside the image.
    pub fn next_rows(&self) -> impl Iterator<Item = Range<usize>> {
        let BlockOrder { width, height, .. } = *self.order;
        let right = self.first + width;
        // Continue with the block to the right, or with the first block of the next band.
        let next = if right < self.row { right } else { height * self.row };
        let width = ACROSS.min(self.row - right % self.row);
        (next..).step_by(self.row).take(height).map(move |start| start..start + width)
    }

    /// Prefetches the rays of the next block.
    pub(super) fn prefetch_next<R>(&self, rays: &[R]) {
        self.next_rows().filter_map(|row| rays.get(row)).for_each(prefetch_early);
    }

    /// Copies the answers of the block to their places among the band's answers.
    pub fn scatter<A: Copy>(&self, found: &[A], answers: &mut [A]) {
        for (row, begins) in self.rows() {
            let (fours, rest) = answers[row].as_chunks_mut::<PACKET>();
            for (four, &begin) in fours.iter_mut().zip(begins) {
                four.copy_from_slice(&found[begin.into()..][..PACKET]);
            }
            if let Some(&begin) = begins.last() {
                rest.iter_mut().zip(&found[begin.into()..]).for_each(|(to, &found)| *to = found);
            }
        }
    }
}
