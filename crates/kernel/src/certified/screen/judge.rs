//! Who settles what the bound leaves open.

use crate::double::{Plane, replay};
use crate::{Ray, Triangle};

use super::super::Certified;

/// What settles the pairs of a ray and a triangle that a bound leaves open, both known by the caller's
/// numbers: the reference's own test, or one that is exact. All rays start at one point.
///
/// ```
/// use intertri::{Certified, Judge, Ray, Replay, Triangle};
///
/// /// A judge who prints what he is asked.
/// struct Loud<J>(J);
/// impl<J: Judge> Judge for Loud<J> {
///     type T = J::T;
///     type Seen = J::Seen;
///     fn see(&self, triangle: u32) -> J::Seen {
///         self.0.see(triangle)
///     }
///     fn t(&self, seen: &J::Seen, ray: usize) -> J::T {
///         self.0.t(seen, ray)
///     }
///     fn hit(&self, triangle: u32, ray: usize) -> Option<J::T> {
///         println!("does ray {ray} hit triangle {triangle}?");
///         self.0.hit(triangle, ray)
///     }
///     fn index(&self, triangle: u32) -> u32 {
///         self.0.index(triangle)
///     }
///     fn rounded(t: J::T) -> f32 {
///         J::rounded(t)
///     }
/// }
///
/// let wall = Triangle::new([0.0, 0.0, 3.0], [1.0, 0.0, 3.0], [0.0, 1.0, 3.0]);
/// let rays = [[0.0, 0.5, 3.0], [0.1, -0.1, 3.0]].map(|dir| Ray::new([0.0; 3], dir));
/// let mode = Certified::default();
/// let judge = Loud(Replay { mode: &mode, rays: &rays, find: |_| wall, index: |_| 0 });
/// assert_eq!((judge.hit(0, 0), judge.hit(0, 1)), (Some(1.0), None));
/// assert_eq!(judge.t(&judge.see(0), 0), 1.0);
/// ```
pub trait Judge {
    /// t, by which near hits are compared.
    type T: Copy + PartialOrd;
    /// What all rays have in common of a triangle.
    type Seen: Copy;
    /// A triangle from where the rays start.
    fn see(&self, triangle: u32) -> Self::Seen;
    /// t of a ray that is known to hit the triangle that was seen.
    fn t(&self, seen: &Self::Seen, ray: usize) -> Self::T;
    /// t of a ray, if it hits the triangle within its interval.
    fn hit(&self, triangle: u32, ray: usize) -> Option<Self::T>;
    /// The triangle's index: of equal t the lower wins.
    fn index(&self, triangle: u32) -> u32;
    /// t in f32, by two roundings to the nearest at most.
    fn rounded(t: Self::T) -> f32;
}

/// The judge of the mode's own answers: the document's operations in f64.
///
/// ```
/// use intertri::{Certified, Judge, Ray, Replay, Triangle};
/// let triangles = [3.0, 5.0].map(|z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]));
/// let (mode, rays) = (Certified::default(), [Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0])]);
/// let find = |number| triangles[number as usize];
/// let judge = Replay { mode: &mode, rays: &rays, find, index: |number| number };
/// assert_eq!((judge.hit(0, 0), judge.hit(1, 0)), (Some(3.0), Some(5.0)));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Replay<'a, T, I> {
    /// Whose answers they are.
    pub mode: &'a Certified,
    /// The rays by number.
    pub rays: &'a [Ray],
    /// A triangle by its number.
    pub find: T,
    /// The triangle's index.
    pub index: I,
}

impl<T: Fn(u32) -> Triangle, I: Fn(u32) -> u32> Judge for Replay<'_, T, I> {
    type T = f64;
    type Seen = Plane;

    #[inline(always)]
    fn see(&self, triangle: u32) -> Plane {
        Plane::new(&(self.find)(triangle), self.rays[0].origin)
    }

    #[inline(always)]
    fn t(&self, seen: &Plane, ray: usize) -> f64 {
        seen.t(self.rays[ray].dir)
    }

    #[inline(always)]
    fn hit(&self, triangle: u32, ray: usize) -> Option<f64> {
        replay(&self.rays[ray], &(self.find)(triangle), self.mode.threshold.get())
    }

    #[inline(always)]
    fn index(&self, triangle: u32) -> u32 {
        (self.index)(triangle)
    }

    #[inline(always)]
    fn rounded(t: f64) -> f32 {
        t as f32
    }
}
