//! The hierarchy as users have it.

mod moved;
mod saved;

use intertri::{Scalar, TriangleOf};

use crate::across::lanes_of;
use crate::build::BuildError;
use crate::given::{Given, Progress};
use crate::memory::{NoMemory, OutOfMemory, filled, room};
use crate::threads;
use crate::tree::{Geometries, Tree};

/// A bounding volume hierarchy over triangles.
///
/// Its answers are those of a plain loop over all triangles, index and bits of t: they depend
/// neither on the hierarchy nor on the number of threads.
///
/// ```
/// use intertri_trace::Bvh;
/// use intertri_trace::intertri::{Certified, Ray, Triangle};
///
/// let floor = Triangle::new([-1.0, 0.0, -1.0], [3.0, 0.0, -1.0], [-1.0, 0.0, 3.0]);
/// let bvh = Bvh::new(&[floor])?;
/// let hit = bvh.closest(&Certified::default(), &Ray::new([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]));
/// assert_eq!(hit.map(|hit| (hit.triangle, hit.t)), Some((0, 2.0)));
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
///
/// Over [`Triangle64`](type@intertri::Triangle64) it is a `Bvh<f64>`, is asked with [`Ray64`](intertri::Ray64), and is
/// right on these coordinates. The walk goes over copies in f32 about the scene's centre; what these leave open, and
/// t, u and v, the originals tell. That takes 72 bytes a triangle more. Only the mode
/// [`Exact`](intertri::Exact) answers.
///
/// ```
/// use intertri_trace::Bvh;
/// use intertri_trace::intertri::{Exact, Ray64, Triangle64};
/// // A wall at UTM coordinates, and a ray that leaves it a nanometre away.
/// let [x, y] = [148_376.0, 528_980.0];
/// let corners = [[x, y, 0.0], [x, y + 4.0, 0.0], [x, y, 3.0]];
/// let bvh = Bvh::new(&[Triangle64(corners)])?;
/// let ray = |way| Ray64::new([x + 1e-9, y + 1.0, 1.0], [way, 0.0, 0.0]);
/// assert!(!bvh.any(&Exact::default(), &ray(1.0)));
/// assert!(bvh.any(&Exact::default(), &ray(-1.0)));
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bvh<S: Given = f32> {
    pub(crate) tree: Tree,
    pub(crate) originals: S::Originals,
}

impl<S: Given> Bvh<S> {
    /// Builds a hierarchy over triangles, which keep their indices.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more, or too little memory.
    pub fn new(triangles: &[TriangleOf<S>]) -> Result<Self, BuildError> {
        Self::with_progress(triangles, &|_, _| ())
    }

