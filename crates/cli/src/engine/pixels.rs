//! The order of a picture's pixels: in tiles, because the rays of neighbours are coherent.

use intertri::Ray;
use intertri_scene::Camera;

/// Pixels along a tile's side: 32 by 32 pixels are the 1024 rays of one bundle in the hierarchy.
const TILE: u32 = 32;

/// Calls `work` with all pixels of a picture, so many at a time.
pub(crate) fn batches(width: u32, height: u32, size: usize, mut work: impl FnMut(&[(u32, u32)])) {
    let mut pixels = tiled(width, height);
    loop {
        let batch: Vec<(u32, u32)> = pixels.by_ref().take(size).collect();
        if batch.is_empty() {
            return;
        }
        work(&batch);
    }
}

/// All pixels of a picture, `(x, y)`, tile by tile; within a tile in Z-order, so that any sixteen in a
/// row are neighbours, too.
fn tiled(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let tiles = (0..height)
        .step_by(TILE as usize)
        .flat_map(move |y| (0..width).step_by(TILE as usize).map(move |x| (x, y)));
    tiles.flat_map(move |(left, top)| {
        let pixels =
            (0..TILE * TILE).map(move |i| (left + every_other(i), top + every_other(i >> 1)));
        pixels.filter(move |&(x, y)| x < width && y < height)
    })
}

/// The rays of a camera through all pixels, in that order: those that are measured.
pub(crate) fn primary_rays(camera: &Camera, (width, height): (u32, u32)) -> Vec<Ray> {
    tiled(width, height).map(|(x, y)| camera.ray(x, y, width, height)).collect()
}

/// The number that bits 0, 2, 4, 6 and 8 make.
fn every_other(i: u32) -> u32 {
    (0..5).map(|bit| (i >> (2 * bit) & 1) << bit).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_hold_every_pixel_once() {
        for (width, height) in [(1, 1), (8, 8), (9, 17), (30, 5)] {
            let mut seen = tiled(width, height).collect::<Vec<_>>();
            assert_eq!(seen[0], (0, 0));
            seen.sort_unstable_by_key(|&(x, y)| (y, x));
            let rows = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            assert!(seen.into_iter().eq(rows));
        }
    }
}
