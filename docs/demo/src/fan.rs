//! A vertex where triangles meet, seen through a square of pixels that may be as small as f32 has steps.

use intertri::{Ray, RayPacket, Triangle};

use crate::input::{Numbers, double, single};
use crate::methods::{METHODS, Pairs, Sink};

/// Pixels of a side, at most.
const MAX_SIZE: usize = 1024;
/// Triangles of a fan, at most: what fits the bits of a pixel.
const MAX_CORNERS: usize = 8;

/// What a pixel is, against the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Class {
    /// Rightly no triangle.
    Background,
    /// Rightly hit: the same triangles as in truth.
    Right,
    /// Nothing is hit where something is.
    Leak,
    /// More triangles are hit than in truth, those of the truth among them.
    Double,
    /// Other triangles are hit.
    Wrong,
}

/// How many classes there are.
pub const CLASSES: usize = 5;

/// The fan and its rays.
#[derive(Clone, Debug)]
pub struct Fan {
    triangles: Vec<Triangle>,
    /// Rays that differ, and which of them each pixel has: pixels smaller than a step of f32 share some.
    packets: Vec<RayPacket<8>>,
    ray_of: Vec<u32>,
    /// A bit a triangle, for each ray.
    truth: Vec<u8>,
}

impl Fan {
    /// A fan from its numbers: pixels of a side, a pixel's width, two shifts of the picture's middle, the
    /// offset from the origin (3), right, up and forward (9), the distance of the eye, how many corners lie
    /// around, the vertex (3), the corners (3 each). `None` where they are none.
    ///
    /// Only `+ - * /` is done on them, so that they are the same rays everywhere.
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
        // Along a row nothing changes but the first product, along a column the second.
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

    /// Which triangles each ray hits by a method, as bits.
    fn hit_by(&self, method: usize) -> Vec<u8> {
        /// For each packet a byte a triangle, which has a bit a ray.
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

    /// How many pixels of each class a method has, and what each pixel is: the class in the low four bits,
    /// the first triangle of the truth above them.
    ///
    /// # Panics
    /// If there is no such method.
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

/// The directions of a square of pixels that differ from those to the left and above, and which of them each
/// pixel has.
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

/// Eight bytes of eight bits, rows as columns.
fn transposed(bits: u64) -> u64 {
    let swap = |x: u64, by: u32, mask: u64| {
        let differ = (x ^ x >> by) & mask;
        x ^ differ ^ differ << by
    };
    let x = swap(bits, 7, 0x00aa_00aa_00aa_00aa);
    let x = swap(x, 14, 0x0000_cccc_0000_cccc);
    swap(x, 28, 0x0000_0000_f0f0_f0f0)
}

/// What a pixel is whose triangles are these.
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
        // The zeros of two signs are two directions.
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
