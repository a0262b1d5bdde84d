//! The hierarchy over triangles of a grid: the same walk, with integers as the resolver.
//!
//! Integers of a grid are exact in f32, so the boxes are, and a crossing lies exactly in its
//! triangle's box. What the walk itself rounds, its padding covers: `docs/numerics/hierarchy.md`.

use intertri::fixed::{Crossing, Fixed, Ray, Sides, Triangle};
use intertri::internal::Filter;
use intertri::{Counts, Crossings, Hit, Triangle as Corners};

use super::{batch, one};
use crate::answers::Answers;
use crate::build::BuildError;
use crate::memory::NoMemory;
use crate::single::Kept;
use crate::threads::each;
use crate::tree::Tree;

/// Rays whose f32 are made at a time: those fit into the cache, until they are traced.
const LINES: usize = 1 << 14;

/// A bounding volume hierarchy over triangles of a grid, for the mode `fixed`.
///
/// Its answers are those of [`Fixed`]'s queries over all triangles, whatever the hierarchy and the
/// number of threads. Rays must be of the triangles' grid.
///
/// ```
/// use intertri_trace::FixedBvh;
/// use intertri_trace::intertri::fixed::{Bits, Fixed, Grid};
/// use intertri_trace::intertri::{Ray, Triangle};
///
/// let floor = Triangle::new([-1.0, 0.0, -1.0], [3.0, 0.0, -1.0], [-1.0, 0.0, 3.0]);
/// let ray = Ray::new([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]);
/// let grid = Grid::around(floor.0.into_iter().chain([ray.origin]), Bits::FINE)?;
/// let bvh = FixedBvh::new(&[grid.triangle(&floor)?])?;
/// let hit = bvh.closest(&Fixed::default(), &grid.ray(&ray)?).unwrap();
/// assert_eq!((hit.triangle, hit.t), (0, 2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct FixedBvh {
    tree: Tree,
}

impl FixedBvh {
    /// Builds a hierarchy over triangles, which keep their indices.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more, or too little memory.
    pub fn new(triangles: &[Triangle]) -> Result<Self, BuildError> {
        Self::with_progress(triangles, &|_, _| ())
    }

    /// [`FixedBvh::new`], telling from time to time how many triangles are done, of how many. The
    /// calls come from any thread.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more, or too little memory.
    pub fn with_progress(
        triangles: &[Triangle],
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, BuildError> {
        let count = triangles.len();
        let corners: Result<Vec<Corners>, _> = each(count, |i| triangles[i].to_f32());
        let corners = corners.map_err(|NoMemory| BuildError::OutOfMemory { count })?;
        Ok(Self { tree: Tree::over(&corners[..], progress)? })
    }

    /// The closest hit; of equal t, which are compared as exact ratios, the lowest index.
    pub fn closest(&self, mode: &Fixed, ray: &Ray) -> Option<Hit> {
        let tree = &self.tree;
        one::closest(tree, &None, &test(*mode).into(), ray.to_f32(), &mut Kept::lend(tree))
            .map(|hit| of_caller(hit, ray))
    }

    /// Whether anything is hit.
    pub fn any(&self, mode: &Fixed, ray: &Ray) -> bool {
        let tree = &self.tree;
        one::any(tree, &None, &test(*mode).into(), ray.to_f32(), &mut Kept::lend(tree))
    }

    /// Every hit, in order of the exact t; of equal t, of the index.
    pub fn all(&self, mode: &Fixed, ray: &Ray) -> Vec<Hit> {
        self.all_crossings(mode, ray).into_iter().map(|crossing| crossing.hit).collect()
    }

    /// Where the ray crosses, and from which side, in order of the exact t; of equal t, of the index. Each
    /// shared edge or corner is crossed once, as [`FixedBvh::all`] has it.
    pub fn all_crossings(&self, mode: &Fixed, ray: &Ray) -> Vec<intertri::Crossing> {
        let mut all: Vec<_> = self.places(*mode, ray).collect();
        all.sort_unstable_by_key(|&(place, crossing)| (crossing.t, self.tree.index_of(place)));
        let sided = |(place, crossing): (u32, Crossing)| {
            let hit = crossing.to_hit(ray, self.tree.index_of(place));
            intertri::Crossing { hit, leaves: crossing.leaves }
        };
        all.into_iter().map(sided).collect()
    }

    /// How often the ray crosses: each shared edge or corner once.
    pub fn crossings(&self, mode: &Fixed, ray: &Ray) -> Crossings {
        let mut count = Crossings::default();
        for (_, crossing) in self.places(*mode, ray) {
            count.add(crossing.leaves);
        }
        count
    }

    /// [`FixedBvh::closest`] of many rays: `hits[i]` becomes the answer of `rays[i]`, [`Hit::MISS`] where
    /// there is none.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_batch(&self, mode: &Fixed, rays: &[Ray], hits: &mut [Hit]) -> Counts {
        batch::chunks(rays, hits, |rays, hits| self.chunk(*mode, rays, Answers::Hits(hits)))
    }

