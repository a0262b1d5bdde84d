//! The `saved` section: answers from hierarchies that were saved and loaded, or refitted.

use intertri::simd::Level;
use intertri::{Hit, Mode, Triangle};
use intertri_trace::Bvh;

use crate::Line;
use crate::digest::Digest;
use crate::scenes::scenes;

/// Computes the lines of all scenes.
pub(crate) fn answers(level: Level) -> Vec<Line> {
    let mode = Mode::exact().at(level);
    let mut lines = vec![];
    for scene in &scenes() {
        let bytes = Bvh::new(&scene.triangles).expect("the scene is small enough").to_bytes();
        let mut bvh = Bvh::from_bytes(&bytes).expect("just saved");
        let mut put = |bvh: &Bvh, query: &str| {
            let mut hits = vec![Hit::MISS; scene.rays.len()];
            bvh.query().mode(mode).closest_batch_into(&scene.rays, &mut hits);
            let mut digest = Digest::new();
            for hit in &hits {
                digest.hit(hit);
            }
            lines.push(Line::new(&scene.name, "exact", query, &digest));
        };
        put(&bvh, "closest, loaded");
        // Move every corner, using sums and products that are the same everywhere.
        let moved = |[x, y, z]: [f32; 3]| [0.75 * x - 0.25 * y, y + 0.125 * z, z - 0.5 * x];
        let moved: Vec<_> = scene.triangles.iter().map(|t| Triangle(t.0.map(moved))).collect();
        bvh.refit(&moved).expect("the number of triangles stays the same");
        put(&bvh, "closest, moved");
    }
    lines
}
