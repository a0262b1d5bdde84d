//! Finds hits in plain loops over all triangles. Every faster search must return the same results.
//!
//! A hit counts if [`Scene::inter_tri`] returns 1 and `t_min <= t < t_max`. The interval is open at
//! its far end, so a `t` of infinity never counts, whatever `t_max` is. If an end of the interval
//! is NaN, no hit counts. With a threshold of 0 or more, there is no hit if the ray or the triangle
//! is not finite.

use alloc::vec::Vec;

use crate::inter_tri::{Ray, Scene};

impl Scene {
    /// Returns `t` if the ray hits triangle `obj` with `t_min <= t < t_max`.
    ///
    /// # Panics
    /// Panics if `obj` is out of bounds.
    pub fn hit(&self, obj: usize, ray: &Ray, t_min: f64, t_max: f64) -> Option<f64> {
        let mut t = f64::NAN;
        let inside = self.inter_tri(obj, ray, &mut t) == 1;
        (inside && t_min <= t && t < t_max).then_some(t)
    }

    /// Returns the index and `t` of the triangle with the smallest `t`. If several triangles have
    /// the same `t`, the lowest index wins.
    pub fn closest(&self, ray: &Ray, t_min: f64, t_max: f64) -> Option<(usize, f64)> {
        let mut closest = None;
        let mut t_closest = t_max;
        for obj in 0..self.trian.len() {
            // Only a smaller t displaces an earlier triangle.
            if let Some(t) = self.hit(obj, ray, t_min, t_closest) {
                closest = Some((obj, t));
                t_closest = t;
            }
        }
        closest
    }

    /// Returns whether the ray hits any triangle.
    pub fn any(&self, ray: &Ray, t_min: f64, t_max: f64) -> bool {
        (0..self.trian.len()).any(|obj| self.hit(obj, ray, t_min, t_max).is_some())
    }

    /// Returns the index and `t` of every triangle that the ray hits, in ascending order by index.
    pub fn all(&self, ray: &Ray, t_min: f64, t_max: f64) -> Vec<(usize, f64)> {
        (0..self.trian.len())
            .filter_map(|obj| self.hit(obj, ray, t_min, t_max).map(|t| (obj, t)))
            .collect()
    }
}
