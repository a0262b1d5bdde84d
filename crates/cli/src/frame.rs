//! One picture's worth of answers: the visibility buffer and the shadow mask, whoever fills them.

use intertri::{Counts, Hit, Ray};
use intertri_scene::{Light, Scene, check_size, hit_point};
use rayon::prelude::*;

use crate::engine::{Engine, Engines, Name};
use crate::error::{Error, Result};
use crate::progress::{Progress, timed};
use crate::raster::Raster;
use crate::render::Shadows;

/// Rays are asked tile by tile, because neighbours have most of the work in common: 32 by 32 pixels
/// are the 1024 rays that a hierarchy treats together.
const TILE: u32 = 32;

/// What was seen.
pub(crate) struct Frame {
    /// What each pixel shows, row by row from the top left.
    pub(crate) hits: Vec<Hit>,
    /// Whether that point sees the light; true where there is no point or no shadow.
    pub(crate) lit: Vec<bool>,
    /// Shadow rays.
    pub(crate) shadow_rays: u64,
    /// The tests of all rays.
    pub(crate) counts: Counts,
    /// Seconds for what is seen.
    pub(crate) trace: f64,
    /// Seconds for what is lit.
    pub(crate) shadow: f64,
}

impl Frame {
    /// Looks at `scene` with the engine of that name, and finds the shadows of what it sees. Shadow
    /// rays are the engine's own; those of the z-buffer, which has none, are certified.
    pub(crate) fn draw(
        scene: &Scene,
        raster: &Raster<'_>,
        engines: &mut Engines<'_>,
        name: Name,
        shadows: Shadows,
    ) -> Result<Self> {
        let size = raster.size;
        let pixels = check_size(size.0, size.1)?;
        let mut frame = Self {
            hits: filled(pixels, Hit::MISS)?,
            lit: filled(pixels, true)?,
            shadow_rays: 0,
            counts: Counts::default(),
            trace: 0.0,
            shadow: 0.0,
        };

        // The visibility buffer.
        let rays = if name == Name::Raster { Name::Certified } else { name };
        if name == Name::Raster {
            let _bar = Progress::new("draw", None);
            frame.hits = timed(&mut frame.trace, || raster.hits())?;
        } else {
            frame.trace(scene, size, &engines.engine(rays)?);
        }

        // The shadow mask.
        match shadows {
            Shadows::None => {}
            Shadows::Rays => frame.trace_shadows(scene, size, &engines.engine(rays)?),
            Shadows::Volumes => {
                let _bar = Progress::new("shadows", None);
                frame.lit = timed(&mut frame.shadow, || raster.lit(&frame.hits))?;
            }
        }
        Ok(frame)
    }

    /// How far apart, in units of the scene, the hits of a pixel are in two frames that show the same
    /// triangle there: the largest distance along the pixel's ray.
    pub(crate) fn apart(&self, other: &Self, scene: &Scene, (width, height): (u32, u32)) -> f64 {
        let pixels = self.hits.par_iter().zip(&other.hits).enumerate();
        let apart = pixels.map(|(i, (a, b))| {
            if a.triangle != b.triangle || !a.is_hit() {
                return 0.0;
            }
            let (x, y) = (i as u32 % width, i as u32 / width);
            let dir = scene.camera.ray(x, y, width, height).dir.map(f64::from);
            (a.t - b.t).abs() * dir.iter().map(|x| x * x).sum::<f64>().sqrt()
        });
        apart.reduce(|| 0.0, f64::max)
    }

    /// What does each pixel's ray meet?
    fn trace(&mut self, scene: &Scene, (width, height): (u32, u32), engine: &Engine) {
        let bar = Progress::new("trace", Some(self.hits.len() as u64));
        let mut hits = Vec::new();
        batches(width, height, engine.batch(), |batch| {
            let ray = |&(x, y): &(u32, u32)| scene.camera.ray(x, y, width, height);
            let rays: Vec<Ray> = batch.par_iter().map(ray).collect();
            hits.clear();
            hits.resize(rays.len(), Hit::MISS);
            self.counts += timed(&mut self.trace, || engine.closest(&rays, &mut hits));
            for (&(x, y), hit) in batch.iter().zip(&hits) {
                self.hits[y as usize * width as usize + x as usize] = *hit;
            }
            bar.add(batch.len());
        });
    }

    /// Is there anything between that and the light?
    fn trace_shadows(&mut self, scene: &Scene, (width, height): (u32, u32), engine: &Engine) {
        // From beside the eye or the light, a point would be off its surface.
        let light = Light { position: engine.place(scene.light.position) };
        let bar = Progress::new("shadows", Some(self.hits.len() as u64));
        let mut blocked = Vec::new();
        batches(width, height, engine.batch(), |batch| {
            let place = |(x, y): (u32, u32)| y as usize * width as usize + x as usize;
            let seen = batch.par_iter().filter(|&&pixel| self.hits[place(pixel)].is_hit());
            let seen: Vec<(u32, u32)> = seen.copied().collect();
            let ray = |&(x, y): &(u32, u32)| {
                let ray = scene.camera.ray(x, y, width, height);
                let ray = Ray { origin: engine.place(ray.origin), ..ray };
                light.shadow_ray(hit_point(&ray, &self.hits[place((x, y))]))
            };
            let rays: Vec<Ray> = seen.par_iter().map(ray).collect();
            blocked.clear();
            blocked.resize(rays.len(), false);
            self.counts += timed(&mut self.shadow, || engine.any(&rays, &mut blocked));
            self.shadow_rays += rays.len() as u64;
            for (pixel, blocked) in seen.into_iter().zip(&blocked) {
                self.lit[place(pixel)] = !blocked;
            }
            bar.add(batch.len());
        });
    }
}

/// Calls `work` with all pixels of a picture, so many at a time.
fn batches(width: u32, height: u32, size: usize, mut work: impl FnMut(&[(u32, u32)])) {
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
pub(crate) fn tiled(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let tiles = (0..height)
        .step_by(TILE as usize)
        .flat_map(move |y| (0..width).step_by(TILE as usize).map(move |x| (x, y)));
    tiles.flat_map(move |(left, top)| {
        let pixels =
            (0..TILE * TILE).map(move |i| (left + every_other(i), top + every_other(i >> 1)));
        pixels.filter(move |&(x, y)| x < width && y < height)
    })
}

/// The number that bits 0, 2, 4, 6 and 8 make.
fn every_other(i: u32) -> u32 {
    (0..5).map(|bit| (i >> (2 * bit) & 1) << bit).sum()
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
