//! The type `Query`, which holds the mode, the selection of triangles, and scratch memory, and
//! provides all methods that trace rays.

mod batches;
mod shortcuts;
mod visible;

use std::fmt;

use intertri::simd::Level;
use intertri::{Crossing, Hit, Hit32, Mode, RayId, RayOf};

use crate::bvh::Bvh;
use crate::scalar::BvhScalar;
use crate::selection::{ActiveSelection, Faces, Selection};
use crate::tree::MeshTriangle;
use crate::walk::one_ray;
use crate::walk::single::{LentScratch, SingleRay, TraversalScratch};

/// A ray query. It determines how hits are decided and which triangles are considered, and provides
/// the methods that trace rays. Create one with [`Bvh::query`].
///
/// By default, the mode is [`Mode::exact`] and all triangles are considered. Each setting returns
/// the query, so calls can be chained. Results equal those of a plain loop over the selected
/// triangles: they do not depend on the hierarchy, the number of threads, or earlier queries.
///
/// If you trace one ray at a time, keep one query per thread and reuse it: it owns the traversal
/// stack and remembers where the last rays went.
///
/// ```
/// use intertri_trace::Bvh;
/// use intertri_trace::intertri::{Mode, Ray, Triangle};
/// // A particle that bounces between two walls.
/// let wall = |x| Triangle::new([x, -9.0, -9.0], [x, 9.0, -9.0], [x, 0.0, 9.0]);
/// let bvh = Bvh::new(&[wall(-1.0), wall(3.0)])?;
/// let mut query = bvh.query().mode(Mode::certified());
/// let (mut ray, mut path) = (Ray::new([0.0; 3], [1.0, 0.0, 0.0]), 0.0);
/// for _ in 0..3 {
///     let hit = query.closest(&ray).expect("the ray hits one of the walls");
///     path += hit.t;
///     ray = Ray::new([ray.origin[0] + ray.dir[0] * hit.t as f32, 0.0, 0.0], ray.dir.map(|d| -d));
///     ray.t_min = 0.5;
/// }
/// assert_eq!(path, 3.0 + 4.0 + 4.0);
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
pub struct Query<'a, S: BvhScalar = f32> {
    bvh: &'a Bvh<S>,
    mode: Mode,
    selection: Selection<'a>,
    /// The filter that traversal applies, or `None` if all triangles are considered.
    active: ActiveSelection<'a>,
    on_this_thread: bool,
    scratch: LentScratch,
}

impl<S: BvhScalar> Bvh<S> {
    /// Creates a query. By default, its mode is [`Mode::exact`] and it considers all triangles.
    #[inline]
    pub fn query(&self) -> Query<'_, S> {
        Query {
            bvh: self,
            mode: Mode::exact(),
            selection: Selection::ALL,
            active: Selection::ALL.active(&self.tree),
            on_this_thread: false,
            scratch: TraversalScratch::lend(&self.tree),
        }
    }
}

/// The mode decides what counts as a hit. With f64 coordinates, hits are always decided exactly.
impl Query<'_, f32> {
    /// Sets the mode.
    #[inline]
    pub fn mode(self, mode: Mode) -> Self {
        Self { mode, ..self }
    }
}

impl<'a, S: BvhScalar> Query<'a, S> {
    /// Sets the mode to [`Mode::once`], in which each point of a mesh belongs to exactly one of its
    /// triangles.
    pub fn once(self) -> Self {
        Self { mode: Mode::once().at(self.mode.level()), ..self }
    }

    /// Sets the instruction set level to use. Results do not depend on it.
    pub fn at(self, level: Level) -> Self {
        Self { mode: self.mode.at(level), ..self }
    }

    /// Traces batches on the calling thread only.
    ///
    /// By default, batches run in the calling thread's rayon pool. Inside `ThreadPool::install`,
    /// that is your own pool.
    pub fn on_this_thread(self) -> Self {
        Self { on_this_thread: true, ..self }
    }

