//! The modes whose answers are document A's.

use crate::Threshold;
use crate::filter::Filter;
use crate::lanes64::Lanes64;
use crate::query::Mode;
use crate::simd::Level;

/// A mode with a threshold and a level of instructions.
macro_rules! mode {
    ($(#[$doc:meta])* $name:ident, $test:ident, $new:path) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name {
            threshold: Threshold,
            level: Level,
        }

        impl $name {
            /// The mode with a threshold of one's own, at this CPU's best level.
            pub fn new(threshold: Threshold) -> Self {
                Self { threshold, level: Level::best() }
            }

            /// The same mode at another level. The answers do not depend on it.
            pub fn at(self, level: Level) -> Self {
                Self { level, ..self }
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::new(Threshold::DEFAULT)
            }
        }

        impl Mode for $name {
            type Test = $test;

            #[inline]
            fn test(&self) -> $test {
                $new(self.threshold, self.level)
            }
        }
    };
}

mode! {
    /// f32 lanes under a proven bound, f64 where it does not decide: the answers of the scalar f64
    /// reference, bit for bit, at the speed of f32.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, Threshold, Triangle, simd::Level};
    /// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    /// let hit = Certified::default().closest(&[triangle], &ray);
    /// assert_eq!(hit.map(|hit| (hit.triangle, hit.t)), Some((0, 5.0)));
    /// assert_eq!(Certified::default().at(Level::PORTABLE).closest(&[triangle], &ray), hit);
    ///
    /// // In a scene of size 1e-7 the default threshold of 1e-9 is a distance.
    /// let small = Triangle::new([0.0, 0.0, 5e-10], [1e-7, 0.0, 5e-10], [0.0, 1e-7, 5e-10]);
    /// let ray = Ray::new([2e-8, 2e-8, 0.0], [0.0, 0.0, 1.0]);
    /// assert!(!Certified::default().any(&[small], &ray));
    /// assert!(Certified::new(Threshold::new(1e-30).unwrap()).any(&[small], &ray));
    /// ```
    Certified, Filter, Filter::certified
}

mode! {
    /// f64 lanes throughout: the answers of the scalar f64 reference, bit for bit. The plain way, to
    /// compare with.
    ///
    /// ```
    /// use intertri::{Double, Mode, Ray, Threshold, Triangle, simd::Level};
    /// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    /// let mode = Double::new(Threshold::new(1e-12).unwrap()).at(Level::PORTABLE);
    /// assert_eq!(mode.closest(&[triangle], &ray).map(|hit| hit.t), Some(5.0));
    /// ```
    Double, Lanes64, Lanes64::new
}
