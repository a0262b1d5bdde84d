//! The public `Bvh<S>`: building it, and looking up its triangles.

mod closest_point;
mod indexed;
mod lookup;
mod refit;
mod saved;

pub use indexed::IndexedMesh;

use std::sync::OnceLock;

use intertri::{LeafSlot, Scalar, TriangleOf};

use crate::build::BuildError;
use crate::scalar::{BvhScalar, Progress};
use crate::tree::{Geometries, Tree};
use crate::util::lane_ops::lanes_of;
use crate::util::memory::{NoMemory, OutOfMemory, filled, room};

/// A bounding volume hierarchy over triangles.
///
/// Its answers equal those of a plain loop over all triangles, index and bits of t: they depend neither on
/// the hierarchy nor on the number of threads. Trace rays with its shortcuts, or with a [`query`](Bvh::query)
/// with your own settings.
///
/// ```
/// use intertri_trace::Bvh;
/// use intertri_trace::intertri::{Ray, Triangle};
///
/// let floor = Triangle::new([-1.0, 0.0, -1.0], [3.0, 0.0, -1.0], [-1.0, 0.0, 3.0]);
/// let bvh = Bvh::new(&[floor])?;
/// let hit = bvh.closest(&Ray::new([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]));
/// assert_eq!(hit.map(|hit| (hit.triangle, hit.t)), Some((0, 2.0)));
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
///
/// Over [`Triangle64`](type@intertri::Triangle64) it is a `Bvh<f64>`, takes [`Ray64`](intertri::Ray64), and
/// its answers are right for these coordinates. Traversal uses f32 copies relative to the scene's centre. The
/// originals decide where the copies cannot, and determine t, u and v. They take 72 more bytes per triangle.
/// Hits are always decided exactly.
///
/// ```
/// use intertri_trace::Bvh;
/// use intertri_trace::intertri::{Ray64, Triangle64};
/// // A wall at UTM coordinates, and a ray that leaves it a nanometre away.
/// let [x, y] = [148_376.0, 528_980.0];
/// let wall = Triangle64::new([x, y, 0.0], [x, y + 4.0, 0.0], [x, y, 3.0]);
/// let bvh = Bvh::new(&[wall])?;
/// let ray = |dir| Ray64::new([x + 1e-9, y + 1.0, 1.0], [dir, 0.0, 0.0]);
/// assert!(!bvh.any(&ray(1.0)));
/// assert!(bvh.any(&ray(-1.0)));
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bvh<S: BvhScalar = f32> {
    pub(crate) tree: Tree,
    pub(crate) originals: S::Originals,
    /// See [`lookup`].
    slots: OnceLock<Box<[LeafSlot]>>,
}

impl<S: BvhScalar> Bvh<S> {
    /// Builds a hierarchy over triangles, which keep their indices.
    ///
    /// # Errors
    /// Fails if there are 2^31 triangles or more, or too little memory.
    pub fn new(triangles: &[TriangleOf<S>]) -> Result<Self, BuildError> {
        Self::with_progress(triangles, &|_, _| ())
    }

