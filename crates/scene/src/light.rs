//! Point lights and directional lights, and their shadow rays.

use glam::DVec3;
use intertri::{Hit, RayOf, Scalar, TriangleOf, spawn_ray, spawn_ray_to};

use crate::camera::Camera;
use crate::coordinate::Coordinate;
use crate::mesh::{Bounds, double, rounded};

/// A light with hard shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light<S = f32> {
    /// A point light.
    Point {
        /// The light's position.
        position: [S; 3],
    },
    /// A light so far away that its rays are parallel. [`Light::sun`] creates one.
    Directional {
        /// The vector to the light. Shadow rays have this length, so the vector must reach beyond
        /// the scene from any surface.
        toward: [S; 3],
    },
}

impl Light {
    /// The end of a shadow ray's interval, as a fraction of the distance from the light to the
    /// surface.
    ///
    /// A shadow ray ends on the triangle that the pixel shows, at `t = 1` up to rounding. The ray's
    /// f32 direction misses the visible point by about 1e-7 of the distance, and the triangle's `t`
    /// differs from 1 by that amount divided by the cosine between ray and normal. A margin of one
    /// part in ten thousand covers every cosine above 1e-3; at smaller cosines, the surface gets no
    /// visible light anyway. In a typical image, the margin is a tenth of a pixel. This is a
    /// tolerance for shading only; the intersection test has none.
    pub const REACH: f32 = 0.9999;
}

impl<S: Coordinate> Light<S> {
    /// Creates a light for `bounds` as seen by `camera`: high over the photographer's left
    /// shoulder, and far enough away that shadows do not spread much. If the camera is inside the
    /// bounds, which may be a room, the light is slightly above the camera and to its left.
    pub fn over_the_shoulder(bounds: &Bounds<S>, camera: &Camera<S>) -> Self {
        let [right, up, forward] = camera.basis();
        let position = if bounds.contains(camera.eye()) {
            double(camera.eye()) + (up - right) * (bounds.radius() * 0.07)
        } else {
            let toward = up * 1.0 - right * 0.75 - forward * 0.8;
            bounds.centre() + toward.normalize() * (bounds.radius() * 4.0)
        };
        Self::Point { position: rounded(position) }
    }

    /// Creates a directional light for `bounds`. `toward` is the direction to the light, of any
    /// length. Returns `None` if `toward` is zero or not finite, or if the bounds are too large for
    /// the scalar.
    pub fn sun(toward: [f32; 3], bounds: &Bounds<S>) -> Option<Self> {
        let direction = double(toward).try_normalize()?;
        // Make the vector longer than any segment in the bounds.
        let toward: [S; 3] = rounded(direction * (bounds.radius() * 2.02));
        toward.iter().all(|x| x.is_finite()).then_some(Self::Directional { toward })
    }

    /// Returns the origin of the shadow ray for `point`.
    pub fn origin(&self, point: [f64; 3]) -> [S; 3] {
        match *self {
            Self::Point { position } => position,
            Self::Directional { toward } => rounded(DVec3::from(point) + double(toward)),
        }
    }

    /// Returns the shadow ray for `point`, which is on a surface. Any hit occludes the light.
    ///
    /// The ray runs in reverse: from the light, or from a point far enough toward it, to the
    /// surface at `t = 1`, over the interval `0 <= t <` [`Light::REACH`]. All shadow rays of a
    /// point light have the same origin, bit for bit, and are as coherent as camera rays.
    pub fn shadow_ray(&self, point: [f64; 3]) -> RayOf<S> {
        Self::shadow_ray_from(self.origin(point), point)
    }

    /// Returns the shadow ray for `point` as [`Light::shadow_ray`] does, but from a given origin,
    /// such as one snapped to a grid.
    pub fn shadow_ray_from(origin: [S; 3], point: [f64; 3]) -> RayOf<S> {
        let dir = DVec3::from(point) - double(origin);
        RayOf::new(origin, rounded::<S>(dir)).between(S::ZERO, S::from(Light::REACH))
    }

