//! What may be asked of many rays: their closest hits, their closest triangles, or whether they hit.

use intertri::lanes::Simd;
use intertri::{Best, Hit, Pairs, Ray};

use crate::batch::Tracer;
use crate::bvh::Bvh;
use crate::scratch::{NOTHING, Scratch};

/// What is asked of a ray.
pub(crate) trait Answer: Copy + Send {
    /// Whether any hit will do.
    const ANY: bool;

    /// The answers of the tile that was searched last.
    fn of_tile<S: Simd, T: Tracer>(
        by: &T,
        rays: &[T::Ray],
        tile: &mut Scratch,
        answers: &mut [Self],
    );

    /// The answer of a ray, if that takes no f64: else it waits for others like it.
    fn at_once(best: &Best) -> Option<Self>;

    /// The answer for a hit.
    fn of_hit(hit: Hit) -> Self;
}

impl Answer for Hit {
    const ANY: bool = false;
    #[inline(always)]
    fn of_tile<S: Simd, T: Tracer>(by: &T, rays: &[T::Ray], tile: &mut Scratch, hits: &mut [Self]) {
        by.hits::<S>(rays, tile, hits);
    }
    #[inline(always)]
    fn at_once(best: &Best) -> Option<Self> {
        if best.is_hit() { None } else { Some(Self::MISS) }
    }
    #[inline(always)]
    fn of_hit(hit: Hit) -> Self {
        hit
    }
}

impl Answer for u32 {
    const ANY: bool = false;
    #[inline(always)]
    fn of_tile<S: Simd, T: Tracer>(by: &T, _: &[T::Ray], tile: &mut Scratch, answers: &mut [Self]) {
        tile.triangles(by.tree(), answers);
    }
    #[inline(always)]
    fn at_once(best: &Best) -> Option<Self> {
        Some(best.triangle().map_or(NOTHING, |(index, _)| index))
    }
    #[inline(always)]
    fn of_hit(hit: Hit) -> Self {
        hit.triangle as u32
    }
}

impl Answer for bool {
    const ANY: bool = true;
    #[inline(always)]
    fn of_tile<S: Simd, T: Tracer>(_: &T, _: &[T::Ray], tile: &mut Scratch, answers: &mut [Self]) {
        tile.any(answers);
    }
    #[inline(always)]
    fn at_once(best: &Best) -> Option<Self> {
        Some(best.is_hit())
    }
    #[inline(always)]
    fn of_hit(hit: Hit) -> Self {
        hit.is_hit()
    }
}

/// Hits that wait for their t and weights until there are eight of them.
#[derive(Default)]
pub(crate) struct Landing {
    pairs: Pairs,
    numbers: [u32; 8],
    len: usize,
}

impl Landing {
    /// Takes the best of a ray, whose number in `answers` is `number`.
    #[inline(always)]
    pub(crate) fn land<S: Simd, A: Answer>(
        &mut self,
        bvh: &Bvh,
        ray: &Ray,
        number: u32,
        best: &Best,
        answers: &mut [A],
    ) {
        if let Some(answer) = A::at_once(best) {
            answers[number as usize] = answer;
        } else if let Some((index, place)) = best.triangle() {
            self.pairs.set(self.len, ray, &bvh.triangle_in(place), index);
            self.numbers[self.len] = number;
            self.len += 1;
            if self.len == 8 {
                self.finish::<S, A>(answers);
            }
        }
    }

    /// Answers those that still wait.
    #[inline(always)]
    pub(crate) fn finish<S: Simd, A: Answer>(&mut self, answers: &mut [A]) {
        if self.len > 0 {
            let hits = self.pairs.hits_in::<S>();
            for (hit, &number) in hits.into_iter().zip(&self.numbers[..self.len]) {
                answers[number as usize] = A::of_hit(hit);
            }
            self.len = 0;
        }
    }
}
