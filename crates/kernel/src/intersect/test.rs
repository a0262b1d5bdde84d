//! One test of lanes: rays against triangles, either of them the same in all lanes.

use crate::packet::{RayPacket, TriangleBlock};
use crate::resolve::Resolver;
use crate::simd::{Lanes, Level, Vec3};
use crate::{Ray, Triangle};

/// How many tests were made, and how many of them the f32 bound left undecided.
///
/// ```
/// let mut all = intertri::Counts { tests: 64, undecided: 1 };
/// all += intertri::Counts { tests: 36, undecided: 0 };
/// assert_eq!((all.tests, all.undecided), (100, 1));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Ray/triangle tests, dead lanes not counted.
    pub tests: u64,
    /// Tests that a resolver had to settle.
    pub undecided: u64,
}

impl core::ops::AddAssign for Counts {
    fn add_assign(&mut self, more: Self) {
        self.tests += more.tests;
        self.undecided += more.undecided;
    }
}

/// The lanes that a test found to be hits, or may be, but for the far end of their interval.
pub struct Found<F, D> {
    /// Hits of which an enclosure of t is known.
    pub(crate) near: u32,
    /// Hits of which t is known.
    pub(crate) exact: u32,
    /// Lanes that the resolver has to decide.
    pub(crate) undecided: u32,
    pub(crate) t_lo: F,
    pub(crate) t_hi: F,
    pub(crate) t: D,
}

impl<F, D> Found<F, D> {
    /// All lanes that may be hits.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> u32 {
        self.near | self.exact | self.undecided
    }

    /// Drops all other lanes.
    #[inline(always)]
    pub(crate) fn keep(&mut self, lanes: u32) {
        self.near &= lanes;
        self.exact &= lanes;
        self.undecided &= lanes;
    }
}

/// The one test of a mode, generic over its width. All else that a mode can do is made of it, in
/// [`Mode`](crate::Mode).
///
/// `F` and `D` are as many f32 as f64 lanes; a mode uses what it needs of them.
pub trait Test: Copy + Send + Sync {
    /// Rays as lanes.
    type Rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>: Copy;
    /// Triangles as lanes.
    type Triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>: Copy;
    /// What is computed from a triangle once.
    type Constants: Copy;
    /// What the precheck of one triangle asks of rays.
    type Precheck<F: Lanes<Scalar = f32>>: Copy;
    /// One ray with what is computed from it once.
    type Ray: Copy;

    /// The level of instructions to run on.
    fn level(&self) -> Level;

    /// What settles the lanes that the test leaves undecided.
    fn resolver(&self) -> Resolver<'_>;

    /// A t below which a hit is surely before the far end of a ray: the end itself, where that is known.
    #[inline(always)]
    fn sure_end(&self, t_max: f32) -> f32 {
        t_max
    }

    /// N rays.
    fn rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        packet: &RayPacket<N>,
    ) -> Self::Rays<F, D>;

    /// What is computed from a ray once.
    fn ray(&self, ray: &Ray) -> Self::Ray;

    /// The same ray in all lanes.
    fn one_ray<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        ray: &Self::Ray,
    ) -> Self::Rays<F, D>;

    /// N triangles.
    fn triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        block: &TriangleBlock<N>,
    ) -> Self::Triangles<F, D>;

    /// Triangles whose corners are in lanes, and bounds of their longest edges if these are known.
    fn triangles_of_corners<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        corners: [Vec3<F>; 3],
        longest_edges: Option<F>,
    ) -> Self::Triangles<F, D>;

    /// What is computed from a triangle once.
    fn constants(&self, triangle: &Triangle) -> Self::Constants;

    /// The same triangle in all lanes.
    fn one_triangle<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangle: &Triangle,
        constants: &Self::Constants,
    ) -> Self::Triangles<F, D>;

    /// What the precheck asks of rays.
    fn precheck<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        rays: &Self::Rays<F, D>,
    ) -> Self::Precheck<F>;

    /// Whether any of the `live` lanes may be a hit with one triangle: a precheck without a branch, after
    /// which [`Test::test`] is asked.
    fn maybe<F: Lanes<Scalar = f32>>(
        &self,
        triangle: &Self::Constants,
        precheck: &Self::Precheck<F>,
        live: F::Mask,
    ) -> bool;

    /// Which of the `live` lanes are hits with `t_min <= t` and, surely or perhaps, `t <= far`.
    /// `None` where none is.
    fn test<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangles: &Self::Triangles<F, D>,
        rays: &Self::Rays<F, D>,
        far: F,
        live: u32,
        counts: &mut Counts,
    ) -> Option<Found<F, D>>;
}