    /// Returns the shadow ray from a hit found by [`Mode::exact`](intertri::Mode::exact) to the
    /// light. Any hit occludes the light. The ray never hits the triangle itself (see
    /// [`spawn_ray`]), so no part of the segment is skipped.
    pub fn shadow_ray_of(&self, hit: &Hit, triangle: &TriangleOf<S>) -> RayOf<S> {
        match *self {
            Self::Point { position } => spawn_ray_to(hit, triangle, position),
            Self::Directional { toward } => spawn_ray(hit, triangle, toward),
        }
    }

    /// Returns the unit vector from a point to the light.
    #[inline]
    pub(crate) fn direction(&self, point: DVec3) -> DVec3 {
        let toward = match *self {
            Self::Point { position } => double(position) - point,
            Self::Directional { toward } => double(toward),
        };
        toward.normalize_or_zero()
    }
}

/// Returns the point of a `hit` on `ray`, in f64. The point of a miss is not finite.
pub fn hit_point<S: Scalar>(ray: &RayOf<S>, hit: &Hit) -> [f64; 3] {
    (double(ray.origin) + double(ray.dir) * hit.t).to_array()
}

#[cfg(test)]
mod tests {
    use intertri::{Mode, Ray, Triangle};

    use super::*;

    fn sun(toward: DVec3) -> Light {
        Light::Directional { toward: rounded(toward) }
    }

    #[test]
    fn shadow_rays_start_at_the_light_and_end_just_before_the_point() {
        let light = Light::Point { position: [1.0, 10.0, 2.0] };
        let ray = light.shadow_ray([1.5, 0.25, -3.0]);
        assert_eq!(ray.origin, [1.0, 10.0, 2.0]);
        assert_eq!(ray.dir, [0.5, -9.75, -5.0]);
        assert_eq!((ray.t_min, ray.t_max), (0.0, Light::REACH));
    }

    #[test]
    fn a_surface_does_not_shadow_itself_but_what_stands_before_it_does() {
        // Planes through a point, with a cosine of 1e-3 toward the light, from many sides and at
        // many distances. The f32 ray's hit with its own plane must not count.
        let mut worst: f64 = 1.0;
        for i in 0..20_000_u32 {
            let angle = f64::from(i) * 2.399_963;
            let distance = 1.07_f64.powi((i % 200) as i32 - 100);
            let toward = DVec3::new(angle.cos(), 0.3 + (angle * 0.37).sin(), angle.sin());
            let point = DVec3::new(0.1, -0.7, 0.3) * distance;
            let light = rounded(point + toward * distance * 3.0);
            let light =
                [Light::Point { position: light }, sun(toward * distance * 3.0)][i as usize % 2];
            let ray = light.shadow_ray(point.to_array());

            let toward = toward.normalize();
            let tilt = toward.any_orthonormal_vector();
            let normal = toward * 1e-3 + if i % 4 < 2 { tilt } else { -tilt };
            let dir = double(ray.dir);
            let t = normal.dot(point - double(ray.origin)) / normal.dot(dir);
            worst = worst.min(t);
            assert!(t >= f64::from(ray.t_max), "{i}: {t}");
            // An occluder must count if its distance from the surface is a thousandth of the
            // distance to the light.
            assert!(0.999 < ray.t_max);
        }
        // Rounding does move the hit on the surface in front of the point, so the test is
        // meaningful.
        assert!(worst < 1.0 - 1e-5, "{worst}");
    }