    /// Considers only geometries whose mask ([`Bvh::set_mask`]) shares a bit with `mask`.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// const GLASS: u32 = 0b01;
    /// const WALLS: u32 = 0b10;
    /// let at = |z| [Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z])];
    /// let mut bvh = Bvh::from_meshes(&[&at(3.0), &at(5.0)])?;
    /// bvh.set_mask(0, GLASS);
    /// bvh.set_mask(1, WALLS);
    /// let hit = bvh.query().mask(WALLS).closest(&Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0])).unwrap();
    /// assert_eq!((hit.geometry, hit.triangle, hit.t), (1, 0, 5.0));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn mask(self, mask: u32) -> Self {
        let selection = Selection { mask, ..self.selection };
        self.select(selection)
    }

    /// Considers only triangles that a ray hits from the given side.
    ///
    /// ```
    /// use intertri_trace::{Bvh, Faces};
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// // Seen along the ray, one wall's corners run clockwise, and the other's counter-clockwise.
    /// let back = Triangle::new([0.0, 0.0, 3.0], [1.0, 0.0, 3.0], [0.0, 1.0, 3.0]);
    /// let front = Triangle::new([0.0, 0.0, 5.0], [0.0, 1.0, 5.0], [1.0, 0.0, 5.0]);
    /// let bvh = Bvh::new(&[back, front])?;
    /// let ray = Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]);
    /// assert_eq!(bvh.closest(&ray).unwrap().triangle, 0);
    /// assert_eq!(bvh.query().faces(Faces::Front).closest(&ray).unwrap().triangle, 1);
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn faces(self, faces: Faces) -> Self {
        let selection = Selection { faces, ..self.selection };
        self.select(selection)
    }

    /// Ignores the triangles of the given hits. For a batch, pass one list per ray. For single
    /// rays, pass one list, which applies to every ray. Lists identify triangles by
    /// [`Hit::geometry`] and [`Hit::triangle`]; misses in a list have no effect.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let bvh = Bvh::new(&[at(3.0), at(5.0)])?;
    /// let ray = Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]);
    /// let first = bvh.closest(&ray).unwrap();
    /// let next = bvh.query().skip(&[&[first]]).closest(&ray).unwrap();
    /// assert_eq!((first.triangle, next.triangle), (0, 1));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn skip(self, lists: &'a [&'a [Hit]]) -> Self {
        let selection = Selection { skip: lists, ..self.selection };
        self.select(selection)
    }

    fn select(self, selection: Selection<'a>) -> Self {
        // Determine once, instead of for each ray, whether any triangles must be filtered out.
        Self { selection, active: selection.active(&self.bvh.tree), ..self }
    }
}

