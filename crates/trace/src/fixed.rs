//! The hierarchy over triangles of a grid: the same walk, with integers in the leaves.
//!
//! Integers of a grid are exact in f32, so the boxes are, and a crossing lies exactly in its
//! triangle's box. What the walk itself rounds, its padding covers: `docs/numerics/hierarchy.md`.

use intertri::fixed::{Block, Crossing, Crossings, Fixed, Ray, RayLanes, Triangle};
use intertri::lanes::{Simd, WithSimd};
use intertri::{Counts, Hit, Triangle as Corners};

use crate::answer::Answer;
use crate::batch::{Tracer, answer};
use crate::build::BuildError;
use crate::bvh::Bvh;
use crate::integers::OfGrid;
use crate::search::{Visit, walk};
use crate::stack::Kept;

/// A bounding volume hierarchy over triangles of a grid, for the mode `fixed`.
///
/// Its answers are those of [`Fixed`]'s verbs over all triangles, whatever the hierarchy and the
/// number of threads. Rays must be of the triangles' grid.
///
/// ```
/// use intertri::fixed::{Bits, Fixed, Grid};
/// use intertri::{Ray, Triangle};
/// use intertri_trace::FixedBvh;
///
/// let floor = Triangle::new([-1.0, 0.0, -1.0], [3.0, 0.0, -1.0], [-1.0, 0.0, 3.0]);
/// let ray = Ray::new([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]);
/// let grid = Grid::around(floor.0.into_iter().chain([ray.origin]), Bits::FINE)?;
/// let bvh = FixedBvh::new(&[grid.triangle(&floor)?])?;
/// let hit = bvh.closest(&Fixed::default(), &grid.ray(&ray)?);
/// assert_eq!((hit.triangle, hit.t), (0, 2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct FixedBvh {
    /// Its packs are these blocks in f32.
    pub(crate) tree: Bvh,
    blocks: Vec<Block<8>>,
}

impl FixedBvh {
    /// Builds a hierarchy over triangles, which keep their indices.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more.
    pub fn new(triangles: &[Triangle]) -> Result<Self, BuildError> {
        Self::with_progress(triangles, &|_, _| ())
    }

    /// [`FixedBvh::new`], telling from time to time how many triangles are done, of how many. The
    /// calls come from any thread.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more.
    pub fn with_progress(
        triangles: &[Triangle],
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, BuildError> {
        let corners: Vec<Corners> = triangles.iter().map(Triangle::to_f32).collect();
        let tree = Bvh::with_progress(&corners, progress)?;
        let block = |indices: &[u32; 8]| {
            let of = |&index: &u32| Some((*triangles.get(index as usize)?, index));
            Block::new(indices.iter().filter_map(of))
        };
        Ok(Self { blocks: tree.leaves.iter().map(|leaf| block(&leaf.indices)).collect(), tree })
    }

    /// The closest hit; of equal t, which are compared as exact ratios, the lowest index.
    pub fn closest(&self, mode: &Fixed, ray: &Ray) -> Hit {
        let mut hit = Hit::MISS;
        mode.level().run(One { by: self.by(*mode), ray, answer: &mut hit });
        hit
    }

    /// Whether anything is hit.
    pub fn any(&self, mode: &Fixed, ray: &Ray) -> bool {
        let mut hit = false;
        mode.level().run(One { by: self.by(*mode), ray, answer: &mut hit });
        hit
    }

    /// Every hit, in the order of the triangles.
    pub fn all(&self, mode: &Fixed, ray: &Ray) -> Vec<Hit> {
        let mut hits = vec![];
        let each = |crossing: Crossing, index| hits.push(crossing.to_hit(ray, index));
        mode.level().run(All { bvh: self, ray, each });
        hits.sort_unstable_by_key(|hit| hit.triangle);
        hits
    }

    /// How often the ray crosses: each shared edge or corner once.
    pub fn crossings(&self, mode: &Fixed, ray: &Ray) -> Crossings {
        let mut count = Crossings::default();
        let each = |crossing: Crossing, _| {
            count.signed += if crossing.leaves { 1 } else { -1 };
            count.unsigned += 1;
        };
        mode.level().run(All { bvh: self, ray, each });
        count
    }

    /// [`FixedBvh::closest`] of many rays: `hits[i]` becomes the answer of `rays[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_of_each(&self, mode: &Fixed, rays: &[Ray], hits: &mut [Hit]) {
        answer(&self.by(*mode), rays, hits);
    }

