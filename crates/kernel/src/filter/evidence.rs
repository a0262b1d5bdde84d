//! The values on which the filter bases its decisions. They are public so that tests can compare
//! the bounds with exact arithmetic.

use crate::packet::{Copy32, TriangleBlock};
use crate::simd::{Lanes, Level, Mask, Simd, WithSimd};
use crate::{Ray, Threshold, Triangle, TriangleOf};

use super::bound;
use super::edges::{Edges, PlaneHit, Rays, Triangles};
use super::precheck::{Constants, Precheck};
use super::room::Room;

/// The values on which the `certified` mode bases one decision, as computed at a given SIMD level,
/// each with its error bound.
///
/// The notation follows `docs/numerics/certified.md`: `v`, `w`, and `u` are the edge functions,
/// `den` is the denominator, and t is `num / den`. NaN and infinities are passed through.
///
/// ```
/// use intertri::internal::Evidence;
/// use intertri::{Ray, Threshold, Triangle, simd::Level};
/// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let evidence = |x| {
///     let ray = Ray::new([x, 0.25, 0.0], [0.0, 0.0, 1.0]);
///     Evidence::of(&ray, &triangle, Threshold::DEFAULT, Level::best())
/// };
/// // The first ray is certainly inside. The second is on an edge, where f32 cannot decide.
/// assert!(evidence(0.25).w.abs() > evidence(0.25).edge);
/// assert!(evidence(0.0).v.abs() <= evidence(0.0).edge);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// V, the weight of the second corner times the denominator.
    pub v: f32,
    /// W, the weight of the third corner times the denominator.
    pub w: f32,
    /// U, the weight of the first corner times the denominator.
    pub u: f32,
    /// The error bound on V and on W.
    pub edge: f32,
    /// The error bound on U.
    pub u_edge: f32,
    /// The sharp bounds on V, W, and U, for pairs that the other bounds leave undecided.
    pub sharp: [f32; 3],
    /// D, the dot product of the normal (not of unit length) and the direction.
    pub den: f32,
    /// The error bound on D.
    pub den_err: f32,
    /// T, the dot product of the normal and the vector from the origin to the first corner.
    pub num: f32,
    /// The error bound on T.
    pub num_err: f32,
    /// The sharp bound on T, for pairs that the other bound leaves undecided.
    pub sharp_num: f32,
    /// Lower and upper bounds on t from the sharp bound on T, valid if [`Evidence::sure`].
    pub sharp_t: [f32; 2],
    /// The lower bound on t, valid if [`Evidence::sure`].
    pub t_lo: f32,
    /// The upper bound on t, valid if [`Evidence::sure`].
    pub t_hi: f32,
    /// V, W, U, and D divided by `h`, as computed in the precheck.
    pub precheck: [f32; 4],
    /// The error bound on each value in `precheck`.
    pub precheck_bound: f32,
    /// The longest edge of the triangle.
    pub h: f32,
    /// Whether t is certainly outside the ray's interval or certainly not above the threshold;
    /// valid if [`Evidence::sure`].
    pub out_of_range: bool,
    /// Whether the ray is far enough from grazing for anything to be decided.
    pub sure: bool,
}

impl Evidence {
    /// Computes the filter's values for a ray and a triangle at a SIMD level.
    ///
    /// ```
    /// use intertri::internal::Evidence;
    /// use intertri::{Ray, Threshold, Triangle, simd::Level};
    /// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let ray = Ray::new([0.25; 3], [0.0, 0.0, 1.0]);
    /// let seen = Evidence::of(&ray, &triangle, Threshold::DEFAULT, Level::best());
    /// assert!(seen.sure && seen.v > seen.edge && seen.t_lo < 4.75 && 4.75 < seen.t_hi);
    /// ```
    pub fn of(ray: &Ray, triangle: &Triangle, threshold: Threshold, level: Level) -> Self {
        let block = TriangleBlock::new(core::slice::from_ref(triangle));
        let room = &Room::NONE;
        level.run(BlockEvidence { threshold, ray, triangle, block: &block, room })
    }

    /// Like [`Evidence::of`], but for copies of f64 originals. `reach` is an upper bound on the
    /// 1-norm of every corner. In the result, the precheck's values are meaningless.
    pub fn of_copies(ray: &Ray, copy: &Copy32, reach: f32, level: Level) -> Self {
        let block = TriangleBlock::of_copies(core::slice::from_ref(copy));
        let (threshold, room) = (Threshold::ZERO, &Room::of_copies(reach));
        let triangle = &TriangleOf([[0.0; 3]; 3]);
        level.run(BlockEvidence { threshold, ray, triangle, block: &block, room })
    }
}

struct BlockEvidence<'a> {
    threshold: Threshold,
    ray: &'a Ray,
    /// The triangle for the precheck.
    triangle: &'a Triangle,
    block: &'a TriangleBlock<8>,
    room: &'a Room,
}

impl WithSimd for BlockEvidence<'_> {
    type Output = Evidence;
    #[inline(always)]
    fn run<S: Simd>(self) -> Evidence {
        let Self { block, room, .. } = self;
        let triangles = Triangles::<S::F32x8>::of_block(block, room);
        let rays = Rays::splat(&Rays::of_ray(self.ray, self.threshold, room));
        let edges = Edges::new(&triangles, &rays);
        let plane = PlaneHit::new(&triangles, &rays, &edges, room);
        // The block holds one triangle, so its values are in lane 0.
        let lane = |x: S::F32x8| {
            let mut lanes = [0.0; 8];
            x.store(&mut lanes);
            lanes[0]
        };
        let (t_lo, t_hi) = plane.enclosure();
        let far = Lanes::splat(self.ray.t_max);
        let (sharp_lo, sharp_hi) = plane.sharper(&triangles, &rays, &edges, room);
        let [sharp_v, sharp_w, sharp_u] = edges.sharp_bounds(&triangles, &rays, room);
        let edge = lane(edges.bound(&triangles, &rays));
        let at = Constants::new(self.triangle);
        let ([v, w, u, den], bound) = Precheck::new(&rays).values(&at);
        Evidence {
            v: lane(edges.v),
            w: lane(edges.w),
            u: lane(edges.u),
            edge,
            u_edge: 2.0 * edge,
            sharp: [lane(sharp_v), lane(sharp_w), lane(sharp_u)],
            den: lane(edges.den),
            // The kernel stores `SLACK` times the bounds on D and T, whereas tests use the bounds
            // themselves.
            den_err: lane(plane.den_err) / bound::SLACK,
            // `plane.num` is multiplied by the sign of D; flipping it again restores T.
            num: lane(plane.num.flip(edges.den)),
            num_err: lane(plane.num_err) / bound::SLACK,
            sharp_num: lane(PlaneHit::sharp_num_err(&triangles, &rays, &edges, room)),
            sharp_t: [lane(sharp_lo), lane(sharp_hi)],
            t_lo: lane(t_lo),
            t_hi: lane(t_hi),
            precheck: [lane(v), lane(w), lane(u), lane(den)],
            precheck_bound: lane(bound),
            h: block.longest_edges()[0],
            out_of_range: plane.out_of_range(&rays, far).bits() & 1 != 0,
            sure: edges.sure().bits() & 1 != 0,
        }
    }
}
