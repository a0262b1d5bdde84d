//! The modes, and the queries over slices that they support.

use alloc::vec::Vec;

use super::blocks::Blocks;
use super::rows::Rows;
use crate::exact::Rule;
use crate::filter::{Counts, Filter, PreparedTriangle};
use crate::packet::{PacketHits, RayPacket, TriangleBlock};
use crate::simd::{Lane, Level, Simd, Width, WithSimd};
use crate::{Crossings, Hit, Ray, Threshold};

/// Determines how hits are decided and which CPU instructions are used.
///
/// | mode | a triangle is hit if |
/// | --- | --- |
/// | [`Mode::exact`], the default | the true ray meets the closed triangle: its edges and corners belong to it |
/// | [`Mode::once`] | the same, but each point of a mesh belongs to only one of its triangles |
/// | [`Mode::certified`] | the f64 operations of document A, in their order, find a hit: the results equal those of a plain loop over that scalar reference, bit for bit |
///
/// In every mode, a hit counts if `t_min <= t < t_max` and `t > 0`. A ray with a NaN or infinite
/// coordinate hits nothing, and a triangle that has such a coordinate or is degenerate is never
/// hit. If two triangles are hit at the same t, the lower index counts as closer. Results are the
/// same on every CPU and at every [`Level`].
///
/// [`closest`](Mode::closest), [`any`](Mode::any), [`all`](Mode::all), and
/// [`crossings`](Mode::crossings) take slices of any length, in f32 or f64, and return t, u, and v
/// in f64. [`packet`](Mode::packet) and [`block`](Mode::block) take 4, 8, or 16 rays or triangles
/// in lanes. If you write your own BVH, use the mode's [`filter`](Mode::filter) in its loops.
///
/// # Exact
/// Tests run in f32 lanes under a proven error bound, with exact arithmetic for the pairs that the
/// bound leaves undecided. Hits are decided for the coordinates as given, and t, u, and v are the
/// true values, correctly rounded. No ray slips through a mesh between two triangles that share an
/// edge. A ray that starts on a triangle or is parallel to it does not hit it.
/// `docs/numerics/exact.md` has the definition and the proof.
///
/// ```
/// use intertri::{Mode, Ray, Triangle, simd::Level};
/// // A square made of two triangles, and a ray exactly through their common edge.
/// let [a, b, c, d] = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0], [1.0, 1.0, 5.0]];
/// let square = [Triangle::new(a, b, c), Triangle::new(d, c, b)];
/// let ray = Ray::new([0.3, 0.7, 0.0], [0.0, 0.0, 3.0]);
/// let hit = Mode::exact().closest(&square, &ray).unwrap();
/// assert_eq!((hit.triangle, hit.t), (0, 5.0 / 3.0));
/// assert_eq!(Mode::exact().at(Level::PORTABLE).closest(&square, &ray), Some(hit));
/// // Both triangles own their common edge; in the `once` mode, only one of them does.
/// assert_eq!((Mode::exact().all(&square, &ray).len(), Mode::once().all(&square, &ray).len()), (2, 1));
/// ```
///
/// # Certified
/// Tests run in the same f32 lanes, with the reference's own f64 operations for undecided pairs.
/// The reference implements document A, which defines the `InterTri` test (`docs/documents.md`).
/// The mode uses the document's [`Threshold`].
///
/// ```
/// use intertri::{Mode, Ray, Threshold, Triangle};
/// // In a scene of size 1e-7, the default threshold of 1e-9 is a significant distance.
/// let small = Triangle::new([0.0, 0.0, 5e-10], [1e-7, 0.0, 5e-10], [0.0, 1e-7, 5e-10]);
/// let ray = Ray::new([2e-8, 2e-8, 0.0], [0.0, 0.0, 1.0]);
/// assert!(!Mode::certified().any(&[small], &ray));
/// assert!(Mode::certified_with(Threshold::new(1e-30).unwrap()).any(&[small], &ray));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    arithmetic: Arithmetic,
    level: Level,
}

/// The arithmetic that decides hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Arithmetic {
    Exact(Rule),
    Document(Threshold),
}

impl Default for Mode {
    fn default() -> Self {
        Self::exact()
    }
}

impl Mode {
    /// Returns the mode that is correct for the coordinates as given. Edges and corners belong to
    /// all triangles that share them.
    pub fn exact() -> Self {
        Self::of(Arithmetic::Exact(Rule::Closed))
    }

    /// Returns the mode that is correct for the coordinates as given and assigns each point on an
    /// edge or a corner to only one of the triangles that share it, as if the ray's direction were
    /// moved by (ε, ε², ε³). A ray through an edge of a closed mesh crosses it once.
    pub fn once() -> Self {
        Self::of(Arithmetic::Exact(Rule::Once))
    }

    /// Returns the mode whose results match document A's f64 reference, bit for bit, with the
    /// default threshold.
    pub fn certified() -> Self {
        Self::certified_with(Threshold::DEFAULT)
    }

    /// Returns the mode whose results match document A's f64 reference, bit for bit, with the given
    /// threshold.
    pub fn certified_with(threshold: Threshold) -> Self {
        Self::of(Arithmetic::Document(threshold))
    }

    fn of(arithmetic: Arithmetic) -> Self {
        // `Level::best` caches its result, so CPU features are detected only once.
        Self { arithmetic, level: Level::best() }
    }

