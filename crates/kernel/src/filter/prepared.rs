//! Precomputed values of a triangle for many rays, or of rays for many triangles.

use core::slice::from_ref;

use super::precheck::{Constants, Precheck};
use super::walls::parallel_lanes;
use super::{Counts, Filter, Rays, Triangles, Verdicts};
use crate::packet::{RayPacket, TriangleBlock};
use crate::simd::{Lane, Mask, Simd, Width};
use crate::{Ray, RayId, Triangle};

/// A triangle with the constants that every packet of rays needs.
///
/// ```
/// use intertri::{Mode, PreparedTriangle, Ray, RayPacket, Triangle};
/// // Prepare the triangle once for many packets.
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let wall = PreparedTriangle::new(&wall);
/// let rays: Vec<Ray> =
///     (0..20).map(|i| Ray::new([i as f32 * 0.1, 0.5, 0.0], [0.0, 0.0, 1.0])).collect();
/// let mode = Mode::certified();
/// let hits = rays.chunks(8).map(|rays| mode.packet(&RayPacket::<8>::new(rays), &wall).iter().count());
/// assert_eq!(hits.sum::<usize>(), 6);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PreparedTriangle {
    /// This field is first so that the precheck reads only one cache line.
    constants: Constants,
    triangle: Triangle,
}

impl PreparedTriangle {
    /// Prepares a triangle.
    pub fn new(triangle: &Triangle) -> Self {
        Self { constants: Constants::new(triangle), triangle: *triangle }
    }

    /// Returns the original triangle.
    pub fn triangle(&self) -> &Triangle {
        &self.triangle
    }
}

/// A ray with the constants that every block of triangles needs. Create one with
/// [`Filter::prepare_ray`].
///
/// ```
/// use intertri::{Mode, PreparedRay, Ray, RayId};
/// let ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
/// let prepared: PreparedRay = Mode::exact().filter().prepare_ray(&ray);
/// assert_eq!((prepared.ray(), prepared.id()), (&ray, RayId(0)));
/// ```
#[derive(Clone, Copy)]
pub struct PreparedRay {
    pub(crate) ray: Ray,
    /// The ray's id, by which a resolver finds the original.
    pub(crate) id: RayId,
    pub(crate) lanes: Rays<f32>,
    /// The axes along which the direction is 0, a bit each, if the resolver is exact. See
    /// [`PreparedRay::live_lanes`].
    level_axes: u8,
    /// Whether blocks contain copies.
    copies: bool,
}

impl PreparedRay {
    /// Returns the original ray.
    #[inline(always)]
    pub fn ray(&self) -> &Ray {
        &self.ray
    }

    /// Returns the ray's id.
    #[inline(always)]
    pub fn id(&self) -> RayId {
        self.id
    }

    /// Returns the live lanes of a block, without those whose triangles are perpendicular to an
    /// axis along which the ray's direction is 0. For these, D is exactly 0, so the ray does not
    /// hit them. A ray in the plane of a floor or a wall would otherwise be undecided for all of
    /// its triangles. The lanes that are left out count as tested.
    #[inline(always)]
    pub(crate) fn live_lanes<const N: usize>(
        &self,
        block: &TriangleBlock<N>,
        counts: &mut Counts,
    ) -> u32 {
        let live = block.live();
        // Most rays are not parallel to an axis plane.
        if self.level_axes == 0 {
            return live;
        }
        let parallel = live & parallel_lanes(self.level_axes, self.copies, block);
        counts.tests += u64::from(parallel.count_ones());
        live & !parallel
    }
}

