//! The filter: f32 lanes decide every pair for which a proven error bound allows it. The few
//! undecided lanes go to the mode's resolver.
//!
//! ```text
//!   rays, triangles ──► filter (f32, 8 lanes) ──► certain miss   nearly all pairs, by their edges
//!                                            ├──► certain hit    t is in an f32 interval; its f64
//!                                            │                   bits are computed on demand
//!                                            └──► undecided      about 1 in 10,000: to the resolver
//! ```
//!
//! The filter has two forms: one for arbitrary rays and triangles ([`edges`]), and one that
//! projects the triangles, for bundles of rays of one apex ([`projection`]).

mod block_hits;
mod bound;
mod edges;
mod evidence;
mod longest_edge;
mod parallel_rays;
mod precheck;
mod prepared;
pub(crate) mod projection;
mod room;
mod verdicts;
mod walls;
#[cfg(all(test, feature = "std"))]
mod worst;

pub use block_hits::BlockHits;
pub use edges::{Rays, Triangles};
pub use evidence::Evidence;
pub use parallel_rays::{AlongAxis, Axis, LaneHits};
pub use prepared::{PreparedPacket, PreparedRay, PreparedTriangle};
pub use room::Room;
pub use verdicts::Counts;
pub(crate) use verdicts::Verdicts;

use crate::Threshold;
use crate::exact::Rule;
use crate::packet::TriangleBlock;
use crate::resolve::{Originals, Resolver};
use crate::simd::{Lanes, Level, Simd};

use edges::Edges;
use projection::{Frame, Outlines, Points, Starts};

/// The intersection test of a mode, for your own loops over packets and blocks: f32 lanes with a
/// proven error bound, and a resolver for the pairs that the bound leaves undecided. Create one
/// with [`Mode::filter`](crate::Mode::filter).
///
/// Run your loop through [`WithSimd`](crate::simd::WithSimd), which compiles it for each
/// instruction level. A [`TriangleId`](crate::TriangleId) identifies a triangle and breaks ties. A
/// [`LeafSlot`](crate::LeafSlot) is the position at which you store the triangle; it is passed to
/// `find` closures.
///
/// ```
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{Counts, Filter, Mode, Ray, Triangle, TriangleBlock};
///
/// /// Finds which of up to eight triangles a ray hits.
/// struct Hits<'a>(Filter<'a>, &'a Ray, &'a TriangleBlock<8>);
/// impl WithSimd for Hits<'_> {
///     type Output = u32;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> u32 {
///         self.0.block_in::<S, 8>(self.1, self.2, &mut Counts::default()).bits
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let (ray, block) = (Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]), TriangleBlock::new(&[at(1.0), at(-1.0)]));
/// assert_eq!(dispatch(Hits(Mode::exact().filter(), &ray, &block)), 0b01);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Filter<'a> {
    threshold: Threshold,
    resolver: Resolver<'a>,
    level: Level,
    /// A reference, because a filter is copied for every query and should be small.
    room: &'a Room,
}

impl<'a> Filter<'a> {
    /// Creates a filter that resolves undecided pairs with document A's operations and has the
    /// given threshold.
    #[inline]
    pub fn certified(threshold: Threshold, level: Level) -> Self {
        Self { threshold, resolver: Resolver::Document(threshold.get()), level, room: &Room::NONE }
    }

    /// Creates a filter for arbitrary rays and triangles. Its results are exact for the given
    /// coordinates (`docs/numerics/exact.md`).
    #[inline]
    pub fn exact(rule: Rule, level: Level) -> Self {
        let resolver = Resolver::Exact(rule);
        Self { threshold: Threshold::ZERO, resolver, level, room: &Room::EXACT }
    }

    /// Creates a filter for f32 copies of f64 coordinates. Its results are exact for the originals.
    /// `room` bounds the rounding of the copies (`docs/numerics/f64.md`).
    #[doc(hidden)]
    #[inline]
    pub fn on_copies(originals: &'a dyn Originals, room: &'a Room, level: Level) -> Self {
        Self { threshold: Threshold::ZERO, resolver: Resolver::Originals(originals), level, room }
    }

    /// Returns the instruction level at which the filter runs.
    #[inline]
    pub fn level(&self) -> Level {
        self.level
    }

