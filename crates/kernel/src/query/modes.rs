//! The modes for f32 as they are: two whose answers are document A's, and one that is exact.

use alloc::vec::Vec;

use crate::exact;
use crate::filter::Filter;
use crate::lanes64::Lanes64;
use crate::query::{Mode, in_f64};
use crate::simd::Level;
use crate::{Crossing, Hit, Ray, Ray64, Threshold, Triangle, Triangle64};

/// A mode with a threshold and a level of instructions.
macro_rules! mode {
    ($(#[$doc:meta])* $name:ident, $test:ty, $new:path) => {
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
    Certified, Filter<'static>, Filter::certified
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

/// f32 lanes under a proven bound, and exact arithmetic where it does not decide: right on the coordinates
/// as given, at the speed of f32.
///
/// A ray hits the closed triangle: edges and corners belong to every triangle that has them, so that no
/// ray slips through a mesh where two of its triangles share an edge. It hits iff `t > 0` and
/// `t_min <= t < t_max`, all exactly; a ray that starts on a triangle does not hit it there, nor is one hit
/// that is parallel to the ray or without area. t, u and v are the true numbers, each rounded once. Of
/// equal t the lower index is closer. Definition and proof: `docs/numerics/exact.md`.
///
/// ```
/// use intertri::{Exact, Mode, Ray, Triangle, simd::Level};
/// // A square of two triangles, and a ray exactly through their common edge.
/// let [a, b, c, d] = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0], [1.0, 1.0, 5.0]];
/// let square = [Triangle::new(a, b, c), Triangle::new(d, c, b)];
/// let ray = Ray::new([0.3, 0.7, 0.0], [0.0, 0.0, 3.0]);
/// let hit = Exact::default().closest(&square, &ray).unwrap();
/// assert_eq!((hit.triangle, hit.t), (0, 5.0 / 3.0));
/// assert_eq!(Exact::at(Level::PORTABLE).closest(&square, &ray), Some(hit));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    level: Level,
}

impl Exact {
    /// The mode at a level of instructions. The answers do not depend on it.
    pub fn at(level: Level) -> Self {
        Self { level }
    }
}

/// The queries of [`Mode`] of what is given in f64.
///
/// ```
/// use intertri::{Exact, Ray64, Triangle64};
/// // A wall at UTM coordinates, and a ray that leaves it a nanometre away.
/// let [x, y] = [148_376.0, 528_980.0];
/// let wall = Triangle64([[x, y, 0.0], [x, y + 4.0, 0.0], [x, y, 3.0]]);
/// let ray = |way| Ray64::new([x + 1e-9, y + 1.0, 1.0], [way, 0.0, 0.0]);
/// let mode = Exact::default();
/// assert!(!mode.any64(&[wall], &ray(1.0)));
/// assert_eq!(mode.closest64(&[wall], &ray(-1.0)).map(|hit| hit.t), Some(ray(1.0).origin[0] - x));
/// ```
impl Exact {
    /// [`Mode::closest`] of what is given in f64.
    pub fn closest64(&self, triangles: &[Triangle64], ray: &Ray64) -> Option<Hit> {
        in_f64::closest(self.level, triangles, ray)
    }

    /// [`Mode::any`] of what is given in f64.
    pub fn any64(&self, triangles: &[Triangle64], ray: &Ray64) -> bool {
        in_f64::any(self.level, triangles, ray)
    }

    /// [`Mode::all`] of what is given in f64.
    ///
    /// ```
    /// use intertri::{Exact, Ray64, Triangle64};
    /// let at = |z| Triangle64::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let ray = Ray64::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    /// let hits = Exact::default().all64(&[at(1e9), at(-1.0), at(3.0)], &ray);
    /// assert!(hits.iter().map(|hit| hit.t).eq([3.0, 1e9]));
    /// ```
    pub fn all64(&self, triangles: &[Triangle64], ray: &Ray64) -> Vec<Hit> {
        in_f64::all(self.level, triangles, ray)
    }
}

impl Exact {
    /// Where a ray crosses the triangles, in order of the exact t; of equal t, of the index.
    ///
    /// A point on an edge or a corner belongs to one of the triangles that have it, as if the ray's
    /// direction were moved by (ε, ε², ε³): through a closed mesh a ray goes once where it meets an edge,
    /// and from where it starts the crossings with the normal, less those against it, are what the mesh
    /// winds around that point. Each crossing is a hit, too.
    pub fn crossings(&self, triangles: &[Triangle], ray: &Ray) -> Vec<Crossing> {
        let crossing = |hit: Hit| {
            let triangle = &triangles[hit.triangle as usize];
            let leaves = exact::crossing(ray, triangle)? == exact::Side::Leaves;
            Some(Crossing { hit, leaves })
        };
        self.all(triangles, ray).into_iter().filter_map(crossing).collect()
    }
}

impl Default for Exact {
    fn default() -> Self {
        Self::at(Level::best())
    }
}

impl Mode for Exact {
    type Test = Filter<'static>;

    #[inline]
    fn test(&self) -> Filter<'static> {
        Filter::exact(self.level)
    }
}
