//! The mode `double`: `InterTri` (document A) in f64 lanes, its operations in its order.
//!
//! ```text
//!              c3
//!              /\            h4 = c2 - c1     h2 = h1 - c1
//!          h5 /  \ h6        h5 = c3 - c1     h3 = h1 - c2
//!            /  . \          h6 = c3 - c2
//!           /  h1  \         nrm = h4 ^ h5, of unit length
//!         c1 ------ c2
//!              h4            h1 = org + dir * t, the point of the ray in the plane
//! ```
//!
//! No operation here is fused, approximated or reordered, so every lane gives the bits that the
//! scalar listing gives. This is also what replays the lanes that an f32 bound cannot decide.

use crate::lanes::{Lanes, Level, Mask};
use crate::mode::{Counts, Found, Test, Threshold, Which};
use crate::packet::RayLanes;
use crate::{Ray, RayPacket, Triangle, TrianglePack, Vec3};

/// A triangle as the document initialises it, in every lane the same or in every lane another.
#[derive(Clone, Copy)]
pub struct Tri<D> {
    c1: Vec3<D>,
    c2: Vec3<D>,
    pub(crate) nrm: Vec3<D>,
    h4: Vec3<D>,
    h5: Vec3<D>,
    h6: Vec3<D>,
}

impl<D: Lanes<Scalar = f64>> Tri<D> {
    /// The edges and the normal from the corners.
    #[inline(always)]
    pub(crate) fn new([c1, c2, c3]: [Vec3<D>; 3]) -> Self {
        let (h4, h5, h6) = (c2 - c1, c3 - c1, c3 - c2);

        // A triangle without area keeps the zero vector, which is parallel to every ray.
        let normal = h4.cross(h5);
        let length = normal.dot(normal).sqrt();
        let length = D::select(length.le(D::splat(0.0)), D::splat(1.0), length);
        let nrm = Vec3 { x: normal.x / length, y: normal.y / length, z: normal.z / length };
        Self { c1, c2, nrm, h4, h5, h6 }
    }

    /// N triangles.
    #[inline(always)]
    pub(crate) fn of_pack<const N: usize>(pack: &TrianglePack<N>) -> Self {
        // Not by `map`, which would be compiled without the level's instructions.
        let [c1, c2, c3] = pack.corners();
        Self::new([Vec3::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)])
    }

    /// One triangle for all lanes.
    #[inline(always)]
    pub(crate) fn splat(one: &Tri<f64>) -> Self {
        let vec3 = |v: Vec3<f64>| Vec3::splat([v.x, v.y, v.z]);
        Self {
            c1: vec3(one.c1),
            c2: vec3(one.c2),
            nrm: vec3(one.nrm),
            h4: vec3(one.h4),
            h5: vec3(one.h5),
            h6: vec3(one.h6),
        }
    }

    /// `nrm & dir`, and the `t` of the plane.
    #[inline(always)]
    fn plane(&self, org: Vec3<D>, dir: Vec3<D>) -> (D, D) {
        let vd = self.nrm.dot(dir);
        (vd, self.nrm.dot(self.c1 - org) / vd)
    }

    /// The `t` that [`Tri::inter_tri`] gives, without asking whether it is a hit.
    #[inline(always)]
    pub(crate) fn t(&self, org: Vec3<D>, dir: Vec3<D>) -> D {
        self.plane(org, dir).1
    }

    /// The document's test: where the line of sight meets the triangle, and at which `t`.
    #[inline(always)]
    pub(crate) fn inter_tri(&self, org: Vec3<D>, dir: Vec3<D>, threshold: f64) -> (D::Mask, D) {
        let zero = D::splat(0.0);
        let threshold = D::splat(threshold);

        // Parallel to the plane?
        let (vd, t) = self.plane(org, dir);
        let parallel = (-threshold).lt(vd) & vd.lt(threshold);

        // Outside of an edge? A point on it is inside, and a NaN is not `< 0`.
        let h1 = org + dir * t;
        let h2 = h1 - self.c1;
        let outside = self.nrm.dot(self.h4.cross(h2)).lt(zero)
            | self.nrm.dot(h2.cross(self.h5)).lt(zero)
            | self.nrm.dot(self.h6.cross(h1 - self.c2)).lt(zero);

        (!(parallel | outside) & t.gt(threshold), t)
    }

    /// [`Tri::inter_tri`] within the rays' intervals: `t_min <= t < t_max`.
    #[inline(always)]
    pub(crate) fn hit(&self, rays: &RayLanes<D>, threshold: f64) -> (D::Mask, D) {
        let (hit, t) = self.inter_tri(rays.org, rays.dir, threshold);
        (hit & t.ge(rays.t_min) & t.lt(rays.t_max), t)
    }
}

impl Tri<f64> {
    /// One triangle.
    #[inline(always)]
    pub(crate) fn one(&Triangle(corners): &Triangle) -> Self {
        Self::new(corners.map(|c| Vec3::splat(c.map(f64::from))))
    }
}

