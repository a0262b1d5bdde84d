//! One picture's worth of rays: the visibility buffer and the shadow mask.

use intertri::{Counts, Hit, Ray};
use intertri_scene::{Scene, check_size, hit_point};
use rayon::prelude::*;

use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::progress::{Progress, timed};

/// Rays are asked tile by tile, because neighbours take nearly the same way through a hierarchy.
const TILE: u32 = 8;

/// What an engine saw.
pub(crate) struct Frame {
    /// What each pixel's ray met, row by row from the top left.
    pub(crate) hits: Vec<Hit>,
    /// Whether that point sees the light; true where there is no point or no shadow.
    pub(crate) lit: Vec<bool>,
    /// Shadow rays.
    pub(crate) shadow_rays: u64,
    /// The tests of all rays.
    pub(crate) counts: Counts,
    /// Seconds for the rays of the camera.
    pub(crate) trace: f64,
    /// Seconds for the shadow rays.
    pub(crate) shadow: f64,
}

impl Frame {
    /// Looks at `scene` with `engine`.
    pub(crate) fn trace(
        scene: &Scene,
        (width, height): (u32, u32),
        engine: &Engine,
        shadows: bool,
    ) -> Result<Self> {
        let pixels = check_size(width, height)?;
        let mut frame = Self {
            hits: filled(pixels, Hit::MISS)?,
            lit: filled(pixels, true)?,
            shadow_rays: 0,
            counts: Counts::default(),
            trace: 0.0,
            shadow: 0.0,
        };

        let bar = Progress::new("trace", Some(pixels as u64));
        let mut tiles = tiled(width, height);
        loop {
            let batch: Vec<(u32, u32)> = tiles.by_ref().take(engine.batch()).collect();
            if batch.is_empty() {
                break;
            }
            frame.trace_batch(scene, (width, height), engine, shadows, &batch);
            bar.add(batch.len());
        }
        Ok(frame)
    }

    /// Some of the pixels.
    fn trace_batch(
        &mut self,
        scene: &Scene,
        (width, height): (u32, u32),
        engine: &Engine,
        shadows: bool,
        batch: &[(u32, u32)],
    ) {
        let place = |&(x, y): &(u32, u32)| y as usize * width as usize + x as usize;

        // What does each pixel see?
        let rays: Vec<Ray> =
            batch.par_iter().map(|&(x, y)| scene.camera.ray(x, y, width, height)).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        self.counts += timed(&mut self.trace, || engine.closest(&rays, &mut hits));
        for (pixel, hit) in batch.iter().zip(&hits) {
            self.hits[place(pixel)] = *hit;
        }
        if !shadows {
            return;
        }

        // Is there anything between that and the light?
        let seen = (0..hits.len()).filter(|&i| hits[i].is_hit()).collect::<Vec<_>>();
        let rays: Vec<Ray> = seen
            .par_iter()
            .map(|&i| scene.light.shadow_ray(hit_point(&rays[i], &hits[i])))
            .collect();
        let mut blocked = vec![false; rays.len()];
        self.counts += timed(&mut self.shadow, || engine.any(&rays, &mut blocked));
        self.shadow_rays += rays.len() as u64;
        for (i, blocked) in seen.into_iter().zip(blocked) {
            self.lit[place(&batch[i])] = !blocked;
        }
    }
}

/// All pixels of a picture, `(x, y)`, tile by tile.
fn tiled(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let tiles = (0..height)
        .step_by(TILE as usize)
        .flat_map(move |y| (0..width).step_by(TILE as usize).map(move |x| (x, y)));
    tiles.flat_map(move |(left, top)| {
        let across = left..(left + TILE).min(width);
        let down = top..(top + TILE).min(height);
        down.flat_map(move |y| across.clone().map(move |x| (x, y)))
    })
}

/// A buffer that may be too large for this machine.
fn filled<T: Clone>(count: usize, value: T) -> Result<Vec<T>> {
    let mut buffer = Vec::new();
    buffer.try_reserve_exact(count).map_err(|_| {
        Error::new(format!("a picture of {count} pixels needs more memory than there is"))
    })?;
    buffer.resize(count, value);
    Ok(buffer)
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
