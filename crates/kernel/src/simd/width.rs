//! Packet widths: for a number of lanes N, [`Width`] provides the f32 and f64 lane types.

use super::lanes::Lanes;
use super::level_lanes::Simd;
use super::pair::Pair;

/// The lane types for a packet width, implemented by the marker [`Lane<N>`](Lane).
///
/// ```
/// use intertri::simd::{Lane, Width};
/// use intertri::{Mode, PreparedTriangle, RayPacket};
/// // Generic over the number of lanes.
/// fn hits<const N: usize>(mode: Mode, rays: &RayPacket<N>, triangle: &PreparedTriangle) -> u32
/// where
///     Lane<N>: Width,
/// {
///     mode.packet(rays, triangle).bits
/// }
/// ```
pub trait Width {
    /// Lanes of f32.
    type F<S: Simd>: Lanes<Scalar = f32>;
    /// Lanes of f64.
    type D<S: Simd>: Lanes<Scalar = f64>;
}

/// Marks a packet width of N lanes.
///
/// ```
/// use intertri::simd::{Lane, Lanes, Simd, Width, WithSimd, dispatch};
/// struct Count;
/// impl WithSimd for Count {
///     type Output = (usize, usize);
///     fn run<S: Simd>(self) -> (usize, usize) {
///         (<Lane<16> as Width>::F::<S>::N, <Lane<4> as Width>::D::<S>::N)
///     }
/// }
/// assert_eq!(dispatch(Count), (16, 4));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Lane<const N: usize>;

impl Width for Lane<4> {
    type F<S: Simd> = S::F32x4;
    type D<S: Simd> = S::F64x4;
}
impl Width for Lane<8> {
    type F<S: Simd> = S::F32x8;
    type D<S: Simd> = S::F64x8;
}
impl Width for Lane<16> {
    type F<S: Simd> = S::F32x16;
    type D<S: Simd> = Pair<S::F64x8>;
}
