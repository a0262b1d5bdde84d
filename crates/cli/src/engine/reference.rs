//! The `reference` engine: the scalar f64 reference in a plain loop over all triangles.

use intertri::{Hit, Ray, Threshold, Triangle};
use intertri_reference as reference;
use rayon::prelude::*;

/// A scene, converted to the types of the reference.
pub(crate) struct ReferenceScene(reference::Scene);

impl ReferenceScene {
    pub(crate) fn new(triangles: &[Triangle], threshold: Threshold) -> Self {
        let scene = reference::Scene::from_triangles(triangles.iter().map(|t| t.0));
        Self(scene.with_threshold(threshold.get()))
    }

    /// Finds the closest hit of each ray.
    pub(crate) fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        rays.par_iter().zip(hits).for_each(|(ray, hit)| {
            let line = line(ray);
            let closest = self.0.closest(&line, ray.t_min.into(), ray.t_max.into());
            *hit = closest.map_or(Hit::MISS, |found| self.hit(&line, found));
        });
    }

    /// Finds whether each ray hits anything.
    pub(crate) fn any(&self, rays: &[Ray], hits: &mut [bool]) {
        rays.par_iter().zip(hits).for_each(|(ray, hit)| {
            *hit = self.0.any(&line(ray), ray.t_min.into(), ray.t_max.into());
        });
    }

    /// Returns every hit of a ray, ordered by t, then by triangle.
    pub(crate) fn all(&self, ray: &Ray) -> Vec<Hit> {
        let line = line(ray);
        let mut all = self.0.all(&line, ray.t_min.into(), ray.t_max.into());
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        all.into_iter().map(|found| self.hit(&line, found)).collect()
    }

    /// Converts a hit to the kernel's type.
    fn hit(&self, line: &reference::Ray, (obj, t): (usize, f64)) -> Hit {
        let (u, v) = self.0.barycentric(obj, line);
        Hit { t, u, v, triangle: obj as u32, geometry: 0 }
    }
}

/// Converts a ray to the reference's type.
fn line(ray: &Ray) -> reference::Ray {
    reference::Ray::new(ray.origin, ray.dir)
}
