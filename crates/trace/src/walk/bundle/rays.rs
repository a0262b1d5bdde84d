//! Tests whether rays share an origin, end at one point, or share a direction.

use intertri::{Ray, RayId};

use super::reversed_shadow::CommonEnd;

/// Rays whose lines pass through one point, which may be at infinity.
#[derive(Clone, Copy)]
pub(crate) struct BundleRays<'a> {
    pub(crate) rays: &'a [Ray],
    /// The ID of the first ray.
    pub(crate) first: RayId,
    /// The rays that follow in the batch.
    pub(crate) next: &'a [Ray],
    pub(crate) common: Common,
}

/// What the rays of a bundle have in common.
#[derive(Clone, Copy)]
pub(crate) enum Common {
    Origin,
    /// An end. The rays are traced backward from there.
    End(CommonEnd),
    /// A direction.
    Direction {
        /// Whether the rays are traced backward, from infinity to their origins.
        reversed: bool,
    },
}

impl Common {
    /// Returns whether the rays are traced backward.
    #[inline(always)]
    pub(crate) fn is_reversed(self) -> bool {
        match self {
            Self::Origin => false,
            Self::End(_) => true,
            Self::Direction { reversed } => reversed,
        }
    }
}

/// Returns whether all rays start at the same point, bit for bit.
#[inline(always)]
pub(crate) fn shares_origin(rays: &[Ray]) -> bool {
    shared::<0>(rays).is_some()
}

/// Returns whether all rays have the same direction, bit for bit.
#[inline(always)]
pub(crate) fn shares_direction(rays: &[Ray]) -> bool {
    shared::<1>(rays).is_some()
}

/// If all rays have the same direction, returns whether none of them has a far end.
#[inline(always)]
pub(crate) fn endless_direction(rays: &[Ray]) -> Option<bool> {
    shared::<1>(rays).map(|is_same| is_same && rays[0].t_max == f32::INFINITY)
}

/// Checks whether the first three numbers in a half of all rays are the same. If so, returns whether
/// the fourth is also the same.
#[inline(always)]
fn shared<const HALF: usize>(rays: &[Ray]) -> Option<bool> {
    let [first, second, .., last] = rays else { return None };
    let first = bits::<HALF>(first);
    let mut other = [0; 4];
    differ(first, bits::<HALF>(second), &mut other);
    differ(first, bits::<HALF>(last), &mut other);
    if other[..3] == [0; 3] {
        for ray in rays {
            differ(first, bits::<HALF>(ray), &mut other);
        }
    }
    (other[..3] == [0; 3]).then_some(other[3] == 0)
}

/// Returns the bit patterns of half of a ray.
#[inline(always)]
fn bits<const HALF: usize>(ray: &Ray) -> &[u32; 4] {
    bytemuck::cast_ref(half(ray, HALF))
}

/// Records the bits in which four numbers differ.
#[inline(always)]
fn differ(a: &[u32; 4], b: &[u32; 4], other: &mut [u32; 4]) {
    for k in 0..4 {
        other[k] |= a[k] ^ b[k];
    }
}

/// Returns the origin and `t_min` of a ray, or its direction and `t_max`.
#[inline(always)]
pub(crate) fn half(ray: &Ray, half: usize) -> &[f32; 4] {
    let halves: &[[f32; 4]; 2] = bytemuck::cast_ref(ray);
    &halves[half]
}