    /// Returns the resolver for undecided pairs.
    #[inline]
    pub fn resolver(&self) -> Resolver<'a> {
        self.resolver
    }

    /// Returns the document's threshold, or zero for modes without one.
    #[inline]
    pub fn threshold(&self) -> Threshold {
        self.threshold
    }

    /// Returns the parts of the bounds that depend on the scene.
    #[inline(always)]
    pub(crate) fn room(&self) -> &'a Room {
        self.room
    }

    /// Returns a limit below which any t is certainly before the ray's far end. The limit is
    /// `t_max` itself unless the ray is a copy.
    #[inline(always)]
    pub(crate) fn sure_end(&self, t_max: f32) -> f32 {
        // The end of a copied ray is rounded up.
        if self.room.copies { t_max.next_down() } else { t_max }
    }

    /// Like [`Filter::sure_end`], but for N rays.
    #[inline(always)]
    pub(crate) fn sure_ends<F: Lanes<Scalar = f32>, const N: usize>(&self, t_max: &[f32; N]) -> F {
        // Avoid `map`, which is not always inlined.
        let mut ends = *t_max;
        if self.room.copies {
            for t_max in &mut ends {
                *t_max = t_max.next_down();
            }
        }
        F::load(&ends)
    }

    /// Finds which of the `live` lanes are hits with `t_min <= t` and, certainly or possibly,
    /// `t <= far`.
    #[inline(always)]
    pub(crate) fn test<F: Lanes<Scalar = f32>>(
        &self,
        triangles: &Triangles<F>,
        rays: &Rays<F>,
        far: F,
        live: u32,
        counts: &mut Counts,
    ) -> Verdicts<F> {
        counts.tests += u64::from(live.count_ones());
        // Compute the edge functions first: they reject nearly every pair before t is computed.
        let edges = Edges::new(triangles, rays);
        let verdicts = edges.decide(triangles, rays, far, live, (self.threshold, self.room));
        counts.undecided += u64::from(verdicts.undecided.count_ones());
        verdicts
    }
}

impl Filter<'_> {
    /// Projects the triangles in one or two blocks with a frame, for rays whose depth per unit of t
    /// is at least `slowest`. The second block begins at lane 8. Triangles perpendicular to one of the
    /// frame's level axes ([`Filter::level_axes`]) are left out.
    ///
    /// See [`Outlines`] for an example.
    #[inline(always)]
    pub fn outlines_in<S: Simd>(
        &self,
        first: &TriangleBlock<8>,
        second: Option<&TriangleBlock<8>>,
        frame: &Frame,
        slowest: f32,
    ) -> Outlines {
        // The slack in `PARALLEL` is much larger than the rounding error here.
        let least = if self.threshold.get() > 0.0 { self.threshold.above } else { 0.0 };
        let parallel = bound::PARALLEL * least / slowest;
        let mut outlines = Outlines::new::<S>(first, second, frame, parallel, self.room.exact);
        if frame.level_axes() != 0 {
            outlines.leave_out(self.walls(frame.level_axes(), first, second));
        }
        outlines
    }

    /// Returns whether rays and triangles are f32 copies of f64 originals.
    #[doc(hidden)]
    #[inline]
    pub fn is_of_copies(&self) -> bool {
        self.room.copies
    }

    /// Prepares a frame for bundles whose rays miss the origin by at most `off`. For copies of f64
    /// originals, `off` grows by the rounding error of the copies. `reach` is the largest distance
    /// of the rays from the centre of the projection. Both are ignored for parallel rays.
    #[inline]
    pub fn frame(&self, frame: Frame, off: f32, reach: [f32; 2]) -> Frame {
        let frame = if self.room.copies { frame.of_copies() } else { frame };
        if frame.parallel_rays().is_some() {
            return frame;
        }
        let off = off + self.room.passed(frame.origin());
        if off > 0.0 { frame.passed_within(off, reach) } else { frame }
    }

    /// Adds the live rays in a packet to `starts`, the depths at which the rays' intervals begin.
    /// No hit has a t below `t_min[0]`, and any t above `t_min[1]` is certainly past the near end
    /// of the interval.
    ///
    /// See [`Starts`] for an example.
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