/// One ray against one triangle: t, if it is a hit.
#[cold]
#[inline(never)]
pub(crate) fn replay(ray: &Ray, triangle: &Triangle, threshold: f64) -> Option<f64> {
    let (hit, t) = Tri::one(triangle).hit(&RayLanes::of_ray(ray), threshold);
    hit.then_some(t)
}

/// The reference's t of a triangle that is known to be hit.
#[inline(never)]
pub(crate) fn exact_t(ray: &Ray, triangle: &Triangle) -> f64 {
    let rays = RayLanes::of_ray(ray);
    Tri::one(triangle).t(rays.org, rays.dir)
}

/// A triangle's plane as it is seen from an origin.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    nrm: Vec3<f64>,
    num: f64,
}

impl Plane {
    #[inline(never)]
    pub(crate) fn new(triangle: &Triangle, origin: [f32; 3]) -> Self {
        let Tri { nrm, c1, .. } = Tri::one(triangle);
        Self { nrm, num: nrm.dot(c1 - Vec3::splat(origin.map(f64::from))) }
    }

    /// The reference's t of a ray from there that is known to hit the triangle.
    #[inline(always)]
    pub(crate) fn t(&self, dir: [f32; 3]) -> f64 {
        self.num / self.nrm.dot(Vec3::splat(dir.map(f64::from)))
    }
}

/// f64 lanes throughout: the answers of the scalar reference, bit for bit.
///
/// ```
/// use intertri::{Double, Mode, Ray, Triangle};
/// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let hit = Double::default().closest(&[triangle], &Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]));
/// assert_eq!((hit.triangle, hit.t), (0, 5.0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Double {
    threshold: Threshold,
    level: Level,
}

impl Default for Double {
    fn default() -> Self {
        Self::new(Threshold::DEFAULT)
    }
}

impl Double {
    /// The mode with a threshold of one's own, at this CPU's best level.
    ///
    /// ```
    /// use intertri::{Double, Threshold};
    /// let mode = Double::new(Threshold::new(1e-12).unwrap());
    /// ```
    pub fn new(threshold: Threshold) -> Self {
        Self { threshold, level: Level::best() }
    }

    /// The same mode at another level. The answers do not depend on it.
    ///
    /// ```
    /// use intertri::{Double, lanes::Level};
    /// let plain = Double::default().at(Level::SCALAR);
    /// ```
    pub fn at(self, level: Level) -> Self {
        Self { level, ..self }
    }
}

impl Test for Double {
    type Rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> = RayLanes<D>;
    type Triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> = Tri<D>;
    type Constants = Tri<f64>;
    type Look<F: Lanes<Scalar = f32>> = ();
    type Ray = RayLanes<f64>;

    #[inline(always)]
    fn level(&self) -> Level {
        self.level
    }

    #[inline(always)]
    fn which(&self) -> Which<'_> {
        Which::Double(self)
    }

    #[inline(always)]
    fn threshold(&self) -> Threshold {
        self.threshold
    }

    #[inline(always)]
    fn rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        packet: &RayPacket<N>,
    ) -> RayLanes<D> {
        RayLanes::of_packet(packet)
    }

    #[inline(always)]
    fn ray(&self, ray: &Ray) -> RayLanes<f64> {
        RayLanes::of_ray(ray)
    }

    #[inline(always)]
    fn one_ray<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        ray: &RayLanes<f64>,
    ) -> RayLanes<D> {
        RayLanes::splat(ray)
    }

    #[inline(always)]
    fn triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        pack: &TrianglePack<N>,
    ) -> Tri<D> {
        Tri::of_pack(pack)
    }

    #[inline(always)]
    fn constants(&self, triangle: &Triangle) -> Tri<f64> {
        Tri::one(triangle)
    }

    #[inline(always)]
    fn one_triangle<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        _: &Triangle,
        constants: &Tri<f64>,
    ) -> Tri<D> {
        Tri::splat(constants)
    }

    #[inline(always)]
    fn look<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(&self, _: &RayLanes<D>) {}

    #[inline(always)]
    fn maybe<F: Lanes<Scalar = f32>>(&self, _: &Tri<f64>, (): &(), _: F::Mask) -> bool {
        true
    }

    #[inline(always)]
    fn test<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangles: &Tri<D>,
        rays: &RayLanes<D>,
        _far: F,
        live: u32,
        counts: &mut Counts,
    ) -> Option<Found<F, D>> {
        counts.tests += u64::from(live.count_ones());
        let (hit, t) = triangles.hit(rays, self.threshold.get());
        let exact = hit.bits() & live;
        let nothing = F::splat(0.0);
        let found = Found { near: 0, exact, undecided: 0, t_lo: nothing, t_hi: nothing, t };
        (exact != 0).then_some(found)
    }
}
