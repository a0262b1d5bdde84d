//! SIMD lanes. This is the only module that depends on the CPU's instructions.
//!
//! Every algorithm is written once, generic over [`Lanes`] or [`Simd`], and [`dispatch`] runs it on
//! the CPU's widest registers. All `unsafe` code of the library crates is in this folder.
//!
//! ```text
//!   algorithm<S: Simd>  ──►  dispatch ──► Baseline what every CPU of the target has: 128-bit NEON
//!                                    │            or simd128 registers, otherwise the `wide` crate
//!                                    ├──► Avx2     256 bits, fused multiply-add
//!                                    └──► Avx512   512 bits, mask registers
//! ```

/// Calls an intrinsic of an instruction level, for the modules that implement registers.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
#[allow(unused_macros)]
macro_rules! cpu {
    ($call:expr) => {
        // SAFETY: lanes of this level exist only if the CPU has its instructions.
        unsafe { $call }
    };
}

// The baseline of the build target: 128-bit registers if their instructions are implemented here,
// otherwise `wide`.
#[cfg(not(any(
    all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"),
    all(target_arch = "wasm32", target_feature = "simd128")
)))]
#[path = "portable.rs"]
mod baseline;
#[cfg(any(
    all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"),
    all(target_arch = "wasm32", target_feature = "simd128")
))]
#[path = "quad/mod.rs"]
mod baseline;
mod dispatch;
mod int;
mod lanes;
mod level;
mod level_lanes;
mod pair;
mod pods;
mod prefetch;
mod scalar;
#[cfg(test)]
mod tests;
mod vec3;
mod width;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use dispatch::{WithSimd, dispatch};
pub use int::Ints;
#[doc(hidden)]
pub use lanes::lanes_of;
pub use lanes::{Lanes, Mask};
pub use level::Level;
pub use level_lanes::Simd;
pub(crate) use level_lanes::{by_triangle, put_by_triangle};
pub use pair::Pair;
pub use prefetch::{prefetch, prefetch_early};
pub use vec3::Vec3;
pub use width::{Lane, Width};
