//! Checks the true answers against a plain loop over the scalar f64 reference.

use intertri::Ray;
use intertri_scene::Mesh;
use rayon::prelude::*;

use crate::engine::{Answer, Question};

/// Compares at most `some` evenly spaced answers with those of the reference. Returns how many were
/// compared, and how many of them differ: in hit or miss and, for closest hits, in the triangle
/// index or in t.
pub fn differences(
    mesh: &Mesh,
    rays: &[Ray],
    question: Question,
    truth: &[Answer],
    some: usize,
) -> (usize, usize) {
    if some == 0 {
        return (0, 0);
    }
    let vertices = mesh.positions.iter().map(|p| p.map(f64::from).into()).collect();
    let corners = mesh.triangles.iter().map(|t| t.map(|i| i as usize));
    let Ok(scene) = intertri_reference::Scene::new(vertices, corners) else {
        return (0, 0);
    };
    let step = rays.len().div_ceil(some);
    let sample: Vec<_> = rays.iter().zip(truth).step_by(step).collect();
    let differs = |(ray, answer): &&(&Ray, &Answer)| {
        let [t_min, t_max] = [ray.t_min, ray.t_max].map(f64::from);
        let line = intertri_reference::Ray::new(ray.origin.map(f64::from), ray.dir.map(f64::from));
        if question.any {
            scene.any(&line, t_min, t_max) != answer.is_hit()
        } else {
            match scene.closest(&line, t_min, t_max) {
                Some((index, t)) => (index as u32, t) != (answer.triangle, answer.t),
                None => answer.is_hit(),
            }
        }
    };
    (sample.len(), sample.par_iter().filter(differs).count())
}
