//! Defines the view: an eye, its axes, and the image in front of the eye.
//!
//! ```text
//!                    up
//!                     |                     A pixel has a column x and a row y, counted from
//!          +----------|----------+          the top left. Its centre is (x + 0.5, y + 0.5), and
//!          |(0,0)     |          |          the line of sight through it has the direction
//!          |          o----------|-- right
//!          |         /           |            d = forward + right * X + up * Y
//!          |   forward           |
//!          +---------------(W,H)-+          with X in +-half_width, Y in +-half_height
//! ```
//!
//! A point at `eye + a` has the view depth `w = forward · a`, the factor by which `d` must be
//! scaled to reach the point. The inverse `q = 1 / w` is linear over the image within one plane. On
//! a ray whose direction has unit length, the point's `t` is `w * |d| = |d| / q`.

use std::fmt;

use crate::clip::Point4;
use crate::vector::{Vector, add, dot, double, length, scale, sub};

/// The number of fractional bits in pixel coordinates: each pixel is divided into `2^SUBPIXEL_BITS`
/// parts along each axis.
///
/// With 16 bits and at most 2^14 pixels per side, coordinates are at most 2^30, so all edge
/// arithmetic fits in i64.
pub const SUBPIXEL_BITS: u32 = 16;

/// The largest width and height of an image.
pub const MAX_SIDE: u32 = 1 << 14;

/// An eye and its image.
///
/// A tracer's rays from the same eye are `eye + t * d / |d|`, where `d` is the [`View::direction`]
/// at the centre of a pixel, up to rounding to f32. [`View::tolerance`] bounds the effect of that
/// rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    eye: Vector,
    right: Vector,
    up: Vector,
    forward: Vector,
    half_width: f64,
    half_height: f64,
    width: u32,
    height: u32,
}

/// The directions of lines of sight as a linear function of the position in the image:
/// `origin + x * dx + y * dy`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelDirections {
    pub(crate) origin: Vector,
    pub(crate) dx: Vector,
    pub(crate) dy: Vector,
}

