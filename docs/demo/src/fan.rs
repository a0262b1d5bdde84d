//! A vertex where triangles meet, seen through a square of pixels that may be as small as f32 has steps.

use intertri::{Ray, RayPacket, Triangle};

use crate::input::{Numbers, along, double, single};
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
    packets: Vec<RayPacket<8>>,
    size: usize,
    /// A bit a triangle, for each pixel.
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
        let half = (size / 2) as f64;
        let ray = |i: usize| {
            let (x, y) = ((i % size) as f64 - half, half - (i / size) as f64);
            let at = along(middle, [right, up], shift[0] + x * pixel, shift[1] + y * pixel);
            Ray::new(eye, single([0, 1, 2].map(|k| at[k] - f64::from(eye[k]))))
        };
        let rays: Vec<Ray> = (0..size * size).map(ray).collect();
        let packets = rays.chunks(8).map(RayPacket::new).collect();
        let mut fan = Self { triangles, packets, size, truth: vec![] };
        fan.truth = fan.hit_by(METHODS.len() - 1);
        Some(fan)
    }

    /// Which triangles each pixel hits by a method, as bits.
    fn hit_by(&self, method: usize) -> Vec<u8> {
        struct Bits(Vec<u8>);
        impl Sink for Bits {
            #[inline]
            fn hits(&mut self, packet: usize, bits: u32, triangle: usize, _: &[f64; 8]) {
                for (lane, hit) in self.0[8 * packet..].iter_mut().take(8).enumerate() {
                    *hit |= ((bits >> lane & 1) as u8) << triangle;
                }
            }
        }
        let mut hit = Bits(vec![0; self.size * self.size]);
        let (packets, triangles) = (&self.packets[..], &self.triangles[..]);
        let pairs = Pairs { packets, triangles, closest: false };
        METHODS[method].run(pairs, &mut hit);
        hit.0
    }

    /// How many pixels of each class a method has, and what each pixel is: the class in the low four bits,
    /// the first triangle of the truth above them.
    ///
    /// # Panics
    /// If there is no such method.
    pub fn picture(&self, method: usize) -> ([u32; CLASSES], Vec<u8>) {
        let mut counts = [0; CLASSES];
        let hit =
            if method == METHODS.len() - 1 { self.truth.clone() } else { self.hit_by(method) };
        let pixel = |(&hit, &truth): (&u8, &u8)| {
            let class = classify(hit, truth);
            counts[class as usize] += 1;
            class as u8 | (truth.trailing_zeros() as u8 & 7) << 4
        };
        let pixels = hit.iter().zip(&self.truth).map(pixel).collect();
        (counts, pixels)
    }
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
