//! Tests one ray against a block of triangles, such as a leaf of a BVH.

use super::determinants::Determinants;
use super::edges::{Edges, cross, i64s, load, load_f32, splat, splat_f32, volume};
use super::filter::maybe;
use super::{Crossing, IntWidth, Prepared, Ray, Triangle};
use crate::simd::{Lane, Width, lanes_of};
use crate::simd::{Lanes, Simd};

/// N prepared triangles in lanes, each with its index. N is 4 or 8. Unused lanes contain triangles
/// that consist of a single point, so no ray hits them.
///
/// ```
/// use intertri::fixed::{Bits, Block, Grid, RayLanes};
/// use intertri::simd::{Simd, WithSimd, dispatch};
///
/// /// Finds the triangles of a block that a ray crosses, for a custom traversal.
/// struct Leaf<'a>(&'a Block<8>, &'a intertri::fixed::Ray);
/// impl WithSimd for Leaf<'_> {
///     type Output = Vec<u32>;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Vec<u32> {
///         let (lanes, mut crossed) = (RayLanes::<S, 8>::new(self.1), vec![]);
///         self.0.crossings_in::<S, true>(&lanes, |_, index| crossed.push(index));
///         crossed
///     }
/// }
///
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let at = |z| grid.triangle_of([[0, 0, z], [4, 0, z], [0, 4, z]]);
/// let block = Block::new([(at(5)?, 70), (at(-5)?, 71), (at(3)?, 72)]);
/// assert_eq!(block.indices()[..4], [70, 71, 72, u32::MAX]);
/// assert_eq!(dispatch(Leaf(&block, &grid.ray_of([1, 1, 0], [0, 0, 1])?)), [70, 72]);
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Block<const N: usize> {
    c1: [[f32; N]; 3],
    h4: [[f32; N]; 3],
    h5: [[f32; N]; 3],
    n: [[f32; N]; 3],
    longest: [f32; N],
    indices: [u32; N],
}

impl<const N: usize> Block<N> {
    /// Creates a block from the first N triangles, each with its index. If there are fewer than N
    /// triangles, the remaining lanes are unused.
    pub fn new(triangles: impl IntoIterator<Item = (Triangle, u32)>) -> Self {
        // Unused lanes contain a triangle that no ray crosses.
        let (mut prepared, mut indices) = ([Prepared::NONE; N], [u32::MAX; N]);
        for (lane, (triangle, index)) in triangles.into_iter().take(N).enumerate() {
            prepared[lane] = Prepared::new(&triangle);
            indices[lane] = index;
        }
        let lanes = |of: fn(&Prepared) -> [f32; 3]| {
            [0, 1, 2].map(|axis| prepared.each_ref().map(|triangle| of(triangle)[axis]))
        };
        Self {
            c1: lanes(|triangle| triangle.c1),
            h4: lanes(|triangle| triangle.h4),
            h5: lanes(|triangle| triangle.h5),
            n: lanes(|triangle| triangle.n),
            longest: prepared.map(|triangle| triangle.longest),
            indices,
        }
    }

    /// Returns the indices of the triangles, with [`u32::MAX`] in unused lanes.
    pub fn indices(&self) -> &[u32; N] {
        &self.indices
    }

    /// Calls `each` for every crossing of a ray with `t_min <= t < t_max`, lane by lane, passing
    /// the index of the triangle. Call this function in a loop that is compiled for an instruction
    /// level.
    ///
    /// With `FILTER`, an f32 test runs first to reject most misses. It does not change the result.
    #[inline(always)]
    pub fn crossings_in<S: Simd, const FILTER: bool>(
        &self,
        ray: &RayLanes<S, N>,
        mut each: impl FnMut(Crossing, u32),
    ) where
        Lane<N>: IntWidth,
    {
        let mut lanes = (1 << N) - 1;
        if FILTER {
            let triangles =
                [load_f32(&self.c1), load_f32(&self.h4), load_f32(&self.h5), load_f32(&self.n)];
            lanes = maybe(ray.origin, ray.d, ray.longest, triangles, Lanes::load(&self.longest));
            if lanes == 0 {
                return;
            }
        }

        let (h4, h5) = (load(&self.h4), load(&self.h5));
        let edges = Edges::<I<S, N>>::new(
            splat(i64s(ray.ray.origin())),
            splat(i64s(ray.ray.dir())),
            [load(&self.c1), h4, h5, cross(h4, h5)],
        );
        let (with, against) = edges.sides(lanes);
        if with | against == 0 {
            return;
        }

        let at = Determinants::of(&edges);
        for lane in lanes_of(with | against) {
            // Corners are stored in f32, where they are exact, and converted only where integers
            // are needed.
            let (c1, o) = (integers(&self.c1, lane), i64s(ray.ray.origin()));
            let a = [c1[0] - o[0], c1[1] - o[1], c1[2] - o[2]];
            let num = volume(a, integers(&self.h4, lane), integers(&self.h5, lane));
            if let Some(crossing) = at.crossing(lane, num, with >> lane & 1 != 0, &ray.ray) {
                each(crossing, self.indices[lane]);
            }
        }
    }
}

/// Returns the integer vector in a lane.
#[inline(always)]
fn integers<const N: usize>(of: &[[f32; N]; 3], lane: usize) -> [i64; 3] {
    [of[0][lane] as i64, of[1][lane] as i64, of[2][lane] as i64]
}

type F<S, const N: usize> = <Lane<N> as Width>::F<S>;
type I<S, const N: usize> = <Lane<N> as IntWidth>::I<S>;

/// A ray prepared to be tested against many blocks, for one instruction level.
///
/// ```
/// use intertri::fixed::{Bits, Grid, RayLanes};
/// use intertri::simd::{Simd, WithSimd, dispatch};
///
/// struct Prepare<'a>(&'a intertri::fixed::Ray);
/// impl WithSimd for Prepare<'_> {
///     type Output = ();
///     #[inline(always)]
///     fn run<S: Simd>(self) {
///         // Prepare the ray once, then test block after block.
///         let lanes = RayLanes::<S, 8>::new(self.0);
///     }
/// }
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// dispatch(Prepare(&grid.ray_of([1, 1, 0], [0, 0, 1])?));
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy)]
pub struct RayLanes<S: Simd, const N: usize>
where
    Lane<N>: IntWidth,
{
    ray: Ray,
    origin: [F<S, N>; 3],
    d: [F<S, N>; 3],
    longest: F<S, N>,
}

impl<S: Simd, const N: usize> RayLanes<S, N>
where
    Lane<N>: IntWidth,
{
    /// Copies a ray to all lanes.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        Self {
            ray: *ray,
            origin: splat_f32(ray.to_f32().origin),
            d: splat_f32(ray.to_f32().dir),
            longest: Lanes::splat(ray.longest()),
        }
    }
}
