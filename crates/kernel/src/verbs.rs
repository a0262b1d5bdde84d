//! The verbs: what every mode does with its one test.

use crate::double::{exact_t, replay};
use crate::lanes::{Lanes, Simd, WithSimd};
use crate::mode::{Counts, Found, Lane, Scalar, Test, Threshold, Width, lanes_of};
use crate::slices::{All, Any, ClosestOfEach};
use crate::{
    Best, Bests, Coefficients, Hit, Hits, Prepared, PreparedPacket, PreparedRay, Ray, RayPacket,
    Triangle, TrianglePack,
};
use crate::{blocks, pairs};

/// A way to decide hits: [`Certified`](crate::Certified) or [`Double`](crate::Double).
///
/// Both give the same answers, those of a plain loop over the scalar f64 reference. A triangle is
/// hit where the document's `InterTri` returns 1 and `t_min <= t < t_max`; a point on an edge or a
/// corner belongs to every triangle that has it. A ray or a triangle with a NaN or an infinity is
/// never hit, nor is a triangle without area.
///
/// [`closest`](Mode::closest), [`any`](Mode::any) and [`all`](Mode::all) take slices of any length.
/// For an author of a hierarchy there are packets and packs; those whose names end in `_in` are to
/// be called within a loop that was entered by [`WithSimd`].
///
/// ```
/// use intertri::lanes::{Simd, WithSimd, dispatch};
/// use intertri::{Best, Counts, Double, Hit, Mode, Ray, Triangle, TrianglePack};
///
/// /// The closest hit of a ray, eight triangles at a time.
/// struct Loop<'a, M>(M, &'a Ray, &'a [Triangle]);
/// impl<M: Mode> WithSimd for Loop<'_, M> {
///     type Output = Hit;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Hit {
///         let Self(mode, ray, triangles) = self;
///         let (prepared, mut best) = (mode.prepare_ray(ray), Best::new(ray.t_max));
///         let find = |place: u32| triangles[place as usize];
///         let mut counts = Counts::default();
///         for (i, eight) in triangles.chunks(8).enumerate() {
///             let (pack, first) = (TrianglePack::new(eight), 8 * i as u32);
///             let indices = std::array::from_fn(|lane| first + lane as u32);
///             mode.closest_in::<S>(&prepared, &pack, &indices, first, find, &mut best, &mut counts);
///         }
///         mode.hit(ray, &best, find)
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let walls: Vec<Triangle> = (1..20).map(|i| at(20.0 - i as f32)).collect();
/// let (mode, ray) = (Double::default(), Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]));
/// assert_eq!(dispatch(Loop(mode, &ray, &walls)), mode.closest(&walls, &ray));
/// ```
pub trait Mode: Test {
    /// The closest hit; of equal t, the lowest index.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, Triangle};
    /// let near = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let far = Triangle::new([0.0, 0.0, 9.0], [1.0, 0.0, 9.0], [0.0, 1.0, 9.0]);
    /// let hit = Certified::default()
    ///     .closest(&[far, near], &Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 2.0]));
    /// assert_eq!((hit.triangle, hit.t, hit.u, hit.v), (1, 2.5, 0.25, 0.25));
    /// ```
    fn closest(&self, triangles: &[Triangle], ray: &Ray) -> Hit {
        let mut hit = [Hit::MISS];
        self.closest_of_each(triangles, core::slice::from_ref(ray), &mut hit);
        hit[0]
    }

    /// Whether anything is hit.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, Triangle};
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    /// assert!(Certified::default().any(&[wall], &ray));
    /// // The interval is open at its far end.
    /// assert!(!Certified::default().any(&[wall], &ray.between(0.0, 5.0)));
    /// ```
    fn any(&self, triangles: &[Triangle], ray: &Ray) -> bool {
        self.level().run(Any { mode: self, triangles, ray })
    }

    /// Every hit, in the order of the triangles.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, Triangle};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    /// let mut hits = vec![];
    /// Certified::default().all(&[at(5.0), at(-1.0), at(3.0)], &ray, |hit| hits.push(hit.triangle));
    /// assert_eq!(hits, [0, 2]);
    /// ```
    fn all(&self, triangles: &[Triangle], ray: &Ray, each: impl FnMut(Hit)) {
        self.level().run(All { mode: self, triangles, ray, each });
    }

