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
mod longest_edge;
mod parallel_rays;
mod precheck;
pub(crate) mod projection;
mod room;
mod shared_origin;
mod shared_origin_list;
#[cfg(all(test, feature = "std"))]
mod worst;

pub use block_hits::BlockHits;
pub use edges::{Rays, Triangles};
pub use evidence::Evidence;
pub use parallel_rays::{AlongAxis, Axis, LaneHits};
pub use precheck::{Constants, Precheck};
pub use shared_origin::SharedOriginBlock;

use crate::intersect::{ClosestHits, Counts, Found, PreparedPacket, Test, closest_of};
use crate::packet::{RayPacket, TriangleBlock};
use crate::resolve::{Originals, Resolver};
use crate::simd::{Lane, Lanes, Level, Mask, Simd, Vec3, Width};
use crate::{Ray, Threshold, Triangle};

use beam::Beam;
use decided::found;
use edges::Edges;
use projection::{Frame, Outlines, Points, Starts};
pub use room::Room;
use shared_origin_list::SharedOriginList;

/// f32 lanes under a proven bound, and a resolver for what they leave undecided.
#[derive(Clone, Copy, Debug)]
pub struct Filter<'a> {
    threshold: Threshold,
    resolver: Resolver<'a>,
    level: Level,
    /// By reference: a test is small, and copied for every query.
    room: &'a Room,
}

impl<'a> Filter<'a> {
    /// With document A's operations as the resolver, and its threshold.
    #[inline]
    pub fn certified(threshold: Threshold, level: Level) -> Self {
        Self { threshold, resolver: Resolver::Document(threshold.get()), level, room: &Room::NONE }
    }

    /// For rays and triangles of one grid, in f32: what these decide of integers that they hold exactly
    /// is so, and of the rest the integers decide (`docs/numerics/certified.md`, section 10).
    #[inline]
    pub fn on_grid(level: Level) -> Self {
        Self { threshold: Threshold::ZERO, resolver: Resolver::Grid, level, room: &Room::EXACT }
    }

    /// For any rays and triangles, right on their coordinates (`docs/numerics/exact.md`).
    #[inline]
    pub fn exact(level: Level) -> Self {
        Self { threshold: Threshold::ZERO, resolver: Resolver::Exact, level, room: &Room::EXACT }
    }

    /// For copies of what is given in f64, right on the originals (`docs/numerics/f64.md`), with room for their
    /// rounding.
    #[inline]
    pub fn on_copies(originals: &'a dyn Originals, room: &'a Room, level: Level) -> Self {
        Self { threshold: Threshold::ZERO, resolver: Resolver::Originals(originals), level, room }
    }

    /// What settles undecided pairs.
    #[inline]
    pub fn resolver(&self) -> Resolver<'a> {
        self.resolver
    }

    /// The document's threshold; zero for a mode that has none.
    #[inline]
    pub fn threshold(&self) -> Threshold {
        self.threshold
    }
}

impl Test for Filter<'_> {
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
    fn resolver(&self) -> Resolver<'_> {
        self.resolver
    }

    #[inline(always)]
    fn sure_end(&self, t_max: f32) -> f32 {
        // That of a copy is rounded up.
        if self.room.copies { t_max.next_down() } else { t_max }
    }

    #[inline(always)]
    fn rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        packet: &RayPacket<N>,
    ) -> Rays<F> {
        Rays::of_packet(packet, self.threshold, self.room)
    }

    #[inline(always)]
    fn ray(&self, ray: &Ray) -> Rays<f32> {
        Rays::of_ray(ray, self.threshold, self.room)
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
        Triangles::of_block(block, self.room)
    }

    #[inline(always)]
    fn triangles_of_corners<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        corners: [Vec3<F>; 3],
        longest_edges: Option<F>,
    ) -> Triangles<F> {
        match longest_edges {
            Some(longest_edges) => Triangles::new(corners, longest_edges),
            None => Triangles::of_corners(corners),
        }
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
        let decided = edges.decide(triangles, rays, far, live, (self.threshold, self.room));
        Some(found(&decided, counts))
    }
}

impl Filter<'_> {
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
        Outlines::new::<S>(first, second, frame, parallel, self.room.exact)
    }

    /// Whether rays and triangles are copies of what is given in f64.
    #[inline]
    pub fn is_of_copies(&self) -> bool {
        self.room.copies
    }

    /// A frame for bundles: that of what is given in f32, or of copies, which may be passed within so much more.
    /// `reach` is how far from the middle of the projection rays go.
    #[inline]
    pub fn frame(&self, frame: Frame, off: f32, reach: [f32; 2]) -> Frame {
        let frame = if self.room.copies { frame.of_copies() } else { frame };
        let off = off + self.room.passed(frame.origin());
        if off > 0.0 { frame.passed_within(off, reach) } else { frame }
    }

    /// Where the rays so far and the live ones of a packet begin to look for hits: none before the first `t_min`, and
    /// surely beyond the second.
    ///
    /// An example stands at [`Starts`].
    #[inline(always)]
    pub fn starts_in<F: Lanes<Scalar = f32>>(
        &self,
        starts: &Starts<F>,
        points: &Points<F>,
        t_min: [F; 2],
        live: F::Mask,
    ) -> Starts<F> {
        starts.with(points, t_min, live, self.threshold)
    }
}