    #[test]
    fn an_exact_shadow_ray_never_meets_its_triangle_and_all_that_stands_beside_it() {
        let (exact, mut blocked) = (Mode::exact(), 0);
        for i in 0..3000_u32 {
            let angle = f64::from(i) * 2.399_963;
            let size = 1.07_f64.powi((i % 200) as i32 - 100);
            let (along, up) = (angle.cos() * size, (angle * 0.37).sin() * size);
            let at =
                |x: f64, y: f64| rounded(DVec3::new(x, 0.1 * size + 0.3 * x * along / size, y));
            let triangle = Triangle([at(-size, -size), at(size, -size), at(0.0, size)]);
            let ray = Ray::new(rounded(DVec3::new(along, 9.0 * size, up)), [0.0, -1.0, 0.0]);
            let ray =
                Ray { origin: [ray.origin[0] * 0.3, ray.origin[1], ray.origin[2] * 0.3], ..ray };
            let Some(hit) = exact.closest(&[triangle], &ray) else { continue };

            // A light nearly in the triangle's plane or above it, and an occluder at 1e-5 of the
            // distance to the light.
            let point = DVec3::from(hit_point(&ray, &hit));
            let over = if i % 2 == 0 { 1e-6 } else { 3.0 };
            let toward = DVec3::new(2.0 * size, over * size, size);
            let lights = [Light::Point { position: rounded(point + toward) }, sun(toward)];
            let near = point + toward * 1e-5;
            let side = toward.normalize().any_orthonormal_vector() * size;
            let other = toward.normalize().cross(side);
            let wall = [near - side - other, near + side * 2.0, near + other * 2.0].map(rounded);
            let far = [wall, wall.map(|p| rounded(double(p) + toward * 1.1))].map(Triangle);
            for light in lights {
                let next = light.shadow_ray_of(&hit, &triangle);
                assert!(!exact.any(&[triangle], &next), "{i}: {next:?}");
                assert!(exact.any(&far[..1], &next), "{i}: {next:?}");
                blocked += u32::from(!exact.any(&[far[0]], &light.shadow_ray(point.to_array())));
                // A wall behind a point light does not occlude the light.
                let beyond = exact.any(&far[1..], &next);
                assert_eq!(beyond, matches!(light, Light::Directional { .. }), "{i}: {next:?}");
            }
        }
        // A reach of 0.9999 would miss most of these walls.
        assert!(blocked > 1000, "{blocked}");
    }

    #[test]
    fn the_light_stands_above_and_on_the_side_of_the_camera() {
        let bounds = Bounds { min: [-1.0; 3], max: [1.0; 3] };
        let camera = Camera::framing([bounds.min, bounds.max], 1.0).unwrap();
        let light = double(Light::over_the_shoulder(&bounds, &camera).origin([0.0; 3]));
        assert!(light.y > 1.0);
        assert!(light.dot(double(camera.eye())) > 0.0);
    }

    #[test]
    fn in_a_room_the_light_is_in_the_room() {
        let room = Bounds { min: [-3.0, 0.0, -4.0], max: [3.0, 2.5, 4.0] };
        let camera = Camera::new([0.0, 1.6, 3.0], [0.0, 1.0, 0.0], Camera::UP, 60.0).unwrap();
        assert!(room.contains(Light::over_the_shoulder(&room, &camera).origin([0.0; 3])));
    }

    #[test]
    fn the_sun_s_rays_are_parallel_and_start_outside() {
        let bounds = Bounds { min: [-1.0, 0.0, 2.0], max: [3.0, 5.0, 4.0] };
        let light = Light::sun([0.0, 1e-30, 0.0], &bounds).unwrap();
        for point in [[-1.0, 0.0, 2.0], [3.0, 5.0, 4.0], [0.5, 1.0, 3.0]] {
            let ray = light.shadow_ray(point);
            assert!(ray.origin[1] > 5.0 && ray.dir[0] == 0.0 && ray.dir[2] == 0.0, "{ray:?}");
            assert_eq!((ray.t_min, ray.t_max), (0.0, Light::REACH));
            assert_eq!(light.direction(DVec3::from(point)), DVec3::Y);
        }
        assert_eq!(Light::sun([0.0; 3], &bounds), None);
        assert_eq!(Light::sun([f32::NAN, 0.0, 1.0], &bounds), None);
    }

    #[test]
    fn a_hit_point_is_on_the_ray() {
        let ray = Ray::new([1.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
        let hit = Hit { t: 1.5, triangle: 0, ..Hit::MISS };
        assert_eq!(hit_point(&ray, &hit), [1.0, 3.0, 0.0]);
    }
}
