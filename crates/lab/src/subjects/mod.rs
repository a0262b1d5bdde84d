//! The subjects: the known ways to test a ray against a triangle, one file each, written once for any
//! number of lanes of f32 or f64.
//!
//! All of them are two-sided, count a point on a side or corner as inside where their own arithmetic
//! puts it there, and want `t > 0` (or their source's epsilon). All accept by `>=` and `>`, so that a
//! NaN is a miss. What a method computes once for a triangle or for a ray is its own type, so that it
//! is not paid for at every test. Products are not fused: none of the sources counts on it.
//!
//! A new method is a file with an implementation of [`Method`], and a line in the table [`SUBJECTS`].

mod axis;
pub mod badouel;
pub mod baldwin_weber;
pub mod cramer;
pub mod embree;
mod forms;
pub mod inter_tri;
mod kernel;
pub mod moller_trumbore;
mod one_origin;
pub mod pluecker;
pub mod signed_volume;
mod table;
pub mod woop;

use intertri::Vec3;
use intertri::lanes::Lanes;

pub use forms::{Answer, Bundle, Form, Layout, Nearest};
pub use kernel::{on_grid, reference_closest};
pub use table::{OF_THE_REFERENCE, SUBJECTS, Subject};

/// f32 or f64: what the lanes of a method can be made of.
pub trait Number: Copy + Into<f64> + Lanes<Scalar = Self> {
    /// How many significant bits it has.
    const BITS: u32;
    /// One unit in the last place of 1.
    const UNIT: f64;
    /// The nearest to an f64.
    fn nearest(x: f64) -> Self;
}

impl Number for f32 {
    const BITS: u32 = Self::MANTISSA_DIGITS;
    const UNIT: f64 = Self::EPSILON as f64;
    #[inline(always)]
    fn nearest(x: f64) -> Self {
        x as Self
    }
}

impl Number for f64 {
    const BITS: u32 = Self::MANTISSA_DIGITS;
    const UNIT: f64 = Self::EPSILON;
    #[inline(always)]
    fn nearest(x: f64) -> Self {
        x
    }
}

/// Lanes of f32 or f64.
pub trait Real: Lanes<Scalar: Number> {
    /// A constant in every lane.
    #[inline(always)]
    fn of(x: f64) -> Self {
        Self::splat(Self::Scalar::nearest(x))
    }
}

impl<L: Lanes<Scalar: Number>> Real for L {}

/// A way to test a ray against a triangle.
pub trait Method: Copy {
    /// A ray with what is computed from it once.
    type Ray<L: Real>: Copy;
    /// A triangle with what is computed from it once.
    type Triangle<L: Real>: Copy;

    /// Rays from their origins and directions.
    fn ray<L: Real>(self, origin: Vec3<L>, dir: Vec3<L>) -> Self::Ray<L>;

    /// Triangles from their three corners.
    fn triangle<L: Real>(self, corners: [Vec3<L>; 3]) -> Self::Triangle<L>;

    /// One triangle in all lanes: how it meets many rays after it was stored once.
    fn spread<L: Real>(one: &Self::Triangle<L::Scalar>) -> Self::Triangle<L>;

    /// Which lanes are hits, and their `t`, which means nothing where there is no hit.
    fn test<L: Real>(self, triangle: &Self::Triangle<L>, ray: &Self::Ray<L>) -> (L::Mask, L);
}

/// One vector in all lanes.
#[inline(always)]
fn splat<L: Real>(v: Vec3<L::Scalar>) -> Vec3<L> {
    Vec3::splat([v.x, v.y, v.z])
}

/// Three vectors in all lanes. (`map` of an array is not always inlined, and a function that is called
/// is compiled without the level's instructions: so it is spelled out here and in the tests.)
#[inline(always)]
fn splat3<L: Real>([a, b, c]: [Vec3<L::Scalar>; 3]) -> [Vec3<L>; 3] {
    [splat(a), splat(b), splat(c)]
}

/// A ray for which nothing is computed in advance.
#[derive(Clone, Copy, Debug)]
pub struct PlainRay<L> {
    /// Where `t` is 0.
    pub origin: Vec3<L>,
    /// The unit of `t`.
    pub dir: Vec3<L>,
}

#[cfg(test)]
mod tests;
