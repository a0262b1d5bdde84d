//! The `solid64` section: hierarchies over f64 that were saved and loaded, or refitted, with
//! closest points and signed distances.

use intertri::simd::Level;
use intertri::{Hit, Ray64, Triangle64, TriangleOf};
use intertri_trace::{Bvh, ClosestPoint, Solid};

use crate::Line;
use crate::digest::Digest;
use crate::scenes::{Scene, scenes};

/// Moves an f32 number away from zero, so that it uses more digits.
fn place(x: f32) -> f64 {
    f64::from(x) / 3.0 + 528_980.0
}

/// Computes the lines of all scenes.
pub(crate) fn answers(level: Level) -> Vec<Line> {
    let mut lines = vec![];
    for scene in &scenes() {
        let triangle = |t: &intertri::Triangle| TriangleOf(t.0.map(|corner| corner.map(place)));
        let triangles: Vec<Triangle64> = scene.triangles.iter().map(triangle).collect();
        let rays: Vec<Ray64> = scene.rays.iter().take(500).map(ray).collect();
        let bytes = Bvh::new(&triangles).expect("the scene is small enough").to_bytes();
        let mut bvh = Bvh::<f64>::from_bytes(&bytes).expect("just saved");
        lines.push(hits(scene, &bvh, &rays, level, "closest, loaded"));
        lines.push(nearest(scene, &bvh, &rays, "closest point"));
        if scene.closed {
            let points: Vec<[f64; 3]> = rays.iter().map(near).collect();
            let solid = Solid::assume_closed_bvh(bvh.clone());
            let mut distances = vec![0.0; points.len()];
            solid.signed_distance_batch_into(&points, &mut distances);
            let mut digest = Digest::new();
            for distance in distances {
                digest.hits += u64::from(distance < 0.0);
                digest.number(distance);
            }
            lines.push(Line::new(&scene.name, "exact", "signed distance", &digest));
        }

        // Move every corner, using sums and products that are the same everywhere.
        let moved = |[x, y, z]: [f64; 3]| [0.75 * x - 0.25 * y, y + 0.125 * z, z - 0.5 * x];
        let moved: Vec<_> = triangles.iter().map(|t| TriangleOf(t.0.map(moved))).collect();
        bvh.refit(&moved).expect("the number of triangles stays the same");
        lines.push(hits(scene, &bvh, &rays, level, "closest, moved"));
        lines.push(nearest(scene, &bvh, &rays, "closest point, moved"));
    }
    lines
}

fn ray(ray: &intertri::Ray) -> Ray64 {
    let ends = [ray.t_min, ray.t_max].map(f64::from);
    Ray64::new(ray.origin.map(place), ray.dir.map(f64::from)).between(ends[0], ends[1])
}

/// Returns a point along a ray.
fn near(ray: &Ray64) -> [f64; 3] {
    [0, 1, 2].map(|k| ray.origin[k] + 0.25 * ray.dir[k])
}

fn hits(scene: &Scene, bvh: &Bvh<f64>, rays: &[Ray64], level: Level, query: &str) -> Line {
    let mut hits = vec![Hit::MISS; rays.len()];
    bvh.query().at(level).closest_batch_into(rays, &mut hits);
    let mut digest = Digest::new();
    for hit in &hits {
        digest.hit(hit);
    }
    Line::new(&scene.name, "exact", query, &digest)
}

/// Computes the line for the points closest to ray origins and to points along the rays.
fn nearest(scene: &Scene, bvh: &Bvh<f64>, rays: &[Ray64], query: &str) -> Line {
    let origins = rays.iter().map(|ray| ray.origin);
    let points: Vec<[f64; 3]> = origins.chain(rays.iter().map(near)).collect();
    let mut closest = vec![ClosestPoint::NONE; points.len()];
    bvh.closest_point_batch_into(&points, f64::INFINITY, &mut closest);
    let mut digest = Digest::new();
    for found in &closest {
        digest.closest_point(found);
    }
    Line::new(&scene.name, "exact", query, &digest)
}
