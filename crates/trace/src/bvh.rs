//! The hierarchy and its questions.

use intertri::lanes::{Level, Simd, WithSimd};
use intertri::{Best, Counts, Hit, Mode, Ray, RayPacket, Triangle, TrianglePack};

use crate::build::{self, BuildError, Tree};
use crate::node::{NONE, Node};
use crate::questions;
use crate::search;
use crate::stack::{Lent, Stack};

/// Up to eight triangles, in six cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Leaf {
    pub(crate) pack: TrianglePack<8>,
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
/// use intertri::{Certified, Ray, Triangle};
/// use intertri_trace::Bvh;
///
/// let floor = Triangle::new([-1.0, 0.0, -1.0], [3.0, 0.0, -1.0], [-1.0, 0.0, 3.0]);
/// let bvh = Bvh::new(&[floor])?;
/// let hit = bvh.closest(&Certified::default(), &Ray::new([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]));
/// assert_eq!((hit.triangle, hit.t), (0, 2.0));
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
#[derive(Debug)]
pub struct Bvh {
    /// The root is the first; a leaf of a node is the index of a pack.
    pub(crate) nodes: Vec<Node>,
    /// The triangles, eight by eight.
    pub(crate) leaves: Vec<Leaf>,
    /// How many leaves, from the first, are in the nodes; the others are asked of every ray.
    pub(crate) boxed: usize,
    /// No coordinate of a triangle is larger.
    pub(crate) reach: f32,
    /// A stack of this size always suffices.
    stack: usize,
    triangles: usize,
}

impl Bvh {
    /// Builds a hierarchy over triangles, which keep their indices.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more.
    pub fn new(triangles: &[Triangle]) -> Result<Self, BuildError> {
        Self::with_progress(triangles, &|_, _| ())
    }

    /// A hierarchy over triangles that share vertices: three indices a triangle.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more.
    ///
    /// # Panics
    /// If an index is beyond the positions.
    pub fn indexed(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Self, BuildError> {
        let corners = |t: &[u32; 3]| Triangle(t.map(|i| positions[i as usize]));
        Self::new(&triangles.iter().map(corners).collect::<Vec<_>>())
    }

    /// [`Bvh::new`], telling from time to time how many triangles are done, of how many. The calls
    /// come from any thread.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more.
    pub fn with_progress(
        triangles: &[Triangle],
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, BuildError> {
        let Tree { nodes, mut blocks, depth, unbounded } =
            build::build_with_progress(triangles, progress)?;
        let boxed = blocks.len();

        // No coordinate is larger than those of the root's boxes, and of triangles without a box.
        let none = |side: &&f32| side.is_finite();
        let sides =
            (0..3).flat_map(|axis| [nodes[0].sides(axis, false), nodes[0].sides(axis, true)]);
        let corners = unbounded.iter().flat_map(|&i| triangles[i as usize].0.as_flattened());
        let reach = |reach: f32, x: &f32| reach.max(x.abs());
        let reach = sides.flatten().filter(none).chain(corners).fold(0.0, reach);

        // Triangles of which no box is known follow the leaves, in blocks of their own.
        blocks.extend(unbounded.chunks(8).map(|chunk| {
            let mut block = [NONE; 8];
            block[..chunk.len()].copy_from_slice(chunk);
            block
        }));
        let level = Level::best();
        let leaf = |i: usize| {
            let indices = blocks[i];
            Leaf { pack: level.run(Pack { triangles, block: &indices }), indices }
        };
        Ok(Self {
            leaves: build::each(blocks.len(), leaf),
            nodes,
            boxed,
            reach,
            stack: 8 * depth + 8,
            triangles: triangles.len(),
        })
    }

    /// How many triangles it was built over.
    pub fn len(&self) -> usize {
        self.triangles
    }

    /// Whether it was built over no triangle.
    pub fn is_empty(&self) -> bool {
        self.triangles == 0
    }

    /// The closest hit; of equal t, the lowest index.
    pub fn closest<M: Mode>(&self, mode: &M, ray: &Ray) -> Hit {
        questions::closest(self, mode.which(), ray)
    }

    /// Whether anything is hit.
    pub fn any<M: Mode>(&self, mode: &M, ray: &Ray) -> bool {
        questions::any(self, mode.which(), ray)
    }

    /// Every hit, in the order of the triangles.
    pub fn all<M: Mode>(&self, mode: &M, ray: &Ray) -> Vec<Hit> {
        questions::all(self, mode.which(), ray)
    }

    /// [`Bvh::closest`] of the rays of a packet; a dead lane is a miss.
    pub fn closest_packet<M: Mode, const N: usize>(
        &self,
        mode: &M,
        packet: &RayPacket<N>,
    ) -> [Hit; N] {
        let mut hits = [Hit::MISS; N];
        mode.level().run(Packet { bvh: self, mode, packet, hits: &mut hits });
        hits
    }

    /// [`Bvh::closest`] of many rays: `hits[i]` becomes the answer of `rays[i]`.
    ///
    /// Rays that are neighbours in the slice are best neighbours in space, too. Fastest are rays that
    /// share their origin, 1024 of them in a row in a narrow cone, such as 32 by 32 pixels in Z-order;
    /// whether that is so is found out here, and no answer depends on it.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_of_each<M: Mode>(&self, mode: &M, rays: &[Ray], hits: &mut [Hit]) -> Counts {
        questions::closest_of_each(self, mode.which(), rays, hits)
    }

    /// The triangles of [`Bvh::closest_of_each`] alone, `u32::MAX` for a miss: where nobody asks for
    /// t, it need not be computed in f64.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn triangles_of_each<M: Mode>(
        &self,
        mode: &M,
        rays: &[Ray],
        triangles: &mut [u32],
    ) -> Counts {
        questions::triangles_of_each(self, mode.which(), rays, triangles)
    }