    /// [`Mode::closest`] of many rays: `hits[i]` becomes the answer of `rays[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    ///
    /// ```
    /// use intertri::{Certified, Hit, Mode, Ray, Triangle};
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let rays = [0.25, 2.0].map(|x| Ray::new([x, 0.25, 0.0], [0.0, 0.0, 1.0]));
    /// let mut hits = [Hit::MISS; 2];
    /// Certified::default().closest_of_each(&[wall], &rays, &mut hits);
    /// assert_eq!(hits.map(|hit| hit.is_hit()), [true, false]);
    /// ```
    fn closest_of_each(&self, triangles: &[Triangle], rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "one hit a ray");
        self.level().run(ClosestOfEach { mode: self, triangles, rays, hits });
    }

    /// A triangle with what this mode computes from it once.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Prepared, Triangle};
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let prepared: Prepared<Certified> = Certified::default().prepare(&wall);
    /// ```
    fn prepare(&self, triangle: &Triangle) -> Prepared<Self> {
        Prepared { triangle: *triangle, constants: self.constants(triangle) }
    }

    /// N rays, 4, 8 or 16, against one triangle.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, RayPacket, Triangle};
    /// let mode = Certified::default();
    /// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let rays = [0.25, 0.75].map(|x| Ray::new([x, 0.5, 0.0], [0.0, 0.0, 1.0]));
    /// let hits = mode.packet(&RayPacket::<4>::new(&rays), &mode.prepare(&triangle));
    /// assert_eq!((hits.bits, hits.t[0]), (0b01, 5.0));
    /// ```
    fn packet<const N: usize>(&self, rays: &RayPacket<N>, triangle: &Prepared<Self>) -> Hits<N>
    where
        Lane<N>: Width,
    {
        self.level().run(Packet { mode: self, rays, triangle })
    }

    /// One ray against N triangles, 4, 8 or 16.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, Triangle, TrianglePack};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let pack = TrianglePack::<8>::new(&[at(5.0), at(-1.0), at(3.0)]);
    /// let hits = Certified::default().pack(&Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]), &pack);
    /// assert_eq!((hits.bits, hits.t[0], hits.t[2]), (0b101, 5.0, 3.0));
    /// ```
    fn pack<const N: usize>(&self, ray: &Ray, pack: &TrianglePack<N>) -> Hits<N>
    where
        Lane<N>: Width,
    {
        self.level().run(Pack { mode: self, ray, pack })
    }

    /// N rays prepared for one triangle after another, within a loop at some level.
    ///
    /// An example stands at [`PreparedPacket`].
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

    /// [`Mode::packet`] within a loop at some level.
    ///
    /// An example stands at [`PreparedPacket`].
    #[inline(always)]
    fn packet_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, Self, S, N>,
        triangle: &Prepared<Self>,
        counts: &mut Counts,
    ) -> Hits<N>
    where
        Lane<N>: Width,
    {
        let triangles =
            self.one_triangle::<F<S, N>, D<S, N>>(&triangle.triangle, &triangle.constants);
        let far = Lanes::load(&rays.packet().t_max);
        let live = rays.packet().live();
        let found = self.test(&triangles, rays.lanes(), far, live, counts);
        let find = |_| triangle.triangle;
        let scalar = Rays {
            packet: rays.packet(),
            triangle: &triangle.triangle,
            find,
            threshold: self.threshold(),
        };
        Hits::of(found, |lane| rays.packet().t_max[lane], &scalar)
    }

    /// [`Mode::pack`] within a loop at some level.
    ///
    /// An example stands at [`PreparedRay`].
    #[inline(always)]
    fn pack_in<S: Simd, const N: usize>(
        &self,
        ray: &Ray,
        pack: &TrianglePack<N>,
        counts: &mut Counts,
    ) -> Hits<N>
    where
        Lane<N>: Width,
    {
        let lanes = self.one_ray::<F<S, N>, D<S, N>>(&self.ray(ray));
        let triangles = self.triangles::<F<S, N>, D<S, N>, N>(pack);
        let far = Lanes::splat(ray.t_max);
        let found = self.test(&triangles, &lanes, far, pack.live(), counts);
        let find = |lane| pack.triangle(lane as usize);
        let scalar = Triangles { ray, pack, find, threshold: self.threshold() };
        Hits::of(found, |_| ray.t_max, &scalar)
    }

    /// A ray prepared for one pack after another.
    ///
    /// An example stands at [`PreparedRay`].
    #[inline(always)]
    fn prepare_ray(&self, ray: &Ray) -> PreparedRay<Self> {
        PreparedRay { ray: *ray, constants: self.ray(ray) }
    }

    /// Offers the hits of one ray with a pack to the ray's best.
    ///
    /// `indices` are the triangles' own, which break ties; lane i is in place `place + i`, by which
    /// `find` finds a triangle again.
    #[inline(always)]
    fn closest_in<S: Simd>(
        &self,
        ray: &PreparedRay<Self>,
        pack: &TrianglePack<8>,
        indices: &[u32; 8],
        place: u32,
        find: impl Fn(u32) -> Triangle,
        best: &mut Best,
        counts: &mut Counts,
    ) {
        let triangles = self.triangles::<S::F32x8, S::F64x8, 8>(pack);
        let lanes = self.one_ray::<S::F32x8, S::F64x8>(&ray.constants);
        let far = Lanes::splat(best.t_hi());
        if let Some(found) = self.test(&triangles, &lanes, far, pack.live(), counts) {
            let scalar = Triangles { ray: &ray.ray, pack, find, threshold: self.threshold() };
            best.offer_pack(&found, indices, place, &scalar);
        }
    }

    /// Whether one ray hits any triangle of a pack.
    ///
    /// An example stands at [`PreparedRay`].
    #[inline(always)]
    fn any_in<S: Simd>(
        &self,
        ray: &PreparedRay<Self>,
        pack: &TrianglePack<8>,
        counts: &mut Counts,
    ) -> bool {
        let mut best = Best::new(ray.ray.t_max);
        let find = |place| pack.triangle(place as usize);
        self.closest_in::<S>(ray, pack, &[0; 8], 0, find, &mut best, counts);
        best.is_hit()
    }

    /// Offers the hits of N rays with one triangle to their bests; only the lanes in `live` take
    /// part. Index, place and `find` are those of [`Mode::closest_in`].
    ///
    /// An example stands at [`PreparedPacket`].
    #[inline(always)]
    fn packet_closest_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, Self, S, N>,
        triangle: &Prepared<Self>,
        (index, place): (u32, u32),
        find: impl Fn(u32) -> Triangle,
        live: u32,
        bests: &mut Bests<F<S, N>, N>,
        counts: &mut Counts,
    ) where
        Lane<N>: Width,
    {
        let triangles = self.one_triangle(&triangle.triangle, &triangle.constants);
        let far = bests.t_hi();
        if let Some(found) = self.test(&triangles, rays.lanes(), far, live, counts) {
            let (packet, triangle) = (rays.packet(), &triangle.triangle);
            let scalar = Rays { packet, triangle, find, threshold: self.threshold() };
            bests.offer(&found, index, place, &scalar);
        }
    }

    /// [`Mode::packet_closest_in`] for one triangle after another; index and place of the i-th are
    /// `first + i`. All are looked at before any is decided, which is faster than one by one.
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
        bests: &mut Bests<F<S, N>, N>,
        counts: &mut Counts,
    ) where
        Lane<N>: Width,
    {
        blocks::closest_of(self, rays, triangles, first, &find, live, bests, counts);
    }

    /// The exact t of the hits that the bests of N rays stand for, side by side; a lane's bit is set where
    /// it has a hit. `find` is that of [`Mode::closest_in`].
    ///
    /// An example stands at [`PreparedPacket`].
    #[inline(always)]
    fn hits_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, Self, S, N>,
        bests: &Bests<F<S, N>, N>,
        find: impl Fn(u32) -> Triangle,
    ) -> Hits<N>
    where
        Lane<N>: Width,
    {
        bests.hits::<D<S, N>>(rays.packet(), find)
    }

    /// The index and the exact t of the hit that a best stands for. `find` is that of
    /// [`Mode::closest_in`].
    ///
    /// An example stands at [`PreparedRay`].
    #[inline]
    fn index_and_t(
        &self,
        ray: &Ray,
        best: &Best,
        find: impl Fn(u32) -> Triangle,
    ) -> Option<(u32, f64)> {
        let (index, place) = best.triangle()?;
        Some((index, best.known_t().unwrap_or_else(|| exact_t(ray, &find(place)))))
    }

    /// The hit that a best stands for, with its exact t and its weights. `find` is that of
    /// [`Mode::closest_in`].
    #[inline(always)]
    fn hit(&self, ray: &Ray, best: &Best, find: impl Fn(u32) -> Triangle) -> Hit {
        match best.triangle() {
            Some((index, place)) => pairs::hit(ray, &find(place), index),
            None => Hit::MISS,
        }
    }
}

