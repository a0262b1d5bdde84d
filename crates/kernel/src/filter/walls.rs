//! Walls that rays run along: triangles perpendicular to an axis along which the direction is 0.
//!
//! ```text
//!     wall x = 5          D = d·n is exactly 0, because d has no component along x, and n has no other:
//!   ──┼──────────         there is no hit. A ray in the plane of the wall would otherwise be undecided
//!     │ ▲ ▲ ▲  d          for each of its triangles.
//! ```

use super::Filter;
use crate::packet::TriangleBlock;
use crate::resolve::Resolver;
use crate::simd::lanes_of;
use crate::{Ray, RayId};

impl Filter<'_> {
    /// Returns the axes along which the directions of all these rays are 0, a bit each, if the
    /// resolver is exact. No ray hits a triangle that is perpendicular to such an axis. `first` is the
    /// id of the first ray. The rays must have the same direction, but originals of copies may differ.
    #[doc(hidden)]
    #[inline(always)]
    pub fn level_axes(&self, rays: &[Ray], first: RayId) -> u8 {
        let is_exact = !matches!(self.resolver, Resolver::Document(_));
        let Some(ray) = rays.first().filter(|_| is_exact) else { return 0 };
        let mut axes = zeros(ray.dir.map(f32::to_bits));
        if let Resolver::Originals(originals) = self.resolver {
            // A component of a copy may be 0 because it is too small for f32.
            for id in (first.0..).take(rays.len()) {
                if axes == 0 {
                    break;
                }
                axes &= zeros(originals.ray(RayId(id)).dir.map(f64::to_bits));
            }
        }
        axes
    }

    /// Returns the lanes of one or two blocks whose triangles are perpendicular to one of the given
    /// axes. The second block begins at lane 8.
    #[inline(always)]
    pub(super) fn walls(
        &self,
        axes: u8,
        first: &TriangleBlock<8>,
        second: Option<&TriangleBlock<8>>,
    ) -> u32 {
        let lanes = |block| parallel_lanes(axes, self.room.copies, block);
        lanes(first) | second.map_or(0, lanes) << 8
    }
}

/// Returns the components that are 0, a bit each, given the bits of three numbers. The bits are
/// compared because a CPU may be set to read subnormal numbers as 0.
#[inline(always)]
fn zeros<B: Copy + Default + PartialEq + core::ops::Shl<u32, Output = B>>([x, y, z]: [B; 3]) -> u8 {
    let is_zero = |bits: B| u8::from(bits << 1 == B::default());
    is_zero(x) | is_zero(y) << 1 | is_zero(z) << 2
}

/// Returns the lanes whose triangles are perpendicular to one of the given axes.
#[inline(never)]
pub(super) fn parallel_lanes<const N: usize>(
    axes: u8,
    copies: bool,
    block: &TriangleBlock<N>,
) -> u32 {
    let mut lanes = 0;
    let [a, b, c] = block.corners();
    for axis in lanes_of(u32::from(axes)) {
        let [a, b, c] = [&a[axis % 3], &b[axis % 3], &c[axis % 3]];
        for lane in 0..N {
            // As above, compare bits. A copy has edges instead of the other corners, and these are 0
            // only if the coordinates of the original are the same.
            let [a, b, c] = [a, b, c].map(|row| row[lane].to_bits());
            let differ = if copies { (b | c) << 1 } else { a ^ b | b ^ c };
            lanes |= u32::from(differ == 0) << lane;
        }
    }
    lanes
}