    /// [`FixedBvh::any`] of many rays: `hits[i]` becomes the answer of `rays[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn any_of_each(&self, mode: &Fixed, rays: &[Ray], hits: &mut [bool]) {
        answer(&self.by(*mode), rays, hits);
    }

    fn by(&self, mode: Fixed) -> OfGrid<'_> {
        OfGrid { bvh: self, level: mode.level() }
    }

    /// The triangle in a place of the packs.
    #[inline(always)]
    pub(crate) fn triangle_in(&self, place: u32) -> Triangle {
        Triangle::from_f32(&self.tree.triangle_in(place))
    }

    /// The [`walk`] of one ray. Each crossing gives the new far end of the search, or `None` to stop.
    #[inline(always)]
    pub(crate) fn walk<S: Simd>(
        &self,
        ray: &Ray,
        kept: &mut Kept,
        nearest_first: bool,
        each: impl FnMut(Crossing, u32) -> Option<f32>,
    ) {
        let line = ray.to_f32();
        let lanes = RayLanes::<S, 8>::new(ray);
        let mut leaves = Leaves { blocks: &self.blocks, ray: lanes, far: line.t_max, each };
        walk::<S>(&self.tree, line, kept, nearest_first, &mut leaves);
    }
}

/// What the walk does with the blocks on its way.
struct Leaves<'a, S: Simd, E> {
    blocks: &'a [Block<8>],
    ray: RayLanes<S, 8>,
    far: f32,
    each: E,
}

impl<S: Simd, E: FnMut(Crossing, u32) -> Option<f32>> Visit for Leaves<'_, S, E> {
    #[inline(always)]
    fn visit(&mut self, block: usize) -> Option<f32> {
        let (mut far, each) = (Some(self.far), &mut self.each);
        self.blocks[block].crossings_in::<S, true>(&self.ray, |crossing, index| {
            if far.is_some() {
                far = each(crossing, index);
            }
        });
        self.far = far?;
        far
    }
}

/// One ray alone.
struct One<'a, A> {
    by: OfGrid<'a>,
    ray: &'a Ray,
    answer: &'a mut A,
}

impl<A: Answer> WithSimd for One<'_, A> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let (ray, answer) = (std::slice::from_ref(self.ray), std::slice::from_mut(self.answer));
        self.by.others::<S, A>(ray, &[0], answer, &mut Counts::default());
    }
}

struct All<'a, E> {
    bvh: &'a FixedBvh,
    ray: &'a Ray,
    each: E,
}

impl<E: FnMut(Crossing, u32)> WithSimd for All<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        let far = self.ray.to_f32().t_max;
        self.bvh.walk::<S>(self.ray, &mut self.bvh.tree.kept(), false, |crossing, index| {
            (self.each)(crossing, index);
            Some(far)
        });
    }
}

#[cfg(test)]
mod tests {
    use intertri::Hit;
    use intertri::fixed::{Bits, Fixed, Grid, Ray};

    use crate::FixedBvh;
    use crate::batch::answer;

    /// A picture of a bumpy sheet, every fourth ray exactly at a corner: tiles are taken, and the
    /// integers judge few of their pairs.
    #[test]
    fn tiles_are_taken_and_change_nothing() {
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
        let counts = answer(&bvh.by(mode), &rays, &mut hits);
        for (ray, hit) in rays.iter().zip(&hits) {
            assert_eq!(*hit, bvh.closest(&mode, ray));
        }
        assert!(hits.iter().filter(|hit| hit.is_hit()).count() > 3000);
        let share = counts.undecided as f64 / counts.tests as f64;
        assert!(counts.tests > 4096 && share < 0.05, "{counts:?}");
    }
}
