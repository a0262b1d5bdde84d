//! Rays in the units of a tree, prepared for the slab test.

use intertri::Ray;
use intertri::simd::Simd;

use super::matrix::{TreeRay, largest};
use crate::tree::Margin;
use crate::walk::single::{Slabs, octant};

/// Origins must be nearer than this (2^49); otherwise every box counts as met.
const FAR: f64 = (1_u64 << 49) as f64;

/// The least length of a direction, whose inverse is the greatest: 2^-900.
const SHORT: f64 = f64::from_bits((1023 - 900) << 52);

/// A ray in a tree's units, with its direction scaled by a power of two to a length near 1.
pub(super) struct TreeSlabs {
    pub(super) slabs: Slabs,
    pub(super) octant: usize,
    /// The factor from a t of the ray to one of the slabs, a power of two.
    pub(super) unit: f64,
}

impl TreeSlabs {
    /// `None` if numbers are too large or too small for the slab test.
    #[inline(always)]
    pub(super) fn new<S: Simd>(ray: &TreeRay, reach: f32) -> Option<Self> {
        let length = largest(ray.dir);
        let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin, ray.dir);
        let is_near = (ox.abs() < FAR) & (oy.abs() < FAR) & (oz.abs() < FAR);
        let most = 1.0 / SHORT;
        let is_sane = (dx.abs() <= most) & (dy.abs() <= most) & (dz.abs() <= most);
        if !(is_near && is_sane && length >= SHORT) {
            return None;
        }
        // The largest power of two that is not larger, and its inverse.
        let exponent = length.to_bits() >> 52;
        let (unit, over) =
            (f64::from_bits(exponent << 52), f64::from_bits((2046 - exponent) << 52));
        // Scaled to a length between 1 and 2, because the bounds of the slab test exclude very long and very short
        // directions. A power of two rounds nothing.
        let origin = [ox as f32, oy as f32, oz as f32];
        let dir = [(dx * over) as f32, (dy * over) as f32, (dz * over) as f32];
        let scaled = Ray::new(origin, dir);
        let room = (ray.room as f32).next_up();
        let slabs = Slabs::new::<S>(&scaled, &Margin::new(reach, Some(room)))?;
        Some(Self { slabs, octant: octant(&scaled), unit })
    }
}

/// A t in the units of the slabs, rounded down, at least 0.
#[inline(always)]
pub(super) fn rounded_down(t: f64, unit: f64) -> f32 {
    let near = (t.max(0.0) * unit) as f32;
    near.next_down().max(0.0)
}

/// A t in the units of the slabs, rounded up.
#[inline(always)]
pub(super) fn rounded_up(t: f64, unit: f64) -> f32 {
    ((t * unit) as f32).next_up().max(f32::MIN_POSITIVE)
}
