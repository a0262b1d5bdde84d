//! The queries that every mode answers.

use alloc::vec::Vec;

use super::blocks::Blocks;
use super::rows::Rows;
use super::which::Which;
use crate::intersect::{Counts, LaneQueries, Prepared, Test};
use crate::packet::{PacketHits, RayPacket, TriangleBlock};
use crate::simd::{Lane, Level, Simd, Width, WithSimd};
use crate::{Hit, Ray, Triangle};

/// A way to decide hits.
///
/// [`Exact`](crate::Exact) is right on the coordinates as given: a triangle is hit where the true ray meets it.
/// [`Certified`](crate::Certified) and [`Double`](crate::Double) give the same answers, those of a plain loop over
/// the scalar f64 reference: a triangle is hit where the document's `InterTri` returns 1. In all of them a hit counts
/// where `t_min <= t < t_max` and `t > 0`. A point on an edge or a corner belongs to every triangle that has it, as
/// far as the mode can tell. A ray or a triangle with a NaN or an infinity is never hit, nor is a triangle without
/// area.
///
/// [`closest`](Mode::closest), [`any`](Mode::any) and [`all`](Mode::all) take slices of any length. An
/// author of a hierarchy asks the mode's [`test`](Mode::test), within loops of their own.
///
/// ```
/// use intertri::{Mode, Ray, Triangle};
/// /// How many triangles a ray meets, in any mode.
/// fn depth<M: Mode>(mode: &M, triangles: &[Triangle], ray: &Ray) -> usize {
///     mode.all(triangles, ray).len()
/// }
/// ```
pub trait Mode: Copy + Send + Sync {
    /// How it tests rays against triangles.
    type Test: LaneQueries + Into<Which<'static>>;

    /// The test, for loops of one's own: see [`LaneQueries`].
    fn test(&self) -> Self::Test;

    /// The level of instructions that it runs on.
    fn level(&self) -> Level {
        self.test().level()
    }

    /// The closest hit; of equal t, the lowest index.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, Triangle};
    /// let near = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let far = Triangle::new([0.0, 0.0, 9.0], [1.0, 0.0, 9.0], [0.0, 1.0, 9.0]);
    /// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 2.0]);
    /// let hit = Certified::default().closest(&[far, near], &ray).unwrap();
    /// assert_eq!((hit.triangle, hit.t, hit.u, hit.v), (1, 2.5, 0.25, 0.25));
    /// ```
    fn closest(&self, triangles: &[Triangle], ray: &Ray) -> Option<Hit> {
        self.test().into().closest(Rows::Slice(triangles), ray)
    }

    /// Whether anything is hit.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, Triangle};
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    /// assert!(Certified::default().any(&[wall], &ray));
    /// // The interval is open at its far end.
    /// assert!(!Certified::default().any(&[wall], &ray.between(0.0, 5.0)));
    /// ```
    fn any(&self, triangles: &[Triangle], ray: &Ray) -> bool {
        self.test().into().any(Rows::Slice(triangles), ray)
    }

    /// Every hit, in order of t; of equal t, of the index.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, Triangle};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    /// let hits = Certified::default().all(&[at(5.0), at(-1.0), at(3.0)], &ray);
    /// assert!(hits.iter().map(|hit| hit.triangle).eq([2, 0]));
    /// ```
    fn all(&self, triangles: &[Triangle], ray: &Ray) -> Vec<Hit> {
        self.test().into().all(Rows::Slice(triangles), ray)
    }