/// Single-ray queries: one ray per call.
///
/// # Panics
/// Panics if you set more than one list of triangles to skip.
impl<S: BvhScalar> Query<'_, S> {
    /// Returns the closest hit, if any. If two hits have the same t, the lower geometry number
    /// wins, then the lower triangle index.
    #[inline]
    pub fn closest(&mut self, ray: &RayOf<S>) -> Option<Hit> {
        self.trace(ray, one_ray::closest)
    }

    /// Like [`Query::closest`], but with t, u, and v in f32. In the exact modes, each is the true
    /// value rounded once, which takes less time than in f64 if the coordinates are f32.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// let bvh = Bvh::new(&[Triangle::new([0.0, 0.0, 5.0], [3.0, 0.0, 5.0], [0.0, 3.0, 5.0])])?;
    /// let hit = bvh.query().closest32(&Ray::new([1.0, 1.0, 0.0], [0.0, 0.0, 1.0])).unwrap();
    /// assert_eq!((hit.t, hit.u, hit.v), (5.0, 1.0 / 3.0, 1.0 / 3.0));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    #[inline]
    pub fn closest32(&mut self, ray: &RayOf<S>) -> Option<Hit32> {
        self.trace(ray, one_ray::closest32)
    }

    /// Like [`Query::closest`], but returns only the triangle, which saves computing t, u, and v.
    ///
    /// ```
    /// use intertri_trace::{Bvh, MeshTriangle};
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let bvh = Bvh::from_meshes(&[&[at(5.0)], &[at(3.0)]])?;
    /// let triangle = bvh.query().closest_triangle(&Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]));
    /// assert_eq!(triangle, Some(MeshTriangle { triangle: 0, geometry: 1 }));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    #[inline]
    pub fn closest_triangle(&mut self, ray: &RayOf<S>) -> Option<MeshTriangle> {
        self.trace(ray, one_ray::closest_triangle)
    }

    /// Returns whether the ray hits anything.
    #[inline]
    pub fn any(&mut self, ray: &RayOf<S>) -> bool {
        self.trace(ray, one_ray::any)
    }

    /// Returns all hits, sorted by t. Hits with the same t are sorted by geometry, then by
    /// triangle.
    pub fn all(&mut self, ray: &RayOf<S>) -> Vec<Hit> {
        self.trace(ray, one_ray::all)
    }

    /// Returns the points where a ray crosses the mesh, sorted by t. Crossings with the same t are
    /// sorted by geometry, then by triangle. A point on an edge or corner belongs to only one of
    /// the triangles that share it. Crossings are decided exactly in every mode.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// // A square, crossed exactly on its diagonal.
    /// let [a, b, c, d] = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0], [1.0, 1.0, 5.0]];
    /// let bvh = Bvh::new(&[Triangle::new(a, b, c), Triangle::new(d, c, b)])?;
    /// let ray = Ray::new([0.5, 0.5, 0.0], [0.0, 0.0, 1.0]);
    /// assert_eq!((bvh.query().all(&ray).len(), bvh.query().crossings(&ray).len()), (2, 1));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn crossings(&mut self, ray: &RayOf<S>) -> Vec<Crossing> {
        self.trace_in(self.crossing_mode(), ray, one_ray::crossings)
    }

    /// Returns the first of [`Query::crossings`], including the side that is crossed, without
    /// tracing the whole line. Use it for particles that travel from medium to medium.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    /// let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
    /// let bvh = Bvh::new(&faces)?;
    /// // The ray enters exactly at a corner and leaves through the opposite face.
    /// let ray = Ray::new([-1.0; 3], [1.0; 3]);
    /// let entry = bvh.query().next_crossing(&ray).unwrap();
    /// assert!(entry.hit.t == 1.0 && !entry.leaves);
    /// let exit = bvh.query().next_crossing(&Ray { t_min: 1.5, ..ray }).unwrap();
    /// assert!(exit.hit.triangle == 3 && exit.leaves);
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn next_crossing(&mut self, ray: &RayOf<S>) -> Option<Crossing> {
        self.trace_in(self.crossing_mode(), ray, one_ray::next_crossing)
    }

    /// Returns the mode for crossings: exact, counting each crossing once.
    fn crossing_mode(&self) -> Mode {
        // Counting requires a rule that assigns each shared edge to one triangle, whatever mode is
        // set for hits.
        Mode::once().at(self.mode.level())
    }

    /// Traces a ray in the query's mode.
    #[inline(always)]
    fn trace<A>(&mut self, ray: &RayOf<S>, verb: Verb<A>) -> A {
        self.trace_in(self.mode, ray, verb)
    }

    /// Traces a ray in a given mode.
    #[inline(always)]
    fn trace_in<A>(&mut self, mode: Mode, ray: &RayOf<S>, verb: Verb<A>) -> A {
        let Self { bvh, active, scratch, selection, .. } = self;
        assert!(selection.skip.len() <= 1, "pass at most one list of triangles to skip for a ray");
        bvh.trace_ray(mode, active, ray, scratch, verb)
    }
}

impl<S: BvhScalar> Bvh<S> {
    /// Traces a ray through the hierarchy's tree.
    #[inline(always)]
    fn trace_ray<A>(
        &self,
        mode: Mode,
        selection: &ActiveSelection<'_>,
        ray: &RayOf<S>,
        scratch: &mut TraversalScratch,
        verb: Verb<A>,
    ) -> A {
        S::with_ray(&self.tree, &self.originals, mode, ray, |filter, ray| {
            verb(SingleRay { tree: &self.tree, filter, ray, id: RayId(0), selection, scratch })
        })
    }
}

/// A function that traces a single f32 ray, such as a search for its closest hit.
type Verb<A> = fn(SingleRay<'_>) -> A;

impl<S: BvhScalar> Clone for Query<'_, S> {
    fn clone(&self) -> Self {
        Self { scratch: TraversalScratch::lend(&self.bvh.tree), ..*self }
    }
}

impl<S: BvhScalar> fmt::Debug for Query<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { mode, selection, on_this_thread, .. } = self;
        f.debug_struct("Query")
            .field("mode", mode)
            .field("selection", selection)
            .field("on_this_thread", on_this_thread)
            .finish_non_exhaustive()
    }
}
