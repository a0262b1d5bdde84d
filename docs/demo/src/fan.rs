//! Computes the vertex view: the methods test one ray for each pixel of a square image against
//! triangles that share a vertex. A pixel can be smaller than the spacing of f32 numbers.

use intertri::{Ray, RayPacket, Triangle};

use crate::input::{Numbers, double, single};
use crate::methods::{METHODS, Pairs, Sink};

/// The maximum number of pixels along a side.
const MAX_SIZE: usize = 1024;
/// The maximum number of triangles in a fan: each has one bit in a `u8`.
const MAX_CORNERS: usize = 8;

/// The result of comparing a method's hits at a pixel with those of `exact`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Class {
    /// The method and `exact` both miss.
    Background,
    /// The method and `exact` hit the same triangles.
    Right,
    /// The method misses, but `exact` hits.
    Leak,
    /// The method hits the same triangles as `exact`, and at least one more.
    Double,
    /// The hits differ in any other way.
    Wrong,
}

/// The number of classes.
pub const CLASSES: usize = 5;

/// A fan of triangles around a vertex, and its rays.
#[derive(Clone, Debug)]
pub struct Fan {
    triangles: Vec<Triangle>,
    /// The distinct rays. Pixels smaller than the spacing of f32 numbers share rays.
    packets: Vec<RayPacket<8>>,
    /// The index of each pixel's ray.
    ray_of: Vec<u32>,
    /// The triangles that each ray hits according to `exact`, one bit per triangle.
    truth: Vec<u8>,
}

impl Fan {
    /// Reads a fan from a list of numbers, in this order: the number of pixels per side, the width
    /// of a pixel, the shift of the image's centre (2), the offset from the origin (3), the right,
    /// up, and forward directions (9), the distance of the eye, the number of corners around the
    /// vertex, the vertex (3), and the corners (3 each). Returns `None` if the numbers do not
    /// describe a fan.
    ///
    /// This function uses only `+ - * /`, so it returns the same bits on every platform.
    pub fn new(numbers: &[f64]) -> Option<Self> {
        let mut numbers = Numbers::new(numbers);
        let size = numbers.count(MAX_SIZE)?;
        let (pixel, shift) = (numbers.next()?, [numbers.next()?, numbers.next()?]);
        let offset = numbers.vector()?;
        let [right, up, forward] = [numbers.vector()?, numbers.vector()?, numbers.vector()?];
        let (distance, around) = (numbers.next()?, numbers.count(MAX_CORNERS)?);
        let moved = |p: [f64; 3]| single([0, 1, 2].map(|k| p[k] + offset[k]));
        let vertex = moved(numbers.vector()?);
        let corners: Vec<[f32; 3]> =
            (0..around).map(|_| numbers.vector().map(moved)).collect::<Option<_>>()?;
        let triangles: Vec<_> = (0..around)
            .map(|k| Triangle([vertex, corners[k], corners[(k + 1) % around]]))
            .collect();

        let middle = double(vertex);
        let eye = single([0, 1, 2].map(|k| middle[k] - distance * forward[k]));
        let from = double(eye);
        let half = (size / 2) as f64;
        // The product with `right` changes only along a row, and the product with `up` only along a
        // column, so each is computed once.
        let column = |x: usize| {
            let x = shift[0] + (x as f64 - half) * pixel;
            [0, 1, 2].map(|k| middle[k] + x * right[k])
        };
        let row = |y: usize| {
            let y = shift[1] + (half - y as f64) * pixel;
            up.map(|up| y * up)
        };
        let columns: Vec<_> = (0..size).map(column).collect();
        let rows: Vec<_> = (0..size).map(row).collect();
        let (dirs, ray_of) = differing(size, |column, row| {
            let (a, b) = (columns[column], rows[row]);
            single([0, 1, 2].map(|k| a[k] + b[k] - from[k]))
        });
        let packet = |dirs: &[[f32; 3]]| {
            let rays = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| Ray::new(eye, dirs[i.min(dirs.len() - 1)]));
            RayPacket::new(&rays[..dirs.len()])
        };
        let packets = dirs.chunks(8).map(packet).collect();
        let mut fan = Self { triangles, packets, ray_of, truth: vec![] };
        fan.truth = fan.hit_by(METHODS.len() - 1);
        Some(fan)
    }

    /// Returns the triangles that each ray hits according to a method, one bit per triangle.
    fn hit_by(&self, method: usize) -> Vec<u8> {
        /// One word per packet, with one byte per triangle and one bit per ray.
        struct Bits(Vec<u64>);
        impl Sink for Bits {
            #[inline]
            fn hits(&mut self, packet: usize, bits: u32, triangle: usize, _: &[f64; 8]) {
                self.0[packet] |= u64::from(bits) << (8 * triangle);
            }
        }
        let mut hit = Bits(vec![0; self.packets.len()]);
        let (packets, triangles) = (&self.packets[..], &self.triangles[..]);
        let pairs = Pairs { packets, triangles, closest: false };
        METHODS[method].run(pairs, &mut hit);
        hit.0.into_iter().flat_map(|bits| transposed(bits).to_le_bytes()).collect()
    }

    /// Returns the number of pixels in each class for a method, and one byte for each pixel. The
    /// low four bits hold the class, and the high bits hold the index of the first triangle that
    /// `exact` hits.
    ///
    /// # Panics
    /// Panics if the method does not exist.
    pub fn picture(&self, method: usize) -> ([u32; CLASSES], Vec<u8>) {
        let other = (method != METHODS.len() - 1).then(|| self.hit_by(method));
        let hit = other.as_ref().unwrap_or(&self.truth);
        let seen = |(&hit, &truth): (&u8, &u8)| {
            classify(hit, truth) as u8 | (truth.trailing_zeros() as u8 & 7) << 4
        };
        let of_rays: Vec<u8> = hit.iter().zip(&self.truth).map(seen).collect();
        let pixels: Vec<u8> = self.ray_of.iter().map(|&ray| of_rays[ray as usize]).collect();
        let mut counts = [0; CLASSES];
        for pixel in &pixels {
            counts[usize::from(pixel & 15)] += 1;
        }
        (counts, pixels)
    }
}

