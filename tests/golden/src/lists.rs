//! The section `lists`: every hit of many rays, among all triangles and among some, in one mesh and in several.

use intertri::simd::Level;
use intertri::{Certified, Exact, Mode, Ray};
use intertri_trace::{Bvh, Faces, HitLists, Select};

use crate::Line;
use crate::digest::Digest;
use crate::scenes::{Scene, scenes};

/// The lines of all scenes.
pub(crate) fn answers(level: Level) -> Vec<Line> {
    let mut lines = vec![];
    for scene in &scenes() {
        // Two meshes, the second of which has another mask.
        let (first, second) = scene.triangles.split_at(scene.triangles.len() / 3);
        let whole = Bvh::new(&scene.triangles).expect("small");
        let mut parts = Bvh::of_meshes(&[first, second]).expect("small");
        parts.set_mask(1, 0b10);
        let certified = Certified::new(scene.threshold).at(level);
        of_mode(scene, [&whole, &parts], &certified, "certified", &mut lines);
        of_mode(scene, [&whole, &parts], &Exact::at(level), "exact", &mut lines);
    }
    lines
}

/// The lines of a mode.
fn of_mode<M: Mode>(
    scene: &Scene,
    [whole, parts]: [&Bvh; 2],
    mode: &M,
    name: &str,
    lines: &mut Vec<Line>,
) {
    let rays: &[Ray] = &scene.rays[..scene.rays.len().min(500)];
    let mut put = |query: &str, lists: &HitLists| {
        let mut digest = Digest::new();
        for offset in &lists.offsets {
            digest.word(*offset as u64);
        }
        for hit in &lists.hits {
            digest.hit(hit);
            digest.word(hit.geometry.into());
        }
        lines.push(Line::new(&scene.name, name, query, &digest));
    };
    let all = whole.all_batch(mode, rays, None).expect("small");
    put("all, batch", &all);
    put("all, first two", &whole.all_batch(mode, rays, Some(2)).expect("small"));
    put("all, two meshes", &parts.all_batch(mode, rays, None).expect("small"));

    let masked = Select { mask: 0b10, ..Select::default() };
    put("all, masked", &parts.only(&masked).all_batch(mode, rays, None).expect("small"));
    let front = Select { faces: Faces::Front, ..Select::default() };
    put("all, front faces", &whole.only(&front).all_batch(mode, rays, None).expect("small"));
    // All but the first that each ray hit.
    let firsts: Vec<_> = all.iter().map(|hits| &hits[..hits.len().min(1)]).collect();
    let others = Select { skip: &firsts, ..Select::default() };
    put("all, but the first", &whole.only(&others).all_batch(mode, rays, None).expect("small"));
}