    /// [`Bvh::any`] of many rays: `hits[i]` becomes the answer of `rays[i]`.
    ///
    /// Fastest where neighbours share their origin, or end at one point but for rounding, at t = 1 or at `t_max`,
    /// and do not look beyond it: as shadow rays to a light.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn any_of_each<M: Mode>(&self, mode: &M, rays: &[Ray], hits: &mut [bool]) -> Counts {
        questions::any_of_each(self, mode.which(), rays, hits)
    }

    /// The triangle in a place of the leaves.
    #[inline(always)]
    pub(crate) fn triangle_in(&self, place: u32) -> Triangle {
        self.leaves[place as usize / 8].pack.triangle(place as usize % 8)
    }

    /// The index of the triangle in a place of the leaves.
    #[inline(always)]
    pub(crate) fn index_of(&self, place: u32) -> u32 {
        self.leaves[place as usize / 8].indices[place as usize % 8]
    }

    /// The hit that a best stands for.
    #[inline(always)]
    pub(crate) fn hit<M: Mode>(&self, mode: &M, ray: &Ray, best: &Best) -> Hit {
        mode.hit(ray, best, |place| self.triangle_in(place))
    }

    /// Stacks for the searches of some rays.
    pub(crate) fn stacks(&self, rays: usize) -> Stack {
        Stack::new(rays, self.stack)
    }

    /// What a [`search`] for single rays needs.
    #[inline]
    pub(crate) fn kept(&self) -> Lent {
        Lent::new(self.stack)
    }
}

/// The triangles of a block side by side.
struct Pack<'a> {
    triangles: &'a [Triangle],
    block: &'a [u32; 8],
}

impl WithSimd for Pack<'_> {
    type Output = TrianglePack<8>;
    #[inline(always)]
    fn run<S: Simd>(self) -> TrianglePack<8> {
        let mut corners = [Triangle([[0.0; 3]; 3]); 8];
        let mut count = 0;
        for &i in self.block.iter().take_while(|&&i| i != NONE) {
            corners[count] = self.triangles[i as usize];
            count += 1;
        }
        TrianglePack::new_in::<S>(&corners[..count])
    }
}

struct Packet<'a, M, const N: usize> {
    bvh: &'a Bvh,
    mode: &'a M,
    packet: &'a RayPacket<N>,
    hits: &'a mut [Hit; N],
}

impl<M: Mode, const N: usize> WithSimd for Packet<'_, M, N> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { bvh, mode, packet, hits } = self;
        let (mut kept, mut counts) = (bvh.kept(), Counts::default());
        for lane in (0..N).filter(|lane| packet.live() >> lane & 1 != 0) {
            let ray = packet.ray(lane);
            let best = search::closest::<M, S>(bvh, mode, &ray, false, &mut kept, &mut counts);
            hits[lane] = bvh.hit(mode, &ray, &best);
        }
    }
}
