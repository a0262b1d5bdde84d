//! A frame: the visibility buffer and the shadow mask of one image, drawn by any engine.

use clap::ValueEnum;
use intertri::{Counts, Hit, RayOf, Scalar};
use intertri_scene::{Coordinate, Light, Scene, SceneGeometry, check_size, hit_point};
use rayon::prelude::*;
use serde::Serialize;

use crate::engine::engines::Engines;
use crate::engine::memory::{filled, room};
use crate::engine::name::EngineName;
use crate::engine::pixels::Tiles;
use crate::engine::raster::Raster;
use crate::engine::tracer::Tracer;
use crate::error::Result;
use crate::io::progress::{Progress, timed};

/// The method for finding shadows.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Shadows {
    /// Trace a ray between the light and each visible point; for raster, exact does this
    Rays,
    /// Count the shadow volumes that contain each point, without rays
    Volumes,
    /// Light everything
    None,
}

/// The name of the buffers' elements in error messages.
const PIXELS: &str = "pixels";

/// The visibility buffer and the shadow mask.
#[derive(Default)]
pub(crate) struct Frame {
    /// The hit at each pixel, row by row from the top left.
    pub(crate) hits: Vec<Hit>,
    /// Whether the light reaches the hit point; true if there is no hit, or if shadows are off.
    pub(crate) lit: Vec<bool>,
    /// The number of shadow rays.
    pub(crate) shadow_rays: u64,
    /// The numbers of ray/triangle tests for all rays.
    pub(crate) counts: Counts,
    /// The time for the visibility buffer.
    pub(crate) trace_seconds: f64,
    /// The time for the shadow mask.
    pub(crate) shadow_seconds: f64,
}

impl Frame {
    /// Draws `scene` with the named engine, and finds the shadows on the visible points. Each
    /// engine traces its own shadow rays, except that `exact` traces those for the z-buffer.
    pub(crate) fn draw(
        scene: &Scene,
        raster: &Raster<'_>,
        engines: &mut Engines<'_>,
        name: EngineName,
        shadows: Shadows,
    ) -> Result<Self> {
        let mut frame = Self::default();
        // Time all work for an image, including creating rays and storing results. The engines time
        // their own builds.
        let tracer = if name == EngineName::Raster { EngineName::Exact } else { name };
        let (mut trace_seconds, mut shadow_seconds) = (0.0, 0.0);

        // Fill the visibility buffer.
        if name == EngineName::Raster {
            let _bar = Progress::new("draw", None);
            frame.hits = timed(&mut trace_seconds, || raster.hits())?;
        } else {
            let engine = engines.engine(tracer)?;
            timed(&mut trace_seconds, || frame.trace(scene, raster.size, &engine))?;
        }

        // Fill the shadow mask.
        let pixels = frame.hits.len();
        match shadows {
            Shadows::None => frame.lit = filled(pixels, true, PIXELS)?,
            Shadows::Rays => {
                let engine = engines.engine(tracer)?;
                timed(&mut shadow_seconds, || frame.trace_shadows(scene, raster.size, &engine))?;
            }
            Shadows::Volumes => {
                let _bar = Progress::new("shadows", None);
                frame.lit = timed(&mut shadow_seconds, || raster.lit(&frame.hits))?;
            }
        }
        Ok(Self { trace_seconds, shadow_seconds, ..frame })
    }

    /// Draws `scene`, in either scalar, with an engine that traces rays.
    pub(crate) fn traced<T: Tracer, M: SceneGeometry<T::Scalar>>(
        scene: &Scene<T::Scalar, M>,
        size: (u32, u32),
        engine: &T,
        shadows: bool,
    ) -> Result<Self> {
        let mut frame = Self::default();
        let (mut trace_seconds, mut shadow_seconds) = (0.0, 0.0);
        timed(&mut trace_seconds, || frame.trace(scene, size, engine))?;
        if shadows {
            timed(&mut shadow_seconds, || frame.trace_shadows(scene, size, engine))?;
        } else {
            frame.lit = filled(frame.hits.len(), true, PIXELS)?;
        }
        Ok(Self { trace_seconds, shadow_seconds, ..frame })
    }

    /// Traces a camera ray through each pixel.
    fn trace<T: Tracer, M: SceneGeometry<T::Scalar>>(
        &mut self,
        scene: &Scene<T::Scalar, M>,
        size: (u32, u32),
        engine: &T,
    ) -> Result<()> {
        let (width, height) = size;
        self.hits = filled(check_size(width, height)?, Hit::MISS, PIXELS)?;
        let bar = Progress::new("trace", Some(self.hits.len() as u64));
        let tiles = Tiles::new(size);
        let many = in_bands(tiles, engine).min(self.hits.len());
        let (mut rays, mut found) = (room(many, PIXELS)?, filled(many, Hit::MISS, PIXELS)?);
        for (hits, first) in bands(&mut self.hits, tiles, engine) {
            let ray = |place| {
                let (x, y) = tiles.pixel(place);
                scene.camera.ray(x, y, width, height)
            };
            (first..first + hits.len()).into_par_iter().map(ray).collect_into_vec(&mut rays);
            found.resize(rays.len(), Hit::MISS);
            for (rays, found) in in_batches(&rays, &mut found, engine) {
                self.counts += engine.closest(rays, found);
                bar.add(rays.len());
            }
            let rows = hits.par_chunks_mut(width as usize).enumerate();
            rows.for_each(|(row, hits)| {
                let y = (first / width as usize + row) as u32;
                for (x, hit) in (0..).zip(hits) {
                    *hit = found[tiles.place((x, y)) - first];
                }
            });
        }
        Ok(())
    }

