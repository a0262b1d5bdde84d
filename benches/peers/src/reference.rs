//! Compares the truth itself with the plain loop over the scalar f64 reference.

use intertri::{Mode, Ray, Triangle};
use intertri_scene::Mesh;
use rayon::prelude::*;

use crate::engine::{Answer, Question};

/// Compares about `some` rays, spread over all of them. Returns how many were compared, and how many of those
/// differ in hit or miss, index, or a bit of t.
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

/// Counts the answers that name another triangle than the truth, but one at the same exact t: such a tie is as right.
pub fn ties(triangles: &[Triangle], rays: &[Ray], answers: &[Answer], truth: &[Answer]) -> usize {
    let is_tie = |(ray, (answer, truth)): &(&Ray, (&Answer, &Answer))| {
        if !answer.is_hit() || !truth.is_hit() || answer.triangle == truth.triangle {
            return false;
        }
        let Some(&triangle) = triangles.get(answer.triangle as usize) else { return false };
        let hit = Mode::exact().closest(&[triangle], ray);
        hit.is_some_and(|hit| hit.t == truth.t)
    };
    rays.iter().zip(answers.iter().zip(truth)).filter(is_tie).count()
}
