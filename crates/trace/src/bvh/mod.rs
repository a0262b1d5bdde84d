//! The public type `Bvh<S>`: constructors, masks, and access to the triangles.

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
/// Queries return exactly what a plain loop over all triangles would, down to the index and the
/// bits of t, regardless of the hierarchy and the number of threads. Trace rays with the shortcut
/// methods, or create a [`query`](Bvh::query) with your own settings.
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
/// A hierarchy over [`Triangle64`](type@intertri::Triangle64) is a `Bvh<f64>`. It takes
/// [`Ray64`](intertri::Ray64), and its results are correct for the f64 coordinates. Traversal uses
/// f32 copies relative to the scene's centre. The original triangles, which take another 72 bytes
/// each, settle the hits that the copies cannot decide, and determine t, u, and v. Hits are always
/// decided exactly.
///
/// ```
/// use intertri_trace::Bvh;
/// use intertri_trace::intertri::{Ray64, Triangle64};
/// // A wall at UTM coordinates, and a ray that starts a nanometre away from it.
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
    /// The leaf slot of each triangle; see [`lookup`].
    slots: OnceLock<Box<[LeafSlot]>>,
}

impl<S: BvhScalar> Bvh<S> {
    /// Builds a hierarchy over triangles, which keep their indices.
    ///
    /// # Errors
    /// Returns an error if there are 2^31 triangles or more, or if memory runs out.
    pub fn new(triangles: &[TriangleOf<S>]) -> Result<Self, BuildError> {
        Self::with_progress(triangles, &|_, _| ())
    }

    /// Builds a hierarchy over several meshes. Each mesh is a geometry, numbered in order. A hit
    /// reports the geometry and the triangle's index within it. If two hits have the same t, the
    /// lower geometry number wins, then the lower triangle index.
    ///
    /// # Errors
    /// Returns an error if there are 2^31 triangles or more, or if memory runs out.
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
        // Check the count first, so that too many triangles cause an error instead of a huge
        // allocation.
        Tree::check_count(count)?;
        let out_of_memory = |NoMemory| BuildError::OutOfMemory { count };
        let mut all = room(count).map_err(out_of_memory)?;
        for mesh in meshes {
            all.extend_from_slice(mesh);
        }
        Self::of_geometries(&all, meshes.iter().map(|mesh| mesh.len()))
    }

    /// Builds a hierarchy over the concatenated triangles of several meshes.
    fn of_geometries(
        triangles: &[TriangleOf<S>],
        counts: impl ExactSizeIterator<Item = usize> + Clone,
    ) -> Result<Self, BuildError> {
        let count = triangles.len();
        // Allocate the table before building the tree, which takes much longer, so that running out
        // of memory fails early.
        let geometries =
            Geometries::of(counts).map_err(|NoMemory| BuildError::OutOfMemory { count })?;
        let mut bvh = Self::new(triangles)?;
        bvh.tree.geometries = geometries;
        Ok(bvh)
    }

    /// Like [`Bvh::new`], but occasionally calls `progress` with the number of triangles done and
    /// the total. Calls may come from any thread, in any order.
    ///
    /// # Errors
    /// Returns an error if there are 2^31 triangles or more, or if memory runs out.
    pub fn with_progress(
        triangles: &[TriangleOf<S>],
        progress: Progress<'_>,
    ) -> Result<Self, BuildError> {
        let (tree, originals) = S::build(triangles, progress)?;
        Ok(Self::of_parts(tree, originals))
    }

    /// Combines a tree and the data stored with it.
    fn of_parts(tree: Tree, originals: S::Originals) -> Self {
        // The slot table is created by the first call that needs it; most programs make no such
        // call.
        Self { tree, originals, slots: OnceLock::new() }
    }

    /// Like [`Clone::clone`], but with fallible allocation.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
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

    /// Returns the number of triangles the hierarchy was built over.
    pub fn len(&self) -> usize {
        self.tree.triangles
    }

    /// Returns whether [`Bvh::len`] is 0.
    pub fn is_empty(&self) -> bool {
        self.tree.triangles == 0
    }

    /// Returns the smallest and largest corners of the bounding box of all triangles that can be
    /// hit, or `None` if no triangle can be hit. Visits every triangle.
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
            // Consider only live lanes, because triangles that cannot be hit do not count.
            for lane in lanes_of(leaf.block.live()) {
                for corner in self.triangle_in(LeafSlot(first + lane as u32)).0 {
                    all = Some(joined(all, corner));
                }
            }
        }
        all
    }

    /// Returns the number of geometries: one per mesh passed to [`Bvh::from_meshes`], otherwise 1.
    pub fn geometries(&self) -> usize {
        self.tree.geometries.count()
    }

    /// Merges all geometries into one, whose mask has all bits set. Hits then number the triangles
    /// of all meshes consecutively.
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

    /// Sets the mask of a geometry: 32 bits whose meaning you choose. Initially, all bits are set.
    /// A ray query considers a geometry only if its mask shares a bit with the [query's
    /// mask](crate::Query::mask), so a geometry with mask 0 is never considered. Closest-point
    /// queries and [`Solid`](crate::Solid) ignore masks.
    ///
    /// See [`Query::mask`](crate::Query::mask) for an example.
    ///
    /// # Panics
    /// Panics if the geometry is out of bounds.
    pub fn set_mask(&mut self, geometry: usize, mask: u32) {
        self.tree.geometries.set_mask(geometry, mask);
    }

    /// Returns the triangle in a leaf slot.
    #[inline]
    pub(crate) fn triangle_in(&self, slot: LeafSlot) -> TriangleOf<S> {
        S::triangle(&self.tree, &self.originals, slot)
    }
}

impl<S: BvhScalar> Bvh<S> {
    /// Returns the triangles in their original order. Triangles with a non-finite corner are not
    /// stored, so all their coordinates are NaN in the result.
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
    /// Panics if memory runs out.
    pub fn to_triangles(&self) -> Vec<TriangleOf<S>> {
        self.try_to_triangles().expect("not enough memory to list the triangles")
    }

    /// Like [`Bvh::to_triangles`], but returns an error if memory runs out.
    #[doc(hidden)]
    pub fn try_to_triangles(&self) -> Result<Vec<TriangleOf<S>>, OutOfMemory> {
        let nothing = TriangleOf([[S::from(f32::NAN); 3]; 3]);
        let mut triangles = filled(self.tree.triangles, nothing)?;
        for (i, leaf) in self.tree.leaves.iter().enumerate() {
            for lane in lanes_of(self.tree.present(i)) {
                // Leaves store the indices of their triangles. Triangles that no leaf stores were
                // not finite, so they remain NaN.
                triangles[leaf.indices[lane] as usize] =
                    self.triangle_in(LeafSlot((8 * i + lane) as u32));
            }
        }
        Ok(triangles)
    }
}

/// Extends a box to include a point.
fn joined<S: Scalar>(all: Option<[[S; 3]; 2]>, point: [S; 3]) -> [[S; 3]; 2] {
    let [mut lo, mut hi] = all.unwrap_or([point; 2]);
    for k in 0..3 {
        lo[k] = if point[k] < lo[k] { point[k] } else { lo[k] };
        hi[k] = if point[k] > hi[k] { point[k] } else { hi[k] };
    }
    [lo, hi]
}
