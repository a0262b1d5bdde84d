//! The order of an image's pixels: tile by tile, because neighbouring rays are coherent.
//!
//! ```text
//!   +----+----+--+   A band is a row of tiles. Bands run from top to bottom, and tiles from left
//!   | 1  | 2  |3 |   to right. Pixels within a whole tile are in Z-order, so that any aligned run
//!   +----+----+--+   of sixteen is also a square. Tiles cut by the border use row order, so
//!   | 4  | 5  |6 |   that positions and pixels can be computed from each other.
//!   +----+----+--+
//! ```

use intertri::Ray;
use intertri_scene::Camera;

use crate::engine::memory::room;
use crate::error::Result;

/// The side of a tile in pixels. The hierarchy traces a tile's 32×32 rays as one bundle.
const TILE: u32 = 32;

/// The pixels of an image, tile by tile.
#[derive(Clone, Copy)]
pub(crate) struct Tiles {
    width: u32,
    height: u32,
}

impl Tiles {
    /// Creates the order for an image of this size.
    pub(crate) fn new((width, height): (u32, u32)) -> Self {
        Self { width, height }
    }

    /// Returns the number of pixels in a full band. The first band consists of the first rows of
    /// the image.
    pub(crate) fn band(self) -> usize {
        (self.width * TILE) as usize
    }

    /// Returns the pixel `(x, y)` at a position in the order.
    pub(crate) fn pixel(self, place: usize) -> (u32, u32) {
        let (place, band) = (place as u32, self.band() as u32);
        let (top, in_band) = (place / band * TILE, place % band);
        let rows = TILE.min(self.height - top);
        let left = in_band / (TILE * rows) * TILE;
        let in_tile = in_band - left * rows;
        let columns = TILE.min(self.width - left);
        let (x, y) = if columns == TILE && rows == TILE {
            (every_other(in_tile), every_other(in_tile >> 1))
        } else {
            (in_tile % columns, in_tile / columns)
        };
        (left + x, top + y)
    }

    /// Returns the position of a pixel in the order.
    pub(crate) fn place(self, (x, y): (u32, u32)) -> usize {
        let (left, top) = (x / TILE * TILE, y / TILE * TILE);
        let (columns, rows) = (TILE.min(self.width - left), TILE.min(self.height - top));
        let (x, y) = (x - left, y - top);
        let in_tile = if columns == TILE && rows == TILE {
            apart(x) | apart(y) << 1
        } else {
            y * columns + x
        };
        (top * self.width + left * rows + in_tile) as usize
    }
}

/// Returns all pixels `(x, y)` of an image, in tile order.
pub(crate) fn tiled(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let tiles = Tiles::new((width, height));
    (0..width as usize * height as usize).map(move |place| tiles.pixel(place))
}

/// Returns the camera rays through all pixels, in tile order, for measurements.
pub(crate) fn primary_rays(camera: &Camera, (width, height): (u32, u32)) -> Result<Vec<Ray>> {
    let mut rays = room(width as usize * height as usize, "rays")?;
    rays.extend(tiled(width, height).map(|(x, y)| camera.ray(x, y, width, height)));
    Ok(rays)
}

/// Packs bits 0, 2, 4, 6 and 8 into adjacent positions.
fn every_other(i: u32) -> u32 {
    (0..5).map(|bit| (i >> (2 * bit) & 1) << bit).sum()
}

/// Spreads the bits of a number to positions 0, 2, 4, 6 and 8.
fn apart(i: u32) -> u32 {
    (0..5).map(|bit| (i >> bit & 1) << (2 * bit)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_hold_every_pixel_once() {
        for (width, height) in [(1, 1), (8, 8), (9, 17), (30, 5), (64, 32), (100, 70), (33, 96)] {
            let tiles = Tiles::new((width, height));
            let mut seen = tiled(width, height).collect::<Vec<_>>();
            assert_eq!(seen[0], (0, 0));
            assert!(seen.iter().enumerate().all(|(i, &pixel)| tiles.place(pixel) == i));
            // The first band contains only pixels from the first 32 rows.
            let mut band = tiles.band().min(seen.len());
            assert!(seen[..band].iter().all(|&(_, y)| y < 32));
            seen.sort_unstable_by_key(|&(x, y)| (y, x));
            let rows = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            assert!(seen.into_iter().eq(rows));
            // The first tile, if it is whole, contains only pixels from the first 32 columns.
            band = band.min(1024);
            assert!(width < 32 || height < 32 || (0..band).all(|i| tiles.pixel(i).0 < 32));
        }
    }
}
