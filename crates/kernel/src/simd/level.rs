//! Instruction levels: sets of SIMD instructions that the CPU supports.

#[cfg(all(feature = "std", target_arch = "x86_64"))]
use core::sync::atomic::{AtomicU8, Ordering};

/// An instruction level that this CPU supports.
///
/// You cannot create a level that the CPU does not support.
///
/// ```
/// use intertri::simd::Level;
/// use intertri::{Mode, Ray, Triangle};
///
/// // Results do not depend on the level.
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.1, 0.0, 2.0]);
/// let answers = Level::all().map(|level| Mode::certified().at(level).closest(&[wall], &ray));
/// assert!(answers.into_iter().all(|hit| hit == Mode::certified().closest(&[wall], &ray)));
///
/// assert!(["portable", "neon", "simd128"].contains(&Level::PORTABLE.name()));
/// // A CPU with a wider level also has the narrower ones.
/// assert!(Level::avx512().is_none() || Level::avx2().is_some());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level(pub(super) Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// The name of [`Level::PORTABLE`] on this target.
const PORTABLE_NAME: &str =
    if cfg!(all(target_arch = "aarch64", target_feature = "neon", target_endian = "little")) {
        "neon"
    } else if cfg!(all(target_arch = "wasm32", target_feature = "simd128")) {
        "simd128"
    } else {
        "portable"
    };

/// Checks whether the CPU has all of these features. With `std`, they are detected at run time;
/// otherwise, they are fixed by the build.
#[cfg(target_arch = "x86_64")]
macro_rules! has {
    ($($feature:tt),*) => {{
        #[cfg(feature = "std")]
        { true $(&& std::arch::is_x86_feature_detected!($feature))* }
        #[cfg(not(feature = "std"))]
        { true $(&& cfg!(target_feature = $feature))* }
    }};
}

/// The widest level, once it is known, stored as 1 plus its kind.
#[cfg(all(feature = "std", target_arch = "x86_64"))]
static BEST: AtomicU8 = AtomicU8::new(0);

impl Level {
    /// The level that every CPU of the build's target supports: NEON on 64-bit ARM; simd128 in
    /// WebAssembly that is built with it; otherwise, the `wide` crate with the instructions for
    /// which it was compiled.
    pub const PORTABLE: Self = Self(Kind::Portable);

    #[cfg(target_arch = "x86_64")]
    pub(super) const AVX2: Self = Self(Kind::Avx2);
    #[cfg(target_arch = "x86_64")]
    pub(super) const AVX512: Self = Self(Kind::Avx512);

    /// Returns the 256-bit level with fused multiply-add, if the CPU supports it.
    ///
    /// ```
    /// if let Some(level) = intertri::simd::Level::avx2() {
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

    /// Returns the 512-bit level, if the CPU supports it.
    pub fn avx512() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if has!("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl") {
            return Self::avx2().and(Some(Self::AVX512));
        }
        None
    }

    /// Returns the widest level that this CPU supports.
    #[inline]
    pub fn best() -> Self {
        #[cfg(all(feature = "std", target_arch = "x86_64"))]
        return match BEST.load(Ordering::Relaxed) {
            1 => Self::PORTABLE,
            2 => Self::AVX2,
            3 => Self::AVX512,
            _ => Self::find_best(),
        };
        #[cfg(not(all(feature = "std", target_arch = "x86_64")))]
        Self::avx512().or(Self::avx2()).unwrap_or(Self::PORTABLE)
    }

    /// Detects the widest level only once, because detection takes as long as a box test.
    #[cfg(all(feature = "std", target_arch = "x86_64"))]
    #[cold]
    fn find_best() -> Self {
        let best = Self::avx512().or(Self::avx2()).unwrap_or(Self::PORTABLE);
        BEST.store(1 + best.0 as u8, Ordering::Relaxed);
        best
    }

    /// Returns all levels that this CPU supports, from the narrowest to the widest.
    ///
    /// ```
    /// use intertri::simd::Level;
    /// assert!(Level::all().any(|level| level == Level::best()));
    /// ```
    pub fn all() -> impl Iterator<Item = Self> {
        [Some(Self::PORTABLE), Self::avx2(), Self::avx512()].into_iter().flatten()
    }

    /// Returns the name of the level: `avx2` or `avx512`; for the portable level, `neon` or
    /// `simd128` if it uses those instructions, otherwise `portable`.
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Portable => PORTABLE_NAME,
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
        }
    }
}
