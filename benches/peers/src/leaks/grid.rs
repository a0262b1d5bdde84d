//! Counts leaks of rays whose aim is exact on the grid of the `fixed` mode.
//!
//! On the finest grid, the difference between two points can exceed the longest valid direction.
//! The grid used here is three bits coarser, and its directions are six bits longer, so the
//! difference between any two points is a valid direction.

use intertri::Triangle;
use intertri::fixed::{self, Bits, Grid, GridError, Ray};
use intertri_trace::Bvh;

use super::aim::Aim;

/// The engine's name.
pub const NAME: &str = "fixed-aimed";

/// The number of bits per coordinate.
const BITS: u32 = 17;

/// Snaps the mesh, the origins and the targets to the grid, and returns the number of rays that
/// miss the snapped mesh.
pub fn leaks(triangles: &[Triangle], aims: &[Aim]) -> Result<usize, String> {
    let snapped = || {
        let points = triangles.iter().flat_map(|t| t.0);
        let grid = Grid::around(points, Bits::of_grid(BITS)?)?;
        let triangles: Result<Vec<_>, _> = triangles.iter().map(|t| grid.triangle(t)).collect();
        let rays: Result<Vec<_>, _> = aims.iter().map(|aim| ray(&grid, aim)).collect();
        Ok::<_, GridError>((triangles?, rays?))
    };
    let (triangles, rays) = snapped().map_err(|e| e.to_string())?;
    let in_f32: Vec<_> = triangles.iter().map(fixed::Triangle::to_f32).collect();
    let bvh = Bvh::new(&in_f32).map_err(|e| e.to_string())?;
    let lines: Vec<_> = rays.iter().map(|ray| *ray.to_f32()).collect();
    let hits = bvh.query().once().closest_batch(&lines);
    Ok(hits.iter().filter(|hit| !hit.is_hit()).count())
}

/// Returns a ray whose direction is twice the vector from the origin to the midpoint of the two
/// ends.
fn ray(grid: &Grid, aim: &Aim) -> Result<Ray, GridError> {
    let origin = grid.snap(aim.origin)?;
    let [a, b] = [grid.snap(aim.ends[0])?, grid.snap(aim.ends[1])?];
    grid.ray_of(origin, [0, 1, 2].map(|k| a[k] + b[k] - 2 * origin[k]))
}
