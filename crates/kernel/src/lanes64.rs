//! f64 lanes throughout: the test of the mode `double`. There is no filter, and nothing is left
//! undecided.

use crate::document::Tri;
use crate::intersect::{Counts, Found, Test};
use crate::packet::{RayLanes, RayPacket, TriangleBlock};
use crate::resolve::Resolver;
use crate::simd::{Lanes, Level, Mask, Vec3};
use crate::{Ray, Threshold, Triangle};

/// The document's operations in f64 lanes.
#[derive(Clone, Copy, Debug)]
pub struct Lanes64 {
    threshold: Threshold,
    level: Level,
}

impl Lanes64 {
    /// With a threshold, at a level of instructions.
    #[inline]
    pub fn new(threshold: Threshold, level: Level) -> Self {
        Self { threshold, level }
    }

    /// The document's operations, by which nothing is left undecided.
    #[inline]
    pub fn resolver(&self) -> Resolver<'static> {
        Resolver::Document(self.threshold.get())
    }
}

impl Test for Lanes64 {
    type Rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> = RayLanes<D>;
    type Triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> = Tri<D>;
    type Constants = Tri<f64>;
    type Precheck<F: Lanes<Scalar = f32>> = ();
    type Ray = RayLanes<f64>;

    #[inline(always)]
    fn level(&self) -> Level {
        self.level
    }

    #[inline(always)]
    fn resolver(&self) -> Resolver<'_> {
        Self::resolver(self)
    }

    #[inline(always)]
    fn rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        packet: &RayPacket<N>,
    ) -> RayLanes<D> {
        RayLanes::of_packet(packet)
    }

    #[inline(always)]
    fn ray(&self, ray: &Ray) -> RayLanes<f64> {
        RayLanes::of_ray(ray)
    }

    #[inline(always)]
    fn one_ray<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        ray: &RayLanes<f64>,
    ) -> RayLanes<D> {
        RayLanes::splat(ray)
    }

    #[inline(always)]
    fn triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        block: &TriangleBlock<N>,
    ) -> Tri<D> {
        Tri::of_block(block)
    }

    #[inline(always)]
    fn triangles_of_corners<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        [c1, c2, c3]: [Vec3<F>; 3],
        _: Option<F>,
    ) -> Tri<D> {
        Tri::new([widened(c1), widened(c2), widened(c3)])
    }

    #[inline(always)]
    fn constants(&self, triangle: &Triangle) -> Tri<f64> {
        Tri::one(triangle)
    }

    #[inline(always)]
    fn one_triangle<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        _: &Triangle,
        constants: &Tri<f64>,
    ) -> Tri<D> {
        Tri::splat(constants)
    }

    #[inline(always)]
    fn precheck<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(&self, _: &RayLanes<D>) {}

    #[inline(always)]
    fn maybe<F: Lanes<Scalar = f32>>(&self, _: &Tri<f64>, (): &(), _: F::Mask) -> bool {
        true
    }

    #[inline(always)]
    fn test<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangles: &Tri<D>,
        rays: &RayLanes<D>,
        _far: F,
        live: u32,
        counts: &mut Counts,
    ) -> Option<Found<F, D>> {
        counts.tests += u64::from(live.count_ones());
        let (hit, t) = triangles.hit(rays, self.threshold.get());
        let exact = hit.bits() & live;
        let nothing = F::splat(0.0);
        let found = Found { near: 0, exact, undecided: 0, t_lo: nothing, t_hi: nothing, t };
        (exact != 0).then_some(found)
    }
}

/// The same vectors in f64.
#[inline(always)]
fn widened<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(vectors: Vec3<F>) -> Vec3<D> {
    let mut lanes = [[0.0; 16]; 3];
    vectors.store(&mut lanes);
    Vec3::load_f32(&lanes)
}
