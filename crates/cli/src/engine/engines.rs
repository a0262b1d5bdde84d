//! Creates a model's engines by name. Engines that trace the same hierarchy share it.

use std::sync::Arc;

use intertri::fixed::Bits;
use intertri::{Mode, Threshold, Triangle};
use intertri_trace::Bvh;

use crate::engine::fixed::{FixedScene, GridReport};
use crate::engine::name::EngineName;
use crate::engine::ray_engine::RayEngine;
use crate::engine::reference::ReferenceScene;
use crate::error::{Error, Result};
use crate::io::progress::{Progress, timed};

/// Creates engines for one model.
pub(crate) struct Engines<'a> {
    triangles: &'a [Triangle],
    threshold: Threshold,
    bits: Bits,
    /// Points that the grid must contain besides the triangles: ray origins, or the corners of a
    /// box around them.
    room_for: Vec<[f32; 3]>,
    bvh: Option<Arc<Bvh>>,
    fixed: Option<Arc<FixedScene>>,
    /// The time spent on building so far.
    pub(crate) seconds: f64,
}

impl<'a> Engines<'a> {
    pub(crate) fn new(triangles: &'a [Triangle], threshold: Threshold) -> Self {
        let (bits, room_for) = (Bits::FINE, vec![]);
        Self { triangles, threshold, bits, room_for, bvh: None, fixed: None, seconds: 0.0 }
    }

    /// Uses a grid with `bits` bits per coordinate that contains the model and these points.
    pub(crate) fn on_grid(self, bits: Bits, room_for: Vec<[f32; 3]>) -> Self {
        Self { bits, room_for, ..self }
    }

    /// Uses an existing hierarchy over the triangles, if there is one.
    pub(crate) fn with_bvh(self, bvh: Option<Arc<Bvh>>) -> Self {
        Self { bvh, ..self }
    }

    /// Returns the named engine, and builds the hierarchy or grid that the engine needs.
    pub(crate) fn engine(&mut self, name: EngineName) -> Result<RayEngine> {
        Ok(match name {
            EngineName::Exact => RayEngine::Hierarchy(self.bvh()?, Mode::exact()),
            EngineName::Certified => {
                RayEngine::Hierarchy(self.bvh()?, Mode::certified_with(self.threshold))
            }
            EngineName::Fixed => RayEngine::Fixed(self.fixed()?),
            EngineName::Reference => timed(&mut self.seconds, || {
                RayEngine::Reference(ReferenceScene::new(self.triangles, self.threshold))
            }),
            EngineName::Oracle => RayEngine::Oracle(self.triangles.to_vec()),
            EngineName::Raster => {
                return Err(Error::usage(EngineName::ANSWERS_NO_RAYS));
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
        let make = || FixedScene::new(self.triangles, &self.room_for, self.bits);
        let fixed = timed(&mut self.seconds, make)?;
        Ok(self.fixed.insert(Arc::new(fixed)).clone())
    }

    /// Returns the grid of the `fixed` engine, if that engine was created.
    pub(crate) fn grid(&self) -> Option<GridReport> {
        self.fixed.as_ref().map(|fixed| fixed.report())
    }
}
