//! Runs code that is generic over `Simd` with the instructions of one level.

use super::baseline::Baseline;
use super::level::{Kind, Level};
use super::level_lanes::Simd;
#[cfg(target_arch = "x86_64")]
use super::x86::{Avx2, Avx512};

/// Work that is written once, generic over [`Simd`], and compiled for every level.
///
/// `run` and the functions that it calls in its hot loops must be `#[inline(always)]`. A function
/// that is called rather than inlined is compiled without the level's instructions.
///
/// ```
/// use intertri::simd::{Lanes, Level, Mask, Simd, WithSimd};
///
/// /// Counts how many of eight numbers are negative.
/// struct Negative([f32; 8]);
/// impl WithSimd for Negative {
///     type Output = u32;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> u32 {
///         S::F32x8::load(&self.0).lt(S::F32x8::splat(0.0)).bits().count_ones()
///     }
/// }
/// for level in Level::all() {
///     assert_eq!(level.run(Negative([1.0, -2.0, 3.0, -4.0, 0.0, -0.0, f32::NAN, -5.0])), 3);
/// }
/// ```
pub trait WithSimd {
    /// The result of the work.
    type Output;
    /// Runs the work on the lanes of one level.
    fn run<S: Simd>(self) -> Self::Output;
}

impl Level {
    /// Runs the work on the lanes of this level.
    #[inline]
    pub fn run<W: WithSimd>(self, work: W) -> W::Output {
        match self.0 {
            Kind::Portable => enter::<Baseline, W>(work),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => enter::<Avx2, W>(work),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => enter::<Avx512, W>(work),
        }
    }
}

/// Runs the work on the lanes of a level that this CPU supports.
#[inline(always)]
fn enter<S: Simd, W: WithSimd>(work: W) -> W::Output {
    debug_assert!(Level::all().any(|level| level == S::LEVEL));
    // Here, baseline code calls code with the level's instructions, into which all code that uses
    // lanes is inlined. A few large functions are never inlined, and call `vectorize` themselves.
    S::vectorize(
        #[inline(always)]
        || work.run::<S>(),
    )
}

/// Runs the work on the widest lanes that this CPU supports.
///
/// ```
/// use intertri::simd::{Lanes, Simd, WithSimd, dispatch};
///
/// struct Sum<'a>(&'a [f32]);
/// impl WithSimd for Sum<'_> {
///     type Output = f32;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> f32 {
///         let mut sum = S::F32x8::splat(0.0);
///         for chunk in self.0.chunks_exact(8) {
///             sum = sum + S::F32x8::load(chunk);
///         }
///         let mut lanes = [0.0; 8];
///         sum.store(&mut lanes);
///         lanes.iter().sum()
///     }
/// }
/// assert_eq!(dispatch(Sum(&[1.0; 32])), 32.0);
/// ```
#[inline]
pub fn dispatch<W: WithSimd>(work: W) -> W::Output {
    Level::best().run(work)
}