impl<M: Test> Mode for M {}

type F<S, const N: usize> = <Lane<N> as Width>::F<S>;
type D<S, const N: usize> = <Lane<N> as Width>::D<S>;

impl Hit {
    /// A hit whose t is known, with the weights computed from the ray and the triangle.
    ///
    /// ```
    /// use intertri::{Hit, Ray, Triangle};
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let hit = Hit::at(2.5, 7, &Ray::new([0.25, 0.5, 0.0], [0.0, 0.0, 2.0]), &wall);
    /// assert_eq!(hit, Hit { t: 2.5, u: 0.25, v: 0.5, triangle: 7 });
    /// ```
    pub fn at(t: f64, index: u32, ray: &Ray, triangle: &Triangle) -> Self {
        let (u, v) = Coefficients::new(triangle, ray.origin).weights(ray.dir.map(f64::from));
        Self { t, u, v, triangle: u64::from(index) }
    }
}

impl<const N: usize> Hits<N> {
    /// The lanes that a test found, each with its exact t, within the far end of its interval.
    #[inline(always)]
    fn of<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        found: Option<Found<F, D>>,
        t_max: impl Fn(usize) -> f32,
        scalar: &impl Scalar,
    ) -> Self {
        let mut hits = Self { bits: 0, t: [f64::INFINITY; N] };
        let Some(found) = found else { return hits };
        for lane in lanes_of(found.lanes()) {
            let near = found.near >> lane & 1 != 0;
            let t = if near {
                Some(scalar.exact_t(lane, lane as u32))
            } else {
                found.known_t(lane, scalar)
            };
            if let Some(t) = t.filter(|&t| t < f64::from(t_max(lane))) {
                hits.bits |= 1 << lane;
                hits.t[lane] = t;
            }
        }
        hits
    }
}

