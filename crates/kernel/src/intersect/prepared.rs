//! What is computed once, of a triangle for many rays or of rays for many triangles.

use super::Test;
use crate::packet::RayPacket;
use crate::simd::{Lane, Simd, Width};
use crate::{Ray, Triangle};

/// A triangle with what a test computes from it once.
///
/// ```
/// use intertri::{Certified, Mode, Ray, RayPacket, Triangle};
/// // Once for many packets.
/// let mode = Certified::default();
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let wall = mode.prepare(&wall);
/// let rays: Vec<Ray> =
///     (0..20).map(|i| Ray::new([i as f32 * 0.1, 0.5, 0.0], [0.0, 0.0, 1.0])).collect();
/// let hits = rays.chunks(8).map(|rays| mode.packet(&RayPacket::<8>::new(rays), &wall).iter().count());
/// assert_eq!(hits.sum::<usize>(), 6);
/// ```
//
// What every test needs comes first, for `Certified` in one cache line.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct Prepared<T: Test> {
    pub(crate) constants: T::Constants,
    pub(crate) triangle: Triangle,
}

/// A ray with what a test computes from it once.
///
/// ```
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{Certified, ClosestHit, Counts, Hit, LaneQueries, Mode, Ray, Triangle};
/// use intertri::TriangleBlock;
///
/// /// All of a block's hits, and the closest of them.
/// struct Asked<'a, T>(T, &'a Ray, &'a TriangleBlock<8>);
/// impl<T: LaneQueries> WithSimd for Asked<'_, T> {
///     type Output = (u32, Option<Hit>);
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let Self(test, ray, block) = self;
///         let mut counts = Counts::default();
///         let all = test.block_in::<S, 8>(ray, block, &mut counts);
///
///         let prepared = test.prepare_ray(ray);
///         let (mut closest, indices) = (ClosestHit::new(ray.t_max), [10, 11, 12, 13, 14, 15, 16, 17]);
///         let find = |place: u32| block.triangle(place as usize);
///         test.closest_in::<S>(&prepared, block, &indices, 0, find, &mut closest, &mut counts);
///         (all.bits, test.hit(ray, &closest, find))
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let block = TriangleBlock::new(&[at(5.0), at(-1.0), at(3.0)]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
/// let (all, closest) = dispatch(Asked(Certified::default().test(), &ray, &block));
/// assert_eq!((all, closest.map(|hit| (hit.triangle, hit.t))), (0b101, Some((12, 3.0))));
/// ```
#[derive(Clone, Copy)]
pub struct PreparedRay<T: Test> {
    pub(crate) ray: Ray,
    /// By which originals are asked for.
    pub(crate) number: u32,
    pub(crate) constants: T::Ray,
}

impl<T: Test> PreparedRay<T> {
    /// The ray.
    #[inline(always)]
    pub fn ray(&self) -> &Ray {
        &self.ray
    }

    /// The ray's number.
    #[inline(always)]
    pub fn number(&self) -> u32 {
        self.number
    }
}

/// N rays with what a test computes from them once, at one level of instructions.
///
/// ```
/// use intertri::simd::{Lane, Simd, Width, WithSimd, dispatch};
/// use intertri::{Certified, ClosestHits, Counts, LaneQueries, Mode, Ray, RayPacket, Triangle};
///
/// /// What each of eight rays hits first, three times over, and where.
/// struct Asked<'a, T>(T, &'a RayPacket<8>, &'a [Triangle]);
/// impl<T: LaneQueries> WithSimd for Asked<'_, T> {
///     type Output = ([[Option<u32>; 8]; 3], [f64; 8]);
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let Self(test, packet, triangles) = self;
///         let rays = test.prepare_packet_in::<S, 8>(packet);
///         let prepared: Vec<_> = triangles.iter().map(|triangle| test.prepare(triangle)).collect();
///         let (live, mut counts) = (packet.live(), Counts::default());
///         let find = |place: u32| triangles[place as usize];
///
///         // By all hits.
///         let mut nearest = [(None, f64::INFINITY); 8];
///         for (i, triangle) in prepared.iter().enumerate() {
///             for (lane, t) in test.packet_in(&rays, triangle, &mut counts).iter() {
///                 if t < nearest[lane].1 {
///                     nearest[lane] = (Some(i as u32), t);
///                 }
///             }
///         }
///         // One by one, and all in a row.
///         let mut one = ClosestHits::<<Lane<8> as Width>::F<S>, 8>::new(&packet.t_max);
///         let mut row = one;
///         for (i, triangle) in (0..).zip(&prepared) {
///             test.packet_closest_in(&rays, triangle, (i, i), find, live, &mut one, &mut counts);
///         }
///         test.packet_closest_of_in(&rays, &prepared, 0, find, live, &mut row, &mut counts);
///         let index = |closest: &ClosestHits<_, 8>| {
///             std::array::from_fn(|lane| closest.lane(lane).triangle().map(|(index, _)| index))
///         };
///         let t = test.hits_in(&rays, &row, find).t;
///         ([nearest.map(|(index, _)| index), index(&one), index(&row)], t)
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let rays = [0.25, 0.5, 2.0].map(|x| Ray::new([x, 0.25, 0.0], [0.0, 0.0, 1.0]));
/// let (packet, walls) = (RayPacket::new(&rays), [at(5.0), at(3.0), at(9.0)]);
/// let ([all, one, row], t) = dispatch(Asked(Certified::default().test(), &packet, &walls));
/// assert_eq!((&all[..4], t[1]), (&[Some(1), Some(1), None, None][..], 3.0));
/// assert!(all == one && one == row);
/// ```
#[derive(Clone, Copy)]
pub struct PreparedPacket<'a, T: Test, S: Simd, const N: usize>
where
    Lane<N>: Width,
{
    packet: &'a RayPacket<N>,
    lanes: T::Rays<<Lane<N> as Width>::F<S>, <Lane<N> as Width>::D<S>>,
}

impl<'a, T: Test, S: Simd, const N: usize> PreparedPacket<'a, T, S, N>
where
    Lane<N>: Width,
{
    /// A packet with what the test computed from it.
    #[inline(always)]
    pub(crate) fn new(
        packet: &'a RayPacket<N>,
        lanes: T::Rays<<Lane<N> as Width>::F<S>, <Lane<N> as Width>::D<S>>,
    ) -> Self {
        Self { packet, lanes }
    }

    /// The rays.
    #[inline(always)]
    pub(crate) fn packet(&self) -> &'a RayPacket<N> {
        self.packet
    }

    /// What the test computed from them.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> &T::Rays<<Lane<N> as Width>::F<S>, <Lane<N> as Width>::D<S>> {
        &self.lanes
    }
}
