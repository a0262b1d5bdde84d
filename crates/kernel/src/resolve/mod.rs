//! What settles the pairs of a ray and a triangle that the f32 filter leaves undecided.
//!
//! ```text
//!   filter (f32 lanes) ──► surely a miss      nearly all
//!                     ├──► surely a hit       its t lies in an f32 interval
//!                     └──► undecided ──► Resolver ──► document   the f64 operations of document A
//!                                                ├──► grid       integers of a grid
//!                                                ├──► exact      f64 under a bound, or integers
//!                                                └──► originals  the same, of what is given in f64
//! ```
//!
//! A mode is this and nothing else: the filter and the walk through a hierarchy are the same for all.
//! The set is closed. A resolver is asked rarely and out of line, so that no code is compiled again for
//! one.

mod exact;
mod grid;
mod originals;
mod shared_origin;

pub use originals::Originals;
pub use shared_origin::SharedOrigin;

use core::cmp::Ordering;

use crate::exact::Side;
use crate::hit_attributes::Pairs;
use crate::simd::Simd;
use crate::{Hit, Ray, Triangle, document};

/// What settles undecided pairs, one at a time.
#[derive(Clone, Copy, Debug)]
pub enum Resolver<'a> {
    /// The operations of document A in f64, with this threshold.
    Document(f64),
    /// Integers: for rays and triangles of a grid, in f32, which hold them exactly.
    Grid,
    /// Right on the coordinates as given; edges and corners belong to every triangle that has them.
    Exact,
    /// The same of originals, of which the filter has seen copies.
    Originals(&'a dyn Originals),
}

impl<'a> Resolver<'a> {
    /// Whether every hit lies on its triangle. So it does by all that is exact; by the document's operations it may lie
    /// beside it.
    #[inline]
    pub fn hits_lie_on_triangles(self) -> bool {
        !matches!(self, Self::Document(_))
    }

    /// Whether shadow rays may be asked from where they end: the bounds for that are derived of the
    /// document's operations and of exact ones (`docs/numerics/projection.md`, section 6).
    #[inline]
    pub fn may_reverse(self) -> bool {
        matches!(self, Self::Document(_) | Self::Exact | Self::Originals(_))
    }

