//! What may be asked of many rays: their closest hits, their closest triangles, whether they hit, every hit.

use std::ops::Range;

use intertri::internal::prefetch;
use intertri::{ClosestHit, Crossings, Hit};

use crate::pairs::HitPairs;
use crate::place::Place;

/// A slice of answers, one a ray.
pub(crate) enum Answers<'a> {
    /// The closest hits.
    Hits(&'a mut [Hit]),
    /// The triangles of the closest hits, [`Hit::NO_TRIANGLE`] for a miss.
    Triangles(&'a mut [u32]),
    /// Whether anything is hit.
    Any(&'a mut [bool]),
    /// Every hit.
    Pairs(&'a mut HitPairs),
    /// How often rays cross.
    Crossings(&'a mut [Crossings]),
    /// Where rays start.
    Places(&'a mut [Place]),
}

impl Answers<'_> {
    /// The same in chunks of so many rays, and which rays these are.
    ///
    /// # Panics
    /// If there are not `count` answers.
    pub(crate) fn chunks(self, count: usize, size: usize) -> Vec<(Range<usize>, Self)> {
        /// Those of a slice.
        fn of<'a, A>(
            slice: &'a mut [A],
            (count, size): (usize, usize),
            answers: impl Fn(&'a mut [A]) -> Answers<'a>,
        ) -> Vec<(Range<usize>, Answers<'a>)> {
            assert_eq!(count, slice.len(), "one answer a ray");
            let range = |from: usize| from..count.min(from + size);
            (0..count).step_by(size).map(range).zip(slice.chunks_mut(size).map(answers)).collect()
        }

        let by = (count, size);
        match self {
            Self::Hits(hits) => of(hits, by, Self::Hits),
            Self::Triangles(triangles) => of(triangles, by, Self::Triangles),
            Self::Any(any) => of(any, by, Self::Any),
            Self::Crossings(crossings) => of(crossings, by, Self::Crossings),
            Self::Places(places) => of(places, by, Self::Places),
            // Their chunks are put together by who asks for them.
            Self::Pairs(pairs) => vec![(0..count, Self::Pairs(pairs))],
        }
    }

    /// Whether any hit will do.
    #[inline(always)]
    pub(crate) fn any(&self) -> bool {
        matches!(self, Self::Any(_))
    }

    /// Whether every hit is asked for, and not only the closest or any.
    #[inline(always)]
    pub(crate) fn every(&self) -> bool {
        matches!(self, Self::Pairs(_) | Self::Crossings(_) | Self::Places(_))
    }

    /// The answers from one ray to before another.
    #[inline(always)]
    pub(crate) fn part(&mut self, from: usize, to: usize) -> Answers<'_> {
        match self {
            Self::Hits(hits) => Answers::Hits(&mut hits[from..to]),
            Self::Triangles(triangles) => Answers::Triangles(&mut triangles[from..to]),
            Self::Any(any) => Answers::Any(&mut any[from..to]),
            Self::Pairs(pairs) => Answers::Pairs(pairs),
            Self::Crossings(crossings) => Answers::Crossings(&mut crossings[from..to]),
            Self::Places(places) => Answers::Places(&mut places[from..to]),
        }
    }

    /// Asks for the memory of an answer, which is hardly ever in the cache.
    #[inline(always)]
    pub(crate) fn prefetch(&self, ray: usize) {
        match self {
            Self::Hits(hits) => prefetch(&hits[ray..][..1]),
            Self::Triangles(triangles) => prefetch(&triangles[ray..][..1]),
            Self::Any(any) => prefetch(&any[ray..][..1]),
            Self::Pairs(_) => (),
            Self::Crossings(crossings) => prefetch(&crossings[ray..][..1]),
            Self::Places(places) => prefetch(&places[ray..][..1]),
        }
    }

    /// Writes the answer of a ray, if it is known without its t and weights; whether it was.
    #[inline(always)]
    pub(crate) fn write(&mut self, ray: usize, closest: &ClosestHit) -> bool {
        match self {
            Self::Hits(hits) => {
                if closest.is_hit() {
                    return false;
                }
                hits[ray] = Hit::MISS;
            }
            Self::Triangles(triangles) => {
                triangles[ray] = closest.triangle().map_or(Hit::NO_TRIANGLE, |(index, _)| index);
            }
            Self::Any(any) => any[ray] = closest.is_hit(),
            Self::Pairs(_) | Self::Crossings(_) | Self::Places(_) => (),
        }
        true
    }

    /// Writes the hit of a ray.
    #[inline(always)]
    pub(crate) fn write_hit(&mut self, ray: usize, hit: Hit) {
        if let Self::Hits(hits) = self {
            hits[ray] = hit;
        }
    }
}
