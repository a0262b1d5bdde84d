//! Builds f64 tracers by name, and adapts them so that they accept f32 rays.

use std::ops::Range;

use intertri::{Ray, Ray64, Triangle64};

use crate::bvh::TwoWay;
use crate::engine::{Answer, Engine, Question};
use crate::parry::Parry64;
use crate::programs::Program;
use crate::rays::widened;

/// The names of the f64 tracers.
const NAMES: [&str; 6] = ["bvh-f64", "parry-f64", "tinybvh-f64", "libigl", "cgal", "cgal-inexact"];

/// Returns whether `name` is the name of an f64 tracer.
pub fn is(name: &str) -> bool {
    NAMES.contains(&name)
}

/// Builds an f64 tracer over f64 triangles. If that fails, prints the reason and returns `None`.
pub fn engine(name: &str, triangles: &[Triangle64]) -> Option<Box<dyn Engine<Ray64>>> {
    let engine: Result<Box<dyn Engine<Ray64>>, String> = match name {
        "parry-f64" => parry(triangles).map(|engine| Box::new(engine) as _),
        "bvh-f64" => Ok(Box::new(TwoWay::new(triangles))),
        _ => Program::new(name, triangles).map(|engine| Box::new(engine) as _),
    };
    engine.inspect_err(|error| eprintln!("skipping {name}: {error}")).ok()
}

fn parry(triangles: &[Triangle64]) -> Result<Parry64, String> {
    let corners = triangles.iter().flat_map(|triangle| triangle.0).collect::<Vec<_>>();
    let indices = (0..triangles.len() as u32).map(|i| [0, 1, 2].map(|k| 3 * i + k));
    Parry64::new(&corners, &indices.collect::<Vec<_>>())
}

/// An f64 tracer that accepts f32 rays and widens them to f64.
pub struct Widened(pub Box<dyn Engine<Ray64>>);

impl Engine for Widened {
    fn load(&mut self, rays: &[Ray], question: Question) {
        let rays: Vec<Ray64> = rays.iter().map(widened).collect();
        self.0.load(&rays, question);
    }

    fn trace(&mut self, part: Range<usize>) {
        self.0.trace(part);
    }

    fn answers(&self) -> Vec<Answer> {
        self.0.answers()
    }
}