    /// Selects another instruction level. Results do not depend on the level.
    pub fn at(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// Returns the instruction level at which queries run: this CPU's best unless you choose
    /// another.
    pub fn level(self) -> Level {
        self.level
    }

    /// Returns the f32 filter with the mode's resolver, for your own loops.
    #[inline]
    pub fn filter(self) -> Filter<'static> {
        match self.arithmetic {
            Arithmetic::Exact(rule) => Filter::exact(rule, self.level),
            Arithmetic::Document(threshold) => Filter::certified(threshold, self.level),
        }
    }

    /// Returns the rule that determines which triangles own an edge, if the mode is exact.
    ///
    /// ```
    /// use intertri::{Mode, Rule};
    /// assert_eq!(Mode::exact().rule(), Some(Rule::Closed));
    /// assert_eq!(Mode::certified().rule(), None);
    /// ```
    pub fn rule(self) -> Option<Rule> {
        match self.arithmetic {
            Arithmetic::Exact(rule) => Some(rule),
            Arithmetic::Document(_) => None,
        }
    }

    pub(super) fn arithmetic(self) -> Arithmetic {
        self.arithmetic
    }
}

/// Queries for rays or triangles in lanes.
impl Mode {
    /// Tests N rays against one triangle. N is 4, 8, or 16.
    ///
    /// ```
    /// use intertri::{Mode, PreparedTriangle, Ray, RayPacket, Triangle};
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let rays = [0.25, 0.75].map(|x| Ray::new([x, 0.5, 0.0], [0.0, 0.0, 1.0]));
    /// let hits = Mode::exact().packet(&RayPacket::<4>::new(&rays), &PreparedTriangle::new(&wall));
    /// assert_eq!((hits.bits, hits.t[0]), (0b01, 5.0));
    /// ```
    pub fn packet<const N: usize>(
        self,
        rays: &RayPacket<N>,
        triangle: &PreparedTriangle,
    ) -> PacketHits<N>
    where
        Lane<N>: Width,
    {
        self.level.run(Packet { filter: self.filter(), rays, triangle })
    }

    /// Tests one ray against N triangles. N is 4, 8, or 16.
    ///
    /// ```
    /// use intertri::{Mode, Ray, Triangle, TriangleBlock};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let block = TriangleBlock::<8>::new(&[at(5.0), at(-1.0), at(3.0)]);
    /// let hits = Mode::exact().block(&Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]), &block);
    /// assert_eq!((hits.bits, hits.t[0], hits.t[2]), (0b101, 5.0, 3.0));
    /// ```
    pub fn block<const N: usize>(self, ray: &Ray, block: &TriangleBlock<N>) -> PacketHits<N>
    where
        Lane<N>: Width,
    {
        self.level.run(Block { filter: self.filter(), ray, block })
    }
}

impl Blocks {
    /// Like [`Mode::closest`], but for the prepared triangles.
    pub fn closest(&self, mode: Mode, ray: &Ray) -> Option<Hit> {
        super::slices::closest(mode.filter(), Rows::Blocks(self), ray)
    }

    /// Like [`Mode::any`], but for the prepared triangles.
    pub fn any(&self, mode: Mode, ray: &Ray) -> bool {
        super::slices::any(mode.filter(), Rows::Blocks(self), ray)
    }

    /// Counts the crossings of a ray with a surface, as listed by [`Mode::crossings`]. For a closed
    /// mesh, `signed` is the winding number around the ray's origin.
    ///
    /// ```
    /// use intertri::{Blocks, Crossings, Mode, Ray, Triangle};
    /// let [a, b, c, d] = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0], [1.0, 1.0, 5.0]];
    /// let square = Blocks::new(&[Triangle::new(a, b, c), Triangle::new(d, c, b)]);
    /// let crossings = square.count_crossings(Mode::exact(), &Ray::new([0.5, 0.5, 0.0], [0.0, 0.0, 1.0]));
    /// assert_eq!(crossings, Crossings { signed: 1, unsigned: 1 });
    /// ```
    pub fn count_crossings(&self, mode: Mode, ray: &Ray) -> Crossings {
        let once = Mode::once().at(mode.level());
        super::slices::count_crossings(once.filter(), Rows::Blocks(self), ray)
    }

    /// Like [`Mode::all`], but for the prepared triangles.
    pub fn all(&self, mode: Mode, ray: &Ray) -> Vec<Hit> {
        super::slices::all(mode.filter(), Rows::Blocks(self), ray)
    }
}

struct Packet<'a, const N: usize> {
    filter: Filter<'a>,
    rays: &'a RayPacket<N>,
    triangle: &'a PreparedTriangle,
}

impl<const N: usize> WithSimd for Packet<'_, N>
where
    Lane<N>: Width,
{
    type Output = PacketHits<N>;
    #[inline(always)]
    fn run<S: Simd>(self) -> PacketHits<N> {
        let rays = self.filter.prepare_packet_in::<S, N>(self.rays);
        self.filter.packet_in(&rays, self.triangle, &mut Counts::default())
    }
}

struct Block<'a, const N: usize> {
    filter: Filter<'a>,
    ray: &'a Ray,
    block: &'a TriangleBlock<N>,
}

impl<const N: usize> WithSimd for Block<'_, N>
where
    Lane<N>: Width,
{
    type Output = PacketHits<N>;
    #[inline(always)]
    fn run<S: Simd>(self) -> PacketHits<N> {
        self.filter.block_in::<S, N>(self.ray, self.block, &mut Counts::default())
    }
}
