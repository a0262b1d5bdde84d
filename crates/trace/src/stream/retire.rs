//! Rays of a stream that are done: hits wait for their t and weights until there are eight of
//! them.

use intertri::internal::{Pairs, Resolver};
use intertri::simd::Simd;
use intertri::{ClosestHit, Hit, Ray, fixed};

use crate::answers::Answers;
use crate::tree::Tree;

/// Hits that wait.
pub(super) struct Retired<'a> {
    resolver: Resolver<'a>,
    on_grid: &'a [fixed::Ray],
    pairs: Pairs,
    /// Of rays and places.
    numbers: [(u32, u32); 8],
    len: usize,
}

impl<'a> Retired<'a> {
    /// None yet. Of a grid, `on_grid` are the rays as their caller has them.
    pub(super) fn new(resolver: Resolver<'a>, on_grid: &'a [fixed::Ray]) -> Self {
        Self { resolver, on_grid, pairs: Pairs::new(), numbers: [(0, 0); 8], len: 0 }
    }

    /// Takes the closest hit of a ray, whose number in `answers` is `number`.
    #[inline(always)]
    pub(super) fn retire<S: Simd>(
        &mut self,
        bvh: &Tree,
        ray: &Ray,
        number: u32,
        closest: &ClosestHit,
        answers: &mut Answers<'_>,
    ) {
        if answers.write(number as usize, closest) {
            return;
        }
        if let Some((index, place)) = closest.triangle() {
            let triangle = bvh.triangle_in(place);
            if let Resolver::Grid = self.resolver {
                let hit = self.resolver.hit_attributes(ray, &triangle, index, (number, place));
                let t = self.on_grid[number as usize].t_of_caller(hit.t);
                answers.write_hit(number as usize, Hit { t, ..hit });
                return;
            }
            self.pairs.set(self.len, ray, &triangle, index);
            self.numbers[self.len] = (number, place);
            self.resolver.prefetch((number, place));
            self.len += 1;
            if self.len == 8 {
                self.flush::<S>(answers);
            }
        }
    }

    /// Answers those that still wait.
    #[inline(always)]
    pub(super) fn flush<S: Simd>(&mut self, answers: &mut Answers<'_>) {
        if self.len > 0 {
            let hits = self.resolver.hits_in::<S>(&self.pairs, &self.numbers, self.len);
            for (hit, &(number, _)) in hits.into_iter().zip(&self.numbers[..self.len]) {
                answers.write_hit(number as usize, hit);
            }
            self.len = 0;
        }
    }
}