    /// A hierarchy over several meshes, each a geometry by its place among them: hits tell it beside the
    /// triangle's number within it. Of equal t, the lowest geometry is closer, then the lowest triangle.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more, or too little memory.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Exact, Ray, Triangle};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let bvh = Bvh::of_meshes(&[&[at(7.0)], &[], &[at(5.0), at(3.0)]])?;
    /// let ray = Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]);
    /// let hits = bvh.all(&Exact::default(), &ray);
    /// assert!(hits.iter().map(|hit| (hit.geometry, hit.triangle)).eq([(2, 1), (2, 0), (0, 0)]));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn of_meshes(meshes: &[&[TriangleOf<S>]]) -> Result<Self, BuildError> {
        let count = meshes.iter().map(|mesh| mesh.len()).sum();
        Tree::check_count(count)?;
        let out_of_memory = |NoMemory| BuildError::OutOfMemory { count };
        let mut all = room(count).map_err(out_of_memory)?;
        for mesh in meshes {
            all.extend_from_slice(mesh);
        }
        let counts = meshes.iter().map(|mesh| mesh.len());
        let geometries = Geometries::of(counts).map_err(out_of_memory)?;
        let mut bvh = Self::new(&all)?;
        bvh.tree.geometries = geometries;
        Ok(bvh)
    }

    /// A hierarchy over triangles that share vertices: three indices a triangle.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more, or too little memory.
    ///
    /// # Panics
    /// If an index is beyond the positions.
    pub fn indexed(positions: &[[S; 3]], triangles: &[[u32; 3]]) -> Result<Self, BuildError> {
        let corners = |i: usize| TriangleOf(triangles[i].map(|i| positions[i as usize]));
        let corners = threads::each(triangles.len(), corners);
        Self::new(&corners.map_err(|NoMemory| BuildError::OutOfMemory { count: triangles.len() })?)
    }

    /// [`Bvh::new`], telling from time to time how many triangles are done, of how many. The calls
    /// come from any thread and may overtake each other.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more, or too little memory.
    pub fn with_progress(
        triangles: &[TriangleOf<S>],
        progress: Progress<'_>,
    ) -> Result<Self, BuildError> {
        let (tree, originals) = S::build(triangles, progress)?;
        Ok(Self { tree, originals })
    }

    /// A copy, as by [`Clone`], or an error where that would abort.
    ///
    /// # Errors
    /// If there is too little memory.
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
        Ok(Self { tree, originals })
    }

    /// How many triangles it was built over.
    pub fn len(&self) -> usize {
        self.tree.triangles
    }

    /// Whether it was built over no triangle.
    pub fn is_empty(&self) -> bool {
        self.tree.triangles == 0
    }

    /// The smallest and largest corner of the box around all triangles that can be hit; `None` where there
    /// are none. It looks at each of them.
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
            for lane in lanes_of(leaf.block.live()) {
                for corner in self.triangle(first + lane as u32).0 {
                    all = Some(joined(all, corner));
                }
            }
        }
        all
    }

    /// How many geometries there are: the meshes of [`Bvh::of_meshes`], else 1.
    pub fn geometries(&self) -> usize {
        self.tree.geometries.count()
    }

    /// The geometry of a triangle by its position in the whole, where all meshes follow each other, and the
    /// triangle's number within it: what [`Hit::geometry`](intertri::Hit::geometry) and
    /// [`Hit::triangle`](intertri::Hit::triangle) tell.
    ///
    /// # Panics
    /// If there are not so many triangles.
    pub fn geometry_of(&self, position: u32) -> (u32, u32) {
        assert!((position as usize) < self.tree.triangles, "no triangle {position}");
        self.tree.geometries.name(position)
    }

    /// The same with all triangles in one mesh that every mask has: hits tell positions in the whole.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Exact, Ray, Triangle};
    /// let at = |z| [Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z])];
    /// let bvh = Bvh::of_meshes(&[&at(5.0), &at(3.0)])?.into_one_mesh();
    /// let ray = Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]);
    /// let hit = bvh.closest(&Exact::default(), &ray).unwrap();
    /// assert_eq!((hit.geometry, hit.triangle, bvh.geometries()), (0, 1, 1));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn into_one_mesh(mut self) -> Self {
        self.tree.geometries = Geometries::one();
        self
    }

    /// Sets the mask of a geometry, of 32 bits that mean what the caller likes; at first all are set. Queries
    /// of rays count a geometry where its mask and the query's, all bits without [`Bvh::only`], have one in
    /// common, so that one whose mask is 0 never counts. Closest points and [`Solid`](crate::Solid) go by all
    /// triangles, whatever their masks.
    ///
    /// # Panics
    /// If there are not so many geometries.
    ///
    /// ```
    /// use intertri_trace::intertri::{Exact, Ray, Triangle};
    /// use intertri_trace::{Bvh, Select};
    /// const GLASS: u32 = 0b01;
    /// const WALLS: u32 = 0b10;
    /// let at = |z| [Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z])];
    /// let mut bvh = Bvh::of_meshes(&[&at(3.0), &at(5.0)])?;
    /// bvh.set_mask(0, GLASS);
    /// bvh.set_mask(1, WALLS);
    /// let ray = Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]);
    /// let walls = Select { mask: WALLS, ..Select::default() };
    /// let hit = bvh.only(&walls).closest(&Exact::default(), &ray).unwrap();
    /// assert_eq!((hit.geometry, hit.triangle, hit.t), (1, 0, 5.0));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn set_mask(&mut self, geometry: usize, mask: u32) {
        self.tree.geometries.set_mask(geometry, mask);
    }

    /// The triangle in a place of the leaves.
    #[inline]
    pub(crate) fn triangle(&self, place: u32) -> TriangleOf<S> {
        S::triangle(&self.tree, &self.originals, place)
    }
}

impl<S: Given> Bvh<S> {
    /// The triangles, in the order in which they were given. Those with a corner that is not finite are not kept: all
    /// their coordinates are NaN here.
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
    /// If there is too little memory for them.
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
                triangles[leaf.indices[lane] as usize] = self.triangle((8 * i + lane) as u32);
            }
        }
        Ok(triangles)
    }
}

/// A box with one more point in it.
fn joined<S: Scalar>(all: Option<[[S; 3]; 2]>, point: [S; 3]) -> [[S; 3]; 2] {
    let [mut lo, mut hi] = all.unwrap_or([point; 2]);
    for k in 0..3 {
        lo[k] = if point[k] < lo[k] { point[k] } else { lo[k] };
        hi[k] = if point[k] > hi[k] { point[k] } else { hi[k] };
    }
    [lo, hi]
}
