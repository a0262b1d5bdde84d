//! Levels of instructions: what the CPU has.

/// A level of instructions that this CPU has.
///
/// There is no way to make one for a CPU that lacks it.
///
/// ```
/// use intertri::simd::Level;
/// use intertri::{Certified, Mode, Ray, Triangle};
///
/// // The answers do not depend on it.
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.1, 0.0, 2.0]);
/// let answers = Level::all().map(|level| Certified::default().at(level).closest(&[wall], &ray));
/// assert!(answers.into_iter().all(|hit| hit == Certified::default().closest(&[wall], &ray)));
///
/// assert_eq!(Level::PORTABLE.name(), "portable");
/// // A wider level is there only with the narrower.
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
    /// The crate `wide`, with the instructions that the build was compiled for: every CPU has it.
    pub const PORTABLE: Self = Self(Kind::Portable);

    #[cfg(target_arch = "x86_64")]
    pub(super) const AVX2: Self = Self(Kind::Avx2);
    #[cfg(target_arch = "x86_64")]
    pub(super) const AVX512: Self = Self(Kind::Avx512);

    /// The 256-bit level with fused multiply-add, where the CPU has it.
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
        Self::avx512().or(Self::avx2()).unwrap_or(Self::PORTABLE)
    }

    /// Every level of this CPU, from the narrowest to the widest.
    ///
    /// ```
    /// use intertri::simd::Level;
    /// assert!(Level::all().any(|level| level == Level::best()));
    /// ```
    pub fn all() -> impl Iterator<Item = Self> {
        [Some(Self::PORTABLE), Self::avx2(), Self::avx512()].into_iter().flatten()
    }

    /// `portable`, `avx2` or `avx512`.
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
        }
    }
}