    /// Traces a shadow ray between the light and each visible point. If the engine is exact, the
    /// ray starts at the point, so that no part of the segment is omitted; otherwise it starts at
    /// the light.
    fn trace_shadows<T: Tracer, M: SceneGeometry<T::Scalar>>(
        &mut self,
        scene: &Scene<T::Scalar, M>,
        size: (u32, u32),
        engine: &T,
    ) -> Result<()> {
        let (width, height) = size;
        self.lit = filled(self.hits.len(), true, PIXELS)?;
        let bar = Progress::new("shadows", Some(self.hits.len() as u64));
        let tiles = Tiles::new(size);
        let hits = &self.hits;
        let index = |(x, y): (u32, u32)| y as usize * width as usize + x as usize;
        let many = in_bands(tiles, engine).min(hits.len());
        let (mut rays, mut occluded) = (room(many, PIXELS)?, filled(many, false, PIXELS)?);
        for (lit, first) in bands(&mut self.lit, tiles, engine) {
            let pixels = (first..first + lit.len()).into_par_iter().map(|place| tiles.pixel(place));
            let seen: Vec<(u32, u32)> =
                pixels.filter(|&pixel| hits[index(pixel)].is_hit()).collect();
            let ray = |&(x, y): &(u32, u32)| {
                let hit = &hits[index((x, y))];
                if engine.is_exact() {
                    return scene.light.shadow_ray_of(hit, &scene.mesh.triangle_of(hit));
                }
                let ray = scene.camera.ray(x, y, width, height);
                let ray = RayOf { origin: engine.place(ray.origin), ..ray };
                let point = hit_point(&ray, hit);
                // Aim from the snapped light. If the engine moved the origin after the ray was
                // aimed, the ray would miss the visible point.
                Light::shadow_ray_from(engine.place(scene.light.origin(point)), point)
            };
            seen.par_iter().map(ray).collect_into_vec(&mut rays);
            occluded.resize(rays.len(), false);
            for (rays, occluded) in in_batches(&rays, &mut occluded, engine) {
                self.counts += engine.any(rays, occluded);
            }
            self.shadow_rays += rays.len() as u64;
            for (pixel, occluded) in seen.into_iter().zip(&occluded) {
                lit[index(pixel) - first] = !occluded;
            }
            bar.add(lit.len());
        }
        Ok(())
    }

    /// Returns the number of pixels that show a triangle.
    pub(crate) fn seen(&self) -> u64 {
        self.hits.par_iter().filter(|hit| hit.is_hit()).count() as u64
    }

    /// Returns the number of pixels in shadow.
    pub(crate) fn dark(&self) -> u64 {
        self.lit.par_iter().filter(|lit| !**lit).count() as u64
    }

    /// Returns the largest distance between two frames' hits on the same triangle, along a pixel's
    /// ray and in scene units.
    pub(crate) fn largest_distance<S: Coordinate>(
        &self,
        other: &Self,
        scene: &Scene<S>,
        (width, height): (u32, u32),
    ) -> f64 {
        let pixels = self.hits.par_iter().zip(&other.hits).enumerate();
        let distances = pixels.map(|(i, (a, b))| {
            if a.triangle != b.triangle || !a.is_hit() {
                return 0.0;
            }
            let (x, y) = (i as u32 % width, i as u32 / width);
            let dir = scene.camera.ray(x, y, width, height).dir.map(Into::<f64>::into);
            (a.t - b.t).abs() * dir.iter().map(|x| x * x).sum::<f64>().sqrt()
        });
        distances.reduce(|| 0.0, f64::max)
    }
}

/// Splits the entries into groups of several whole bands, large enough to keep all threads busy.
/// Each group comes with the position of its first entry.
fn bands<'a, T>(
    all: &'a mut [T],
    tiles: Tiles,
    engine: &impl Tracer,
) -> impl Iterator<Item = (&'a mut [T], usize)> {
    let entries = in_bands(tiles, engine);
    all.chunks_mut(entries).zip((0..).step_by(entries))
}

/// Returns the number of entries in a group of bands.
fn in_bands(tiles: Tiles, engine: &impl Tracer) -> usize {
    engine.batch_size().div_ceil(tiles.band()) * tiles.band()
}

/// Splits rays and the buffer for their results into batches that are traced one at a time.
fn in_batches<'a, S: Scalar, T>(
    rays: &'a [RayOf<S>],
    answers: &'a mut [T],
    engine: &impl Tracer,
) -> impl Iterator<Item = (&'a [RayOf<S>], &'a mut [T])> {
    let size = engine.batch_size();
    rays.chunks(size).zip(answers.chunks_mut(size))
}
