//! The engines that answer rays, all asked the same way.

use std::sync::Arc;

use intertri::{Certified, Counts, Crossing, Double, Exact, Hit, Ray, Triangle};
use intertri_trace::Bvh;

use crate::engine::fixed::FixedScene;
use crate::engine::oracle;
use crate::engine::reference::ReferenceScene;

/// Something that answers rays.
pub(crate) enum RayEngine {
    Exact(Arc<Bvh>, Exact),
    Certified(Arc<Bvh>, Certified),
    Double(Arc<Bvh>, Double),
    Fixed(Arc<FixedScene>),
    Reference(ReferenceScene),
    Oracle(Vec<Triangle>),
}

impl RayEngine {
    /// How many rays a thread should ask at once: few enough that they and their answers stay in the
    /// cache.
    pub(crate) fn chunk_size(&self) -> usize {
        match self {
            Self::Reference(_) | Self::Oracle(_) => 16,
            _ => 4096,
        }
    }

    /// How many rays of a picture to ask at once: enough for all threads, few enough for a bar to move.
    pub(crate) fn batch_size(&self) -> usize {
        64 * self.chunk_size()
    }

    /// Whether its answers are right on the coordinates as given.
    pub(crate) fn is_exact(&self) -> bool {
        matches!(self, Self::Exact(..) | Self::Oracle(_))
    }

    /// Where a point is for this engine: `fixed` has it on its grid.
    pub(crate) fn place(&self, point: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Fixed(scene) => scene.place(point),
            _ => point,
        }
    }

    /// The closest hit of each ray. Only what walks a hierarchy of f32 counts its tests.
    pub(crate) fn closest(&self, rays: &[Ray], hits: &mut [Hit]) -> Counts {
        match self {
            Self::Exact(bvh, mode) => bvh.closest_batch(mode, rays, hits),
            Self::Certified(bvh, mode) => bvh.closest_batch(mode, rays, hits),
            Self::Double(bvh, mode) => bvh.closest_batch(mode, rays, hits),
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

    /// Whether each ray hits anything. Only what walks a hierarchy of f32 counts its tests.
    pub(crate) fn any(&self, rays: &[Ray], hits: &mut [bool]) -> Counts {
        match self {
            Self::Exact(bvh, mode) => bvh.any_batch(mode, rays, hits),
            Self::Certified(bvh, mode) => bvh.any_batch(mode, rays, hits),
            Self::Double(bvh, mode) => bvh.any_batch(mode, rays, hits),
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

    /// Every hit of a ray, in order of t; of equal t, of the triangles.
    pub(crate) fn all(&self, ray: &Ray) -> Vec<Hit> {
        match self {
            Self::Exact(bvh, mode) => bvh.all(mode, ray),
            Self::Certified(bvh, mode) => bvh.all(mode, ray),
            Self::Double(bvh, mode) => bvh.all(mode, ray),
            Self::Fixed(scene) => scene.all(ray),
            Self::Reference(scene) => scene.all(ray),
            Self::Oracle(triangles) => oracle::all(triangles, ray),
        }
    }

    /// Where a ray crosses, each edge and corner once, in order of t; of equal t, of the triangles.
    /// Nothing of engines that have no such rule: `trace` refuses to ask them.
    pub(crate) fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        match self {
            Self::Exact(bvh, mode) => bvh.crossings(mode, ray),
            Self::Fixed(scene) => scene.crossings(ray),
            _ => Vec::new(),
        }
    }
}