    /// Builds a hierarchy over several meshes: each is a geometry, numbered in order. A hit has the number of
    /// its geometry and of the triangle within it. If two hits have the same t, the lower geometry wins, then
    /// the lower triangle.
    ///
    /// # Errors
    /// Fails if there are 2^31 triangles or more, or too little memory.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let bvh = Bvh::from_meshes(&[&[at(7.0)], &[], &[at(5.0), at(3.0)]])?;
    /// let hits = bvh.all(&Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]));
    /// assert!(hits.iter().map(|hit| (hit.geometry, hit.triangle)).eq([(2, 1), (2, 0), (0, 0)]));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn from_meshes(meshes: &[&[TriangleOf<S>]]) -> Result<Self, BuildError> {
        let count = meshes.iter().map(|mesh| mesh.len()).sum();
        // Checked first, so that too many triangles are an error and not a huge allocation.
        Tree::check_count(count)?;
        let out_of_memory = |NoMemory| BuildError::OutOfMemory { count };
        let mut all = room(count).map_err(out_of_memory)?;
        for mesh in meshes {
            all.extend_from_slice(mesh);
        }
        Self::of_geometries(&all, meshes.iter().map(|mesh| mesh.len()))
    }

    /// Builds over the concatenated triangles of several meshes.
    fn of_geometries(
        triangles: &[TriangleOf<S>],
        counts: impl ExactSizeIterator<Item = usize> + Clone,
    ) -> Result<Self, BuildError> {
        let count = triangles.len();
        // Allocated before the tree is built, which takes much longer: if the table does not fit, this fails
        // early.
        let geometries =
            Geometries::of(counts).map_err(|NoMemory| BuildError::OutOfMemory { count })?;
        let mut bvh = Self::new(triangles)?;
        bvh.tree.geometries = geometries;
        Ok(bvh)
    }

    /// Like [`Bvh::new`], but occasionally calls `progress` with the number of triangles that are done, and
    /// their total. The calls may come from any thread and out of order.
    ///
    /// # Errors
    /// Fails if there are 2^31 triangles or more, or too little memory.
    pub fn with_progress(
        triangles: &[TriangleOf<S>],
        progress: Progress<'_>,
    ) -> Result<Self, BuildError> {
        let (tree, originals) = S::build(triangles, progress)?;
        Ok(Self::of_parts(tree, originals))
    }

    /// Combines a tree and the data stored with it.
    fn of_parts(tree: Tree, originals: S::Originals) -> Self {
        // The table of slots is created by the first call that needs it; most programs never do.
        Self { tree, originals, slots: OnceLock::new() }
    }

    /// A copy, as from [`Clone`], but returns an error if there is too little memory.
    ///
    /// # Errors
    /// Fails if there is too little memory.
    ///
    /// ```
    /// use intertri_trace::{Bvh, intertri::Triangle};
    /// let bvh = Bvh::new(&[Triangle::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, -3.0])])?;
    /// assert_eq!(bvh.try_clone()?.to_bytes(), bvh.to_bytes());
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn try_clone(&self) -> Result<Self, BuildError> {
        let out_of_memory = BuildError::OutOfMemory { count: self.len() };
        let tree = self.tree.try_clone().map_err(|NoMemory| out_of_memory)?;
        let originals = S::try_clone(&self.originals).map_err(|OutOfMemory| out_of_memory)?;
        Ok(Self::of_parts(tree, originals))
    }

    /// The number of triangles it was built over.
    pub fn len(&self) -> usize {
        self.tree.triangles
    }

    /// Whether it was built over no triangles.
    pub fn is_empty(&self) -> bool {
        self.tree.triangles == 0
    }

    /// The smallest and largest corner of the box around all triangles that can be hit; `None` if there are
    /// none. Visits each of them.
    ///
    /// ```
    /// use intertri_trace::{Bvh, intertri::Triangle};
    /// let bvh = Bvh::new(&[Triangle::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, -3.0])])?;
    /// assert_eq!(bvh.bounds(), Some([[0.0, 0.0, -3.0], [1.0, 2.0, 0.0]]));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn bounds(&self) -> Option<[[S; 3]; 2]> {
        let mut all: Option<[[S; 3]; 2]> = None;
        for (leaf, first) in self.tree.leaves.iter().zip((0..).step_by(8)) {
            // Only live lanes: triangles that cannot be hit do not count.
            for lane in lanes_of(leaf.block.live()) {
                for corner in self.triangle_in(LeafSlot(first + lane as u32)).0 {
                    all = Some(joined(all, corner));
                }
            }
        }
        all
    }

    /// The number of geometries: the meshes of [`Bvh::from_meshes`], otherwise 1.
    pub fn geometries(&self) -> usize {
        self.tree.geometries.count()
    }

    /// Merges all geometries into one, which every mask selects: hits number triangles across all meshes.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// let at = |z| [Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z])];
    /// let bvh = Bvh::from_meshes(&[&at(5.0), &at(3.0)])?.into_one_mesh();
    /// let hit = bvh.closest(&Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0])).unwrap();
    /// assert_eq!((hit.geometry, hit.triangle, bvh.geometries()), (0, 1, 1));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn into_one_mesh(mut self) -> Self {
        self.tree.geometries = Geometries::one();
        self
    }

    /// Sets the mask of a geometry: 32 bits whose meaning you choose; at first all are set. A ray query
    /// considers a geometry if its mask and the [query's](crate::Query::mask) have a bit in common, so one
    /// whose mask is 0 is never considered. Closest points and [`Solid`](crate::Solid) consider all
    /// triangles, whatever their masks.
    ///
    /// See [`Query::mask`](crate::Query::mask) for an example.
    ///
    /// # Panics
    /// Panics if the geometry is out of bounds.
    pub fn set_mask(&mut self, geometry: usize, mask: u32) {
        self.tree.geometries.set_mask(geometry, mask);
    }

    /// The triangle in a slot of the leaves.
    #[inline]
    pub(crate) fn triangle_in(&self, slot: LeafSlot) -> TriangleOf<S> {
        S::triangle(&self.tree, &self.originals, slot)
    }
}

impl<S: BvhScalar> Bvh<S> {
    /// The triangles in their original order. Those with a corner that is not finite are not stored: here all
    /// their coordinates are NaN.
    ///
    /// ```
    /// use intertri_trace::{Bvh, intertri::Triangle};
    /// let floor = Triangle::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    /// let bvh = Bvh::new(&[floor, Triangle([[f32::INFINITY; 3]; 3])])?;
    /// let triangles = bvh.to_triangles();
    /// assert!(triangles[0] == floor && triangles[1].0[0][0].is_nan());
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    ///
    /// # Panics
    /// Panics if there is too little memory for them.
    pub fn to_triangles(&self) -> Vec<TriangleOf<S>> {
        self.try_to_triangles().expect("memory for the triangles of a hierarchy")
    }

    /// [`Bvh::to_triangles`], or an error if there is too little memory.
    #[doc(hidden)]
    pub fn try_to_triangles(&self) -> Result<Vec<TriangleOf<S>>, OutOfMemory> {
        let nothing = TriangleOf([[S::from(f32::NAN); 3]; 3]);
        let mut triangles = filled(self.tree.triangles, nothing)?;
        for (i, leaf) in self.tree.leaves.iter().enumerate() {
            for lane in lanes_of(self.tree.present(i)) {
                // Leaves know their triangles' indices. Triangles in no leaf were not finite, and stay NaN.
                triangles[leaf.indices[lane] as usize] =
                    self.triangle_in(LeafSlot((8 * i + lane) as u32));
            }
        }
        Ok(triangles)
    }
}

/// A box extended by a point.
fn joined<S: Scalar>(all: Option<[[S; 3]; 2]>, point: [S; 3]) -> [[S; 3]; 2] {
    let [mut lo, mut hi] = all.unwrap_or([point; 2]);
    for k in 0..3 {
        lo[k] = if point[k] < lo[k] { point[k] } else { lo[k] };
        hi[k] = if point[k] > hi[k] { point[k] } else { hi[k] };
    }
    [lo, hi]
}
