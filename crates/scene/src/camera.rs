//! A pinhole camera.
//!
//! ```text
//!                       up
//!                        |   (x, y)
//!               +--------|----*---+   y grows downward,
//!               |        |   /    |   pixel (0, 0) at the top left
//!   target <----|--------o--/-----|---- forward
//!               |          / \    |
//!               +---------/---\---+
//!                        /     right
//!                     eye
//! ```

use std::fmt;

use glam::DVec3;
use intertri::Ray;

use crate::mesh::{Bounds, double, single};

/// An eye, where it looks, and how wide.
///
/// Every ray of a camera has the bit-identical origin, so that what depends on the viewpoint alone
/// can be prepared once per triangle. The arithmetic is f64 and each result is rounded to f32 once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    eye: [f32; 3],
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Half of the picture's height at distance 1.
    half_height: f64,
}

impl Camera {
    /// The vertical field of view of [`Camera::framing`], in degrees: a moderate telephoto lens.
    pub const FOV: f64 = 35.0;
    /// From where [`Camera::framing`] looks: a three-quarter view from slightly above, y up.
    pub const VIEW: [f32; 3] = [0.55, 0.38, 1.0];
    /// What is up for [`Camera::framing`].
    pub const UP: [f32; 3] = [0.0, 1.0, 0.0];

    /// A camera at `eye` that has `target` in the middle of its picture and `up` upward in it.
    ///
    /// `fov` is the vertical field of view in degrees, between 0 and 180, both excluded.
    ///
    /// # Errors
    /// If a number is not finite, `fov` is out of its range, `eye` and `target` are one point, or
    /// `up` points along the line of sight (or is zero).
    pub fn new(
        eye: [f32; 3],
        target: [f32; 3],
        up: [f32; 3],
        fov: f64,
    ) -> Result<Self, CameraError> {
        let finite = |p: [f32; 3]| p.iter().all(|x| x.is_finite());
        if !(finite(eye) && finite(target) && finite(up)) {
            return Err(CameraError::NotFinite);
        }
        if !(fov > 0.0 && fov < 180.0) {
            return Err(CameraError::Fov(fov));
        }
        let forward = (double(target) - double(eye)).try_normalize().ok_or(CameraError::NoView)?;
        let up = double(up).try_normalize().ok_or(CameraError::Up)?;
        let right = forward.cross(up);
        // Below this the picture's tilt would be decided by rounding.
        if right.length() < 1e-6 {
            return Err(CameraError::Up);
        }
        let right = right.normalize();
        let half_height = (fov.to_radians() * 0.5).tan();
        Ok(Self { eye, right, up: right.cross(forward), forward, half_height })
    }

    /// A camera that has the whole box in its picture: [`Camera::framing_from`] with
    /// [`Camera::VIEW`], [`Camera::UP`] and [`Camera::FOV`].
    ///
    /// `aspect` is the picture's width divided by its height.
    ///
    /// # Errors
    /// If the camera would stand beyond the range of f32, or `aspect` is not positive and finite.
    pub fn framing(bounds: &Bounds, aspect: f64) -> Result<Self, CameraError> {
        Self::framing_from(bounds, Self::VIEW, Self::UP, Self::FOV, aspect)
    }

    /// A camera that has the whole box in its picture, as large as a narrow margin allows, seen from
    /// the direction `view` (from the box toward the eye).
    ///
    /// # Errors
    /// As [`Camera::new`], with `view` as the line of sight; and if `aspect` is not positive and
    /// finite.
    pub fn framing_from(
        bounds: &Bounds,
        view: [f32; 3],
        up: [f32; 3],
        fov: f64,
        aspect: f64,
    ) -> Result<Self, CameraError> {
        if !(aspect > 0.0 && aspect.is_finite()) {
            return Err(CameraError::Aspect(aspect));
        }
        // The directions of the wanted camera are those of one that looks from `view` at the origin.
        let center = bounds.center();
        let facing = Self::new(view, [0.0; 3], up, fov)?;

        // A corner stays in the picture when its distance to the line of sight is at most the
        // picture's half size at its depth: |x| <= half * (distance - toward the eye).
        let half_width = facing.half_height * aspect;
        let distance = bounds.corners().into_iter().map(|corner| {
            let arm = corner - center;
            let toward = -arm.dot(facing.forward);
            let across = (arm.dot(facing.right).abs() / half_width)
                .max(arm.dot(facing.up).abs() / facing.half_height);
            across * 1.04 + toward
        });
        let distance = distance.fold(bounds.radius() * 0.01, f64::max);

        let eye = single(center - facing.forward * distance);
        Self::new(eye, single(center), up, fov)
    }

    /// Where the camera stands: the origin of all its rays.
    pub fn eye(&self) -> [f32; 3] {
        self.eye
    }

    /// The ray through the center of pixel `(x, y)` of a picture of `width` times `height` pixels;
    /// `x` grows to the right and `y` downward. `dir` has unit length up to f32 rounding, so `t` is
    /// a distance. The interval is that of [`Ray::new`].
    pub fn ray(&self, x: u32, y: u32, width: u32, height: u32) -> Ray {
        // A pixel is square: both axes are measured in half picture heights.
        let half = f64::from(height) * 0.5;
        let across = (f64::from(x) + 0.5 - f64::from(width) * 0.5) / half;
        let above = (half - f64::from(y) - 0.5) / half;
        let dir = self.forward
            + self.right * (across * self.half_height)
            + self.up * (above * self.half_height);
        Ray::new(self.eye, single(dir.normalize()))
    }

