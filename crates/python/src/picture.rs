//! Pixels that come in rows are traced tile by tile.
//!
//! Rays of one origin are fastest where 1024 in a row make a narrow cone. Rows of pixels are flat fans, so a block of
//! rows is read row by row, four pixels at a time, and put where its tiles want them:
//!
//! ```text
//!   128 pixels of 32 rows          tiles of 32 by 32       in Z-order, by packets of 4 by 4
//!   ──────────────────────►       ┌────┬────┬────┬────┐       0  1  4  5
//!   ──────────────────────►  ──►  │  0 │  1 │  2 │  3 │       2  3  6  7
//!   ──────────────────────►       └────┴────┴────┴────┘       8  9 12 13
//! ```
//!
//! Memory is read and written in long runs, and a block fits the cache. No answer depends on it.

use std::borrow::Cow;

use intertri::RayOf;

use crate::pool::workers;
use crate::scalar::Scalar;
use crate::source::Source;

/// Pixels a side of a tile.
const TILE: usize = 32;

/// Pixels a side of a packet.
const PACKET: usize = 4;

/// Pixels of a row that are taken at a time.
const ACROSS: usize = 4 * TILE;

/// Fewer rays are no picture.
const PICTURE: usize = 4 * TILE * TILE;

/// Fewer rows are no picture.
const ROWS: usize = TILE / 4;

/// Bands per thread: several, so that all threads finish at about the same time.
const BANDS: usize = 4;

/// Rows of pixels that are traced together.
#[derive(Clone)]
pub(crate) struct Band {
    /// Pixels of a row.
    width: usize,
    rows: usize,
    whole: Order,
    right: Order,
}

/// Where the pixels of a block go: row by row, where each four begin among its rays.
#[derive(Clone)]
struct Order {
    width: usize,
    height: usize,
    begins: Vec<u16>,
}

/// Some columns of a band.
#[derive(Clone, Copy)]
pub(crate) struct Block<'a> {
    /// The pixel of the band in its corner.
    first: usize,
    /// Pixels of a row of the band.
    row: usize,
    order: &'a Order,
}

impl Band {
    /// Of a picture of so many pixels in rows of so many: as high as a tile, but where that made too few bands for
    /// the threads of this pool.
    pub(crate) fn new(width: usize, pixels: usize) -> Self {
        let least = BANDS * workers();
        let mut rows = TILE;
        while rows > ROWS && pixels / (width * rows) < least {
            rows /= 2;
        }
        Self::of_rows(width, rows)
    }

    fn of_rows(width: usize, rows: usize) -> Self {
        let right = Order::new(width % ACROSS, rows);
        Self { width, rows, whole: Order::new(width.min(ACROSS), rows), right }
    }

    /// How many pixels it has.
    pub(crate) fn len(&self) -> usize {
        self.width * self.rows
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// This one, or where fewer pixels are left, a band of the whole rows among them.
    pub(crate) fn within(&self, pixels: usize) -> Cow<'_, Self> {
        if pixels < self.len() {
            Cow::Owned(Self::of_rows(self.width, pixels / self.width))
        } else {
            Cow::Borrowed(self)
        }
    }

    /// Its blocks, from the left to the right.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = Block<'_>> {
        (0..self.width).step_by(ACROSS).map(|first| {
            let order = if first + ACROSS <= self.width { &self.whole } else { &self.right };
            Block { first, row: self.width, order }
        })
    }
}

impl Order {
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

/// The packets of a tile in Z-order: their x and y.
fn z_order() -> [(usize, usize); (TILE / PACKET).pow(2)] {
    let even = |n: usize| (0..3).map(|bit| (n >> (2 * bit) & 1) << bit).sum();
    std::array::from_fn(|n| (even(n), even(n >> 1)))
}

impl Block<'_> {
    /// Its rows: the first pixel of the band in each, and where its fours begin.
    fn rows(&self) -> impl Iterator<Item = (usize, &[u16])> {
        let fours = self.order.width.div_ceil(PACKET).max(1);
        let rows = self.order.begins.chunks_exact(fours);
        rows.enumerate().map(|(y, begins)| (self.first + y * self.row, begins))
    }

