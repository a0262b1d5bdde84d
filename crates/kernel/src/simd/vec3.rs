//! Three-dimensional vectors whose components are lanes: each [`Vec3`] holds N points or
//! directions.

use core::ops::{Add, Mul, Sub};

use super::lanes::Lanes;

/// N vectors in structure-of-arrays layout.
///
/// ```
/// use intertri::simd::{Lanes, Vec3};
///
/// // The normals of N triangles. A single f64 also counts as a lane.
/// fn normals<L: Lanes>([a, b, c]: [Vec3<L>; 3]) -> Vec3<L> {
///     (b - a).cross(c - a)
/// }
/// let corner = |x, y| Vec3::<f64>::splat([x, y, 5.0]);
/// let normal = normals([corner(0.0, 0.0), corner(2.0, 0.0), corner(0.0, 2.0)]);
/// assert_eq!((normal.x, normal.y, normal.z), (0.0, 0.0, 4.0));
/// assert_eq!((normal.dot(normal), normal.norm1(), (normal * -1.0).abs().z), (16.0, 4.0, 4.0));
///
/// // Fused versions, for use with an error bound.
/// assert_eq!(normal.dot_fused(normal), 16.0);
/// assert_eq!(normal.cross_fused(normal).norm1(), 0.0);
///
/// // To arrays and back.
/// let mut lanes = [[0.0]; 3];
/// (corner(1.0, 2.0) + corner(0.0, 0.0)).store(&mut lanes);
/// assert_eq!(lanes, [[1.0], [2.0], [10.0]]);
/// assert_eq!(Vec3::<f64>::load(&lanes).x, Vec3::<f64>::load_f32(&[[1.0], [2.0], [10.0]]).x);
/// ```
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Vec3<L> {
    /// The x components.
    pub x: L,
    /// The y components.
    pub y: L,
    /// The z components.
    pub z: L,
}

impl<L: Lanes> Vec3<L> {
    /// Copies a vector to every lane.
    #[inline(always)]
    pub fn splat([x, y, z]: [L::Scalar; 3]) -> Self {
        Self { x: L::splat(x), y: L::splat(y), z: L::splat(z) }
    }

    /// Loads the first N vectors from three arrays.
    #[inline(always)]
    pub fn load<const N: usize>([x, y, z]: &[[L::Scalar; N]; 3]) -> Self {
        Self { x: L::load(x), y: L::load(y), z: L::load(z) }
    }

    /// Writes the vectors to three arrays.
    #[inline(always)]
    pub fn store<const N: usize>(self, [x, y, z]: &mut [[L::Scalar; N]; 3]) {
        self.x.store(x);
        self.y.store(y);
        self.z.store(z);
    }

    /// Loads the first N vectors from three f32 arrays and converts them.
    #[inline(always)]
    pub fn load_f32<const N: usize>([x, y, z]: &[[f32; N]; 3]) -> Self {
        Self { x: L::load_f32(x), y: L::load_f32(y), z: L::load_f32(z) }
    }

    /// Returns `x x' + y y' + z z'`, evaluated left to right, with every operation rounded
    /// separately.
    #[inline(always)]
    pub fn dot(self, b: Self) -> L {
        self.x * b.x + self.y * b.y + self.z * b.z
    }

    /// Returns the cross product, with every operation rounded separately.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        Self {
            x: self.y * b.z - self.z * b.y,
            y: self.z * b.x - self.x * b.z,
            z: self.x * b.y - self.y * b.x,
        }
    }

    /// Returns the dot product, using fused operations if the CPU has them. The rounding therefore
    /// depends on the CPU, so allow for it with an error bound.
    #[inline(always)]
    pub fn dot_fused(self, b: Self) -> L {
        self.z.mul_add(b.z, self.y.mul_add(b.y, self.x * b.x))
    }

    /// Returns `c` plus the dot product, using fused operations if the CPU has them.
    #[inline(always)]
    pub(crate) fn dot_add(self, b: Self, c: L) -> L {
        self.z.mul_add(b.z, self.y.mul_add(b.y, self.x.mul_add(b.x, c)))
    }

    /// Returns the cross product, using fused operations if the CPU has them. The rounding
    /// therefore depends on the CPU, so allow for it with an error bound.
    #[inline(always)]
    pub fn cross_fused(self, b: Self) -> Self {
        Self {
            x: self.y.mul_add(b.z, -(self.z * b.y)),
            y: self.z.mul_add(b.x, -(self.x * b.z)),
            z: self.x.mul_add(b.y, -(self.y * b.x)),
        }
    }

    /// Returns the absolute value of each component.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// Returns the cross product with `+` in place of `-`. For vectors of absolute values, a bound
    /// on the cross product's rounding errors is proportional to this result.
    #[inline(always)]
    pub(crate) fn permanents(self, b: Self) -> Self {
        Self {
            x: self.y.mul_add(b.z, self.z * b.y),
            y: self.z.mul_add(b.x, self.x * b.z),
            z: self.x.mul_add(b.y, self.y * b.x),
        }
    }

    /// Returns `|x| + |y| + |z|`.
    #[inline(always)]
    pub fn norm1(self) -> L {
        self.x.abs() + self.y.abs() + self.z.abs()
    }
}

impl<L: Lanes<Scalar = f64>> Vec3<L> {
    /// Converts a vector to f64 and copies it to every lane.
    #[inline(always)]
    pub(crate) fn splat_f32([x, y, z]: [f32; 3]) -> Self {
        Self::splat([x.into(), y.into(), z.into()])
    }
}

impl<L: Lanes> Add for Vec3<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self { x: self.x + b.x, y: self.y + b.y, z: self.z + b.z }
    }
}

impl<L: Lanes> Sub for Vec3<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self { x: self.x - b.x, y: self.y - b.y, z: self.z - b.z }
    }
}

impl<L: Lanes> Mul<L> for Vec3<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: L) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}
