//! What is computed once, of a triangle for many rays or of rays for many triangles.

use crate::lanes::Simd;
use crate::mode::{Lane, Test, Width};
use crate::{Ray, RayPacket, Triangle};

/// A triangle with what a mode computes from it once.
///
/// ```
/// use intertri::{Certified, Mode, Prepared, Ray, RayPacket, Triangle};
/// // Once for many packets.
/// let mode = Certified::default();
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let wall: Prepared<Certified> = mode.prepare(&wall);
/// let rays: Vec<Ray> =
///     (0..20).map(|i| Ray::new([i as f32 * 0.1, 0.5, 0.0], [0.0, 0.0, 1.0])).collect();
/// let hits = rays.chunks(8).map(|rays| mode.packet(&RayPacket::<8>::new(rays), &wall).iter().count());
/// assert_eq!(hits.sum::<usize>(), 6);
/// ```
//
// What every test needs comes first, for `Certified` in one cache line.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct Prepared<M: Test> {
    pub(crate) constants: M::Constants,
    pub(crate) triangle: Triangle,
}

/// A ray with what a mode computes from it once.
///
/// ```
/// use intertri::lanes::{Simd, WithSimd, dispatch};
/// use intertri::{Best, Certified, Counts, Mode, Ray, Triangle, TrianglePack};
///
/// /// All of a pack's hits, whether there are any, and the closest of them.
/// struct Asked<'a>(Certified, &'a Ray, &'a TrianglePack<8>);
/// impl WithSimd for Asked<'_> {
///     type Output = (u32, bool, Option<(u32, f64)>);
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let Self(mode, ray, pack) = self;
///         let mut counts = Counts::default();
///         let all = mode.pack_in::<S, 8>(ray, pack, &mut counts);
///
///         let prepared = mode.prepare_ray(ray);
///         let any = mode.any_in::<S>(&prepared, pack, &mut counts);
///         let (mut best, indices) = (Best::new(ray.t_max), [10, 11, 12, 13, 14, 15, 16, 17]);
///         let find = |place: u32| pack.triangle(place as usize);
///         mode.closest_in::<S>(&prepared, pack, &indices, 0, find, &mut best, &mut counts);
///         (all.bits, any, mode.index_and_t(ray, &best, find))
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let pack = TrianglePack::new(&[at(5.0), at(-1.0), at(3.0)]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
/// let answers = dispatch(Asked(Certified::default(), &ray, &pack));
/// assert_eq!(answers, (0b101, true, Some((12, 3.0))));
/// ```
#[derive(Clone, Copy)]
pub struct PreparedRay<M: Test> {
    pub(crate) ray: Ray,
    pub(crate) constants: M::Ray,
}

/// N rays with what a mode computes from them once, at one level of instructions.
///
/// ```
/// use intertri::lanes::{Simd, WithSimd, dispatch};
/// use intertri::{Bests, Certified, Counts, Lane, Mode, Ray, RayPacket, Triangle, Width};
///
/// /// What each of eight rays hits first, three times over, and where.
/// struct Asked<'a>(Certified, &'a RayPacket<8>, &'a [Triangle]);
/// impl WithSimd for Asked<'_> {
///     type Output = ([[Option<u32>; 8]; 3], [f64; 8]);
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let Self(mode, packet, triangles) = self;
///         let rays = mode.prepare_packet_in::<S, 8>(packet);
///         let prepared: Vec<_> = triangles.iter().map(|triangle| mode.prepare(triangle)).collect();
///         let (live, mut counts) = (packet.live(), Counts::default());
///         let find = |place: u32| triangles[place as usize];
///
///         // By all hits.
///         let mut nearest = [(None, f64::INFINITY); 8];
///         for (i, triangle) in prepared.iter().enumerate() {
///             for (lane, t) in mode.packet_in(&rays, triangle, &mut counts).iter() {
///                 if t < nearest[lane].1 {
///                     nearest[lane] = (Some(i as u32), t);
///                 }
///             }
///         }
///         // One by one, and all in a row.
///         let mut one = Bests::<<Lane<8> as Width>::F<S>, 8>::new(&packet.t_max);
///         let mut row = one;
///         for (i, triangle) in (0..).zip(&prepared) {
///             mode.packet_closest_in(&rays, triangle, (i, i), find, live, &mut one, &mut counts);
///         }
///         mode.packet_closest_of_in(&rays, &prepared, 0, find, live, &mut row, &mut counts);
///         let index = |bests: &Bests<_, 8>| {
///             std::array::from_fn(|lane| bests.lane(lane).triangle().map(|(index, _)| index))
///         };
///         let t = mode.hits_in(&rays, &row, find).t;
///         ([nearest.map(|(index, _)| index), index(&one), index(&row)], t)
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let rays = [0.25, 0.5, 2.0].map(|x| Ray::new([x, 0.25, 0.0], [0.0, 0.0, 1.0]));
/// let asked = Asked(Certified::default(), &RayPacket::new(&rays), &[at(5.0), at(3.0), at(9.0)]);
/// let ([all, one, row], t) = dispatch(asked);
/// assert_eq!((&all[..4], t[1]), (&[Some(1), Some(1), None, None][..], 3.0));
/// assert!(all == one && one == row);
/// ```
#[derive(Clone, Copy)]
pub struct PreparedPacket<'a, M: Test, S: Simd, const N: usize>
where
    Lane<N>: Width,
{
    packet: &'a RayPacket<N>,
    lanes: M::Rays<<Lane<N> as Width>::F<S>, <Lane<N> as Width>::D<S>>,
}

impl<'a, M: Test, S: Simd, const N: usize> PreparedPacket<'a, M, S, N>
where
    Lane<N>: Width,
{
    /// A packet with what the mode computed from it.
    #[inline(always)]
    pub(crate) fn new(
        packet: &'a RayPacket<N>,
        lanes: M::Rays<<Lane<N> as Width>::F<S>, <Lane<N> as Width>::D<S>>,
    ) -> Self {
        Self { packet, lanes }
    }

    /// The rays.
    #[inline(always)]
    pub(crate) fn packet(&self) -> &'a RayPacket<N> {
        self.packet
    }

    /// What the mode computed from them.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> &M::Rays<<Lane<N> as Width>::F<S>, <Lane<N> as Width>::D<S>> {
        &self.lanes
    }
}
