//! The engines for f64 scenes: `exact` and its oracle.

use std::sync::Arc;

use intertri::{Counts, Crossing, Hit, Ray64, Triangle64};
use intertri_trace::Bvh;

use crate::engine::memory;
use crate::engine::name::EngineName;
use crate::engine::oracle;
use crate::engine::tracer::Tracer;
use crate::error::{Error, Result};
use crate::io::progress::Progress;

/// An engine for f64 coordinates.
pub(crate) enum Engine64 {
    Exact(Arc<Bvh<f64>>),
    Oracle(Vec<Triangle64>),
}

impl Engine64 {
    /// Refuses an engine that does not support `--scalar f64`.
    pub(crate) fn check(name: EngineName) -> Result<()> {
        let why = match name {
            EngineName::Exact | EngineName::Oracle => return Ok(()),
            EngineName::Certified | EngineName::Reference | EngineName::Raster => {
                "supports only f32 coordinates"
            }
            EngineName::Fixed => "snaps f32 coordinates to its grid",
        };
        Err(Error::usage(format!("--scalar f64: the {name} engine {why}; choose exact or oracle")))
    }

    /// Creates the named engine, which must pass [`Engine64::check`], for the given triangles. The
    /// `exact` engine uses `bvh` as its hierarchy, or builds one if `bvh` is `None`. The oracle
    /// ignores `bvh`.
    pub(crate) fn new(
        name: EngineName,
        triangles: Vec<Triangle64>,
        bvh: Option<Arc<Bvh<f64>>>,
    ) -> Result<Self> {
        if name == EngineName::Oracle {
            return Ok(Self::Oracle(triangles));
        }
        if let Some(bvh) = bvh {
            return Ok(Self::Exact(bvh));
        }
        let bar = Progress::new("build", Some(triangles.len() as u64));
        let bvh = Bvh::with_progress(&triangles, &|done, total| bar.set(done, total))?;
        Ok(Self::Exact(Arc::new(bvh)))
    }
}

impl Tracer for Engine64 {
    type Scalar = f64;

    fn chunk_size(&self) -> usize {
        match self {
            Self::Exact(_) => 4096,
            Self::Oracle(_) => 16,
        }
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn closest(&self, rays: &[Ray64], hits: &mut [Hit]) -> Counts {
        match self {
            Self::Exact(bvh) => bvh.query().closest_batch_into(rays, hits),
            Self::Oracle(triangles) => {
                oracle::closest_batch(triangles, rays, hits);
                Counts::default()
            }
        }
    }

    fn any(&self, rays: &[Ray64], hits: &mut [bool]) -> Counts {
        match self {
            Self::Exact(bvh) => bvh.query().any_batch_into(rays, hits),
            Self::Oracle(triangles) => {
                oracle::any_batch(triangles, rays, hits);
                Counts::default()
            }
        }
    }

    fn all(&self, ray: &Ray64) -> Result<Vec<Hit>> {
        match self {
            Self::Exact(bvh) => memory::hits(bvh.query(), ray),
            Self::Oracle(triangles) => Ok(oracle::all(triangles, ray)),
        }
    }

    fn crossings(&self, ray: &Ray64) -> Result<Vec<Crossing>> {
        match self {
            Self::Exact(bvh) => memory::crossings(bvh.query(), ray),
            Self::Oracle(_) => Ok(Vec::new()),
        }
    }
}
