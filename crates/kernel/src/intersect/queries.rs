//! What the author of a hierarchy asks of a test, within loops that were entered by
//! [`WithSimd`](crate::simd::WithSimd).

use super::candidates::{Candidates, closest_of};
use super::pairs::{LanePairs, RayOnBlock, RaysOnTriangle};
use super::{ClosestHit, ClosestHits, Counts, Found, Prepared, PreparedPacket, PreparedRay, Test};
use crate::packet::{PacketHits, RayPacket, TriangleBlock};
use crate::simd::{Lane, Lanes, Mask, Simd, Width, lanes_of};
use crate::{Hit, Ray, Triangle};

/// Packets of rays and blocks of triangles, for walks of one's own. Every mode has a
/// [`test`](crate::Mode::test) that answers them.
///
/// An *index* is a triangle's own number, which breaks ties; a *place* is where the caller finds it again,
/// by `find`.
///
/// ```
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{ClosestHit, Counts, Double, Hit, LaneQueries, Mode, Ray, Triangle, TriangleBlock};
///
/// /// The closest hit of a ray, eight triangles at a time.
/// struct Loop<'a, T>(T, &'a Ray, &'a [Triangle]);
/// impl<T: LaneQueries> WithSimd for Loop<'_, T> {
///     type Output = Option<Hit>;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Option<Hit> {
///         let Self(test, ray, triangles) = self;
///         let (prepared, mut closest) = (test.prepare_ray(ray), ClosestHit::new(ray.t_max));
///         let find = |place: u32| triangles[place as usize];
///         let mut counts = Counts::default();
///         for (i, eight) in triangles.chunks(8).enumerate() {
///             let (block, first) = (TriangleBlock::new(eight), 8 * i as u32);
///             let indices = std::array::from_fn(|lane| first + lane as u32);
///             test.closest_in::<S>(&prepared, &block, &indices, first, find, &mut closest, &mut counts);
///         }
///         test.hit(ray, &closest, find)
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let walls: Vec<Triangle> = (1..20).map(|i| at(20.0 - i as f32)).collect();
/// let (mode, ray) = (Double::default(), Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]));
/// assert_eq!(dispatch(Loop(mode.test(), &ray, &walls)), mode.closest(&walls, &ray));
/// ```
pub trait LaneQueries: Test {
    /// A triangle with what the test computes from it once.
    #[inline]
    fn prepare(&self, triangle: &Triangle) -> Prepared<Self> {
        Prepared { triangle: *triangle, constants: self.constants(triangle) }
    }

    /// A ray prepared for one block after another.
    #[inline(always)]
    fn prepare_ray(&self, ray: &Ray) -> PreparedRay<Self> {
        self.prepare_numbered(ray, 0)
    }

    /// A ray of that number, by which a resolver of originals knows it.
    #[doc(hidden)]
    #[inline(always)]
    fn prepare_numbered(&self, ray: &Ray, number: u32) -> PreparedRay<Self> {
        PreparedRay { ray: *ray, number, constants: self.ray(ray) }
    }

    /// The closest hit of a ray before anything is hit.
    #[doc(hidden)]
    #[inline(always)]
    fn no_hit(&self, ray: &Ray) -> ClosestHit {
        ClosestHit::before(self.sure_end(ray.t_max), ray.t_max)
    }