/// N rays with the constants that every triangle needs, for one instruction level. Create one with
/// [`Filter::prepare_packet_in`].
///
/// ```
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{Counts, Mode, PreparedPacket, PreparedTriangle, Ray, RayPacket, Triangle};
///
/// /// Finds which of eight rays hit a triangle.
/// struct Hits<'a>(&'a RayPacket<8>, &'a PreparedTriangle);
/// impl WithSimd for Hits<'_> {
///     type Output = u32;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> u32 {
///         let filter = Mode::exact().filter();
///         let rays: PreparedPacket<'_, S, 8> = filter.prepare_packet_in(self.0);
///         filter.packet_in(&rays, self.1, &mut Counts::default()).bits
///     }
/// }
///
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let rays = [0.25, 2.0].map(|x| Ray::new([x, 0.25, 0.0], [0.0, 0.0, 1.0]));
/// assert_eq!(dispatch(Hits(&RayPacket::new(&rays), &PreparedTriangle::new(&wall))), 0b01);
/// ```
#[derive(Clone, Copy)]
pub struct PreparedPacket<'a, S: Simd, const N: usize>
where
    Lane<N>: Width,
{
    pub(crate) packet: &'a RayPacket<N>,
    pub(crate) lanes: Rays<<Lane<N> as Width>::F<S>>,
    precheck: Precheck<<Lane<N> as Width>::F<S>>,
}

impl Filter<'_> {
    /// Prepares a ray to be tested against many blocks.
    #[inline(always)]
    pub fn prepare_ray(&self, ray: &Ray) -> PreparedRay {
        self.prepare_numbered(ray, RayId(0))
    }

    /// Prepares a ray with an id, by which a resolver finds the ray's f64 original.
    #[doc(hidden)]
    #[inline(always)]
    pub fn prepare_numbered(&self, ray: &Ray, id: RayId) -> PreparedRay {
        let level_axes = self.level_axes(from_ref(ray), id);
        let lanes = Rays::of_ray(ray, self.threshold(), self.room());
        PreparedRay { ray: *ray, id, lanes, level_axes, copies: self.room().copies }
    }

    /// Prepares N rays to be tested against many triangles.
    #[inline(always)]
    pub fn prepare_packet_in<'a, S: Simd, const N: usize>(
        &self,
        packet: &'a RayPacket<N>,
    ) -> PreparedPacket<'a, S, N>
    where
        Lane<N>: Width,
    {
        let lanes = Rays::of_packet(packet, self.threshold(), self.room());
        PreparedPacket { packet, lanes, precheck: Precheck::new(&lanes) }
    }

    /// Returns the filter's verdicts on N rays and one triangle.
    #[inline(always)]
    pub(crate) fn test_packet<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, S, N>,
        triangle: &PreparedTriangle,
        far: <Lane<N> as Width>::F<S>,
        live: u32,
        counts: &mut Counts,
    ) -> Verdicts<<Lane<N> as Width>::F<S>>
    where
        Lane<N>: Width,
    {
        // The precheck nearly always rejects all rays in a packet.
        if !rays.may_hit(triangle, live) {
            counts.tests += u64::from(live.count_ones());
            return Verdicts::miss();
        }
        self.test_candidate(rays, triangle, far, live, counts)
    }

    /// Like [`Filter::test_packet`], but for a triangle that passed the precheck.
    #[inline(always)]
    pub(crate) fn test_candidate<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, S, N>,
        PreparedTriangle { constants, triangle }: &PreparedTriangle,
        far: <Lane<N> as Width>::F<S>,
        live: u32,
        counts: &mut Counts,
    ) -> Verdicts<<Lane<N> as Width>::F<S>>
    where
        Lane<N>: Width,
    {
        // The precheck's constants are relative to the world's origin. The test itself translates
        // the triangle first, so it needs only h.
        self.test(&Triangles::splat(triangle, constants.h), &rays.lanes, far, live, counts)
    }
}

impl<S: Simd, const N: usize> PreparedPacket<'_, S, N>
where
    Lane<N>: Width,
{
    /// Returns whether any live ray may hit the triangle, according to the precheck.
    #[inline(always)]
    pub(crate) fn may_hit(&self, triangle: &PreparedTriangle, live: u32) -> bool {
        // Ignore the lanes without a live ray.
        (!self.precheck.sure_miss(&triangle.constants)).bits() & live != 0
    }
}

#[cfg(test)]
mod tests {
    use crate::exact::{Rule, Tier, crossing_from};
    use crate::simd::Level;
    use crate::{Counts, Filter, Ray, Triangle, TriangleBlock};

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
            let block = TriangleBlock::<8>::new(&triangles);
            let lanes =
                block.live() & !filter.prepare_ray(&ray).live_lanes(&block, &mut Counts::default());
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
