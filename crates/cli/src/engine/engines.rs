//! The engines of one model, made by name; those that trace the same hierarchy share it.

use std::sync::Arc;

use intertri::fixed::Bits;
use intertri::{Certified, Double, Threshold, Triangle};
use intertri_trace::Bvh;

use crate::engine::fixed::{FixedScene, GridReport};
use crate::engine::name::EngineName;
use crate::engine::ray_engine::RayEngine;
use crate::engine::reference::ReferenceScene;
use crate::error::{Error, Result};
use crate::io::progress::{Progress, timed};

/// Makes engines for one model.
pub(crate) struct Engines<'a> {
    triangles: &'a [Triangle],
    threshold: Threshold,
    bits: Bits,
    /// Where rays start: the grid must hold these points.
    origins: Vec<[f32; 3]>,
    bvh: Option<Arc<Bvh>>,
    fixed: Option<Arc<FixedScene>>,
    /// How long building has taken so far.
    pub(crate) seconds: f64,
}

impl<'a> Engines<'a> {
    pub(crate) fn new(triangles: &'a [Triangle], threshold: Threshold) -> Self {
        let (bits, origins) = (Bits::FINE, vec![]);
        Self { triangles, threshold, bits, origins, bvh: None, fixed: None, seconds: 0.0 }
    }

    /// The same with a grid of so many bits, for rays from those points.
    pub(crate) fn on_grid(self, bits: Bits, origins: Vec<[f32; 3]>) -> Self {
        Self { bits, origins, ..self }
    }

    /// The engine of that name.
    pub(crate) fn engine(&mut self, name: EngineName) -> Result<RayEngine> {
        Ok(match name {
            EngineName::Certified => {
                RayEngine::Certified(self.bvh()?, Certified::new(self.threshold))
            }
            EngineName::Double => RayEngine::Double(self.bvh()?, Double::new(self.threshold)),
            EngineName::Fixed => RayEngine::Fixed(self.fixed()?),
            EngineName::Reference => timed(&mut self.seconds, || {
                RayEngine::Reference(ReferenceScene::new(self.triangles, self.threshold))
            }),
            EngineName::Raster => {
                return Err(Error::new(
                    "engine raster draws pictures and answers no rays; choose another",
                ));
            }
        })
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

    fn fixed(&mut self) -> Result<Arc<FixedScene>> {
        if let Some(fixed) = &self.fixed {
            return Ok(fixed.clone());
        }
        let make = || FixedScene::new(self.triangles, &self.origins, self.bits);
        let fixed = timed(&mut self.seconds, make)?;
        Ok(self.fixed.insert(Arc::new(fixed)).clone())
    }

    /// The grid of the engine `fixed`, if that was asked for.
    pub(crate) fn grid(&self) -> Option<GridReport> {
        self.fixed.as_ref().map(|fixed| fixed.report())
    }
}
