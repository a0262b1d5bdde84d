//! Rays aimed exactly on the grid of the mode `fixed`.
//!
//! Its finest grid has longer differences than directions. Here the grid is coarser by three bits and
//! directions are six bits longer: the difference of any two points of the grid is a direction.

use intertri::Triangle;
use intertri::fixed::{self, Bits, Grid, GridError, Ray};
use intertri_trace::Bvh;

use super::aim::Aim;

/// Its name among the engines.
pub const NAME: &str = "fixed-aimed";

/// Bits of a coordinate.
const BITS: u32 = 17;

/// How many rays miss when the mesh, the origins and what is aimed at are snapped first.
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

/// Twice the way to the middle of the two ends.
fn ray(grid: &Grid, aim: &Aim) -> Result<Ray, GridError> {
    let origin = grid.snap(aim.origin)?;
    let [a, b] = [grid.snap(aim.ends[0])?, grid.snap(aim.ends[1])?];
    grid.ray_of(origin, [0, 1, 2].map(|k| a[k] + b[k] - 2 * origin[k]))
}
