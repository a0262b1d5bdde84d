//! What rays are told, and how it is written down.

use std::fmt;
use std::io::Write;

use intertri::{Hit, Ray};

use crate::engine::Engine;
use crate::numbers::Decimal;

/// What is asked.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verb {
    Closest,
    Any,
    All,
}

/// What rays are asked, and how the answers are to be written down.
pub(crate) struct Question<'a> {
    pub(crate) engine: &'a Engine,
    pub(crate) verb: Verb,
    pub(crate) format: Format,
}

/// The answers of some rays: as they are found, and written down while they are in the cache. The memory of
/// earlier answers is used again: new memory would take as long as the rays.
#[derive(Default)]
pub(crate) struct Answers {
    closest: Vec<Hit>,
    any: Vec<bool>,
    bytes: Vec<u8>,
}

impl Answers {
    /// The answers written down.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Asks the rays from number `first` on, and says how many hit something.
    pub(crate) fn ask(&mut self, question: &Question<'_>, rays: &[Ray], first: u64) -> u64 {
        self.bytes.clear();
        let size = question.engine.piece();
        let pieces = rays.chunks(size).zip((first..).step_by(size));
        pieces.map(|(rays, first)| self.add(question, rays, first)).sum()
    }

    /// The same, and adds what they are told.
    fn add(&mut self, question: &Question<'_>, rays: &[Ray], first: u64) -> u64 {
        let Self { closest, any, bytes } = self;
        let Question { engine, verb, format } = *question;
        let numbers = first..;
        let mut count = 0;
        match verb {
            Verb::Closest => {
                closest.resize(rays.len(), Hit::MISS);
                engine.closest(rays, closest);
                for (ray, hit) in numbers.zip(closest) {
                    count += u64::from(hit.is_hit());
                    match format {
                        Format::Csv => csv(bytes, ray, hit),
                        Format::Raw => bytes.extend_from_slice(&raw(hit)),
                    }
                }
            }
            Verb::Any => {
                any.resize(rays.len(), false);
                engine.any(rays, any);
                for (ray, &mut hit) in numbers.zip(any) {
                    count += u64::from(hit);
                    match format {
                        Format::Csv => line(bytes, format_args!("{ray},{}", u8::from(hit))),
                        Format::Raw => bytes.push(u8::from(hit)),
                    }
                }
            }
            Verb::All => {
                for (ray, line) in numbers.zip(rays) {
                    let hits = engine.all(line);
                    count += u64::from(!hits.is_empty());
                    let hits = if hits.is_empty() { &[Hit::MISS] } else { hits.as_slice() };
                    for hit in hits {
                        match format {
                            Format::Csv => csv(bytes, ray, hit),
                            Format::Raw => {
                                bytes.extend_from_slice(&ray.to_le_bytes());
                                bytes.extend_from_slice(&raw(hit));
                            }
                        }
                    }
                }
            }
        }
        count
    }
}

/// How answers are written down.
#[derive(Clone, Copy)]
pub(crate) enum Format {
    Csv,
    Raw,
}

impl Format {
    /// What stands before the first answer.
    pub(crate) fn header(self, verb: Verb) -> &'static [u8] {
        match (self, verb) {
            (Self::Raw, _) => b"",
            (Self::Csv, Verb::Any) => b"ray,hit\n",
            (Self::Csv, _) => b"ray,triangle,t,u,v\n",
        }
    }
}

/// A line `ray,triangle,t,u,v`.
fn csv(out: &mut Vec<u8>, ray: u64, hit: &Hit) {
    if hit.is_hit() {
        let [t, u, v] = [hit.t, hit.u, hit.v].map(Decimal);
        line(out, format_args!("{ray},{},{t},{u},{v}", hit.triangle));
    } else {
        line(out, format_args!("{ray},,,,"));
    }
}

fn line(out: &mut Vec<u8>, text: fmt::Arguments<'_>) {
    // Memory takes everything.
    let _ = writeln!(out, "{text}");
}

/// A record of 32 bytes.
fn raw(hit: &Hit) -> [u8; 32] {
    // No triangle is all ones, which is -1.
    let [t, u, v] = [hit.t, hit.u, hit.v].map(f64::to_le_bytes);
    bytemuck::cast([hit.triangle.to_le_bytes(), t, u, v])
}