    /// [`FixedBvh::any`] of many rays: `any[i]` becomes the answer of `rays[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn any_batch(&self, mode: &Fixed, rays: &[Ray], any: &mut [bool]) -> Counts {
        batch::chunks(rays, any, |rays, any| self.chunk(*mode, rays, Answers::Any(any)))
    }

    /// The places of the triangles that a ray crosses, and where.
    fn places(&self, mode: Fixed, ray: &Ray) -> impl Iterator<Item = (u32, Crossing)> {
        let places = one::places(&self.tree, (&None, 0), &test(mode).into(), ray.to_f32());
        places.into_iter().map(|place| {
            let triangle = Triangle::from_f32(&self.tree.triangle_in(place));
            (place, Sides::new(&triangle, ray.origin()).crossing(ray))
        })
    }

    /// The answers of a chunk of rays, some at a time.
    fn chunk(&self, mode: Fixed, rays: &[Ray], mut answers: Answers<'_>) -> Counts {
        let mut lines = Vec::with_capacity(rays.len().min(LINES));
        let mut counts = Counts::default();
        for (some, from) in rays.chunks(LINES).zip((0..).step_by(LINES)) {
            lines.clear();
            lines.extend(some.iter().map(|ray| *ray.to_f32()));
            let answers = answers.part(from, from + some.len());
            let asked = batch::Asked { bvh: &self.tree, choice: None, rays: &lines, on_grid: some };
            counts += batch::chunk(asked, test(mode), answers);
        }
        counts
    }
}

/// The filter at the mode's level, with integers behind it.
fn test(mode: Fixed) -> Filter<'static> {
    Filter::on_grid(mode.level())
}

/// A hit in units of the grid, in those of the ray's caller.
fn of_caller(hit: Hit, ray: &Ray) -> Hit {
    Hit { t: ray.t_of_caller(hit.t), ..hit }
}

#[cfg(test)]
mod tests {
    use intertri::fixed::{Bits, Fixed, Grid, Ray};
    use intertri::{Hit, Triangle};

    use crate::FixedBvh;

    /// A picture of a bumpy sheet, every fourth ray exactly at a corner: bundles are traced, and the
    /// integers settle few of their pairs.
    #[test]
    fn bundles_are_traced_and_change_nothing() {
        let grid = Grid::at(Bits::FINE, 0, [0; 3]).unwrap();
        let corner = |x: i32, y: i32| [1000 * x, 1000 * y, x * y % 5 * 100];
        let cells = (0..900).map(|i| (i % 30, i / 30));
        let pair = |(x, y)| {
            let across = [corner(x + 1, y), corner(x, y + 1)];
            [[corner(x, y), across[0], across[1]], [corner(x + 1, y + 1), across[0], across[1]]]
        };
        let triangles: Vec<_> =
            cells.flat_map(pair).map(|corners| grid.triangle_of(corners).unwrap()).collect();
        let bvh = FixedBvh::new(&triangles).unwrap();

        let eye = [14_300, 15_100, 100_000];
        let ray = |i: i32| {
            let (x, y) = (i / 256 % 4 * 16 + i % 16, i / 1024 * 16 + i / 16 % 16);
            let to = if i % 4 == 0 { corner(x / 2, y / 2) } else { [500 * x, 500 * y, 77] };
            grid.ray_of(eye, [0, 1, 2].map(|k| to[k] - eye[k])).unwrap()
        };
        let rays: Vec<Ray> = (0..4096).map(ray).collect();
        let mode = Fixed::default();
        let mut hits = vec![Hit::MISS; rays.len()];
        let counts = bvh.closest_batch(&mode, &rays, &mut hits);
        for (ray, hit) in rays.iter().zip(&hits) {
            assert_eq!(hit.some(), bvh.closest(&mode, ray));
        }
        assert!(hits.iter().filter(|hit| hit.is_hit()).count() > 3000);
        let share = counts.undecided as f64 / counts.tests as f64;
        assert!(counts.tests > 4096 && share < 0.05, "{counts:?}");
    }

    /// Rays whose directions are snapped by powers of two of their own, in bundles and in a stream: each t is
    /// in multiples of its caller's direction.
    #[test]
    fn t_is_that_of_the_caller() {
        let wall = |z: f32| Triangle::new([-9.0, -9.0, z], [9.0, -9.0, z], [0.0, 9.0, z]);
        let walls: Vec<Triangle> = (1..40).map(|i| wall(0.25 * i as f32)).collect();
        let points = walls.iter().flat_map(|wall| wall.0).chain([[0.0, 0.0, -4.0]]);
        let grid = Grid::around(points, Bits::FINE).unwrap();
        let walls: Vec<_> = walls.iter().map(|wall| grid.triangle(wall).unwrap()).collect();
        let bvh = FixedBvh::new(&walls).unwrap();

        let ray = |i: usize| {
            // 4.25 to the first wall; the direction's length is a power of two.
            let length = [0.125, 1.0, 4.0, 1024.0][i % 4];
            let [x, y] = [i % 32, i / 32 % 32].map(|k| (k as f32 - 16.0) / 64.0);
            let ray = intertri::Ray::new([0.0, 0.0, -4.0], [x, y, 1.0].map(|x| x * length));
            (grid.ray(&ray).unwrap(), 4.25 / f64::from(length))
        };
        // From one origin they make bundles; from origins of their own, a stream.
        let apart = |i: usize| {
            let length = [0.125, 1.0, 4.0, 1024.0][i % 4];
            let origin = [(i as f32 - 2048.0) / 4096.0, 0.0, -4.0];
            let ray = intertri::Ray::new(origin, [0.0, 0.0, length]);
            (grid.ray(&ray).unwrap(), 4.25 / f64::from(length))
        };
        let mode = Fixed::default();
        let kinds: [&dyn Fn(usize) -> (Ray, f64); 3] = [&ray, &|i| ray(i * 1021 % 4096), &apart];
        for rays in kinds {
            let (rays, t): (Vec<Ray>, Vec<f64>) = (0..4096).map(rays).unzip();
            let mut hits = vec![Hit::MISS; rays.len()];
            bvh.closest_batch(&mode, &rays, &mut hits);
            for ((ray, hit), t) in rays.iter().zip(&hits).zip(&t) {
                assert_eq!(hit.some(), bvh.closest(&mode, ray));
                assert!((hit.t / t - 1.0).abs() < 1e-5, "{} is not {t}", hit.t);
            }
        }
    }
}