    /// [`Mode::closest`] of many rays: `hits[i]` becomes the answer of `rays[i]`, [`Hit::MISS`] where
    /// there is none. Many rays from one origin share what depends on it.
    ///
    /// # Panics
    /// If the slices differ in length.
    ///
    /// ```
    /// use intertri::{Certified, Hit, Mode, Ray, Triangle};
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let rays = [0.25, 2.0].map(|x| Ray::new([x, 0.25, 0.0], [0.0, 0.0, 1.0]));
    /// let mut hits = [Hit::MISS; 2];
    /// Certified::default().closest_batch(&[wall], &rays, &mut hits);
    /// assert_eq!(hits.map(|hit| hit.is_hit()), [true, false]);
    /// ```
    fn closest_batch(&self, triangles: &[Triangle], rays: &[Ray], hits: &mut [Hit]) {
        self.test().into().closest_batch(triangles, rays, hits);
    }

    /// A triangle with what this mode's test computes from it once.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Triangle};
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let prepared = Certified::default().prepare(&wall);
    /// ```
    fn prepare(&self, triangle: &Triangle) -> Prepared<Self::Test> {
        self.test().prepare(triangle)
    }

    /// N rays, 4, 8 or 16, against one triangle.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, RayPacket, Triangle};
    /// let mode = Certified::default();
    /// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let rays = [0.25, 0.75].map(|x| Ray::new([x, 0.5, 0.0], [0.0, 0.0, 1.0]));
    /// let hits = mode.packet(&RayPacket::<4>::new(&rays), &mode.prepare(&triangle));
    /// assert_eq!((hits.bits, hits.t[0]), (0b01, 5.0));
    /// ```
    fn packet<const N: usize>(
        &self,
        rays: &RayPacket<N>,
        triangle: &Prepared<Self::Test>,
    ) -> PacketHits<N>
    where
        Lane<N>: Width,
    {
        self.level().run(Packet { test: self.test(), rays, triangle })
    }

    /// One ray against N triangles, 4, 8 or 16.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, Triangle, TriangleBlock};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let block = TriangleBlock::<8>::new(&[at(5.0), at(-1.0), at(3.0)]);
    /// let hits = Certified::default().block(&Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]), &block);
    /// assert_eq!((hits.bits, hits.t[0], hits.t[2]), (0b101, 5.0, 3.0));
    /// ```
    fn block<const N: usize>(&self, ray: &Ray, block: &TriangleBlock<N>) -> PacketHits<N>
    where
        Lane<N>: Width,
    {
        self.level().run(Block { test: self.test(), ray, block })
    }
}

impl Blocks {
    /// [`Mode::closest`] of these triangles.
    pub fn closest<M: Mode>(&self, mode: &M, ray: &Ray) -> Option<Hit> {
        mode.test().into().closest(Rows::Blocks(self), ray)
    }

    /// [`Mode::any`] of these triangles.
    pub fn any<M: Mode>(&self, mode: &M, ray: &Ray) -> bool {
        mode.test().into().any(Rows::Blocks(self), ray)
    }

    /// [`Mode::all`] of these triangles.
    pub fn all<M: Mode>(&self, mode: &M, ray: &Ray) -> Vec<Hit> {
        mode.test().into().all(Rows::Blocks(self), ray)
    }
}

struct Packet<'a, T: Test, const N: usize> {
    test: T,
    rays: &'a RayPacket<N>,
    triangle: &'a Prepared<T>,
}

impl<T: Test, const N: usize> WithSimd for Packet<'_, T, N>
where
    Lane<N>: Width,
{
    type Output = PacketHits<N>;
    #[inline(always)]
    fn run<S: Simd>(self) -> PacketHits<N> {
        let rays = self.test.prepare_packet_in::<S, N>(self.rays);
        self.test.packet_in(&rays, self.triangle, &mut Counts::default())
    }
}

struct Block<'a, T, const N: usize> {
    test: T,
    ray: &'a Ray,
    block: &'a TriangleBlock<N>,
}

impl<T: Test, const N: usize> WithSimd for Block<'_, T, N>
where
    Lane<N>: Width,
{
    type Output = PacketHits<N>;
    #[inline(always)]
    fn run<S: Simd>(self) -> PacketHits<N> {
        self.test.block_in::<S, N>(self.ray, self.block, &mut Counts::default())
    }
}