    /// A row of it by fours: where these begin among its rays, and how many they are.
    pub(crate) fn fours(&self, row: usize) -> impl Iterator<Item = (usize, usize)> {
        let Order { width, begins, .. } = self.order;
        let fours = width.div_ceil(PACKET);
        let begins = begins[row * fours..(row + 1) * fours].iter();
        begins
            .zip((0..*width).step_by(PACKET))
            .map(move |(&begin, x)| (begin.into(), PACKET.min(width - x)))
    }

    /// Gathers its rays, of a band that begins with a ray.
    pub(crate) fn gather<S: Scalar>(
        &self,
        (rays, first): (&Source<'_, S>, usize),
        gathered: &mut Vec<RayOf<S>>,
    ) {
        let Order { width, height, .. } = *self.order;
        gathered.resize(width * height, RayOf::new([S::default(); 3], [S::default(); 3]));
        for (start, begins) in self.rows() {
            let begins = begins.iter().map(|&begin| begin.into());
            rays.put((first + start, width), begins, gathered);
        }
    }

    /// Prefetches the rays of the block that comes next.
    pub(crate) fn prefetch_next<S: Scalar>(&self, (rays, first): (&Source<'_, S>, usize)) {
        let Order { width, height, .. } = *self.order;
        let right = self.first + width;
        let next = if right < self.row { right } else { height * self.row };
        let width = ACROSS.min(self.row - right % self.row);
        for start in (first + next..).step_by(self.row).take(height) {
            rays.prefetch(start.min(rays.count)..(start + width).min(rays.count));
        }
    }

    /// Writes its answers to those of the band.
    pub(crate) fn scatter<A: Copy>(&self, found: &[A], answers: &mut [A]) {
        for (start, begins) in self.rows() {
            let row = &mut answers[start..start + self.order.width];
            let (fours, rest) = row.as_chunks_mut::<PACKET>();
            for (four, &begin) in fours.iter_mut().zip(begins) {
                four.copy_from_slice(&found[begin.into()..usize::from(begin) + PACKET]);
            }
            if let Some(&begin) = begins.last() {
                rest.iter_mut().zip(&found[begin.into()..]).for_each(|(to, &found)| *to = found);
            }
        }
    }
}

/// How many pixels the rows of a picture have: as the caller's shape says, or as the directions show.
/// `None` where rays are not of one origin, come in no rows, or skip triangles.
pub(crate) fn row_width<S: Scalar>(rays: &Source<'_, S>, width: usize) -> Option<usize> {
    // Tiles are made of rays alone.
    if rays.count < PICTURE || rays.skips() {
        return None;
    }
    let [origin, _] = rays.line(0);
    let shares = |i: usize| rays.line(i)[0] == origin;
    if !(1..16).all(|k| shares(k * (rays.count - 1) / 15)) {
        return None;
    }
    let width = if width > 1 { width } else { seen_width(rays)? };
    (width >= TILE && rays.count / width >= ROWS).then_some(width)
}

/// How long rows are, as far as a look at some of them tells: after so many rays the direction jumps back, time
/// and again.
fn seen_width<S: Scalar>(rays: &Source<'_, S>) -> Option<usize> {
    let step = |i: usize, j: usize| {
        let ([_, a], [_, b]) = (rays.line(i), rays.line(j));
        [0, 1, 2].map(|k| b[k] - a[k])
    };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let along = step(0, 1);
    let width = 1 + (1..rays.count / ROWS).find(|&i| dot(step(i, i + 1), along) < 0.0)?;
    let rows = rays.count / width;
    let is_row = |row: usize| {
        let (first, last) = (row * width, row * width + width - 1);
        let across = step(first, last);
        let down = if row + 1 < rows { step(first, first + width) } else { [0.0; 3] };
        dot(across, along) > 0.0 && dot(down, down) < dot(across, across) / 4.0
    };
    (0..16).all(|k| is_row(k * (rows - 1) / 15)).then_some(width)
}

/// The rays of a square picture, as they are traced.
pub(crate) fn tiled<S: Scalar>(rays: &Source<'_, S>) -> Vec<RayOf<S>> {
    let side = rays.count.isqrt();
    let (mut tiled, mut gathered) = (Vec::with_capacity(side * side), Vec::new());
    let whole = Band::of_rows(side.max(1), TILE);
    for first in (0..side * side).step_by(whole.len()) {
        let band = whole.within(side * side - first);
        for block in band.blocks() {
            block.gather((rays, first), &mut gathered);
            tiled.extend_from_slice(&gathered);
        }
    }
    tiled
}