    /// To the right of the picture, toward its top, and into it: three unit vectors at right angles.
    pub fn axes(&self) -> [[f64; 3]; 3] {
        self.basis().map(|axis| axis.to_array())
    }

    /// Half of the picture's height at distance 1: the tangent of half the vertical field of view.
    pub fn half_height(&self) -> f64 {
        self.half_height
    }

    /// [`Camera::axes`].
    pub(crate) fn basis(&self) -> [DVec3; 3] {
        [self.right, self.up, self.forward]
    }
}

/// Why there is no such camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraError {
    /// A coordinate is NaN or infinite, or became so because the model is too large.
    NotFinite,
    /// The field of view, in degrees, is not between 0 and 180.
    Fov(f64),
    /// Width divided by height is not a positive number.
    Aspect(f64),
    /// Eye and target are the same point.
    NoView,
    /// The up direction is zero or points along the line of sight.
    Up,
}

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(
                f,
                "camera: a coordinate is not finite in f32; give finite numbers, or scale the model down"
            ),
            Self::Fov(fov) => {
                write!(f, "camera: a field of view of {fov} degrees; give one between 0 and 180")
            }
            Self::Aspect(aspect) => {
                write!(f, "camera: a picture of aspect {aspect}; give it a width and a height")
            }
            Self::NoView => {
                write!(f, "camera: eye and target are the same point; move one of them")
            }
            Self::Up => write!(
                f,
                "camera: the up direction is zero or along the line of sight; choose another"
            ),
        }
    }
}

impl std::error::Error for CameraError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_share_their_origin_and_have_unit_length() {
        let camera = Camera::new([1.0, 2.0, 3.0], [0.1, 0.2, 0.3], Camera::UP, 50.0).unwrap();
        for (x, y) in [(0, 0), (639, 0), (0, 479), (639, 479), (320, 240)] {
            let ray = camera.ray(x, y, 640, 480);
            assert_eq!(ray.origin.map(f32::to_bits), [1.0f32, 2.0, 3.0].map(f32::to_bits));
            assert!((double(ray.dir).length() - 1.0).abs() < 1e-7);
            assert_eq!((ray.t_min, ray.t_max), (0.0, f32::INFINITY));
        }
    }

    #[test]
    fn the_middle_pixel_looks_at_the_target_and_y_grows_downward() {
        let camera = Camera::new([0.0, 0.0, 5.0], [0.0; 3], Camera::UP, 90.0).unwrap();
        assert_eq!(camera.ray(1, 1, 3, 3).dir, [0.0, 0.0, -1.0]);
        // A field of view of 90 degrees reaches as far up as it looks ahead; a pixel's center in
        // the top row of three is at 2/3 of that.
        let top = camera.ray(1, 0, 3, 3).dir;
        assert!((top[1] / -top[2] - 2.0 / 3.0).abs() < 1e-6 && top[0] == 0.0);
        let right = camera.ray(2, 1, 3, 3).dir;
        assert!((right[0] / -right[2] - 2.0 / 3.0).abs() < 1e-6 && right[1] == 0.0);
    }

    #[test]
    fn framing_holds_every_corner_and_wastes_little() {
        let boxes = [
            Bounds { min: [-1.0; 3], max: [1.0; 3] },
            Bounds { min: [1e6, 0.0, -3.0], max: [1.00001e6, 100.0, 3.0] },
            Bounds { min: [0.0, 0.0, 0.0], max: [50.0, 0.0, 1.0] },
        ];
        for bounds in boxes {
            for aspect in [0.3, 1.0, 4.0 / 3.0, 3.0] {
                let camera = Camera::framing(&bounds, aspect).unwrap();
                // How far a corner is from the middle, 1 being the picture's edge.
                let reach = bounds.corners().into_iter().map(|corner| {
                    let arm = corner - double(camera.eye);
                    let depth = arm.dot(camera.forward) * camera.half_height;
                    assert!(depth > 0.0);
                    let up = arm.dot(camera.up).abs() / depth;
                    up.max(arm.dot(camera.right).abs() / depth / aspect)
                });
                let reach = reach.fold(0.0, f64::max);
                assert!((0.85..1.0).contains(&reach), "{bounds:?} {aspect}: {reach}");
            }
        }
    }

    #[test]
    fn impossible_cameras_are_errors() {
        let new = Camera::new;
        assert_eq!(new([f32::NAN; 3], [0.0; 3], Camera::UP, 40.0), Err(CameraError::NotFinite));
        assert_eq!(new([1.0; 3], [1.0; 3], Camera::UP, 40.0), Err(CameraError::NoView));
        assert_eq!(new([0.0, 3.0, 0.0], [0.0; 3], Camera::UP, 40.0), Err(CameraError::Up));
        assert_eq!(new([1.0; 3], [0.0; 3], [0.0; 3], 40.0), Err(CameraError::Up));
        for fov in [0.0, -1.0, 180.0, f64::INFINITY] {
            assert_eq!(new([1.0; 3], [0.0; 3], Camera::UP, fov), Err(CameraError::Fov(fov)));
        }
        let point = Bounds { min: [2.0; 3], max: [2.0; 3] };
        assert!(Camera::framing(&point, 1.0).is_ok());
        assert!(Camera::framing(&point, 0.0).is_err());
        let huge = Bounds { min: [f32::MIN; 3], max: [f32::MAX; 3] };
        assert_eq!(Camera::framing(&huge, 1.0), Err(CameraError::NotFinite));
    }
}
