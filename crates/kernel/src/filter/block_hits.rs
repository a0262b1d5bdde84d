//! All hits of a ray on the triangles in a block, as decided by the filter.

use crate::packet::TriangleBlock;
use crate::simd::{Lanes, Mask, Simd};

use super::edges::{Edges, Rays, Triangles};
use super::verdicts::Verdicts;
use super::{Counts, Filter, PreparedRay};
use crate::Ray;
use crate::resolve::Resolver;

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
    /// Returns the lanes whose triangles are perpendicular to an axis along which the ray's
    /// direction is 0. Then D is exactly 0, so the ray hits none of them. A ray in the plane of a
    /// floor or a wall is undecided for all of its triangles, and asking the resolver eight times
    /// takes much longer. Only an exact resolver on the coordinates themselves is told of this.
    #[cold]
    #[inline(never)]
    pub(crate) fn parallel_lanes<const N: usize>(
        &self,
        ray: &Ray,
        block: &TriangleBlock<N>,
    ) -> u32 {
        let (mut lanes, is_exact) = (0, matches!(self.resolver, Resolver::Exact(_)));
        let [a, b, c] = block.corners();
        // Compare bits, because a CPU may be set to read subnormal numbers as 0.
        for axis in (0..3).filter(|&axis| is_exact && ray.dir[axis].to_bits() << 1 == 0) {
            for lane in 0..N {
                let [a, b, c] = [a, b, c].map(|corner| corner[axis][lane].to_bits());
                lanes |= u32::from(a == b && b == c) << lane;
            }
        }
        lanes
    }

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
        let (triangles, live) = (Triangles::<S::F32x8>::of_block(block, self.room), block.live());
        let rays = Rays::splat(&ray.lanes);
        counts.tests += u64::from(live.count_ones());
        let edges = Edges::new(&triangles, &rays);
        let far = Lanes::splat(far);
        let Verdicts { hit, mut undecided, t_lo, t_hi } =
            edges.decide(&triangles, &rays, far, live, (self.threshold, self.room));
        // Most blocks return here, without storing anything.
        if hit | undecided == 0 {
            return None;
        }
        counts.undecided += u64::from(undecided.count_ones());
        if undecided != 0 {
            undecided &= !self.parallel_lanes(&ray.ray, block);
        }

        // If the upper bound on t reaches the end of the interval, the hit may be beyond that end,
        // so it is not certain.
        let sure = hit & Mask::bits(t_hi.lt(Lanes::splat(self.sure_end(ray.ray.t_max))));
        let leaves = sure & !Mask::bits(edges.den.negative());
        let mut hits = BlockHits {
            sure,
            undecided: undecided | hit & !sure,
            leaves,
            t_lo: [0.0; 8],
            t_hi: [0.0; 8],
        };
        t_lo.store(&mut hits.t_lo);
        t_hi.store(&mut hits.t_hi);
        Some(hits)
    }
}

#[cfg(test)]
mod tests {
    use crate::exact::{Rule, Tier, crossing_from};
    use crate::simd::Level;
    use crate::{Filter, Ray, Triangle, TriangleBlock};

    /// Tests rays beside and inside walls, some of which are tilted by the smallest possible step,
    /// also between subnormal numbers.
    #[test]
    fn only_lanes_in_parallel_planes_are_left_out() {
        let filter = Filter::exact(Rule::Closed, Level::PORTABLE);
        let (mut left_out, mut hits) = (0, 0);
        for i in 0..3000_u32 {
            let number =
                |j: u32| f32::from((i.wrapping_mul(40_503) >> (j % 13)) as u8) / 64.0 - 2.0;
            let (k, unit) = (i as usize % 3, if i % 2 == 0 { 1.0 } else { 1e-41 });
            let wall = unit * number(3);
            let corner = |lane: u32, n: u32| {
                let mut c = [0, 1, 2].map(|j| number(7 * n + 3 * lane + j));
                c[k] = if lane < 4 { wall } else { wall + unit * number(lane) };
                c
            };
            let mut triangles: Vec<Triangle> =
                (0..8).map(|l| Triangle([corner(l, 0), corner(l, 1), corner(l, 2)])).collect();
            triangles[3].0[1][k] = wall.next_up();
            triangles[2].0[2][k] = -wall;
            let (mut origin, mut dir) = ([1, 2, 3].map(number), [4, 5, 6].map(number));
            (origin[k], dir[k]) = match i / 6 % 4 {
                0 => (wall, 0.0),
                1 => (wall, -0.0),
                2 => (wall - unit, 0.0),
                _ => (wall.next_down(), 1e-44),
            };
            let ray = Ray::new(origin, dir);
            let lanes = filter.parallel_lanes(&ray, &TriangleBlock::<8>::new(&triangles));
            left_out += lanes.count_ones();
            for (lane, triangle) in triangles.iter().enumerate() {
                let hit = crossing_from(Tier::Narrow, Rule::Closed, &ray, triangle).is_some();
                hits += u32::from(hit);
                assert!(!(hit && lanes >> lane & 1 != 0), "{ray:?} {triangle:?}");
                let [a, b, c] = triangle.0.map(|corner| corner[k].to_bits());
                let is_parallel = dir[k] == 0.0 && a == b && b == c;
                assert!(!is_parallel || lanes >> lane & 1 != 0, "{ray:?} {triangle:?}");
            }
        }
        assert!(left_out > 4000 && hits > 100, "{left_out} left out, {hits} hits");
    }
}
