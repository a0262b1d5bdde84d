//! An engine that traces its own rays and ignores those passed to it.

use std::ops::Range;
use std::sync::Arc;

use intertri::Ray;

use crate::engine::{Answer, Engine, Question};

pub struct Own<E, R> {
    engine: E,
    rays: Arc<[R]>,
}

impl<E, R> Own<E, R> {
    pub fn new(engine: E, rays: &Arc<[R]>) -> Self {
        Self { engine, rays: rays.clone() }
    }
}

impl<E: Engine<R>, R: Send + Sync> Engine for Own<E, R> {
    fn load(&mut self, rays: &[Ray], question: Question) {
        assert_eq!(rays.len(), self.rays.len(), "the number of rays must match");
        self.engine.load(&self.rays, question);
    }

    fn trace(&mut self, part: Range<usize>) {
        self.engine.trace(part);
    }

    fn answers(&self) -> Vec<Answer> {
        self.engine.answers()
    }

    fn exact(&self) -> bool {
        self.engine.exact()
    }
}
