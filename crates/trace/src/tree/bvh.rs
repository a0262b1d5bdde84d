//! The hierarchy.

use intertri::{Triangle, TriangleBlock};

use super::aabb::Aabb;
use super::geometries::Geometries;
use super::node::{NONE, Node};
use crate::across::lanes_of;
use crate::memory::{NoMemory, room};

/// Up to eight triangles, in six cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Leaf {
    pub(crate) block: TriangleBlock<8>,
    /// Their indices in the order given.
    pub(crate) indices: [u32; 8],
}

const _: () = assert!(size_of::<Leaf>() == 384);

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
#[derive(Clone, Debug)]
pub struct Bvh {
    /// The root is the first; a leaf of a node is the index of a block.
    pub(crate) nodes: Vec<Node>,
    /// The triangles, eight by eight.
    pub(crate) leaves: Vec<Leaf>,
    /// How many leaves, from the first, are in the nodes; the others are tested with every ray.
    pub(crate) boxed: usize,
    /// No coordinate of a triangle is larger.
    pub(crate) reach: f32,
    /// A stack of this size always suffices.
    pub(crate) stack: usize,
    pub(crate) triangles: usize,
    /// Which triangle is whose.
    pub(crate) geometries: Geometries,
    /// What it cost as built; known once it was refitted.
    pub(crate) cost_as_built: Option<f64>,
}

impl Bvh {
    /// How many triangles it was built over.
    pub fn len(&self) -> usize {
        self.triangles
    }

    /// Whether it was built over no triangle.
    pub fn is_empty(&self) -> bool {
        self.triangles == 0
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
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        let mut all = Aabb::EMPTY;
        for leaf in &self.leaves {
            for lane in lanes_of(leaf.block.live()) {
                if let Some(bounds) = Aabb::of(&leaf.block.triangle(lane)) {
                    all.join(&bounds);
                }
            }
        }
        let corner = |[x, y, z, _]: [f32; 4]| [x, y, z];
        (all.lo[0] <= all.hi[0]).then(|| [corner(all.lo), corner(all.hi)])
    }

    /// The triangles, in the order in which they were given. Those that can never be hit, which have no area or a
    /// corner that is not finite, are not kept: all their coordinates are NaN here.
    ///
    /// ```
    /// use intertri_trace::{Bvh, intertri::Triangle};
    /// let floor = Triangle::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    /// let bvh = Bvh::new(&[floor, Triangle([[7.0; 3]; 3])])?;
    /// let triangles = bvh.to_triangles();
    /// assert!(triangles[0] == floor && triangles[1].0[0][0].is_nan());
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn to_triangles(&self) -> Vec<Triangle> {
        let mut triangles = vec![Triangle([[f32::NAN; 3]; 3]); self.triangles];
        for leaf in &self.leaves {
            for lane in lanes_of(leaf.block.live()) {
                triangles[leaf.indices[lane] as usize] = leaf.block.triangle(lane);
            }
        }
        triangles
    }

    /// The triangles that have no place in the tree, ascending: they could not be hit when it was built, or had no
    /// box.
    pub(crate) fn left_out(&self) -> Result<Vec<u32>, NoMemory> {
        let in_tree = || {
            let indices = self.leaves[..self.boxed].iter().flat_map(|leaf| leaf.indices);
            indices.filter(|&index| index != NONE)
        };
        if in_tree().count() == self.triangles {
            return Ok(Vec::new());
        }
        let mut is_in = room(self.triangles)?;
        is_in.resize(self.triangles, false);
        in_tree().for_each(|index| is_in[index as usize] = true);
        let mut left_out = room(is_in.iter().filter(|&&is_in| !is_in).count())?;
        left_out.extend((0..self.triangles as u32).filter(|&index| !is_in[index as usize]));
        Ok(left_out)
    }

    /// The stack for a tree of so many nodes on its longest path.
    pub(crate) fn stack_for(depth: usize) -> usize {
        8 * depth + 8
    }

    /// No coordinate of a triangle is larger: of the boxes of the root, and of the leaves without a box.
    pub(crate) fn find_reach(&self) -> f32 {
        let root = &self.nodes[0];
        let sides = (0..3).flat_map(|axis| [root.sides(axis, false), root.sides(axis, true)]);
        let sides = sides.flatten().filter(|side| side.is_finite());
        let unboxed = self.leaves[self.boxed..].iter();
        let corners = unboxed.flat_map(|leaf| leaf.block.corners().as_flattened().as_flattened());
        sides.chain(corners).fold(0.0, |reach, x| reach.max(x.abs()))
    }

    /// The triangle in a place of the leaves.
    #[inline(always)]
    pub(crate) fn triangle_in(&self, place: u32) -> Triangle {
        self.leaves[place as usize / 8].block.triangle(place as usize % 8)
    }

    /// The index of the triangle in a place of the leaves.
    #[inline(always)]
    pub(crate) fn index_of(&self, place: u32) -> u32 {
        self.leaves[place as usize / 8].indices[place as usize % 8]
    }
}

impl Bvh {
    /// How many geometries there are: the meshes of [`Bvh::of_meshes`], else 1.
    pub fn geometries(&self) -> usize {
        self.geometries.count()
    }

    /// The geometry of a triangle by its position in the whole, where all meshes follow each other, and the
    /// triangle's number within it: what [`Hit::geometry`] and [`Hit::triangle`] tell.
    ///
    /// # Panics
    /// If there are not so many triangles.
    pub fn geometry_of(&self, position: u32) -> (u32, u32) {
        assert!((position as usize) < self.triangles, "no triangle {position}");
        self.geometries.name(position)
    }

    /// Sets the mask of a geometry, of 32 bits that mean what the caller likes; at first all are set. Queries
    /// by [`Bvh::only`] count a geometry where its mask and the query's have a bit in common. One whose mask
    /// is 0 never counts.
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
        self.geometries.set_mask(geometry, mask);
    }
}
