//! Tests parallel rays whose lines are close together: finds the triangles in a block that may be
//! hit by one of the rays, and then which of sixteen rays hit a given triangle.
//!
//! ```text
//!   axis ──► block of eight        V, W, U of a ray along the axis, and their gradients across it
//!   rays ──► remaining triangles   V, W, U of sixteen rays: three multiply-adds
//!     └────► remaining pairs       the general test for arbitrary rays
//! ```
//!
//! `docs/numerics/exact.md`, section 10, has the bound and the proof.

use crate::Ray;
use crate::packet::TriangleBlock;
use crate::simd::{Lanes, Mask, Simd, Vec3};

use super::edges::{Edges, Rays, Triangles};
use super::verdicts::Verdicts;
use super::{Counts, Filter, PreparedPacket, bound};

/// The common axis of parallel rays.
#[derive(Clone, Copy)]
pub struct Axis {
    rays: Rays<f32>,
    dir: [f32; 3],
    reach: [f32; 3],
}

/// The edge functions of eight triangles along the axis of parallel rays.
///
/// ```
/// use intertri::internal::{AlongAxis, LaneHits};
/// use intertri::simd::{Simd, Vec3, WithSimd, dispatch};
/// use intertri::{Counts, Mode, Ray, RayPacket, Triangle, TriangleBlock};
///
/// /// Rays that run upward from a row of points around an axis at x = 0.
/// struct Up<'a>(&'a [Ray], &'a TriangleBlock<8>);
/// impl WithSimd for Up<'_> {
///     type Output = (u32, u32, LaneHits);
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let (test, packet, mut along) = (Mode::exact().filter(), RayPacket::new(self.0), AlongAxis::default());
///         let axis = test.axis(&Ray::new([0.0; 3], [0.0, 0.0, 1.0]), [0.5, 0.0, 0.0], 1.0);
///         let reached = test.along_in::<S>(&axis, self.1, &mut along);
///         let maybe = along.maybe_in::<S>(1, &Vec3::load(&packet.origin));
///         let rays = test.prepare_packet_in::<S, 16>(&packet);
///         (reached, maybe, test.lane_hits_in::<S>(&rays, self.1, 1, maybe, &mut Counts::default()))
///     }
/// }
///
/// // One triangle is out of reach; the other is within reach of half of the rays.
/// let at = |x| Triangle::new([x, -1.0, 5.0], [x + 9.0, -1.0, 5.0], [x, 9.0, 5.0]);
/// let rays: Vec<Ray> =
///     (0..16).map(|i| Ray::new([(i as f32 - 7.5) / 16.0, 0.0, 0.0], [0.0, 0.0, 1.0])).collect();
/// let (reached, maybe, hits) = dispatch(Up(&rays, &TriangleBlock::new(&[at(2.0), at(0.0)])));
/// assert_eq!((reached, maybe, hits.sure, hits.leaves), (0b10, 0xff00, 0xff00, true));
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct AlongAxis {
    /// V on the axis, positive inside the triangle.
    v: [f32; 8],
    /// W on the axis, positive inside the triangle.
    w: [f32; 8],
    /// The magnitude of D.
    den: [f32; 8],
    /// The gradient of V perpendicular to the axis.
    of_v: [[f32; 8]; 3],
    /// The gradient of W perpendicular to the axis.
    of_w: [[f32; 8]; 3],
    /// If V, W, or half of U is less than this value, the ray certainly misses.
    least: [f32; 8],
}

/// The hits of sixteen rays on one triangle. A lane that is in neither `sure` nor `undecided` is a
/// miss.
#[derive(Clone, Copy, Debug)]
pub struct LaneHits {
    /// Certain hits: within the interval and inside all edges.
    pub sure: u32,
    /// Undecided lanes, for the resolver.
    pub undecided: u32,
    /// Whether the rays cross the plane in the direction of the normal at the certain hits.
    pub leaves: bool,
}

impl AlongAxis {
    /// Finds which of sixteen rays may hit the triangle in a lane, given the offsets of their lines
    /// from the axis.
    #[inline(always)]
    pub fn maybe_in<S: Simd>(&self, lane: usize, beside: &Vec3<S::F32x16>) -> u32 {
        let splat = |row: &[f32; 8]| S::F32x16::splat(row[lane % 8]);
        let at = |of: &[[f32; 8]; 3], axis| {
            let [x, y, z] = of;
            Vec3 { x: splat(x), y: splat(y), z: splat(z) }.dot_add(*beside, axis)
        };
        // The rays are parallel, so all have the same D, and V and W are linear in the offset.
        let (v, w) = (at(&self.of_v, splat(&self.v)), at(&self.of_w, splat(&self.w)));
        let u = (splat(&self.den) - v) - w;
        let edge = v.min(w).min(u * S::F32x16::splat(0.5));
        (!edge.lt(splat(&self.least))).bits()
    }
}

