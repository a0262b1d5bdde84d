//! Finds the longest axis of a vector and permutes vectors so that this axis comes last.

use intertri::simd::Vec3;
use intertri::simd::{Lanes, Mask};

/// The axis of each lane's largest component.
///
/// If one ray is tested against many triangles, or one triangle against many rays, the axis is the
/// same in all lanes and a permutation costs nothing. Otherwise, it costs six selections.
#[derive(Clone, Copy)]
pub(super) enum Axis<M> {
    /// The same axis in every lane.
    Same(usize),
    /// The x axis in the lanes of the first mask, the y axis in the lanes of the second, and the z
    /// axis in the other lanes.
    Mixed(M, M),
}

impl<M: Mask> Axis<M> {
    /// Returns the axis of each lane's largest component. If a component is NaN, the axis may not
    /// be that of the largest.
    #[inline(always)]
    pub(super) fn longest<L: Lanes<Mask = M>>(v: Vec3<L>) -> Self {
        let (ax, ay, az) = (v.x.abs(), v.y.abs(), v.z.abs());
        let x = ax.ge(ay) & ax.ge(az);
        let y = ay.ge(az) & !x;
        let all = ((1_u64 << M::N) - 1) as u32;
        match (x.bits(), y.bits()) {
            (0, 0) => Self::Same(2),
            (0, bits) if bits == all => Self::Same(1),
            (bits, _) if bits == all => Self::Same(0),
            _ => Self::Mixed(x, y),
        }
    }

    /// Copies the axis of a single lane to all lanes of a wider type.
    #[inline(always)]
    pub(super) fn spread<N: Mask>(self) -> Axis<N> {
        let all = |mask: M| N::from_bits(if mask.any() { u32::MAX } else { 0 });
        match self {
            Self::Same(axis) => Axis::Same(axis),
            Self::Mixed(x, y) => Axis::Mixed(all(x), all(y)),
        }
    }

    /// Permutes a vector cyclically so that each lane's axis becomes z.
    #[inline(always)]
    pub(super) fn turn<L: Lanes<Mask = M>>(self, v: Vec3<L>) -> Vec3<L> {
        match self {
            Self::Same(0) => Vec3 { x: v.y, y: v.z, z: v.x },
            Self::Same(1) => Vec3 { x: v.z, y: v.x, z: v.y },
            Self::Same(_) => v,
            Self::Mixed(x, y) => {
                let pick = |of_x, of_y, of_z| L::select(x, of_x, L::select(y, of_y, of_z));
                Vec3 { x: pick(v.y, v.z, v.x), y: pick(v.z, v.x, v.y), z: pick(v.x, v.y, v.z) }
            }
        }
    }
}