/// Computes the directions of a square of pixels, reusing the direction of the pixel to the left or
/// above if it is the same. Returns the distinct directions and the index of each pixel's
/// direction.
fn differing(size: usize, dir: impl Fn(usize, usize) -> [f32; 3]) -> (Vec<[f32; 3]>, Vec<u32>) {
    let (mut dirs, mut ray_of) = (Vec::with_capacity(size * size), Vec::with_capacity(size * size));
    let same = |a: [f32; 3], b: [f32; 3]| a.map(f32::to_bits) == b.map(f32::to_bits);
    for row in 0..size {
        for column in 0..size {
            let dir = dir(column, row);
            let known =
                [(column > 0, 1), (row > 0, size)].into_iter().find_map(|(is_there, back)| {
                    let ray: u32 = *is_there.then(|| &ray_of[ray_of.len() - back])?;
                    same(dirs[ray as usize], dir).then_some(ray)
                });
            ray_of.push(known.unwrap_or_else(|| {
                dirs.push(dir);
                dirs.len() as u32 - 1
            }));
        }
    }
    (dirs, ray_of)
}

/// Transposes an 8×8 matrix of bits, stored one row per byte.
fn transposed(bits: u64) -> u64 {
    let swap = |x: u64, by: u32, mask: u64| {
        let differ = (x ^ x >> by) & mask;
        x ^ differ ^ differ << by
    };
    let x = swap(bits, 7, 0x00aa_00aa_00aa_00aa);
    let x = swap(x, 14, 0x0000_cccc_0000_cccc);
    swap(x, 28, 0x0000_0000_f0f0_f0f0)
}

/// Classifies a pixel, given the sets of triangles that the method and `exact` hit.
fn classify(hit: u8, truth: u8) -> Class {
    match (hit, truth) {
        (0, 0) => Class::Background,
        _ if hit == truth => Class::Right,
        (0, _) => Class::Leak,
        _ if hit & truth == truth && truth != 0 => Class::Double,
        _ => Class::Wrong,
    }
}

#[cfg(test)]
mod tests {
    use super::{differing, transposed};

    #[test]
    fn rows_become_columns() {
        for (row, column) in [(0, 0), (0, 7), (7, 0), (3, 5), (6, 1)] {
            assert_eq!(transposed(1 << (8 * row + column)), 1 << (8 * column + row));
        }
        assert_eq!(transposed(0xff), 0x0101_0101_0101_0101);
    }

    #[test]
    fn each_pixel_has_its_own_ray() {
        // Directions that differ only in the sign of a zero count as different.
        let dir =
            |x: usize, y: usize| [(x / 2) as f32, y.min(2) as f32, if x < 6 { 0.0 } else { -0.0 }];
        let (dirs, ray_of) = differing(8, dir);
        assert_eq!(dirs.len(), 4 * 3);
        for (i, &ray) in ray_of.iter().enumerate() {
            let wanted = dir(i % 8, i / 8).map(f32::to_bits);
            assert_eq!(dirs[ray as usize].map(f32::to_bits), wanted, "{i}");
        }
    }
}