    /// N rays prepared for one triangle after another.
    #[inline(always)]
    fn prepare_packet_in<'a, S: Simd, const N: usize>(
        &self,
        packet: &'a RayPacket<N>,
    ) -> PreparedPacket<'a, Self, S, N>
    where
        Lane<N>: Width,
    {
        PreparedPacket::new(packet, self.rays(packet))
    }

    /// All hits of N rays with one triangle.
    ///
    /// An example stands at [`PreparedPacket`].
    #[inline(always)]
    fn packet_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, Self, S, N>,
        triangle: &Prepared<Self>,
        counts: &mut Counts,
    ) -> PacketHits<N>
    where
        Lane<N>: Width,
    {
        let (packet, constants) = (rays.packet(), &triangle.constants);
        let triangles = self.one_triangle::<F<S, N>, D<S, N>>(&triangle.triangle, constants);
        let far = Lanes::load(&packet.t_max);
        let found = self.test(&triangles, rays.lanes(), far, packet.live(), counts);
        let (resolver, triangle) = (self.resolver(), &triangle.triangle);
        let (first, place, find) = (0, 0, |_| *triangle);
        let pairs = RaysOnTriangle { resolver, packet, first, triangle, place, find };
        all_hits(found, |lane| self.sure_end(packet.t_max[lane]), &pairs)
    }

    /// The lanes of N rays that hit one triangle, a bit each: those of [`LaneQueries::packet_in`] without their t,
    /// which takes long where pairs are close. Only the lanes in `live` take part.
    ///
    /// ```
    /// use intertri::simd::{Simd, WithSimd, dispatch};
    /// use intertri::{Counts, Exact, LaneQueries, Mode, Ray, RayPacket, Triangle};
    ///
    /// /// The rays that a wall stops.
    /// struct Shadow<'a>(&'a RayPacket<8>, &'a Triangle);
    /// impl WithSimd for Shadow<'_> {
    ///     type Output = u32;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> u32 {
    ///         let (test, mut counts) = (Exact::default().test(), Counts::default());
    ///         let rays = test.prepare_packet_in::<S, 8>(self.0);
    ///         test.packet_any_in(&rays, &test.prepare(self.1), self.0.live(), &mut counts)
    ///     }
    /// }
    ///
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// // Inside, on the longest edge, a step of f32 beside it, and a ray that ends before the wall.
    /// let ray = |y: f32| Ray::new([0.5, y, 0.0], [0.0, 0.0, 1.0]);
    /// let rays = [ray(0.25), ray(0.5), ray(0.5_f32.next_up()), ray(0.25).between(0.0, 5.0)];
    /// assert_eq!(dispatch(Shadow(&RayPacket::new(&rays), &wall)), 0b0011);
    /// ```
    #[inline(always)]
    fn packet_any_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, Self, S, N>,
        triangle: &Prepared<Self>,
        live: u32,
        counts: &mut Counts,
    ) -> u32
    where
        Lane<N>: Width,
    {
        let (packet, constants) = (rays.packet(), &triangle.constants);
        let triangles = self.one_triangle::<F<S, N>, D<S, N>>(&triangle.triangle, constants);
        let far = Lanes::load(&packet.t_max);
        let Some(found) = self.test(&triangles, rays.lanes(), far, live, counts) else { return 0 };
        let (resolver, triangle) = (self.resolver(), &triangle.triangle);
        let (first, place, find) = (0, 0, |_| *triangle);
        let pairs = RaysOnTriangle { resolver, packet, first, triangle, place, find };
        let sure_end = packet.t_max.map(|t_max| self.sure_end(t_max));
        let sure = found.exact | found.near & found.t_hi.lt(Lanes::load(&sure_end)).bits();
        let meets = |hits, lane| hits | u32::from(pairs.meets(lane)) << lane;
        lanes_of(found.lanes() & !sure).fold(sure, meets)
    }

    /// All hits of one ray with N triangles.
    ///
    /// An example stands at [`PreparedRay`].
    #[inline(always)]
    fn block_in<S: Simd, const N: usize>(
        &self,
        ray: &Ray,
        block: &TriangleBlock<N>,
        counts: &mut Counts,
    ) -> PacketHits<N>
    where
        Lane<N>: Width,
    {
        self.block_at_in::<S, N>(&self.prepare_ray(ray), block, 0, counts)
    }

    /// All hits of a prepared ray with N triangles, in places from `place` on.
    #[doc(hidden)]
    #[inline(always)]
    fn block_at_in<S: Simd, const N: usize>(
        &self,
        &PreparedRay { ref ray, number, ref constants }: &PreparedRay<Self>,
        block: &TriangleBlock<N>,
        place: u32,
        counts: &mut Counts,
    ) -> PacketHits<N>
    where
        Lane<N>: Width,
    {
        let lanes = self.one_ray::<F<S, N>, D<S, N>>(constants);
        let triangles = self.triangles::<F<S, N>, D<S, N>, N>(block);
        let far = Lanes::splat(ray.t_max);
        let found = self.test(&triangles, &lanes, far, block.live(), counts);
        let (resolver, find) = (self.resolver(), |lane| block.triangle(lane as usize));
        let pairs = RayOnBlock { resolver, ray, number, block, place, find };
        all_hits(found, |_| self.sure_end(ray.t_max), &pairs)
    }

    /// Offers the hits of one ray with a block to the ray's closest. Lane i of the block has the index
    /// `indices[i]` and the place `place + i`.
    ///
    /// An example stands at [`PreparedRay`].
    #[inline(always)]
    fn closest_in<S: Simd>(
        &self,
        ray: &PreparedRay<Self>,
        block: &TriangleBlock<8>,
        indices: &[u32; 8],
        place: u32,
        find: impl Fn(u32) -> Triangle,
        closest: &mut ClosestHit,
        counts: &mut Counts,
    ) {
        let triangles = self.triangles::<S::F32x8, S::F64x8, 8>(block);
        let lanes = self.one_ray::<S::F32x8, S::F64x8>(&ray.constants);
        let far = Lanes::splat(closest.t_hi());
        if let Some(found) = self.test(&triangles, &lanes, far, block.live(), counts) {
            let (resolver, number) = (self.resolver(), ray.number);
            let pairs = RayOnBlock { resolver, ray: &ray.ray, number, block, place, find };
            closest.offer_block(&found, indices, place, &pairs);
        }
    }

    /// [`LaneQueries::closest_in`] among the triangles that count: of the lanes that may be hits those that
    /// `keep` gives back. It is asked only where there are such lanes.
    ///
    /// ```
    /// use intertri::simd::{Simd, WithSimd, dispatch};
    /// use intertri::{ClosestHit, Counts, Exact, LaneQueries, Mode, Ray, Triangle, TriangleBlock};
    ///
    /// /// The closest of two walls but for those in the lanes of a mask.
    /// struct Without<'a>(u32, &'a Ray, &'a [Triangle; 2]);
    /// impl WithSimd for Without<'_> {
    ///     type Output = Option<(u32, u32)>;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> Self::Output {
    ///         let Self(skip, ray, walls) = self;
    ///         let (test, block) = (Exact::default().test(), TriangleBlock::new(walls));
    ///         let (mut closest, counts) = (ClosestHit::new(ray.t_max), &mut Counts::default());
    ///         let (find, keep) = (|place: u32| walls[place as usize], |lanes| lanes & !skip);
    ///         let (ray, indices) = (test.prepare_ray(ray), [0, 1, 2, 3, 4, 5, 6, 7]);
    ///         test.closest_among_in::<S>(&ray, &block, &indices, 0, find, keep, &mut closest, counts);
    ///         closest.triangle()
    ///     }
    /// }
    ///
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let (walls, ray) = ([at(3.0), at(5.0)], Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]));
    /// let without = [0b00, 0b01, 0b11].map(|skip| dispatch(Without(skip, &ray, &walls)));
    /// assert_eq!(without, [Some((0, 0)), Some((1, 1)), None]);
    /// ```
    #[inline(always)]
    fn closest_among_in<S: Simd>(
        &self,
        ray: &PreparedRay<Self>,
        block: &TriangleBlock<8>,
        indices: &[u32; 8],
        place: u32,
        find: impl Fn(u32) -> Triangle,
        keep: impl FnOnce(u32) -> u32,
        closest: &mut ClosestHit,
        counts: &mut Counts,
    ) {
        let triangles = self.triangles::<S::F32x8, S::F64x8, 8>(block);
        let lanes = self.one_ray::<S::F32x8, S::F64x8>(&ray.constants);
        let far = Lanes::splat(closest.t_hi());
        if let Some(mut found) = self.test(&triangles, &lanes, far, block.live(), counts) {
            if found.lanes() == 0 {
                return;
            }
            found.keep(keep(found.lanes()));
            let (resolver, number) = (self.resolver(), ray.number);
            let pairs = RayOnBlock { resolver, ray: &ray.ray, number, block, place, find };
            closest.offer_block(&found, indices, place, &pairs);
        }
    }

    /// Offers the hits of N rays with one triangle to their closest; only the lanes in `live` take part.
    ///
    /// An example stands at [`PreparedPacket`].
    #[inline(always)]
    fn packet_closest_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, Self, S, N>,
        triangle: &Prepared<Self>,
        index_and_place: (u32, u32),
        find: impl Fn(u32) -> Triangle,
        live: u32,
        closest: &mut ClosestHits<F<S, N>, N>,
        counts: &mut Counts,
    ) where
        Lane<N>: Width,
    {
        let triangles = self.one_triangle(&triangle.triangle, &triangle.constants);
        let far = closest.t_hi();
        if let Some(found) = self.test(&triangles, rays.lanes(), far, live, counts) {
            let (packet, triangle) = (rays.packet(), &triangle.triangle);
            let (resolver, place) = (self.resolver(), index_and_place.1);
            let pairs = RaysOnTriangle { resolver, packet, first: 0, triangle, place, find };
            closest.offer(&found, index_and_place, &pairs);
        }
    }

    /// [`LaneQueries::packet_closest_in`] for one triangle after another; index and place of the i-th are
    /// `first + i`. All are prechecked before any is tested, which is faster than one by one.
    ///
    /// An example stands at [`PreparedPacket`].
    #[inline(always)]
    fn packet_closest_of_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, Self, S, N>,
        triangles: &[Prepared<Self>],
        first: u32,
        find: impl Fn(u32) -> Triangle,
        live: u32,
        closest: &mut ClosestHits<F<S, N>, N>,
        counts: &mut Counts,
    ) where
        Lane<N>: Width,
    {
        let precheck = self.precheck(rays.lanes());
        let list = PreparedList { test: self, rays, precheck, triangles, first, find, live };
        closest_of(&list, live, closest, counts);
    }

    /// t of the hits that the closest of N rays stand for, side by side; a lane's bit is set where it has
    /// a hit.
    ///
    /// An example stands at [`PreparedPacket`].
    #[inline(always)]
    fn hits_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, Self, S, N>,
        closest: &ClosestHits<F<S, N>, N>,
        find: impl Fn(u32) -> Triangle,
    ) -> PacketHits<N>
    where
        Lane<N>: Width,
    {
        closest.hits::<D<S, N>>(self.resolver(), rays.packet(), find)
    }

    /// The hit that a ray's closest stands for, with its t and weights.
    #[inline(always)]
    fn hit(&self, ray: &Ray, closest: &ClosestHit, find: impl Fn(u32) -> Triangle) -> Option<Hit> {
        let (index, place) = closest.triangle()?;
        Some(self.resolver().hit_attributes(ray, &find(place), index, (0, place)))
    }
}

