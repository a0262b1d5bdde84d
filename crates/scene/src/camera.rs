//! A pinhole camera.
//!
//! ```text
//!                       up
//!                        |   (x, y)
//!               +--------|----*---+   y grows downward.
//!               |        |   /    |   Pixel (0, 0) is at the top left.
//!   target <----|--------o--/-----|---- forward
//!               |          / \    |
//!               +---------/---\---+
//!                        /     right
//!                     eye
//! ```

use std::fmt;

use glam::{DQuat, DVec3};
use intertri::RayOf;

use crate::coordinate::Coordinate;
use crate::mesh::{double, rounded};

/// The smallest allowed sine of the angle between the view direction and up. Below this value,
/// rounding would determine the tilt of the image.
const LEVEL: f64 = 1e-6;

/// A pinhole camera with an eye, a view direction, and a field of view.
///
/// All rays of a camera have the same origin, bit for bit, so they can be traced in bundles. The
/// arithmetic is in f64, and each result is rounded once to the camera's scalar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera<S = f32> {
    eye: [S; 3],
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Half the image plane's height at distance 1.
    half_height: f64,
}

impl Camera {
    /// The vertical field of view of [`Camera::framing`], in degrees: a moderate telephoto lens.
    pub const FOV: f64 = 35.0;
    /// The view direction of [`Camera::framing`]: a three-quarter view from slightly above, y up.
    pub const VIEW: [f32; 3] = [0.55, 0.38, 1.0];
    /// The up direction of [`Camera::framing`].
    pub const UP: [f32; 3] = [0.0, 1.0, 0.0];

    /// Returns [`Camera::VIEW`] after the rotation that takes [`Camera::UP`] to `up`. A model
    /// rotated in the same way gives the same image.
    pub fn view_for(up: [f32; 3]) -> [f32; 3] {
        match double(up).try_normalize() {
            Some(to) if up != Self::UP => {
                rounded(DQuat::from_rotation_arc(double(Self::UP), to) * double(Self::VIEW))
            }
            _ => Self::VIEW,
        }
    }

    /// Returns the default up direction for a view along `view`: [`Camera::UP`] or, if the view is
    /// along that axis, north on a map.
    pub fn up_for(view: [f32; 3]) -> [f32; 3] {
        let along = double(view).normalize_or_zero();
        if along != DVec3::ZERO && along.cross(double(Self::UP)).length() < LEVEL {
            [0.0, 0.0, -view[1].signum()]
        } else {
            Self::UP
        }
    }
}

impl<S: Coordinate> Camera<S> {
    /// Creates a camera at `eye` with `target` in the centre of its image and `up` pointing upward.
    ///
    /// `fov` is the vertical field of view in degrees, above 0 and below 180.
    ///
    /// # Errors
    /// Returns an error if a value is not finite, `fov` is out of range, `eye` and `target` are the
    /// same point, or `up` is zero or points along the view direction.
    pub fn new(eye: [S; 3], target: [S; 3], up: [f32; 3], fov: f64) -> Result<Self, CameraError> {
        let finite = |p: [S; 3]| p.iter().all(|x| x.is_finite());
        if !(finite(eye) && finite(target) && up.iter().all(|x| x.is_finite())) {
            return Err(CameraError::NotFinite);
        }
        if !(fov > 0.0 && fov < 180.0) {
            return Err(CameraError::Fov(fov));
        }
        let forward = (double(target) - double(eye)).try_normalize().ok_or(CameraError::NoView)?;
        let up = double(up).try_normalize().ok_or(CameraError::Up)?;
        let right = forward.cross(up);
        if right.length() < LEVEL {
            return Err(CameraError::Up);
        }
        let right = right.normalize();
        let half_height = (fov.to_radians() * 0.5).tan();
        Ok(Self { eye, right, up: right.cross(forward), forward, half_height })
    }

    /// Creates a camera with all `points` in its image: [`Camera::framing_from`] with
    /// [`Camera::VIEW`], [`Camera::UP`], and [`Camera::FOV`].
    ///
    /// `aspect` is the image's width divided by its height.
    ///
    /// # Errors
    /// Returns an error if the camera would be outside the range of its scalar, or if `aspect` is
    /// not positive and finite.
    pub fn framing(
        points: impl IntoIterator<Item = [S; 3]>,
        aspect: f64,
    ) -> Result<Self, CameraError> {
        Self::framing_from(points, Camera::VIEW, Camera::UP, Camera::FOV, aspect)
    }

