//! The engines that can be chosen by name, all asked the same way.

use std::sync::Arc;

use clap::ValueEnum;
use intertri::fixed::Bits;
use intertri::{Certified, Counts, Double, Hit, Ray, Threshold, Triangle};
use intertri_reference as reference;
use intertri_trace::Bvh;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::{Error, Result};
use crate::fixed::{self, OnGrid};
use crate::progress::{Progress, timed};

/// What finds the hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Name {
    /// f32 lanes under a proven bound, f64 where it cannot decide; a hierarchy
    Certified,
    /// f64 lanes; a hierarchy
    Double,
    /// Integers: exact on a grid that the scene is snapped to (--grid), and so another scene's
    /// answers by a rounding; a hierarchy
    Fixed,
    /// The scalar f64 reference in a plain loop over all triangles: slow
    Reference,
    /// The z-buffer: no rays, and so another witness; for pictures alone
    Raster,
}

/// Makes engines for one model; those that need a hierarchy share one.
pub(crate) struct Engines<'a> {
    triangles: &'a [Triangle],
    threshold: Threshold,
    bits: Bits,
    /// Where rays start, for the grid to hold.
    from: Vec<[f32; 3]>,
    bvh: Option<Arc<Bvh>>,
    fixed: Option<Arc<OnGrid>>,
    /// How long the building took so far.
    pub(crate) seconds: f64,
}

impl<'a> Engines<'a> {
    pub(crate) fn new(triangles: &'a [Triangle], threshold: Threshold) -> Self {
        let (bits, from) = (Bits::FINE, vec![]);
        Self { triangles, threshold, bits, from, bvh: None, fixed: None, seconds: 0.0 }
    }

    /// The same with a grid of so many bits, for rays from those points.
    pub(crate) fn on_grid(self, bits: Bits, from: Vec<[f32; 3]>) -> Self {
        Self { bits, from, ..self }
    }

    /// The grid of the engine `fixed`, if that was asked for.
    pub(crate) fn grid(&self) -> Option<fixed::Report> {
        self.fixed.as_ref().map(|fixed| fixed.report())
    }

    /// The engine of that name.
    pub(crate) fn engine(&mut self, name: Name) -> Result<Engine> {
        Ok(match name {
            Name::Certified => Engine::Certified(self.bvh()?, Certified::new(self.threshold)),
            Name::Double => Engine::Double(self.bvh()?, Double::new(self.threshold)),
            Name::Fixed => Engine::Fixed(self.fixed()?),
            Name::Reference => timed(&mut self.seconds, || {
                let scene = reference::Scene::from_triangles(self.triangles.iter().map(|t| t.0));
                Engine::Reference(scene.with_threshold(self.threshold.get()))
            }),
            Name::Raster => {
                return Err(Error::new(
                    "engine raster draws pictures and answers no rays; choose another",
                ));
            }
        })
    }

    fn fixed(&mut self) -> Result<Arc<OnGrid>> {
        if let Some(fixed) = &self.fixed {
            return Ok(fixed.clone());
        }
        let make = || OnGrid::new(self.triangles, &self.from, self.bits);
        let fixed = timed(&mut self.seconds, make)?;
        Ok(self.fixed.insert(Arc::new(fixed)).clone())
    }

    fn bvh(&mut self) -> Result<Arc<Bvh>> {
        if let Some(bvh) = &self.bvh {
            return Ok(bvh.clone());
        }
        let bar = Progress::new("build", Some(self.triangles.len() as u64));
        let bvh = timed(&mut self.seconds, || {
            Bvh::with_progress(self.triangles, &|done, total| bar.set(done, total))
        })?;
        Ok(self.bvh.insert(Arc::new(bvh)).clone())
    }
}

/// Something that answers rays.
pub(crate) enum Engine {
    Certified(Arc<Bvh>, Certified),
    Double(Arc<Bvh>, Double),
    Fixed(Arc<OnGrid>),
    Reference(reference::Scene),
}

impl Engine {
    /// Rays that a thread is best asked at once: few enough that they and their answers stay in the cache.
    pub(crate) fn piece(&self) -> usize {
        match self {
            Self::Certified(..) | Self::Double(..) | Self::Fixed(_) => 4096,
            Self::Reference(_) => 16,
        }
    }

    /// How many rays of a picture to ask at once: enough for all threads, few enough for a bar to move.
    pub(crate) fn batch(&self) -> usize {
        64 * self.piece()
    }

    /// Where a point is for this engine: `fixed` has it on its grid.
    pub(crate) fn place(&self, point: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Fixed(scene) => scene.place(point),
            _ => point,
        }
    }

    /// The closest hit of each ray. The reference counts nothing, nor does `fixed`.
    pub(crate) fn closest(&self, rays: &[Ray], hits: &mut [Hit]) -> Counts {
        match self {
            Self::Certified(bvh, mode) => bvh.closest_of_each(mode, rays, hits),
            Self::Double(bvh, mode) => bvh.closest_of_each(mode, rays, hits),
            Self::Fixed(scene) => {
                scene.closest(rays, hits);
                Counts::default()
            }
            Self::Reference(scene) => {
                rays.par_iter().zip(hits).for_each(|(ray, hit)| {
                    let line = line(ray);
                    let closest = scene.closest(&line, ray.t_min.into(), ray.t_max.into());
                    *hit = closest.map_or(Hit::MISS, |found| hit_of(scene, &line, found));
                });
                Counts::default()
            }
        }
    }

    /// Whether each ray hits anything. The reference counts nothing, nor does `fixed`.
    pub(crate) fn any(&self, rays: &[Ray], hits: &mut [bool]) -> Counts {
        match self {
            Self::Certified(bvh, mode) => bvh.any_of_each(mode, rays, hits),
            Self::Double(bvh, mode) => bvh.any_of_each(mode, rays, hits),
            Self::Fixed(scene) => {
                scene.any(rays, hits);
                Counts::default()
            }
            Self::Reference(scene) => {
                rays.par_iter().zip(hits).for_each(|(ray, hit)| {
                    *hit = scene.any(&line(ray), ray.t_min.into(), ray.t_max.into());
                });
                Counts::default()
            }
        }
    }

    /// Every hit of a ray, in the order of the triangles.
    pub(crate) fn all(&self, ray: &Ray) -> Vec<Hit> {
        match self {
            Self::Certified(bvh, mode) => bvh.all(mode, ray),
            Self::Double(bvh, mode) => bvh.all(mode, ray),
            Self::Fixed(scene) => scene.all(ray),
            Self::Reference(scene) => {
                let line = line(ray);
                let all = scene.all(&line, ray.t_min.into(), ray.t_max.into());
                all.into_iter().map(|found| hit_of(scene, &line, found)).collect()
            }
        }
    }
}

/// The reference's ray.
fn line(ray: &Ray) -> reference::Ray {
    reference::Ray::new(ray.origin, ray.dir)
}

/// What the reference found, as the kernel says it.
fn hit_of(scene: &reference::Scene, line: &reference::Ray, (obj, t): (usize, f64)) -> Hit {
    let (u, v) = scene.barycentric(obj, line);
    Hit { t, u, v, triangle: obj as u64 }
}