    /// What to prefetch while so many rays are traced, the first of which has a number: the `next` rays, or where rays
    /// are copies, what later ones are copied from.
    #[inline]
    pub fn memory_after<'b>(self, (number, count): (u32, usize), next: &'b [Ray]) -> &'b [u8]
    where
        'a: 'b,
    {
        match self {
            Self::Originals(originals) => originals.later(number, count),
            _ => bytemuck::cast_slice(&next[..next.len().min(count)]),
        }
    }

    /// Prefetches what will be asked for about a pair; only originals are elsewhere. The numbers are those of the ray and of
    /// the triangle's place.
    #[inline(always)]
    pub fn prefetch(self, numbers: (u32, u32)) {
        if let Self::Originals(originals) = self {
            originals.prefetch(numbers.0, numbers.1);
        }
    }

    /// t, rounded to f64, if the ray hits the triangle within its interval. The numbers are those of the ray and of the
    /// triangle's place.
    #[cold]
    #[inline(never)]
    pub fn hit(self, ray: &Ray, triangle: &Triangle, numbers: (u32, u32)) -> Option<f64> {
        match self {
            Self::Document(threshold) => document::hit(ray, triangle, threshold),
            Self::Grid => grid::hit(ray, triangle),
            Self::Exact => exact::hit(ray, triangle),
            Self::Originals(originals) => originals.hit(numbers.0, numbers.1),
        }
    }

    /// Whether the ray hits the triangle within its interval, for whoever asks for no t.
    #[cold]
    #[inline(never)]
    pub fn meets(self, ray: &Ray, triangle: &Triangle, numbers: (u32, u32)) -> bool {
        match self {
            Self::Exact => crate::exact::hit(ray, triangle),
            _ => self.hit(ray, triangle, numbers).is_some(),
        }
    }

    /// t, rounded to f64, of a triangle that the ray is known to hit.
    #[inline(never)]
    pub fn t(self, ray: &Ray, triangle: &Triangle, numbers: (u32, u32)) -> f64 {
        match self {
            Self::Document(_) => document::t(ray, triangle),
            Self::Grid => grid::t(ray, triangle),
            Self::Exact => exact::t(ray, triangle),
            Self::Originals(originals) => originals.t(numbers.0, numbers.1),
        }
    }

    /// The side from which a ray crosses a triangle that it is known to hit, if it does, each point of a mesh belonging to
    /// one of its triangles; by what is exact alone.
    #[inline(never)]
    pub fn crossing(self, ray: &Ray, triangle: &Triangle, numbers: (u32, u32)) -> Option<Side> {
        match self {
            Self::Originals(originals) => originals.crossing(numbers.0, numbers.1),
            _ => crate::exact::crossing(ray, triangle),
        }
    }

    /// Whether a ray starts on a triangle, exactly.
    #[inline(never)]
    pub fn starts_on(self, ray: &Ray, triangle: &Triangle, numbers: (u32, u32)) -> bool {
        match self {
            Self::Originals(originals) => originals.starts_on(numbers.0, numbers.1),
            _ => crate::exact::is_on(triangle, ray.origin),
        }
    }

    /// Whether a ray runs with a triangle's normal or against it, exactly; `None` where it runs along the plane.
    #[inline(never)]
    pub fn facing(self, ray: &Ray, triangle: &Triangle, numbers: (u32, u32)) -> Option<Side> {
        match self {
            Self::Originals(originals) => originals.facing(numbers.0, numbers.1),
            _ => crate::exact::facing(ray, triangle),
        }
    }

    /// Which of two triangles whose rounded t are equal the ray hits first. The document knows no
    /// other t. The numbers are those of the ray and of the places.
    #[cold]
    #[inline(never)]
    pub fn order(
        self,
        ray: &Ray,
        [a, b]: [&Triangle; 2],
        (number, one, other): (u32, u32, u32),
    ) -> Ordering {
        match self {
            Self::Document(_) => Ordering::Equal,
            Self::Grid => grid::order(ray, a, b),
            Self::Exact => exact::order(ray, a, b),
            Self::Originals(originals) => originals.order(number, one, other),
        }
    }

    /// Whether a ray that hits two triangles surely does so at one t, because it meets them where they touch. Of a pair
    /// that is no hit it may say either; a resolver that does not know says no, and asks for nothing. The numbers are
    /// those of the ray and of the places.
    #[inline(always)]
    pub fn touch(
        self,
        pair: impl FnOnce() -> (Ray, [Triangle; 2]),
        (number, one, other): (u32, u32, u32),
    ) -> bool {
        match self {
            Self::Exact => {
                let (ray, [a, b]) = pair();
                exact::touch(&ray, &a, &b)
            }
            Self::Originals(originals) => originals.touch(number, one, other),
            Self::Document(_) | Self::Grid => false,
        }
    }

    /// Which of two hits of a ray comes first: by t, and where that is equal, by the index. The numbers are those of the
    /// ray and of the places.
    #[inline]
    pub fn first(
        self,
        (ray, number): (&Ray, u32),
        (a, at, one): (&Hit, &Triangle, u32),
        (b, bt, other): (&Hit, &Triangle, u32),
    ) -> Ordering {
        (a.t.total_cmp(&b.t))
            .then_with(|| self.order(ray, [at, bt], (number, one, other)))
            .then(a.triangle.cmp(&b.triangle))
    }

    /// What rays from one origin share in asking which triangle comes first. The numbers are those of one of the rays and
    /// of the triangle's place.
    #[inline(always)]
    pub fn shared_origin(
        self,
        triangle: &Triangle,
        origin: [f32; 3],
        (number, place): (u32, u32),
    ) -> SharedOrigin<'a> {
        match self {
            Self::Document(_) => SharedOrigin::document(triangle, origin),
            Self::Grid => SharedOrigin::grid(triangle, origin),
            Self::Exact => {
                SharedOrigin::Exact(crate::exact::SeenPlane::new(triangle, origin), *triangle)
            }
            Self::Originals(originals) => {
                SharedOrigin::Originals(originals.plane(number, place), originals, place)
            }
        }
    }

    /// Where the ray meets a triangle that it is known to hit.
    #[inline(always)]
    pub fn hit_attributes(
        self,
        ray: &Ray,
        triangle: &Triangle,
        index: u32,
        numbers: (u32, u32),
    ) -> Hit {
        match self {
            Self::Document(_) => crate::hit_attributes::of_pair(ray, triangle, index),
            Self::Grid => grid::hit_attributes(ray, triangle, index),
            Self::Exact => exact::hit_attributes(ray, triangle, index),
            Self::Originals(originals) => originals.hit_attributes(numbers.0, numbers.1),
        }
    }

    /// Where rays meet triangles that they are known to hit: the first `len` of eight pairs and their numbers. No grid
    /// comes here.
    #[inline(always)]
    pub fn hits_in<S: Simd>(
        self,
        pairs: &Pairs,
        numbers: &[(u32, u32); 8],
        len: usize,
    ) -> [Hit; 8] {
        // By a call: it is asked in many places, and once for eight hits.
        S::vectorize(
            #[inline(always)]
            || match self {
                Self::Exact => crate::exact::hits_in::<S>(pairs, len),
                Self::Originals(originals) => {
                    let mut hits = [Hit::MISS; 8];
                    originals.hits(&numbers[..len], &mut hits);
                    hits
                }
                Self::Document(_) | Self::Grid => pairs.hits_in::<S>(),
            },
        )
    }
}