    /// Creates a camera that is as close to the `points` as it can be with all of them in its
    /// image, except for a narrow margin. `view` is the direction from the points to the eye. If
    /// there are no points, the camera looks at the origin.
    ///
    /// ```text
    ///   left border                       right border
    ///            \      .   .     .       /
    ///             \  .    .    .   .     /       w, toward the eye
    ///              * . .     .      .  /         |
    ///               \     .    .     *          |
    ///                 \          /              +---- r, to the right
    ///                    \    /
    ///                      eye
    /// ```
    ///
    /// # Errors
    /// Returns an error under the same conditions as [`Camera::new`], with the reverse of `view` as
    /// the view direction, or if `aspect` is not positive and finite.
    pub fn framing_from(
        points: impl IntoIterator<Item = [S; 3]>,
        view: [f32; 3],
        up: [f32; 3],
        fov: f64,
        aspect: f64,
    ) -> Result<Self, CameraError> {
        const MARGIN: f64 = 1.1;
        if !(aspect > 0.0 && aspect.is_finite()) {
            return Err(CameraError::Aspect(aspect));
        }
        // The axes are those of a camera at `view` that looks at the origin.
        let Camera { right, up: top, forward, half_height, .. } =
            Camera::new(view, [0.0; 3], up, fov)?;
        let (half_width, half_height) = (half_height * aspect / MARGIN, half_height / MARGIN);

        // A point is in the image if |r - r of the eye| <= half_width * (w of the eye - w), and
        // similarly for up and down. Move each border outward until it contains all points.
        let mut borders = [f64::NEG_INFINITY; 4];
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for point in points {
            let point = double(point);
            let [r, u, w] = [point.dot(right), point.dot(top), -point.dot(forward)];
            let beyond = [r, -r, u, -u];
            for (border, (side, half)) in borders.iter_mut().zip(beyond.into_iter().zip([
                half_width,
                half_width,
                half_height,
                half_height,
            ])) {
                *border = border.max(side + half * w);
            }
            min = min.min(DVec3::new(r, u, w));
            max = max.max(DVec3::new(r, u, w));
        }
        if min.x > max.x {
            return Self::framing_from([[S::ZERO; 3]], view, up, fov, aspect);
        }

        // Each pair of opposite borders determines how far back the eye must be. The eye is placed
        // at the larger of the two distances, centred between the borders and behind the foremost
        // point.
        let [r_max, r_min, u_max, u_min] = borders;
        let size = (max - min).length();
        let near = max.z + if size > 0.0 { size * 0.01 } else { 1.0 };
        let w = ((r_max + r_min) / (2.0 * half_width))
            .max((u_max + u_min) / (2.0 * half_height))
            .max(near);
        let eye = right * ((r_max - r_min) * 0.5) + top * ((u_max - u_min) * 0.5) - forward * w;
        let target = eye + forward * (w - (min.z + max.z) * 0.5);
        Self::new(rounded(eye), rounded(target), up, fov)
    }

    /// Returns the eye: the origin of all camera rays.
    pub fn eye(&self) -> [S; 3] {
        self.eye
    }

    /// Returns the camera ray through the centre of pixel `(x, y)` in an image of `width`×`height`
    /// pixels. `x` grows to the right and `y` downward. `dir` has unit length up to rounding, so
    /// `t` is a distance. The interval is the default of [`RayOf::new`].
    pub fn ray(&self, x: u32, y: u32, width: u32, height: u32) -> RayOf<S> {
        // Pixels are square: both axes are measured in half heights of the image.
        let half = f64::from(height) * 0.5;
        let right = (f64::from(x) + 0.5 - f64::from(width) * 0.5) / half;
        let up = (half - f64::from(y) - 0.5) / half;
        let dir = self.forward
            + self.right * (right * self.half_height)
            + self.up * (up * self.half_height);
        RayOf::new(self.eye, rounded::<S>(dir.normalize()))
    }

    /// Returns the directions right, up, and into the image: three orthogonal unit vectors.
    pub fn axes(&self) -> [[f64; 3]; 3] {
        self.basis().map(|axis| axis.to_array())
    }

    /// Returns half the image plane's height at distance 1, which is the tangent of half the
    /// vertical field of view.
    pub fn half_height(&self) -> f64 {
        self.half_height
    }

    /// Returns [`Camera::axes`] as vectors.
    pub(crate) fn basis(&self) -> [DVec3; 3] {
        [self.right, self.up, self.forward]
    }
}

