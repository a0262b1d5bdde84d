//! The `modes` section: `certified` and `exact` over f32 scenes: closest hits, any hits, and all
//! hits; with `exact`, also crossings and containment.

use intertri::simd::Level;
use intertri::{Hit, Mode};
use intertri_trace::{Bvh, Solid};

use crate::Line;
use crate::digest::Digest;
use crate::scenes::{Scene, scenes};

/// Computes the lines of all scenes.
pub(crate) fn answers(level: Level) -> Vec<Line> {
    let mut lines = vec![];
    for scene in &scenes() {
        let bvh = Bvh::new(&scene.triangles).expect("the scene is small enough");
        let certified = Mode::certified_with(scene.threshold);
        of_mode(scene, &bvh, certified.at(level), "certified", &mut lines);
        of_mode(scene, &bvh, Mode::exact().at(level), "exact", &mut lines);
        of_crossings(scene, &bvh, Mode::exact().at(level), &mut lines);
        if scene.closed {
            lines.push(contains(scene));
        }
    }
    lines
}

/// Appends the lines for one mode.
fn of_mode(scene: &Scene, bvh: &Bvh, mode: Mode, name: &str, lines: &mut Vec<Line>) {
    let Scene { triangles, rays, .. } = scene;
    let mut query = bvh.query().mode(mode);
    let mut put = |query: &str, digest: Digest| {
        lines.push(Line::new(&scene.name, name, query, &digest));
    };

    let mut digest = Digest::new();
    let mut hits = query.closest_batch(rays);
    for hit in &hits {
        digest.hit(hit);
    }
    put("closest, batch", digest);

    let mut digest = Digest::new();
    let few = &rays[..rays.len().min(100)];
    for ray in few {
        digest.hit(&query.closest(ray).unwrap_or(Hit::MISS));
    }
    put("closest, one", digest);

    let mut digest = Digest::new();
    let slices = &mut hits[..few.len()];
    mode.closest_batch(triangles, few, slices);
    for hit in slices {
        digest.hit(hit);
    }
    put("closest, slices", digest);

    let mut digest = Digest::new();
    for any in query.any_batch(rays) {
        digest.truth(any);
    }
    put("any", digest);

    let mut digest = Digest::new();
    for hit in few.iter().flat_map(|ray| query.all(ray)) {
        digest.hit(&hit);
    }
    put("all", digest);
}

/// Computes the line for crossings, in the `exact` mode.
fn of_crossings(scene: &Scene, bvh: &Bvh, mode: Mode, lines: &mut Vec<Line>) {
    let Scene { name, rays, .. } = scene;
    let mut digest = Digest::new();
    let mut query = bvh.query().mode(mode);
    let counts = query.count_crossings_batch(rays);
    for (ray, count) in rays.iter().zip(&counts).take(100) {
        digest.word(count.signed as u64);
        for crossing in query.crossings(ray) {
            digest.hit(&crossing.hit);
            digest.word(crossing.leaves.into());
        }
    }
    lines.push(Line::new(name, "exact", "crossings", &digest));
}

/// Computes the line for containment in a closed mesh, in the `exact` mode.
fn contains(Scene { name, triangles, rays, .. }: &Scene) -> Line {
    let solid = Solid::new(triangles).expect("the mesh is closed");
    let points = rays.iter().map(|ray| [0, 1, 2].map(|k| ray.origin[k] + 0.9 * ray.dir[k]));
    let points: Vec<[f32; 3]> = points.chain(triangles.iter().map(|t| t.0[0])).collect();
    let mut digest = Digest::new();
    for containment in solid.classify_batch(&points) {
        digest.containment(containment);
    }
    Line::new(name, "exact", "contains", &digest)
}
