//! The `fixed` mode's queries over any number of triangles.

use alloc::vec::Vec;

use super::{Grid, GridError, Ray, Triangle};
use crate::simd::Level;
use crate::{Blocks, Crossings, Hit, Mode};

/// The `fixed` mode at a given instruction level. All levels return the same results.
///
/// ```
/// use intertri::fixed::{Bits, Fixed, Grid, blocks};
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// // An integer tetrahedron with corners counter-clockwise as seen from outside.
/// let [o, x, y, z] = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]];
/// let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|f| grid.triangle_of(f));
/// let solid = blocks(&faces.into_iter().collect::<Result<Vec<_>, _>>()?);
///
/// // From inside, the ray leaves through the opposite face.
/// let fixed = Fixed::default();
/// let ray = grid.ray_of([1, 1, 1], [1, 1, 1])?;
/// let count = fixed.crossings(&solid, &ray);
/// assert_eq!((count.signed, count.unsigned), (1, 1));
/// assert!(fixed.any(&solid, &ray) && fixed.contains(&solid, &grid, [1.0, 1.0, 1.0])?);
/// let hits = fixed.all(&solid, &ray);
/// assert_eq!((hits.len(), hits[0].triangle, hits[0].t), (1, 3, 1.0 / 3.0));
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
///
/// ```
/// use intertri::fixed::{Bits, Fixed, Grid, blocks};
/// use intertri::{Hit, simd::Level};
/// // The closest hits of many rays at the portable level, which returns the same results.
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let plain = Fixed::at(Level::PORTABLE);
/// assert_eq!(plain.level(), Level::PORTABLE);
/// let walls = [5, 3].map(|z| grid.triangle_of([[0, 0, z], [4, 0, z], [0, 4, z]]).unwrap());
/// let rays = [1, 9].map(|x| grid.ray_of([x, 1, 0], [0, 0, 1]).unwrap());
/// let mut hits = [Hit::MISS; 2];
/// plain.closest_batch(&blocks(&walls), &rays, &mut hits);
/// assert_eq!(hits.map(|hit| hit.triangle), [1, Hit::NO_TRIANGLE]);
/// // An open sheet does not enclose any point. See the example above for a closed mesh.
/// assert_eq!(plain.winding(&blocks(&walls), &grid, [1.0, 1.0, 9.0])?, 0);
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fixed {
    level: Level,
}

impl Default for Fixed {
    fn default() -> Self {
        Self { level: Level::best() }
    }
}

/// Prepares snapped triangles for the queries. A triangle's index is its position in the slice.
///
/// ```
/// use intertri::fixed::{Bits, Fixed, Grid, blocks};
/// use intertri::{Ray, Triangle};
/// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 2.0]);
///
/// let points = triangle.0.into_iter().chain([ray.origin]);
/// let grid = Grid::around(points, Bits::FINE)?;
/// let blocks = blocks(&[grid.triangle(&triangle)?]);
/// let hit = Fixed::default().closest(&blocks, &grid.ray(&ray)?).unwrap();
/// assert_eq!((hit.triangle, hit.t, hit.u, hit.v), (0, 2.5, 0.25, 0.25));
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
pub fn blocks(triangles: &[Triangle]) -> Blocks {
    Blocks::new(&triangles.iter().map(Triangle::to_f32).collect::<Vec<_>>())
}

impl Fixed {
    /// Creates the mode at a given instruction level.
    pub fn at(level: Level) -> Self {
        Self { level }
    }

    /// Returns the instruction level at which queries run.
    pub fn level(&self) -> Level {
        self.level
    }

    /// Returns the closest hit. If several hits have the same t, the lowest index wins.
    pub fn closest(&self, blocks: &Blocks, ray: &Ray) -> Option<Hit> {
        Some(of_caller(ray, blocks.closest(self.mode(), ray.to_f32())?))
    }

    /// Returns whether the ray hits anything.
    pub fn any(&self, blocks: &Blocks, ray: &Ray) -> bool {
        blocks.any(self.mode(), ray.to_f32())
    }

    /// Returns every hit, sorted by exact t and, for equal t, by index.
    pub fn all(&self, blocks: &Blocks, ray: &Ray) -> Vec<Hit> {
        let mut hits = blocks.all(self.mode(), ray.to_f32());
        for hit in &mut hits {
            *hit = of_caller(ray, *hit);
        }
        hits
    }

    /// Counts the crossings of a ray. A crossing at a shared edge or corner counts once.
    pub fn crossings(&self, blocks: &Blocks, ray: &Ray) -> Crossings {
        blocks.count_crossings(self.mode(), ray.to_f32())
    }

    /// Computes the winding number of a closed mesh around a point from the signed crossings of a
    /// ray. If the triangles are counter-clockwise as seen from outside, the winding number is 1
    /// inside and 0 outside; if the mesh is inside out, it is -1 inside. A point on the surface has
    /// the winding number of a neighbouring point.
    ///
    /// # Errors
    /// Returns an error if the point is not on the grid.
    pub fn winding(&self, blocks: &Blocks, grid: &Grid, point: [f32; 3]) -> Result<i64, GridError> {
        let ray = grid.ray(&crate::Ray::new(point, [1.0, 0.0, 0.0]))?;
        Ok(self.crossings(blocks, &ray).signed)
    }

    /// Returns whether a closed mesh contains a point, that is, whether the winding number is
    /// nonzero.
    ///
    /// # Errors
    /// Returns an error if the point is not on the grid.
    pub fn contains(
        &self,
        blocks: &Blocks,
        grid: &Grid,
        point: [f32; 3],
    ) -> Result<bool, GridError> {
        Ok(self.winding(blocks, grid, point)? != 0)
    }

    /// Like [`Fixed::closest`], but for many rays: `hits[i]` becomes the closest hit of `rays[i]`, or
    /// [`Hit::MISS`].
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    pub fn closest_batch(&self, blocks: &Blocks, rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "`rays` and `hits` must have the same length");
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.closest(blocks, ray).unwrap_or(Hit::MISS);
        }
    }

    fn mode(self) -> Mode {
        Mode::once().at(self.level)
    }
}

/// Converts t from multiples of the snapped direction to multiples of the given one.
fn of_caller(ray: &Ray, hit: Hit) -> Hit {
    Hit { t: ray.t_of_caller(hit.t), ..hit }
}
