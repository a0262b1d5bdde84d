//! The engines for f32 scenes, unified in one type.

use std::sync::Arc;

use intertri::{Counts, Crossing, Hit, Mode, Ray, Triangle};
use intertri_trace::Bvh;

use crate::engine::fixed::FixedScene;
use crate::engine::memory;
use crate::engine::oracle;
use crate::engine::reference::ReferenceScene;
use crate::engine::tracer::Tracer;
use crate::error::Result;

/// An engine for f32 coordinates.
pub(crate) enum RayEngine {
    /// A hierarchy, and the mode to trace it in.
    Hierarchy(Arc<Bvh>, Mode),
    Fixed(Arc<FixedScene>),
    Reference(ReferenceScene),
    Oracle(Vec<Triangle>),
}

impl Tracer for RayEngine {
    type Scalar = f32;

    fn chunk_size(&self) -> usize {
        match self {
            Self::Reference(_) | Self::Oracle(_) => 16,
            _ => 4096,
        }
    }

    fn is_exact(&self) -> bool {
        match self {
            Self::Hierarchy(_, mode) => *mode == Mode::exact(),
            Self::Oracle(_) => true,
            Self::Fixed(_) | Self::Reference(_) => false,
        }
    }

    fn place(&self, point: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Fixed(scene) => scene.place(point),
            _ => point,
        }
    }

    fn is_outside(&self, point: [f32; 3]) -> bool {
        matches!(self, Self::Fixed(scene) if scene.is_outside(point))
    }

    fn closest(&self, rays: &[Ray], hits: &mut [Hit]) -> Counts {
        match self {
            Self::Hierarchy(bvh, mode) => bvh.query().mode(*mode).closest_batch_into(rays, hits),
            Self::Fixed(scene) => {
                scene.closest(rays, hits);
                Counts::default()
            }
            Self::Reference(scene) => {
                scene.closest(rays, hits);
                Counts::default()
            }
            Self::Oracle(triangles) => {
                oracle::closest_batch(triangles, rays, hits);
                Counts::default()
            }
        }
    }

    fn any(&self, rays: &[Ray], hits: &mut [bool]) -> Counts {
        match self {
            Self::Hierarchy(bvh, mode) => bvh.query().mode(*mode).any_batch_into(rays, hits),
            Self::Fixed(scene) => {
                scene.any(rays, hits);
                Counts::default()
            }
            Self::Reference(scene) => {
                scene.any(rays, hits);
                Counts::default()
            }
            Self::Oracle(triangles) => {
                oracle::any_batch(triangles, rays, hits);
                Counts::default()
            }
        }
    }

    fn all(&self, ray: &Ray) -> Result<Vec<Hit>> {
        match self {
            Self::Hierarchy(bvh, mode) => memory::hits(bvh.query().mode(*mode), ray),
            Self::Fixed(scene) => scene.all(ray),
            Self::Reference(scene) => Ok(scene.all(ray)),
            Self::Oracle(triangles) => Ok(oracle::all(triangles, ray)),
        }
    }

    fn crossings(&self, ray: &Ray) -> Result<Vec<Crossing>> {
        match self {
            Self::Hierarchy(bvh, _) => memory::crossings(bvh.query(), ray),
            Self::Fixed(scene) => scene.crossings(ray),
            Self::Reference(_) | Self::Oracle(_) => Ok(Vec::new()),
        }
    }
}
