//! The filter: f32 lanes decide what a proven bound lets them decide. The rare lane that it leaves
//! undecided goes to a resolver; which one makes the mode.
//!
//! ```text
//!   rays, triangles ──► filter (f32, 8 lanes) ──► surely a miss   nearly all, by their edges
//!                                            ├──► surely a hit    t lies in an f32 interval; its f64
//!                                            │                    bits only where somebody needs them
//!                                            └──► undecided       about 1 in 10,000: to the resolver
//! ```
//!
//! Three forms: any rays and triangles ([`edges`], after a [`precheck`]); rays that share an origin
//! ([`shared_origin`]), a whole packet at once ([`beam`]); and bundles of such rays, projected
//! ([`projection`]).

mod beam;
mod block_hits;
mod bound;
mod decided;
mod edges;
mod evidence;
mod precheck;
pub(crate) mod projection;
mod shared_origin;
mod shared_origin_list;

pub use block_hits::BlockHits;
pub use edges::{Rays, Triangles};
pub use evidence::Evidence;
pub use precheck::{Constants, Precheck};
pub use shared_origin::SharedOriginBlock;

use crate::intersect::{ClosestHits, Counts, Found, PreparedPacket, Test, closest_of};
use crate::packet::{RayPacket, TriangleBlock};
use crate::resolve::Resolver;
use crate::simd::{Lane, Lanes, Level, Mask, Simd, Width};
use crate::{Ray, Threshold, Triangle};

use beam::Beam;
use decided::found;
use edges::Edges;
use projection::{Frame, Outlines, Points, Starts};
use shared_origin_list::SharedOriginList;

/// f32 lanes under a proven bound, and a resolver for what they leave undecided.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    threshold: Threshold,
    resolver: Resolver,
    level: Level,
}

impl Filter {
    /// With document A's operations as the resolver, and its threshold.
    #[inline]
    pub fn certified(threshold: Threshold, level: Level) -> Self {
        Self { threshold, resolver: Resolver::Document(threshold.get()), level }
    }

    /// For rays and triangles of one grid, in f32: what these decide of integers that they hold exactly
    /// is so, and of the rest the integers decide (`docs/numerics/certified.md`, section 10).
    #[inline]
    pub fn on_grid(level: Level) -> Self {
        Self { threshold: Threshold::ZERO, resolver: Resolver::Grid, level }
    }

    /// For any rays and triangles, right on their coordinates (`docs/numerics/exact.md`).
    #[inline]
    pub fn exact(level: Level) -> Self {
        Self { threshold: Threshold::ZERO, resolver: Resolver::Exact, level }
    }

    /// The document's threshold; zero for a mode that has none.
    #[inline]
    pub fn threshold(&self) -> Threshold {
        self.threshold
    }
}

impl Test for Filter {
    type Rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> = Rays<F>;
    type Triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> = Triangles<F>;
    type Constants = Constants;
    type Precheck<F: Lanes<Scalar = f32>> = Precheck<F>;
    type Ray = Rays<f32>;

    #[inline(always)]
    fn level(&self) -> Level {
        self.level
    }

    #[inline(always)]
    fn resolver(&self) -> Resolver {
        self.resolver
    }

