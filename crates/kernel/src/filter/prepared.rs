//! Precomputed values of a triangle for many rays, or of rays for many triangles.

use super::precheck::{Constants, Precheck};
use super::{Counts, Filter, Rays, Triangles, Verdicts};
use crate::packet::RayPacket;
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
        PreparedRay { ray: *ray, id, lanes: Rays::of_ray(ray, self.threshold(), self.room()) }
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
