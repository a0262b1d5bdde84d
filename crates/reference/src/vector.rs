//! A vector of three f64 values with document A's operators, and the square root that `core` lacks.

use core::ops::{Add, BitAnd, BitXor, Mul, Sub};

/// A point or a direction. `a & b` is the dot product and `a ^ b` the cross product.
///
/// Operations are evaluated in the order in which they are written. Each rounds once, and nothing
/// is fused. In Rust `&` and `^` bind more loosely than `+` and `*` but more tightly than `<`, and
/// `&` more tightly than `^`, so expressions that mix them need the same parentheses as in the
/// document.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector {
    /// The first coordinate.
    pub x: f64,
    /// The second coordinate.
    pub y: f64,
    /// The third coordinate.
    pub z: f64,
}

impl Vector {
    /// Creates a vector from its coordinates.
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    /// Returns the length: the square root of the vector's dot product with itself.
    #[expect(clippy::eq_op, reason = "`&` is the dot product")]
    pub fn length(self) -> f64 {
        sqrt(self & self)
    }

    /// Returns a vector of length 1 in the same direction: each component divided by the length.
    ///
    /// A vector whose length is 0, even by underflow (below 1e-162), is returned unchanged. A
    /// vector whose length overflows (above 1e154) becomes zero. A component that is not finite
    /// becomes NaN, and a NaN makes all three NaN.
    pub fn unit(self) -> Self {
        let len = self.length();
        if len == 0.0 { self } else { Self::new(self.x / len, self.y / len, self.z / len) }
    }
}

/// The dot product, summed from left to right.
impl BitAnd for Vector {
    type Output = f64;

    fn bitand(self, b: Self) -> f64 {
        self.x * b.x + self.y * b.y + self.z * b.z
    }
}

/// The cross product.
impl BitXor for Vector {
    type Output = Self;

    fn bitxor(self, b: Self) -> Self {
        Self {
            x: self.y * b.z - self.z * b.y,
            y: self.z * b.x - self.x * b.z,
            z: self.x * b.y - self.y * b.x,
        }
    }
}

impl Add for Vector {
    type Output = Self;

    fn add(self, b: Self) -> Self {
        Self { x: self.x + b.x, y: self.y + b.y, z: self.z + b.z }
    }
}

impl Sub for Vector {
    type Output = Self;

    fn sub(self, b: Self) -> Self {
        Self { x: self.x - b.x, y: self.y - b.y, z: self.z - b.z }
    }
}

impl Mul<f64> for Vector {
    type Output = Self;

    fn mul(self, s: f64) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

/// Converts exactly, because every f32 is also an f64.
impl From<[f32; 3]> for Vector {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self { x: f64::from(x), y: f64::from(y), z: f64::from(z) }
    }
}

impl From<[f64; 3]> for Vector {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<Vector> for [f64; 3] {
    fn from(v: Vector) -> Self {
        [v.x, v.y, v.z]
    }
}

/// Returns the correctly rounded square root, bit for bit as in IEEE 754: NaN for a negative
/// number, and `-0.0` for `-0.0`.
pub fn sqrt(x: f64) -> f64 {
    // These cases do not need arithmetic: 0, -0, NaN, and +inf are their own roots, and negative
    // numbers have no real root.
    if x == 0.0 || x.is_nan() || x == f64::INFINITY {
        return x;
    }
    if x < 0.0 {
        return f64::NAN;
    }

    // x = m * 2^e, where m is a 53-bit integer. The fraction of a subnormal is shifted until bit 52
    // is set.
    let bits = x.to_bits();
    let (mut m, mut e) = match (bits >> 52, bits & ((1 << 52) - 1)) {
        (0, fraction) => {
            let shift = fraction.leading_zeros() - 11;
            (fraction << shift, -1074 - shift as i32)
        }
        (exponent, fraction) => (fraction | 1 << 52, exponent as i32 - 1075),
    };

    // Make the exponent even, so that it halves exactly.
    if e % 2 != 0 {
        m <<= 1;
        e -= 1;
    }

    // The root of m * 2^54, rounded down, is 54 bits long: the 53 bits of the result and one bit
    // for rounding. The root is never exactly halfway between two results: such a root would be
    // odd, and so would its square, but m * 2^54 is even.
    let root = (u128::from(m) << 54).isqrt() as u64;
    let rounded = (root + 1) >> 1;

    // The result is rounded * 2^((e - 52) / 2). The leading bit adds 1 to the exponent field, and
    // so does a carry from rounding.
    let exponent = ((e - 52) / 2 + 1074) as u64;
    f64::from_bits((exponent << 52) + rounded)
}
