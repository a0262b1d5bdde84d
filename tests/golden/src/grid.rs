//! The `fixed` section: the `fixed` mode on three grids over the same scenes.

use intertri::Hit;
use intertri::fixed::{Bits, Fixed, Grid, Ray, Triangle, blocks};
use intertri::simd::Level;

use crate::Line;
use crate::digest::Digest;
use crate::scenes::{Scene, scenes};

/// Computes the lines of all scenes. A scene whose points fit no grid has no lines.
pub(crate) fn answers(level: Level) -> Vec<Line> {
    let fixed = Fixed::at(level);
    let mut lines = vec![];
    for scene in &scenes() {
        for (name, bits) in [
            ("fixed, fine", Bits::FINE),
            ("fixed, coarse", Bits::COARSE),
            ("fixed, 6 bits", Bits::of_grid(6).expect("a grid with 6 bits exists")),
        ] {
            if let Some((triangles, rays)) = snapped(scene, bits) {
                of_grid(&scene.name, name, fixed, &triangles, &rays, &mut lines);
            }
        }
    }
    lines
}

/// Returns the triangles and rays of a scene that fit on a grid around its points.
fn snapped(scene: &Scene, bits: Bits) -> Option<(Vec<Triangle>, Vec<Ray>)> {
    let corners = scene.triangles.iter().flat_map(|triangle| triangle.0);
    let points = corners.chain(scene.rays.iter().map(|ray| ray.origin));
    let finite = points.filter(|point| point.iter().all(|x| x.is_finite()));
    let grid = Grid::around(finite, bits).ok()?;
    let triangles = scene.triangles.iter().filter_map(|t| grid.triangle(t).ok()).collect();
    let rays = scene.rays.iter().filter_map(|ray| grid.ray(ray).ok()).collect();
    Some((triangles, rays))
}

/// Computes the lines of a grid: for packets of rays, for blocks of triangles, and for counts.
fn of_grid(
    scene: &str,
    name: &str,
    fixed: Fixed,
    triangles: &[Triangle],
    rays: &[Ray],
    lines: &mut Vec<Line>,
) {
    let few = &rays[..rays.len().min(200)];
    let blocks = blocks(triangles);
    let (mut batch, mut one, mut counts) = (Digest::new(), Digest::new(), Digest::new());
    let mut hits = vec![Hit::MISS; few.len()];
    fixed.closest_batch(&blocks, few, &mut hits);
    for (ray, hit) in few.iter().zip(&hits) {
        batch.hit(hit);
        one.hit(&fixed.closest(&blocks, ray).unwrap_or(Hit::MISS));
        let crossings = fixed.crossings(&blocks, ray);
        counts.hits += crossings.unsigned;
        counts.word(crossings.signed as u64);
        counts.word(crossings.unsigned);
    }
    lines.push(Line::new(scene, name, "closest, batch", &batch));
    lines.push(Line::new(scene, name, "closest, one", &one));
    lines.push(Line::new(scene, name, "crossings", &counts));
}
