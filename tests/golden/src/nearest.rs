//! The `nearest` section: closest points on meshes, and signed distances to closed meshes.

use intertri::simd::Level;
use intertri_trace::{Bvh, Solid};

use crate::Line;
use crate::digest::Digest;
use crate::scenes::{Scene, scenes};

/// Computes the lines of all scenes. These queries always use the CPU's best level.
pub(crate) fn answers(_: Level) -> Vec<Line> {
    let mut lines = vec![];
    for scene in &scenes() {
        let along = |x: f32| {
            let rays = scene.rays.iter().take(500);
            rays.map(move |ray| [0, 1, 2].map(|k| ray.origin[k] + x * ray.dir[k]))
        };
        let points: Vec<[f32; 3]> = along(0.0).chain(along(0.9)).chain(along(2.0)).collect();
        let bvh = Bvh::new(&scene.triangles).expect("the scene is small enough");
        lines.push(closest(scene, &bvh, &points, "closest point", f64::INFINITY));
        lines.push(closest(scene, &bvh, &points, "closest point within 0.25", 0.25));
        if scene.closed {
            let solid = Solid::new(&scene.triangles).expect("the mesh is closed");
            let mut digest = Digest::new();
            for distance in solid.signed_distance_batch(&points) {
                digest.hits += u64::from(distance < 0.0);
                digest.number(distance);
            }
            lines.push(Line::new(&scene.name, "exact", "signed distance", &digest));
        }
    }
    lines
}

/// Computes the line for closest points within a radius.
fn closest(scene: &Scene, bvh: &Bvh, points: &[[f32; 3]], query: &str, radius: f64) -> Line {
    let mut digest = Digest::new();
    for found in &bvh.closest_point_batch(points, radius) {
        digest.closest_point(found);
    }
    Line::new(&scene.name, "exact", query, &digest)
}
