//! The interface that every measured tracer implements.

use std::ops::Range;

use intertri::Ray;
use rayon::prelude::*;

/// The kind of query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Question {
    /// Whether this is an any-hit query; otherwise it is a closest-hit query.
    pub any: bool,
    /// Whether neighbouring rays are coherent.
    pub coherent: bool,
}

/// The answer for a ray: a triangle and its t. The answer to an any-hit query only distinguishes a
/// hit from a miss.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    pub triangle: u32,
    pub t: f64,
}

impl Answer {
    pub const MISS: Self = Self { triangle: u32::MAX, t: f64::INFINITY };
    pub const ANY: Self = Self { triangle: 0, t: 0.0 };

    pub fn is_hit(&self) -> bool {
        self.triangle != u32::MAX
    }
}

/// A tracer for one scene that takes rays of type `R`.
pub trait Engine<R = Ray>: Send + Sync {
    /// Stores rays in the layout that suits the tracer. Calls to this function are not timed.
    fn load(&mut self, rays: &[R], question: Question);
    /// Traces a range of the rays on the threads of the current pool. The range starts at a
    /// multiple of [`CHUNK`], and ends at another multiple or after the last ray. Calls to this
    /// function are timed.
    fn trace(&mut self, part: Range<usize>);
    /// Returns the hits, in the order of the rays.
    fn answers(&self) -> Vec<Answer>;
    /// Returns whether the engine guarantees every bit of t.
    fn exact(&self) -> bool {
        false
    }
}

/// The number of rays that a thread processes at a time.
pub const CHUNK: usize = 1024;

/// The rays for a tracer that traces one ray per call.
pub struct Singles<R> {
    rays: Vec<R>,
    any: bool,
    answers: Vec<Answer>,
}

impl<R> Default for Singles<R> {
    fn default() -> Self {
        Self { rays: Vec::new(), any: false, answers: Vec::new() }
    }
}

impl<R: Send + Sync> Singles<R> {
    pub fn load<G>(&mut self, rays: &[G], question: Question, convert: impl Fn(&G) -> R) {
        self.rays = rays.iter().map(convert).collect();
        self.any = question.any;
        self.answers = vec![Answer::MISS; rays.len()];
    }

    #[inline(always)]
    pub fn trace(
        &mut self,
        part: Range<usize>,
        closest: impl Fn(&R) -> Answer + Sync,
        any: impl Fn(&R) -> bool + Sync,
    ) {
        self.trace_with(part, || (), |(), ray| closest(ray), |(), ray| any(ray));
    }

    /// Like [`Singles::trace`], but creates a value with `make` for each chunk.
    #[inline(always)]
    pub fn trace_with<K>(
        &mut self,
        part: Range<usize>,
        make: impl Fn() -> K + Sync,
        closest: impl Fn(&mut K, &R) -> Answer + Sync,
        any: impl Fn(&mut K, &R) -> bool + Sync,
    ) {
        let (rays, answers) = (&self.rays[part.clone()], &mut self.answers[part]);
        let chunks = rays.par_chunks(CHUNK).zip(answers.par_chunks_mut(CHUNK));
        if self.any {
            chunks.for_each(|(rays, answers)| {
                let mut kept = make();
                for (ray, answer) in rays.iter().zip(answers) {
                    *answer = if any(&mut kept, ray) { Answer::ANY } else { Answer::MISS };
                }
            });
        } else {
            chunks.for_each(|(rays, answers)| {
                let mut kept = make();
                for (ray, answer) in rays.iter().zip(answers) {
                    *answer = closest(&mut kept, ray);
                }
            });
        }
    }

    pub fn answers(&self) -> Vec<Answer> {
        self.answers.clone()
    }
}

/// Lets a boxed tracer be used wherever an engine is expected.
impl<R> Engine<R> for Box<dyn Engine<R>> {
    fn load(&mut self, rays: &[R], question: Question) {
        self.as_mut().load(rays, question);
    }

    fn trace(&mut self, part: Range<usize>) {
        self.as_mut().trace(part);
    }

    fn answers(&self) -> Vec<Answer> {
        self.as_ref().answers()
    }

    fn exact(&self) -> bool {
        self.as_ref().exact()
    }
}
