//! A frame: the visibility buffer and the shadow mask of one picture, from any engine.

use clap::ValueEnum;
use intertri::{Counts, Hit, Ray};
use intertri_scene::{Light, Scene, check_size, hit_point};
use rayon::prelude::*;
use serde::Serialize;

use crate::engine::engines::Engines;
use crate::engine::name::EngineName;
use crate::engine::pixels::batches;
use crate::engine::raster::Raster;
use crate::engine::ray_engine::RayEngine;
use crate::error::{Error, Result};
use crate::io::progress::{Progress, timed};

/// How the shadow mask is made.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Shadows {
    /// A ray from the light to each point that is seen; those of engine raster are certified
    Rays,
    /// Counting the volumes of shadow that each point is in: no rays
    Volumes,
    /// Everything is lit
    None,
}

/// What is seen, and what is lit.
pub(crate) struct Frame {
    /// What each pixel shows, row by row from the top left.
    pub(crate) hits: Vec<Hit>,
    /// Whether the light reaches that point; true where there is no point or no shadow.
    pub(crate) lit: Vec<bool>,
    /// How many shadow rays were traced.
    pub(crate) shadow_rays: u64,
    /// The tests of all rays.
    pub(crate) counts: Counts,
    /// How long the visibility buffer took.
    pub(crate) trace_seconds: f64,
    /// How long the shadow mask took.
    pub(crate) shadow_seconds: f64,
}

impl Frame {
    /// Draws `scene` with the engine of that name, and finds the shadows of what it sees. The engine
    /// traces its own shadow rays; for the z-buffer, which has none, `certified` does.
    pub(crate) fn draw(
        scene: &Scene,
        raster: &Raster<'_>,
        engines: &mut Engines<'_>,
        name: EngineName,
        shadows: Shadows,
    ) -> Result<Self> {
        let size = raster.size;
        let pixels = check_size(size.0, size.1)?;
        let mut frame = Self {
            hits: filled(pixels, Hit::MISS)?,
            lit: filled(pixels, true)?,
            shadow_rays: 0,
            counts: Counts::default(),
            trace_seconds: 0.0,
            shadow_seconds: 0.0,
        };

        // The visibility buffer.
        let tracer = if name == EngineName::Raster { EngineName::Certified } else { name };
        if name == EngineName::Raster {
            let _bar = Progress::new("draw", None);
            frame.hits = timed(&mut frame.trace_seconds, || raster.hits())?;
        } else {
            frame.trace(scene, size, &engines.engine(tracer)?);
        }

        // The shadow mask.
        match shadows {
            Shadows::None => {}
            Shadows::Rays => frame.trace_shadows(scene, size, &engines.engine(tracer)?),
            Shadows::Volumes => {
                let _bar = Progress::new("shadows", None);
                frame.lit = timed(&mut frame.shadow_seconds, || raster.lit(&frame.hits))?;
            }
        }
        Ok(frame)
    }

    /// Traces a camera ray through each pixel.
    fn trace(&mut self, scene: &Scene, (width, height): (u32, u32), engine: &RayEngine) {
        let bar = Progress::new("trace", Some(self.hits.len() as u64));
        let mut hits = Vec::new();
        batches(width, height, engine.batch_size(), |batch| {
            let ray = |&(x, y): &(u32, u32)| scene.camera.ray(x, y, width, height);
            let rays: Vec<Ray> = batch.par_iter().map(ray).collect();
            hits.clear();
            hits.resize(rays.len(), Hit::MISS);
            self.counts += timed(&mut self.trace_seconds, || engine.closest(&rays, &mut hits));
            for (&(x, y), hit) in batch.iter().zip(&hits) {
                self.hits[y as usize * width as usize + x as usize] = *hit;
            }
            bar.add(batch.len());
        });
    }

    /// Traces a shadow ray from the light to each point that is seen.
    fn trace_shadows(&mut self, scene: &Scene, (width, height): (u32, u32), engine: &RayEngine) {
        // A ray from an origin that is not snapped would miss the surface of its point.
        let light = Light { position: engine.place(scene.light.position) };
        let bar = Progress::new("shadows", Some(self.hits.len() as u64));
        let mut occluded = Vec::new();
        batches(width, height, engine.batch_size(), |batch| {
            let index = |(x, y): (u32, u32)| y as usize * width as usize + x as usize;
            let seen = batch.par_iter().filter(|&&pixel| self.hits[index(pixel)].is_hit());
            let seen: Vec<(u32, u32)> = seen.copied().collect();
            let ray = |&(x, y): &(u32, u32)| {
                let ray = scene.camera.ray(x, y, width, height);
                let ray = Ray { origin: engine.place(ray.origin), ..ray };
                light.shadow_ray(hit_point(&ray, &self.hits[index((x, y))]))
            };
            let rays: Vec<Ray> = seen.par_iter().map(ray).collect();
            occluded.clear();
            occluded.resize(rays.len(), false);
            self.counts += timed(&mut self.shadow_seconds, || engine.any(&rays, &mut occluded));
            self.shadow_rays += rays.len() as u64;
            for (pixel, occluded) in seen.into_iter().zip(&occluded) {
                self.lit[index(pixel)] = !occluded;
            }
            bar.add(batch.len());
        });
    }

    /// The largest distance, along a pixel's ray and in units of the scene, between two frames' hits of
    /// the same triangle.
    pub(crate) fn largest_distance(
        &self,
        other: &Self,
        scene: &Scene,
        (width, height): (u32, u32),
    ) -> f64 {
        let pixels = self.hits.par_iter().zip(&other.hits).enumerate();
        let distances = pixels.map(|(i, (a, b))| {
            if a.triangle != b.triangle || !a.is_hit() {
                return 0.0;
            }
            let (x, y) = (i as u32 % width, i as u32 / width);
            let dir = scene.camera.ray(x, y, width, height).dir.map(f64::from);
            (a.t - b.t).abs() * dir.iter().map(|x| x * x).sum::<f64>().sqrt()
        });
        distances.reduce(|| 0.0, f64::max)
    }
}

/// A buffer; an error if it is too large for this machine.
fn filled<T: Clone>(count: usize, value: T) -> Result<Vec<T>> {
    let mut buffer = Vec::new();
    let room = buffer.try_reserve_exact(count);
    room.map_err(|_| Error::no_memory(format_args!("{count} pixels")))?;
    buffer.resize(count, value);
    Ok(buffer)
}
