//! The choice of instructions: what the CPU has, and how work is run with it.

#[cfg(target_arch = "x86_64")]
use super::x86::{Avx2, Avx512, Sse41};
use super::{Simd, scalar::Scalar, wide::Wide};

/// A piece of work that is written once over [`Simd`] and compiled for every level.
///
/// `run` and whatever it calls in its hot loops must be `#[inline(always)]`: a function that is
/// called rather than inlined is compiled without the level's instructions.
///
/// ```
/// use intertri::lanes::{Lanes, Level, Mask, Simd, WithSimd};
///
/// /// How many of eight numbers are negative?
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
    /// What the work gives.
    type Output;
    /// The work, on the lanes of one level.
    fn run<S: Simd>(self) -> Self::Output;
}

/// A level of instructions that this CPU has.
///
/// There is no way to make one for a CPU that lacks it.
///
/// ```
/// use intertri::lanes::Level;
/// use intertri::{Certified, Mode, Ray, Triangle};
///
/// // The answers do not depend on it.
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.1, 0.0, 2.0]);
/// let answers = Level::all().map(|level| Certified::default().at(level).closest(&[wall], &ray));
/// assert!(answers.into_iter().all(|hit| hit == Certified::default().closest(&[wall], &ray)));
///
/// assert_eq!((Level::SCALAR.name(), Level::WIDE.name()), ("scalar", "wide"));
/// // A wider level is there only with the narrower.
/// assert!(Level::avx512().is_none() || Level::avx2().is_some());
/// assert!(Level::avx2().is_none() || Level::sse41().is_some());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Scalar,
    Wide,
    #[cfg(target_arch = "x86_64")]
    Sse41,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// Whether the CPU has all of some features: asked at run time with `std`, else of the build.
#[cfg(target_arch = "x86_64")]
macro_rules! has {
    ($($feature:tt),*) => {{
        #[cfg(feature = "std")]
        { true $(&& std::arch::is_x86_feature_detected!($feature))* }
        #[cfg(not(feature = "std"))]
        { true $(&& cfg!(target_feature = $feature))* }
    }};
}

impl Level {
    /// Plain numbers, one lane at a time.
    pub const SCALAR: Self = Self(Kind::Scalar);
    /// The crate `wide`, with the instructions that the build was compiled for.
    pub const WIDE: Self = Self(Kind::Wide);

    #[cfg(target_arch = "x86_64")]
    pub(super) const SSE41: Self = Self(Kind::Sse41);
    #[cfg(target_arch = "x86_64")]
    pub(super) const AVX2: Self = Self(Kind::Avx2);
    #[cfg(target_arch = "x86_64")]
    pub(super) const AVX512: Self = Self(Kind::Avx512);

    /// The level of [`Level::WIDE`] with 128-bit multiplication of integers, where the CPU has it.
    pub fn sse41() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if has!("sse4.1") {
            return Some(Self::SSE41);
        }
        None
    }

    /// The 256-bit level with fused multiply-add, where the CPU has it.
    ///
    /// ```
    /// if let Some(level) = intertri::lanes::Level::avx2() {
    ///     assert_eq!(level.name(), "avx2");
    /// }
    /// ```
    pub fn avx2() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if has!("avx2", "fma", "bmi1", "bmi2", "lzcnt", "popcnt") {
            return Some(Self::AVX2);
        }
        None
    }

    /// The 512-bit level, where the CPU has it.
    pub fn avx512() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if has!("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl") {
            return Self::avx2().and(Some(Self::AVX512));
        }
        None
    }

    /// The widest level of this CPU.
    pub fn best() -> Self {
        Self::avx512().or(Self::avx2()).or(Self::sse41()).unwrap_or(Self::WIDE)
    }

    /// Every level of this CPU, from the narrowest to the widest.
    ///
    /// ```
    /// use intertri::lanes::Level;
    /// assert!(Level::all().any(|level| level == Level::best()));
    /// ```
    pub fn all() -> impl Iterator<Item = Self> {
        let levels =
            [Some(Self::SCALAR), Some(Self::WIDE), Self::sse41(), Self::avx2(), Self::avx512()];
        levels.into_iter().flatten()
    }

    /// `scalar`, `wide`, `sse41`, `avx2` or `avx512`.
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Scalar => "scalar",
            Kind::Wide => "wide",
            #[cfg(target_arch = "x86_64")]
            Kind::Sse41 => "sse41",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
        }
    }

    /// Does the work on the lanes of this level.
    #[inline]
    pub fn run<W: WithSimd>(self, work: W) -> W::Output {
        match self.0 {
            Kind::Scalar => enter::<Scalar, W>(work),
            Kind::Wide => enter::<Wide, W>(work),
            #[cfg(target_arch = "x86_64")]
            Kind::Sse41 => enter::<Sse41, W>(work),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => enter::<Avx2, W>(work),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => enter::<Avx512, W>(work),
        }
    }
}

/// Does the work on the lanes of a level that this CPU has.
#[inline(always)]
fn enter<S: Simd, W: WithSimd>(work: W) -> W::Output {
    debug_assert!(Level::all().any(|level| level == S::LEVEL));
    S::vectorize(
        #[inline(always)]
        || work.run::<S>(),
    )
}

/// Does the work on the widest lanes of this CPU.
///
/// ```
/// use intertri::lanes::{Lanes, Simd, WithSimd, dispatch};
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

/// Asks for the memory of things that will be used soon, where the CPU can be asked.
///
/// ```
/// let far_away = vec![1.0_f32; 1000];
/// intertri::lanes::prefetch(&far_away[500..516]);
/// ```
#[inline(always)]
pub fn prefetch<T>(things: &[T]) {
    ask::<FIRST_CACHE, T>(things);
}

/// Asks for the memory of things that will be used some time later: to the second cache, so that they do not
/// take the place of what is used meanwhile.
///
/// ```
/// let far_away = vec![1.0_f32; 1000];
/// intertri::lanes::prefetch_early(&far_away[500..516]);
/// ```
#[inline(always)]
pub fn prefetch_early<T>(things: &[T]) {
    ask::<SECOND_CACHE, T>(things);
}

/// How x86 calls the caches: `_MM_HINT_T0` and `_MM_HINT_T1`.
const FIRST_CACHE: i32 = 3;
const SECOND_CACHE: i32 = 2;

#[allow(unsafe_code)]
#[inline(always)]
fn ask<const CACHE: i32, T>(things: &[T]) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..size_of_val(things).div_ceil(64) {
        let address = things.as_ptr().cast::<i8>().wrapping_add(64 * line);
        // SAFETY: a hint, of any address; every CPU of this kind has it.
        unsafe { core::arch::x86_64::_mm_prefetch::<CACHE>(address) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = things;
}