/// The lanes of a packet of rays with one triangle.
pub(crate) struct Rays<'a, P, const N: usize> {
    pub(crate) packet: &'a RayPacket<N>,
    pub(crate) triangle: &'a Triangle,
    pub(crate) find: P,
    pub(crate) threshold: Threshold,
}

impl<P: Fn(u32) -> Triangle, const N: usize> Scalar for Rays<'_, P, N> {
    #[inline(always)]
    fn replay(&self, lane: usize) -> Option<f64> {
        replay(&self.packet.ray(lane), self.triangle, self.threshold.get())
    }
    #[inline(always)]
    fn exact_t(&self, lane: usize, place: u32) -> f64 {
        exact_t(&self.packet.ray(lane), &(self.find)(place))
    }
}

/// The lanes of a pack of triangles with one ray.
struct Triangles<'a, P, const N: usize> {
    ray: &'a Ray,
    pack: &'a TrianglePack<N>,
    find: P,
    threshold: Threshold,
}

impl<P: Fn(u32) -> Triangle, const N: usize> Scalar for Triangles<'_, P, N> {
    #[inline(always)]
    fn replay(&self, lane: usize) -> Option<f64> {
        replay(self.ray, &self.pack.triangle(lane), self.threshold.get())
    }
    #[inline(always)]
    fn exact_t(&self, _lane: usize, place: u32) -> f64 {
        exact_t(self.ray, &(self.find)(place))
    }
}

struct Packet<'a, M: Test, const N: usize> {
    mode: &'a M,
    rays: &'a RayPacket<N>,
    triangle: &'a Prepared<M>,
}

impl<M: Test, const N: usize> WithSimd for Packet<'_, M, N>
where
    Lane<N>: Width,
{
    type Output = Hits<N>;
    #[inline(always)]
    fn run<S: Simd>(self) -> Hits<N> {
        let rays = self.mode.prepare_packet_in::<S, N>(self.rays);
        self.mode.packet_in(&rays, self.triangle, &mut Counts::default())
    }
}

struct Pack<'a, M, const N: usize> {
    mode: &'a M,
    ray: &'a Ray,
    pack: &'a TrianglePack<N>,
}

impl<M: Test, const N: usize> WithSimd for Pack<'_, M, N>
where
    Lane<N>: Width,
{
    type Output = Hits<N>;
    #[inline(always)]
    fn run<S: Simd>(self) -> Hits<N> {
        self.mode.pack_in::<S, N>(self.ray, self.pack, &mut Counts::default())
    }
}
