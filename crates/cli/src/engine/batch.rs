//! Traces rays in batches, and formats the answers while they are still in the cache.

use std::time::Instant;

use intertri::{Hit, RayOf};
use intertri_scene::Coordinate;

use crate::engine::tracer::Tracer;
use crate::error::Result;
use crate::io::answers::{Format, Query};

/// The engine and the query for the rays, and the format of the answers.
pub(crate) struct Question<'a, T> {
    pub(crate) engine: &'a T,
    pub(crate) query: Query,
    pub(crate) format: Format,
}

/// Rays and their answers. Batches are reused, because allocating new memory would take as long as
/// tracing.
#[derive(Default)]
pub(crate) struct Batch<S> {
    pub(crate) rays: Vec<RayOf<S>>,
    /// The number of the first ray.
    pub(crate) first: u64,
    /// The number of rays that hit something.
    pub(crate) hits: u64,
    /// The numbers of the rays that start outside the engine's grid, and therefore hit nothing.
    pub(crate) outside: Vec<u64>,
    /// The time spent computing the answers.
    pub(crate) seconds: f64,
    answers: Answers,
}

impl<S: Coordinate> Batch<S> {
    /// Traces all rays, chunk by chunk.
    ///
    /// # Errors
    /// Returns an error if memory runs out for the answers of a ray.
    pub(crate) fn answer(
        &mut self,
        question: &Question<'_, impl Tracer<Scalar = S>>,
    ) -> Result<()> {
        let start = Instant::now();
        self.answers.bytes.clear();
        let size = question.engine.chunk_size();
        let chunks = self.rays.chunks(size).zip((self.first..).step_by(size));
        self.hits = 0;
        for (rays, first) in chunks {
            self.hits += self.answers.add(question, rays, first)?;
        }
        self.outside.clear();
        let numbered = (self.first..).zip(&self.rays);
        let outside = numbered.filter(|(_, ray)| question.engine.is_outside(ray.origin));
        self.outside.extend(outside.map(|(number, _)| number));
        self.seconds = start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Returns the formatted answers.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.answers.bytes
    }
}

/// The answers of the current chunk, and the formatted answers of the batch so far.
#[derive(Default)]
struct Answers {
    closest: Vec<Hit>,
    any: Vec<bool>,
    bytes: Vec<u8>,
}

impl Answers {
    /// Traces rays and adds their answers. The rays are numbered from `first` on. Returns how many
    /// rays hit something.
    fn add<T: Tracer>(
        &mut self,
        question: &Question<'_, T>,
        rays: &[RayOf<T::Scalar>],
        first: u64,
    ) -> Result<u64> {
        let Self { closest, any, bytes } = self;
        let Question { engine, query, format } = *question;
        let numbers = first..;
        let mut count = 0;
        match query {
            Query::Closest => {
                closest.resize(rays.len(), Hit::MISS);
                engine.closest(rays, closest);
                for (number, hit) in numbers.zip(closest) {
                    count += u64::from(hit.is_hit());
                    format.closest(bytes, number, hit)?;
                }
            }
            Query::Any => {
                any.resize(rays.len(), false);
                engine.any(rays, any);
                for (number, &mut hit) in numbers.zip(any) {
                    count += u64::from(hit);
                    format.any(bytes, number, hit)?;
                }
            }
            Query::All => {
                for (number, ray) in numbers.zip(rays) {
                    let hits = engine.all(ray)?;
                    count += u64::from(!hits.is_empty());
                    format.all(bytes, number, &hits)?;
                }
            }
            Query::Crossings => {
                for (number, ray) in numbers.zip(rays) {
                    let crossings = engine.crossings(ray)?;
                    count += u64::from(!crossings.is_empty());
                    format.crossings(bytes, number, &crossings)?;
                }
            }
        }
        Ok(count)
    }
}
