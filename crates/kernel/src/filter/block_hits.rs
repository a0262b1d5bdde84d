//! All hits of a ray on the triangles in a block, as decided by the filter.

use crate::packet::TriangleBlock;
use crate::simd::{Lanes, Mask, Simd};

use super::edges::{Edges, Rays, Triangles};
use super::verdicts::Verdicts;
use super::{Counts, Filter, PreparedRay};

/// The hits of a ray on the triangles in a block. A lane that is in neither `sure` nor `undecided`
/// is a miss.
///
/// ```
/// use intertri::internal::BlockHits;
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{Counts, Mode, Ray, Triangle, TriangleBlock};
///
/// struct Leaf<'a>(&'a TriangleBlock<8>, &'a Ray);
/// impl WithSimd for Leaf<'_> {
///     type Output = Option<BlockHits>;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let (test, counts) = (Mode::exact().filter(), &mut Counts::default());
///         test.block_hits_in::<S>(&test.prepare_ray(self.1), self.0, self.1.t_max, counts)
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let block = TriangleBlock::new(&[at(5.0), at(-1.0), at(3.0)]);
/// let hits = |x| dispatch(Leaf(&block, &Ray::new([x, 0.25, 0.0], [0.0, 0.0, 1.0])));
/// let inside = hits(0.25).unwrap();
/// assert_eq!((inside.sure, inside.undecided, inside.leaves & 0b101), (0b101, 0, 0b101));
/// assert!(inside.t_lo[2] < 3.0 && 3.0 < inside.t_hi[2]);
/// // The rays at x = 0 run through edges, where f32 cannot decide.
/// assert_eq!(hits(0.0).unwrap().undecided, 0b101);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct BlockHits {
    /// Certain hits: within the interval and inside all edges.
    pub sure: u32,
    /// Undecided lanes, for the resolver.
    pub undecided: u32,
    /// Certain hits at which the ray crosses the plane in the direction of the normal.
    pub leaves: u32,
    /// Lower bounds on t for the certain hits.
    pub t_lo: [f32; 8],
    /// Upper bounds on t for the certain hits.
    pub t_hi: [f32; 8],
}

impl Filter<'_> {
    /// Tests a ray against a block. Returns `None` if all lanes certainly miss. A lane whose t
    /// certainly exceeds `far` counts as a miss.
    #[inline(always)]
    pub fn block_hits_in<S: Simd>(
        &self,
        ray: &PreparedRay,
        block: &TriangleBlock<8>,
        far: f32,
        counts: &mut Counts,
    ) -> Option<BlockHits> {
        let (triangles, live) =
            (Triangles::<S::F32x8>::of_block(block, self.room), ray.live_lanes(block, counts));
        let rays = Rays::splat(&ray.lanes);
        counts.tests += u64::from(live.count_ones());
        let edges = Edges::new(&triangles, &rays);
        let far = Lanes::splat(far);
        let Verdicts { hit, undecided, leaves, t_lo, t_hi } =
            edges.decide(&triangles, &rays, far, live, (self.threshold, self.room));
        // Most blocks return here, without storing anything.
        if hit | undecided == 0 {
            return None;
        }
        counts.undecided += u64::from(undecided.count_ones());

        // If the upper bound on t reaches the end of the interval, the hit may be beyond that end,
        // so it is not certain.
        let sure = hit & Mask::bits(t_hi.lt(Lanes::splat(self.sure_end(ray.ray.t_max))));
        let mut hits = BlockHits {
            sure,
            undecided: undecided | hit & !sure,
            leaves: leaves & sure,
            t_lo: [0.0; 8],
            t_hi: [0.0; 8],
        };
        t_lo.store(&mut hits.t_lo);
        t_hi.store(&mut hits.t_hi);
        Some(hits)
    }
}