impl<T: Test> LaneQueries for T {}

type F<S, const N: usize> = <Lane<N> as Width>::F<S>;
type D<S, const N: usize> = <Lane<N> as Width>::D<S>;

/// Prepared triangles as the candidates of one packet.
struct PreparedList<'a, 'p, T: Test, S: Simd, P, const N: usize>
where
    Lane<N>: Width,
{
    test: &'a T,
    rays: &'a PreparedPacket<'p, T, S, N>,
    precheck: T::Precheck<F<S, N>>,
    triangles: &'a [Prepared<T>],
    first: u32,
    find: P,
    live: u32,
}

impl<T: Test, S: Simd, P: Fn(u32) -> Triangle, const N: usize> Candidates<F<S, N>, N>
    for PreparedList<'_, '_, T, S, P, N>
where
    Lane<N>: Width,
{
    #[inline(always)]
    fn groups(&self) -> usize {
        self.triangles.len().div_ceil(64)
    }

    #[inline(always)]
    fn precheck(&self, group: usize) -> (u64, usize) {
        let triangles = &self.triangles[64 * group..];
        let triangles = &triangles[..triangles.len().min(64)];
        let live = Mask::from_bits(self.live);
        let mut list = 0_u64;
        for (i, triangle) in triangles.iter().enumerate() {
            list |= u64::from(self.test.maybe(&triangle.constants, &self.precheck, live)) << i;
        }
        (list, triangles.len())
    }

    #[inline(always)]
    fn offer(&self, i: usize, closest: &mut ClosestHits<F<S, N>, N>, counts: &mut Counts) {
        let Self { test, rays, triangles, first, ref find, live, .. } = *self;
        let at = (first + i as u32, first + i as u32);
        test.packet_closest_in(rays, &triangles[i], at, find, live, closest, counts);
    }
}

/// The lanes that a test found, each with its t, within the far end of its interval.
#[inline(always)]
fn all_hits<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
    found: Option<Found<F, D>>,
    t_max: impl Fn(usize) -> f32,
    pairs: &impl LanePairs,
) -> PacketHits<N> {
    let mut hits = PacketHits { bits: 0, t: [f64::INFINITY; N] };
    let Some(found) = found else { return hits };
    let mut t_hi = [0.0; N];
    found.t_hi.store(&mut t_hi);
    for lane in lanes_of(found.lanes()) {
        let t = if found.near >> lane & 1 == 0 {
            found.known_t(lane, pairs)
        } else if t_hi[lane] < t_max(lane) {
            Some(pairs.t(lane))
        } else {
            pairs.hit(lane)
        };
        if let Some(t) = t {
            hits.bits |= 1 << lane;
            hits.t[lane] = t;
        }
    }
    hits
}