    #[inline(always)]
    fn rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        packet: &RayPacket<N>,
    ) -> Rays<F> {
        Rays::of_packet(packet, self.threshold)
    }

    #[inline(always)]
    fn ray(&self, ray: &Ray) -> Rays<f32> {
        Rays::of_ray(ray, self.threshold)
    }

    #[inline(always)]
    fn one_ray<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(&self, ray: &Rays<f32>) -> Rays<F> {
        Rays::splat(ray)
    }

    #[inline(always)]
    fn triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        block: &TriangleBlock<N>,
    ) -> Triangles<F> {
        Triangles::of_block(block)
    }

    #[inline(always)]
    fn constants(&self, triangle: &Triangle) -> Constants {
        Constants::new(triangle)
    }

    #[inline(always)]
    fn one_triangle<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangle: &Triangle,
        constants: &Constants,
    ) -> Triangles<F> {
        Triangles::splat(triangle, constants.h)
    }

    #[inline(always)]
    fn precheck<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        rays: &Rays<F>,
    ) -> Precheck<F> {
        Precheck::new(rays)
    }

    #[inline(always)]
    fn maybe<F: Lanes<Scalar = f32>>(
        &self,
        triangle: &Constants,
        precheck: &Precheck<F>,
        live: F::Mask,
    ) -> bool {
        (!precheck.sure_miss(triangle) & live).any()
    }

    #[inline(always)]
    fn test<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangles: &Triangles<F>,
        rays: &Rays<F>,
        far: F,
        live: u32,
        counts: &mut Counts,
    ) -> Option<Found<F, D>> {
        counts.tests += u64::from(live.count_ones());
        let edges = Edges::new(triangles, rays);
        let decided = edges.decide(triangles, rays, far, live, self.threshold);
        Some(found(&decided, counts))
    }
}

impl Filter {
    /// Eight triangles as they are seen from the origin that rays share (document D): computed once,
    /// it makes each ray's test three dot products.
    ///
    /// An example stands at [`SharedOriginBlock`].
    #[inline(always)]
    pub fn shared_origin_in<S: Simd>(
        &self,
        block: &TriangleBlock<8>,
        origin: [f32; 3],
    ) -> SharedOriginBlock {
        SharedOriginBlock::new::<S::F64x8>(block, origin, self.threshold.get())
    }

    /// [`LaneQueries::packet_closest_of_in`](crate::LaneQueries::packet_closest_of_in) for rays that all
    /// start at the origin of the blocks; index and place of the i-th triangle are `first + i`, every
    /// block but the last full. The packet is held against eight triangles at once before its rays are:
    /// what it cannot reach at all costs little if its rays are alike.
    ///
    /// An example stands at [`SharedOriginBlock`].
    #[inline(always)]
    pub fn shared_origin_closest_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, Self, S, N>,
        blocks: &[SharedOriginBlock],
        first: u32,
        find: impl Fn(u32) -> Triangle,
        live: u32,
        closest: &mut ClosestHits<<Lane<N> as Width>::F<S>, N>,
        counts: &mut Counts,
    ) where
        Lane<N>: Width,
    {
        let (resolver, packet, rays) = (self.resolver, rays.packet(), rays.lanes());
        let beam = Beam::of::<_, N>(rays);
        let list =
            SharedOriginList::<S, _, N> { resolver, packet, rays, beam, blocks, first, find, live };
        closest_of(&list, live, closest, counts);
    }

    /// The triangles of one block or two as a frame projects them, for rays none of which has a smaller
    /// z than `slowest`. Those of the second begin at lane 8.
    ///
    /// An example stands at [`Outlines`].
    #[inline(always)]
    pub fn outlines_in<S: Simd>(
        &self,
        first: &TriangleBlock<8>,
        second: Option<&TriangleBlock<8>>,
        frame: &Frame,
        slowest: f32,
    ) -> Outlines {
        // What f32 rounds here is far less than PARALLEL has to spare.
        let least = if self.threshold.get() > 0.0 { self.threshold.above } else { 0.0 };
        let parallel = bound::PARALLEL * least / slowest;
        Outlines::new::<S>(first, second, frame, parallel)
    }

    /// Where the rays so far and the live ones of a packet begin to look for hits.
    ///
    /// An example stands at [`Starts`].
    #[inline(always)]
    pub fn starts_in<F: Lanes<Scalar = f32>>(
        &self,
        starts: &Starts<F>,
        points: &Points<F>,
        t_min: F,
        live: F::Mask,
    ) -> Starts<F> {
        starts.with(points, t_min, live, self.threshold)
    }
}
