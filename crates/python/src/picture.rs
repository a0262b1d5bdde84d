//! Gathers the rays of images, which numpy arrays store row by row, into tiles, as the library does
//! for slices of rays.

use std::ops::Range;
use std::sync::Arc;

use intertri::RayOf;
use intertri_trace::internal::{Band, Block, LOWEST, Run, TILE, runs};

use crate::pool::workers;
use crate::scalar::Scalar;
use crate::source::Source;

/// The minimum number of rays in an image. Fewer rays are not treated as an image.
const PICTURE: usize = 4 * TILE * TILE;

/// A range of consecutive rays that a thread takes at a time.
pub(crate) struct Piece {
    pub(crate) rays: Range<usize>,
    /// The shape of the band, if the rays are the pixels of an image.
    pub(crate) band: Option<Arc<Band>>,
}

/// Splits rays into pieces of `size`, and images into bands for the threads of the current pool.
///
/// `width` is the length of the last dimension of the caller's array, which may be an image.
pub(crate) fn pieces<S: Scalar>(rays: &Source<'_, S>, width: usize, size: usize) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for Run { rays, width } in pictures(rays, width) {
        let band = width.map(|width| Arc::new(Band::of_picture(width, rays.len(), workers())));
        let size = band.as_ref().map_or(size, |band| band.pixels());
        let begins = rays.clone().step_by(size);
        pieces.extend(begins.map(|begin| {
            let rays = begin..rays.end.min(begin + size);
            Piece { rays, band: band.clone() }
        }));
    }
    pieces
}

/// Finds the runs of consecutive rays that form images.
fn pictures<S: Scalar>(rays: &Source<'_, S>, width: usize) -> Vec<Run> {
    let all = 0..rays.count;
    // Tiles hold only rays, not the triangles that each ray skips.
    if rays.count < PICTURE || rays.skips() {
        return vec![Run { rays: all, width: None }];
    }
    // Try the caller's shape first: in a panorama, `runs` cannot tell where a row ends.
    let [origin, _] = rays.line(0);
    let shares = |i: usize| rays.line(i)[0] == origin;
    let is_picture = width >= TILE
        && rays.count / width >= LOWEST
        && (1..16).all(|k| shares(k * (rays.count - 1) / 15));
    if is_picture {
        return vec![Run { rays: all, width: Some(width) }];
    }
    runs(rays.count, |i| rays.line(i))
}

/// Gathers the rays of a block in the band that begins with the ray `first`.
pub(crate) fn gather<S: Scalar>(
    block: &Block<'_>,
    (rays, first): (&Source<'_, S>, usize),
    gathered: &mut Vec<RayOf<S>>,
) {
    gathered.resize(block.pixels(), RayOf::new([S::default(); 3], [S::default(); 3]));
    for (row, begins) in block.rows() {
        let begins = begins.iter().map(|&begin| begin.into());
        rays.put((first + row.start, row.len()), begins, gathered);
    }
}

/// Prefetches the rays of the block that follows `block`.
pub(crate) fn prefetch_next<S: Scalar>(block: &Block<'_>, (rays, first): (&Source<'_, S>, usize)) {
    for row in block.next_rows() {
        rays.prefetch((first + row.start).min(rays.count)..(first + row.end).min(rays.count));
    }
}

/// Returns the rays of a square image in the order in which they are traced, tile by tile.
pub(crate) fn tiled<S: Scalar>(rays: &Source<'_, S>) -> Vec<RayOf<S>> {
    let side = rays.count.isqrt();
    let (mut tiled, mut gathered) = (Vec::with_capacity(side * side), Vec::new());
    let whole = Band::new(side.max(1), TILE);
    for first in (0..side * side).step_by(whole.pixels()) {
        let band = whole.within(side * side - first);
        for block in band.blocks() {
            gather(&block, (rays, first), &mut gathered);
            tiled.extend_from_slice(&gathered);
        }
    }
    tiled
}
