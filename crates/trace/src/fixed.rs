//! The hierarchy over triangles of a grid: the same walk, with integers in the leaves.
//!
//! Integers of a grid are exact in f32, so the boxes are, and a crossing lies exactly in its
//! triangle's box. What the walk itself rounds, its padding covers: `docs/numerics/hierarchy.md`.

use intertri::fixed::{Best, Block, Crossing, Crossings, Fixed, Ray, RayLanes, Triangle};
use intertri::lanes::{Simd, WithSimd};
use intertri::{Counts, Hit, Triangle as Corners};

use crate::batch::chunks;
use crate::build::BuildError;
use crate::bvh::Bvh;
use crate::search::{Visit, walk};
use crate::stack::Stack;

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
    /// Its packs are these blocks.
    tree: Bvh,
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
        let mut tree = Bvh::with_progress(&corners, progress)?;
        tree.packs = vec![];
        let block = |indices: &[u32; 8]| {
            let of = |&index: &u32| Some((*triangles.get(index as usize)?, index));
            Block::new(indices.iter().filter_map(of))
        };
        Ok(Self { blocks: tree.indices.iter().map(block).collect(), tree })
    }

    /// The closest hit; of equal t, which are compared as exact ratios, the lowest index.
    pub fn closest(&self, mode: &Fixed, ray: &Ray) -> Hit {
        let mut hit = [Hit::MISS];
        mode.level().run(Closest { bvh: self, rays: std::slice::from_ref(ray), hits: &mut hit });
        hit[0]
    }

    /// Whether anything is hit.
    pub fn any(&self, mode: &Fixed, ray: &Ray) -> bool {
        let mut hit = [false];
        mode.level().run(Any { bvh: self, rays: std::slice::from_ref(ray), hits: &mut hit });
        hit[0]
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
        assert_eq!(rays.len(), hits.len(), "one hit a ray");
        chunks(rays, hits, |rays, hits| mode.level().run(Closest { bvh: self, rays, hits }));
    }

    /// [`FixedBvh::any`] of many rays: `hits[i]` becomes the answer of `rays[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn any_of_each(&self, mode: &Fixed, rays: &[Ray], hits: &mut [bool]) {
        assert_eq!(rays.len(), hits.len(), "one answer a ray");
        chunks(rays, hits, |rays, hits| mode.level().run(Any { bvh: self, rays, hits }));
    }

    /// The walk of one ray. Each crossing gives the new far end of the search, or `None` to stop.
    #[inline(always)]
    fn walk<S: Simd>(
        &self,
        ray: &Ray,
        stack: &mut Stack,
        each: impl FnMut(Crossing, u32) -> Option<f32>,
    ) {
        let line = ray.to_f32();
        let lanes = RayLanes::<S, 8>::new(ray);
        let mut leaves = Leaves { blocks: &self.blocks, ray: lanes, far: line.t_max, each };
        walk::<S>(&self.tree, &line, stack, &mut leaves);
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

struct Closest<'a> {
    bvh: &'a FixedBvh,
    rays: &'a [Ray],
    hits: &'a mut [Hit],
}

impl WithSimd for Closest<'_> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self) -> Counts {
        let stack = &mut self.bvh.tree.stack();
        for (ray, hit) in self.rays.iter().zip(self.hits) {
            let mut best = Best::default();
            self.bvh.walk::<S>(ray, stack, |crossing, index| {
                best.offer(crossing, index);
                Some(best.t_hi())
            });
            *hit = best.to_hit(ray);
        }
        Counts::default()
    }
}

struct Any<'a> {
    bvh: &'a FixedBvh,
    rays: &'a [Ray],
    hits: &'a mut [bool],
}

impl WithSimd for Any<'_> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self) -> Counts {
        let stack = &mut self.bvh.tree.stack();
        for (ray, hit) in self.rays.iter().zip(self.hits) {
            *hit = false;
            self.bvh.walk::<S>(ray, stack, |_, _| {
                *hit = true;
                None
            });
        }
        Counts::default()
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
        self.bvh.walk::<S>(self.ray, &mut self.bvh.tree.stack(), |crossing, index| {
            (self.each)(crossing, index);
            Some(far)
        });
    }
}
