//! [`Threshold`], which decides whether a ray counts as parallel to a triangle and whether a hit is
//! too close to the ray's origin.

use core::fmt;

/// The `Threshold` of document A, which defines the `InterTri` test (`docs/documents.md`). A ray
/// counts as parallel to a triangle if the magnitude of the dot product of its direction and the
/// triangle's unit normal is below the threshold. A hit counts only if its t is above the
/// threshold.
///
/// ```
/// use intertri::{Mode, Ray, Threshold, Triangle};
/// let near = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
/// assert!(Mode::certified_with(Threshold::DEFAULT).any(&[near], &ray));
/// assert!(!Mode::certified_with(Threshold::new(5.0).unwrap()).any(&[near], &ray));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    exact: f64,
    /// The threshold rounded to f32.
    pub(crate) near: f32,
    /// The f32 value just below `near`.
    pub(crate) below: f32,
    /// The f32 value just above `near`.
    pub(crate) above: f32,
}

impl Threshold {
    /// The default: far above the rounding errors of f64 in a scene of unit size, and far below the
    /// size of its features.
    ///
    /// ```
    /// assert_eq!(intertri::Threshold::DEFAULT.get(), 1e-9);
    /// ```
    pub const DEFAULT: Self = Self::of(1e-9);

    /// No threshold: only exactly parallel rays count as parallel.
    ///
    /// ```
    /// use intertri::{Mode, Threshold};
    /// assert_eq!(Threshold::ZERO, Threshold::new(0.0).unwrap());
    /// let mode = Mode::certified_with(Threshold::ZERO);
    /// ```
    pub const ZERO: Self = Self::of(0.0);

    /// Creates a threshold.
    ///
    /// # Errors
    /// Returns an error if the threshold is negative, infinite, or NaN.
    ///
    /// ```
    /// use intertri::Threshold;
    /// assert_eq!(Threshold::new(0.0).unwrap().get(), 0.0);
    /// assert!(Threshold::new(-1.0).is_err());
    /// ```
    pub fn new(threshold: f64) -> Result<Self, BadThreshold> {
        if threshold >= 0.0 && threshold.is_finite() {
            Ok(Self::of(threshold))
        } else {
            Err(BadThreshold(threshold))
        }
    }

    const fn of(exact: f64) -> Self {
        // Rounding to f32 may move the threshold either way, so f32 lanes compare with the
        // neighbouring f32 value on the safe side.
        let near = exact as f32;
        Self { exact, near, below: near.next_down(), above: near.next_up() }
    }

    /// Returns the threshold as an f64.
    ///
    /// ```
    /// assert_eq!(intertri::Threshold::new(1e-6).unwrap().get(), 1e-6);
    /// ```
    #[inline(always)]
    pub fn get(self) -> f64 {
        self.exact
    }
}

impl Default for Threshold {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The error for a threshold that is negative, infinite, or NaN.
///
/// ```
/// let refused = intertri::Threshold::new(f64::NAN).unwrap_err();
/// assert!(refused.to_string().contains("finite"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BadThreshold(pub f64);

impl fmt::Display for BadThreshold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the threshold is {}, but must be finite and non-negative", self.0)
    }
}

impl core::error::Error for BadThreshold {}
