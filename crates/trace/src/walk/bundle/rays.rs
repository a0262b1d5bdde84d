//! The rays of a bundle: consecutive rays from one origin or toward one point.

use intertri::{Ray, RayId};

use super::reversed_shadow::CommonEnd;

/// Rays from one origin or toward one point.
#[derive(Clone, Copy)]
pub(crate) struct BundleRays<'a> {
    pub(crate) rays: &'a [Ray],
    /// The ID of the first ray.
    pub(crate) first: RayId,
    /// The rays that follow in the batch.
    pub(crate) next: &'a [Ray],
    /// The common end of the rays, if they are traced backward from there.
    pub(crate) reversed: Option<CommonEnd>,
}

impl BundleRays<'_> {
    /// Returns the point that all rays have in common.
    #[inline(always)]
    pub(crate) fn origin(&self) -> [f32; 3] {
        self.reversed.map_or(self.rays[0].origin, |end| end.point)
    }
}

/// Returns whether all rays start at the same point, bit for bit.
#[inline(always)]
pub(crate) fn shares_origin(rays: &[Ray]) -> bool {
    let [first, second, .., last] = rays else { return false };
    let origin = bits(first);
    let mut other = [0; 4];
    differ(origin, bits(second), &mut other);
    differ(origin, bits(last), &mut other);
    if other[..3] == [0; 3] {
        for ray in rays {
            differ(origin, bits(ray), &mut other);
        }
    }
    other[..3] == [0; 3]
}

/// Returns the bit patterns of a ray's components.
#[inline(always)]
fn bits(ray: &Ray) -> &[u32; 8] {
    bytemuck::cast_ref(ray)
}

/// Records the bits in which the first four components of two rays differ.
#[inline(always)]
fn differ(a: &[u32; 8], b: &[u32; 8], other: &mut [u32; 4]) {
    for k in 0..4 {
        other[k] |= a[k] ^ b[k];
    }
}
