//! Document D: computes texture coordinates from the barycentric coordinates of a hit, and looks up
//! textures.
//!
//! ```text
//!   t ^   c3                Each corner has texture coordinates (s, t). They are interpolated by the
//!     |   /\                barycentric coordinates, where u and v belong to c2 and c3:
//!   1 +--/--\--+            (s, t) = p1 + u (p2 - p1) + v (p3 - p1)
//!     | / .  \ |
//!     |c1-----c2            A texture is the unit square, and it repeats in both directions. The
//!     +--------+---> s      first row of an image is at its top, where t is 1.
//!              1
//! ```

use std::path::Path;

use glam::{DVec2, Vec3};

use crate::image::{Image, ImageError};
use crate::srgb::Srgb;

/// A pattern or image that covers a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// The document's pattern: the exclusive or of a texel's column and row numbers, modulo
    /// `texels`, the number of columns and rows. A result of 0 reflects the fraction `dark` of the
    /// light, and the largest result reflects all of the light.
    Xor {
        /// Texels per side, a power of two.
        texels: u32,
        /// The fraction of light that a result of 0 reflects.
        dark: f32,
    },
    /// An image, with bilinear filtering.
    Image(Image),
}

/// Interpolates the texture coordinates of a hit between those of the corners. The barycentric
/// coordinate `u` belongs to the second corner and `v` to the third.
///
/// ```
/// let corners = [[0.0, 0.0], [2.0, 0.0], [0.0, 4.0]];
/// assert_eq!(intertri_scene::place(&corners, 0.5, 0.25), [1.0, 1.0]);
/// ```
pub fn place(corners: &[[f32; 2]; 3], u: f64, v: f64) -> [f64; 2] {
    let [first, p, q] = ways(corners);
    (first + p * u + q * v).to_array()
}

/// Returns the first corner's texture coordinates, and the vectors from there to the coordinates of
/// the other two corners.
pub(crate) fn ways(corners: &[[f32; 2]; 3]) -> [DVec2; 3] {
    let [a, b, c] = corners.map(|[s, t]| DVec2::new(s.into(), t.into()));
    [a, b - a, c - a]
}

impl Texture {
    /// The XOR pattern for a whole model, with few texels and a wide range of light, so that it is
    /// recognizable at any image size and with any shading.
    pub const XOR: Self = Self::Xor { texels: 32, dark: 0.04 };

    /// Reads a PNG or JPEG file.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, is in neither format, or has more than
    /// [`crate::MAX_PIXELS`] pixels.
    pub fn load(path: &Path) -> Result<Self, ImageError> {
        Image::read(path).map(Self::Image)
    }

    /// Looks up the linear albedo at texture coordinates. For coordinates that are not finite, the
    /// result is the colour of an arbitrary texel.
    #[inline]
    pub fn color(&self, [s, t]: [f64; 2]) -> Vec3 {
        match self {
            Self::Xor { texels, dark } => {
                // Round down without calling the C library.
                let number = |x: f64| {
                    let x = x * f64::from(*texels);
                    let toward_zero = x as i64;
                    toward_zero.saturating_sub(i64::from(toward_zero as f64 > x))
                };
                let most = i64::from(*texels) - 1;
                let level = ((number(s) ^ number(t)) & most) as f32 / most.max(1) as f32;
                Vec3::splat(dark + (1.0 - dark) * level)
            }
            Self::Image(image) => {
                let srgb = Srgb::get();
                // Pixel centres are at integers here, and rows are counted downward.
                let size = [image.width(), image.height()];
                let x = (s - s.floor()) * f64::from(size[0]) - 0.5;
                let y = (t.ceil() - t) * f64::from(size[1]) - 0.5;
                let pixel = |dx: f64, dy: f64| {
                    let wrap = |x: f64, side: u32| (x.floor() as i64).rem_euclid(i64::from(side));
                    let (x, y) = (wrap(x + dx, size[0]), wrap(y + dy, size[1]));
                    let [r, g, b] = image.pixels()[y as usize * size[0] as usize + x as usize];
                    Vec3::from([r, g, b].map(|x| srgb.decode(x)))
                };
                let (right, down) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
                let above = pixel(0.0, 0.0).lerp(pixel(1.0, 0.0), right);
                above.lerp(pixel(0.0, 1.0).lerp(pixel(1.0, 1.0), right), down)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_xor_pattern_is_the_document_s() {
        // The document's triangle is 255 texels long, and its colour is 256 times the number.
        let texture = Texture::Xor { texels: 256, dark: 0.5 };
        for (x, y) in [(0, 0), (1, 0), (3, 5), (255, 255), (255, 0), (170, 85), (128, 127)] {
            let colour = texture.color([x, y].map(|i| (f64::from(i) + 0.5) / 256.0));
            let level = f64::from(x ^ y) as f32 / 255.0;
            assert_eq!(colour, Vec3::splat(0.5 + 0.5 * level));
        }
        // Unlike the document's pattern, which rounds toward zero, this pattern also repeats below
        // zero.
        let coarse = Texture::Xor { texels: 8, dark: 0.5 };
        assert_eq!(coarse.color([0.3, 0.9]), coarse.color([-0.7, 5.9]));
        assert!(coarse.color([0.3, 0.9]) != coarse.color([0.5, 0.9]));
    }

    #[test]
    fn an_image_stands_upright_and_repeats() {
        let mut image = Image::new(2, 2).unwrap();
        image.pixels_mut().copy_from_slice(&[[255; 3], [0; 3], [255, 0, 0], [0, 0, 255]]);
        let texture = Texture::Image(image);
        let at = |s, t| texture.color([s, t]).to_array();
        // Test the centres of the pixels.
        assert_eq!(at(0.25, 0.75), [1.0; 3]);
        assert_eq!(at(0.75, 0.75), [0.0; 3]);
        assert_eq!(at(0.25, 0.25), [1.0, 0.0, 0.0]);
        assert_eq!(at(-0.25, 7.25), [0.0, 0.0, 1.0]);
        // Test points halfway between two pixels and between all four, even across the border.
        assert_eq!(at(0.5, 0.75), [0.5; 3]);
        assert_eq!(at(0.0, 0.0), at(0.5, 0.5));
        assert_eq!(at(0.5, 0.5), [0.5, 0.25, 0.5]);
    }

    #[test]
    fn no_place_is_too_far() {
        let image = Texture::Image(Image::new(3, 5).unwrap());
        for texture in
            [Texture::Xor { texels: 256, dark: 0.5 }, Texture::Xor { texels: 1, dark: 0.5 }, image]
        {
            for far in [f64::NAN, f64::INFINITY, -1e300, 1e300, f64::MIN_POSITIVE, -0.0] {
                assert!(texture.color([far, 0.5]).is_finite() || far.is_infinite() || far.is_nan());
                texture.color([0.5, far]);
            }
        }
    }
}