impl Filter<'_> {
    /// Prepares the axis of parallel rays. Along each coordinate, the rays' lines must be within
    /// `reach` of the axis. `away` is an upper bound on the 1-norm of every origin.
    #[inline(always)]
    pub fn axis(&self, axis: &Ray, reach: [f32; 3], away: f32) -> Axis {
        let [x, y, z] = reach;
        let away = away * if self.room.copies { bound::COPY_AWAY } else { bound::AWAY };
        // A distance that covers how much V, W, and U of a ray may differ from the values predicted
        // from the axis and the computed gradients, including the rounding from subtracting large
        // coordinates (exact.md, section 10).
        let off = Lanes::mul_add(x + y + z, bound::BESIDE, away);
        let rays = Rays::of_ray(axis, self.threshold, self.room).passed_within(off);
        Axis { rays, dir: axis.dir, reach }
    }

    /// Finds the triangles in a block that rays around an axis may hit, and returns them as bits.
    /// If there are any, stores their edge functions in `along`.
    #[inline(always)]
    pub fn along_in<S: Simd>(
        &self,
        axis: &Axis,
        block: &TriangleBlock<8>,
        along: &mut AlongAxis,
    ) -> u32 {
        let triangles = Triangles::<S::F32x8>::of_block(block, self.room);
        let rays = Rays::splat(&axis.rays);
        let edges = Edges::new(&triangles, &rays);
        let bound = edges.bound(&triangles, &rays);
        // If the sign of D is unknown, no edge can reject a triangle.
        let least = Lanes::select(edges.sure(), -bound, S::F32x8::splat(f32::NEG_INFINITY));
        let [v, w, u] = edges.weights();

        // The largest values that V, W, and U reach in the tube around the axis.
        let (dir, reach) = (Vec3::<S::F32x8>::splat(axis.dir), Vec3::splat(axis.reach));
        let (of_v, of_w) = (triangles.h5.cross_fused(dir), triangles.minus_h4.cross_fused(dir));
        // A linear form over the box `±reach` has its maximum at a corner: its value on the axis
        // plus |gradient| · reach.
        let most = |at: S::F32x8, of: Vec3<S::F32x8>| of.abs().dot_add(reach, at);
        let least_of_v_and_w = most(v, of_v).min(most(w, of_w));
        let edge = least_of_v_and_w.min(most(u, of_v + of_w) * S::F32x8::splat(0.5));
        // Test for "not less" instead of "greater or equal", so that a triangle with a NaN is kept.
        let reached = (!edge.lt(least)).bits() & block.live();
        if reached != 0 {
            v.store(&mut along.v);
            w.store(&mut along.w);
            edges.den.abs().store(&mut along.den);
            least.store(&mut along.least);
            flipped(of_v, edges.den).store(&mut along.of_v);
            flipped(of_w, edges.den).store(&mut along.of_w);
        }
        reached
    }

    /// Finds which of the `live` rays among sixteen hit the triangle in a lane of a block.
    #[inline(always)]
    pub fn lane_hits_in<S: Simd>(
        &self,
        rays: &PreparedPacket<'_, S, 16>,
        block: &TriangleBlock<8>,
        lane: usize,
        live: u32,
        counts: &mut Counts,
    ) -> LaneHits {
        let triangle = Triangles::<S::F32x16>::of_lane(block, lane, self.room);
        counts.tests += u64::from(live.count_ones());
        let (packet, rays) = (rays.packet, &rays.lanes);
        let (edges, far) = (Edges::new(&triangle, rays), Lanes::load(&packet.t_max));
        let Verdicts { hit, undecided, leaves, t_hi, .. } =
            edges.decide(&triangle, rays, far, live, (self.threshold, self.room));
        counts.undecided += u64::from(undecided.count_ones());

        // If the upper bound on t reaches the end of the interval, the hit may be beyond that end,
        // so it is not certain.
        let sure = hit & Mask::bits(t_hi.lt(self.sure_ends(&packet.t_max)));
        LaneHits { sure, undecided: undecided | hit & !sure, leaves: leaves & sure != 0 }
    }
}

/// Flips the sign of each component in lanes where `of` is negative.
#[inline(always)]
fn flipped<F: Lanes<Scalar = f32>>(Vec3 { x, y, z }: Vec3<F>, of: F) -> Vec3<F> {
    Vec3 { x: x.flip(of), y: y.flip(of), z: z.flip(of) }
}
