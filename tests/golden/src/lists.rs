//! The `lists` section: every hit of many rays, among all triangles and among a selection, in one
//! mesh and in several.

use intertri::simd::Level;
use intertri::{Mode, Ray};
use intertri_trace::{Bvh, Faces, HitLists};

use crate::Line;
use crate::digest::Digest;
use crate::scenes::{Scene, scenes};

/// Computes the lines of all scenes.
pub(crate) fn answers(level: Level) -> Vec<Line> {
    let mut lines = vec![];
    for scene in &scenes() {
        // Two meshes with different masks.
        let (first, second) = scene.triangles.split_at(scene.triangles.len() / 3);
        let whole = Bvh::new(&scene.triangles).expect("the scene is small enough");
        let mut parts = Bvh::from_meshes(&[first, second]).expect("the scene is small enough");
        parts.set_mask(1, 0b10);
        let certified = Mode::certified_with(scene.threshold).at(level);
        of_mode(scene, [&whole, &parts], certified, "certified", &mut lines);
        of_mode(scene, [&whole, &parts], Mode::exact().at(level), "exact", &mut lines);
    }
    lines
}

/// Computes the lines of a mode.
fn of_mode(
    scene: &Scene,
    [whole, parts]: [&Bvh; 2],
    mode: Mode,
    name: &str,
    lines: &mut Vec<Line>,
) {
    let rays: &[Ray] = &scene.rays[..scene.rays.len().min(500)];
    let mut put = |query: &str, lists: &HitLists| {
        let mut digest = Digest::new();
        for offset in &lists.offsets {
            digest.word(*offset as u64);
        }
        for hit in &lists.items {
            digest.hit(hit);
            digest.word(hit.geometry.into());
        }
        lines.push(Line::new(&scene.name, name, query, &digest));
    };
    let query = |bvh| Bvh::query(bvh).mode(mode);
    let all = query(whole).all_batch(rays, None).expect("the scene is small enough");
    put("all, batch", &all);
    put(
        "all, first two",
        &query(whole).all_batch(rays, Some(2)).expect("the scene is small enough"),
    );
    put("all, two meshes", &query(parts).all_batch(rays, None).expect("the scene is small enough"));
    put(
        "all, masked",
        &query(parts).mask(0b10).all_batch(rays, None).expect("the scene is small enough"),
    );
    let front = query(whole).faces(Faces::Front);
    put("all, front faces", &front.all_batch(rays, None).expect("the scene is small enough"));
    // Skip the first hit of each ray.
    let firsts: Vec<_> = all.iter().map(|hits| &hits[..hits.len().min(1)]).collect();
    let others = query(whole).skip(&firsts);
    put("all, but the first", &others.all_batch(rays, None).expect("the scene is small enough"));
}