impl View {
    /// Creates a view from `eye` along the axes right, up, and forward, with `width`×`height`
    /// square pixels. `half_height` is half the image's height at distance 1, which is the tangent
    /// of half the vertical field of view.
    ///
    /// # Errors
    /// Returns an error if a value is not finite, the axes are not orthonormal to 1e-9, half the
    /// height or width at distance 1 is not between 1e-9 and 1e9, or a side of the image is 0 or
    /// more than [`MAX_SIDE`].
    ///
    /// ```
    /// use intertri_raster::View;
    /// let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    /// let view = View::new([0.0; 3], axes, 0.5, 640, 480).unwrap();
    /// assert_eq!(view.direction(320.0, 0.0), [0.0, 0.5, -1.0]);
    /// ```
    pub fn new(
        eye: [f32; 3],
        [right, up, forward]: [[f64; 3]; 3],
        half_height: f64,
        width: u32,
        height: u32,
    ) -> Result<Self, ViewError> {
        if ![width, height].iter().all(|side| (1..=MAX_SIDE).contains(side)) {
            return Err(ViewError::Size(width, height));
        }
        if !eye.iter().all(|x| x.is_finite()) {
            return Err(ViewError::Eye);
        }
        let near = |a, b, wanted: f64| (dot(a, b) - wanted).abs() <= 1e-9;
        let unit = [right, up, forward].iter().all(|&axis| near(axis, axis, 1.0));
        let upright = near(right, up, 0.0) && near(up, forward, 0.0) && near(forward, right, 0.0);
        if !(unit && upright) {
            return Err(ViewError::Axes);
        }
        let half_width = half_height * f64::from(width) / f64::from(height);
        if !(half_height > 1e-9 && half_width > 1e-9 && half_height.max(half_width) < 1e9) {
            return Err(ViewError::Field(half_height));
        }
        Ok(Self { eye: double(eye), right, up, forward, half_width, half_height, width, height })
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the position of the eye.
    pub fn eye(&self) -> [f64; 3] {
        self.eye
    }

    /// Returns the axes right, up, and forward.
    pub(crate) fn axes(&self) -> [Vector; 3] {
        [self.right, self.up, self.forward]
    }

    /// Returns half the image's height at distance 1.
    pub(crate) fn half_height(&self) -> f64 {
        self.half_height
    }

    /// Returns the direction of the line of sight through a point in the image, given in pixels
    /// from the top left corner. Its component along `forward` is 1.
    pub fn direction(&self, x: f64, y: f64) -> [f64; 3] {
        let PixelDirections { origin, dx, dy } = self.pixel_directions();
        add(origin, add(scale(dx, x), scale(dy, y)))
    }

    /// Returns the [`View::direction`] through the centre of a pixel, and the length of that
    /// direction.
    pub(crate) fn through(&self, x: u32, y: u32) -> (Vector, f64) {
        let d = self.direction(f64::from(x) + 0.5, f64::from(y) + 0.5);
        (d, length(d))
    }

    /// Returns the directions as a linear function of the position in the image.
    pub(crate) fn pixel_directions(&self) -> PixelDirections {
        let across = scale(self.right, self.half_width);
        let above = scale(self.up, self.half_height);
        PixelDirections {
            origin: add(sub(self.forward, across), above),
            dx: scale(across, 2.0 / f64::from(self.width)),
            dy: scale(above, -2.0 / f64::from(self.height)),
        }
    }

    /// Returns the largest value of `|d|`, which occurs at the corners of the image.
    pub(crate) fn longest(&self) -> f64 {
        (1.0 + self.half_width * self.half_width + self.half_height * self.half_height).sqrt()
    }

    /// Returns the largest distance, in pixels, between an edge as seen by traced rays and the same
    /// edge in this crate's image.
    ///
    /// The value is the sum of two rounding errors, derived in `docs/raster.md`: the tracer rounds
    /// its directions to f32, and this crate snaps the corners of facets to 2^-16 of a pixel.
    pub fn tolerance(&self) -> f64 {
        let pixels = f64::from(self.height) / (2.0 * self.half_height);
        let longest = self.longest();
        let rounded_ray = 2f64.powi(-24) * longest * longest * pixels;
        let snapped = 2f64.powi(-(SUBPIXEL_BITS as i32));
        rounded_ray + snapped
    }

    /// Returns the view depth of `eye + arm`.
    pub(crate) fn depth(&self, arm: Vector) -> f64 {
        dot(self.forward, arm)
    }

    /// Projects a point at `eye + arm` (`weight` 1) or at infinity in the direction `arm` (`weight`
    /// 0) to the homogeneous coordinates of this image, with the near wall at the view depth `near`
    /// and the far wall at infinity.
    pub(crate) fn project(&self, arm: Vector, weight: f64, near: f64) -> Point4 {
        let w = self.depth(arm);
        Point4 {
            x: dot(self.right, arm) / self.half_width,
            y: dot(self.up, arm) / self.half_height,
            z: w - 2.0 * near * weight,
            w,
        }
    }

    /// Returns the position of a point in the image, in pixels from its top left corner.
    pub(crate) fn pixel(&self, point: Point4) -> [f64; 2] {
        let half = [self.width, self.height].map(|side| f64::from(side) * 0.5);
        [(1.0 + point.x / point.w) * half[0], (1.0 - point.y / point.w) * half[1]]
    }

    /// Returns [`View::pixel`] in integer fractions of a pixel, clamped to the image. NaN becomes
    /// 0.
    pub(crate) fn snap(&self, point: Point4) -> [i32; 2] {
        let [x, y] = self.pixel(point).map(|x| (x * f64::from(1 << SUBPIXEL_BITS)).round() as i32);
        let limit = |side: u32| (side << SUBPIXEL_BITS) as i32;
        [x.clamp(0, limit(self.width)), y.clamp(0, limit(self.height))]
    }
}

/// The reason that a view is invalid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewError {
    /// Width and height are not both between 1 and [`MAX_SIDE`].
    Size(u32, u32),
    /// A coordinate of the eye is NaN or infinite.
    Eye,
    /// The axes are not three orthogonal unit vectors.
    Axes,
    /// Half the image's height (or width) at distance 1 is not between 1e-9 and 1e9.
    Field(f64),
}

impl fmt::Display for ViewError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size(width, height) => write!(
                f,
                "raster: an image of {width}x{height} pixels; give each side 1 to {MAX_SIDE} pixels"
            ),
            Self::Eye => write!(f, "raster: the eye is not finite; give three finite numbers"),
            Self::Axes => write!(
                f,
                "raster: the axes of the view are not three unit vectors at right angles; normalize them"
            ),
            Self::Field(half) => write!(
                f,
                "raster: half the image's height at distance 1 is {half}; give a field of view between 0 and 180 degrees"
            ),
        }
    }
}

impl std::error::Error for ViewError {}