/// The reason that a camera is invalid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraError {
    /// A coordinate is NaN or infinite, or became infinite because the model is too large.
    NotFinite,
    /// The field of view is not between 0 and 180 degrees.
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
                "camera: a coordinate is not finite, or too large for its scalar; give finite numbers, or scale the model down"
            ),
            Self::Fov(fov) => {
                write!(f, "camera: a field of view of {fov} degrees; give one between 0 and 180")
            }
            Self::Aspect(aspect) => {
                write!(f, "camera: an aspect ratio of {aspect}; give a positive width and height")
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
        let camera: Camera = Camera::new([0.0, 0.0, 5.0], [0.0; 3], Camera::UP, 90.0).unwrap();
        assert_eq!(camera.ray(1, 1, 3, 3).dir, [0.0, 0.0, -1.0]);
        // With a field of view of 90 degrees, half the image's height equals the distance of the
        // image plane. In the top row of three, pixel centres are at 2/3 of that height.
        let top = camera.ray(1, 0, 3, 3).dir;
        assert!((top[1] / -top[2] - 2.0 / 3.0).abs() < 1e-6 && top[0] == 0.0);
        let right = camera.ray(2, 1, 3, 3).dir;
        assert!((right[0] / -right[2] - 2.0 / 3.0).abs() < 1e-6 && right[1] == 0.0);
    }

    #[test]
    fn framing_holds_every_point_and_wastes_little() {
        let corners = |min: [f32; 3], max: [f32; 3]| {
            let ends = [min, max];
            let corner = |i: usize| [ends[i & 1][0], ends[i >> 1 & 1][1], ends[i >> 2][2]];
            (0..8).map(corner).collect::<Vec<_>>()
        };
        let clouds = [
            corners([-1.0; 3], [1.0; 3]),
            corners([1e6, 0.0, -300.0], [1.0001e6, 100.0, 3.0]),
            corners([0.0, 0.0, 0.0], [50.0, 0.0, 1.0]),
            // Points that do not fill their bounding box.
            vec![[0.0; 3], [10.0, 0.0, 0.0], [10.0, 9.0, 1.0], [9.0, 8.0, 10.0]],
        ];
        for points in clouds {
            for aspect in [0.3, 1.0, 4.0 / 3.0, 3.0] {
                let camera = Camera::framing(points.iter().copied(), aspect).unwrap();
                // Project the points to an image whose borders are at -1 and 1.
                let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
                for &point in &points {
                    let arm = double(point) - double(camera.eye);
                    let depth = arm.dot(camera.forward) * camera.half_height;
                    assert!(depth > 0.0);
                    let place =
                        [arm.dot(camera.right) / depth / aspect, arm.dot(camera.up) / depth];
                    for axis in 0..2 {
                        min[axis] = min[axis].min(place[axis]);
                        max[axis] = max[axis].max(place[axis]);
                    }
                }
                // In one direction, the points almost reach both borders.
                let reach = (0..2).map(|axis| max[axis].min(-min[axis])).fold(0.0, f64::max);
                let most = max.into_iter().chain(min.map(|x| -x)).fold(0.0, f64::max);
                assert!(reach > 0.9 && most < 1.0, "{points:?} {aspect}: {min:?} {max:?}");
            }
        }
    }

    #[test]
    fn up_and_view_fit_each_other() {
        assert_eq!(Camera::up_for([0.0, 5.0, 0.0]), [0.0, 0.0, -1.0]);
        assert_eq!(Camera::up_for([1e-9, -1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(Camera::up_for([0.1, 1.0, 0.0]), Camera::UP);
        assert_eq!(Camera::view_for([0.0, 2.0, 0.0]), Camera::VIEW);
        let [x, y, z] = Camera::view_for([0.0, 0.0, 1.0]);
        let [right, up, back] = Camera::VIEW;
        assert!((x - right).abs() < 1e-6 && (y + back).abs() < 1e-6 && (z - up).abs() < 1e-6);
        assert_eq!(Camera::view_for([0.0; 3]), Camera::VIEW);
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
        assert!(Camera::framing([[2.0; 3]], 1.0).is_ok());
        assert!(Camera::<f32>::framing([], 1.0).is_ok());
        assert!(Camera::framing([[2.0; 3]], 0.0).is_err());
        let huge = [[f32::MIN; 3], [f32::MAX, 0.0, 0.0]];
        assert_eq!(Camera::framing(huge, 1.0), Err(CameraError::NotFinite));
    }
}
