//! The `doubles` section: `exact` over scenes in f64: closest hits, any hits, all hits, crossings,
//! and containment.

use intertri::simd::Level;
use intertri::{Hit, Mode, Ray, Ray64, Triangle64};
use intertri_trace::{Bvh, Solid};

use crate::Line;
use crate::digest::Digest;
use crate::scenes::{Scene, scenes};

/// The offsets of the scenes: none, and UTM coordinates.
const PLACES: [(&str, [f64; 3]); 2] =
    [("at home", [0.0; 3]), ("far away", [448_262.118, 5_411_932.678, 113.4])];

/// Computes the lines of all scenes, scaled by a third so that their coordinates are not exact in
/// f32.
pub(crate) fn answers(level: Level) -> Vec<Line> {
    let mut lines = vec![];
    for scene in &scenes() {
        for (place, by) in PLACES {
            of_scene(&format!("{}, {place}", scene.name), scene, by, level, &mut lines);
        }
    }
    lines
}

/// Computes the lines of a scene that is moved by a vector.
fn of_scene(name: &str, scene: &Scene, by: [f64; 3], level: Level, lines: &mut Vec<Line>) {
    let third = |p: [f32; 3]| p.map(|x| f64::from(x) / 3.0);
    let moved = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] + by[k]);
    let triangles: Vec<_> =
        scene.triangles.iter().map(|t| Triangle64(t.0.map(|p| moved(third(p))))).collect();
    let ray = |ray: &Ray| {
        let moved = Ray64::new(moved(third(ray.origin)), third(ray.dir));
        moved.between(ray.t_min.into(), ray.t_max.into())
    };
    let rays: Vec<_> = scene.rays.iter().map(ray).collect();
    let few = &rays[..rays.len().min(100)];
    let bvh = Bvh::new(&triangles).expect("the scene is small enough");
    let mut put = |query: &str, digest: Digest| {
        lines.push(Line::new(name, "exact", query, &digest));
    };

    let mut query = bvh.query().at(level);
    put("closest, batch", of_hits(query.closest_batch(&rays)));
    put("closest, one", of_hits(few.iter().map(|r| query.closest(r).unwrap_or(Hit::MISS))));
    put("all", of_hits(few.iter().flat_map(|r| query.all(r))));
    let lists = query.all_batch(few, Some(3)).expect("the scene is small enough");
    put("all, first three", of_hits(lists.items));
    let mode = Mode::exact().at(level);
    let slices = few.iter().map(|r| mode.closest(&triangles, r).unwrap_or(Hit::MISS));
    put("closest, slices", of_hits(slices));

    let mut digest = Digest::new();
    for any in query.any_batch(&rays) {
        digest.truth(any);
    }
    put("any", digest);

    let mut digest = Digest::new();
    for count in query.count_crossings_batch(&rays) {
        digest.hits += count.unsigned;
        digest.word(count.signed as u64);
        digest.word(count.unsigned);
    }
    put("crossings", digest);

    if scene.closed {
        let solid = Solid::assume_closed(&triangles).expect("the scene is small enough");
        let points = rays.iter().map(|r| [0, 1, 2].map(|k| r.origin[k] + 0.9 * r.dir[k]));
        let points: Vec<_> = points.chain(triangles.iter().map(|t| t.0[0])).collect();
        let mut digest = Digest::new();
        for containment in solid.classify_batch(&points) {
            digest.containment(containment);
        }
        put("contains", digest);
    }
}

/// Returns the digest of hits.
fn of_hits(hits: impl IntoIterator<Item = Hit>) -> Digest {
    let mut digest = Digest::new();
    for hit in hits {
        digest.hit(&hit);
    }
    digest
}
