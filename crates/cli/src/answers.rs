//! What rays are told, and how it is written down.

use intertri::{Hit, Ray};
use rayon::prelude::*;

use crate::engine::Engine;
use crate::numbers::Decimal;

/// What is asked.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verb {
    Closest,
    Any,
    All,
}

/// What a batch of rays got.
pub(crate) enum Answers {
    Closest(Vec<Hit>),
    Any(Vec<bool>),
    All(Vec<Vec<Hit>>),
}

impl Answers {
    /// To what will be asked, none yet.
    pub(crate) fn new(verb: Verb) -> Self {
        match verb {
            Verb::Closest => Self::Closest(vec![]),
            Verb::Any => Self::Any(vec![]),
            Verb::All => Self::All(vec![]),
        }
    }

    /// Asks, in the place of what was asked before: new memory would take as long as the rays.
    pub(crate) fn ask(&mut self, engine: &Engine, rays: &[Ray]) {
        match self {
            Self::Closest(hits) => {
                hits.resize(rays.len(), Hit::MISS);
                engine.closest(rays, hits);
            }
            Self::Any(hits) => {
                hits.resize(rays.len(), false);
                engine.any(rays, hits);
            }
            Self::All(hits) => *hits = rays.par_iter().map(|ray| engine.all(ray)).collect(),
        }
    }

    /// Rays that hit something.
    pub(crate) fn hits(&self) -> u64 {
        let count = match self {
            Self::Closest(hits) => hits.iter().filter(|hit| hit.is_hit()).count(),
            Self::Any(hits) => hits.iter().filter(|&&hit| hit).count(),
            Self::All(hits) => hits.iter().filter(|hits| !hits.is_empty()).count(),
        };
        count as u64
    }

    /// The answers written down, piece by piece; the first is that of ray number `first`.
    pub(crate) fn bytes(&self, format: Format, first: u64) -> Vec<Vec<u8>> {
        match self {
            Self::Closest(hits) => pieces(hits, first, |out, ray, hit| match format {
                Format::Csv => csv(out, ray, hit),
                Format::Raw => raw(out, hit),
            }),
            Self::Any(hits) => pieces(hits, first, |out, ray, &hit| match format {
                Format::Csv => out.extend(format!("{ray},{}\n", u8::from(hit)).bytes()),
                Format::Raw => out.push(u8::from(hit)),
            }),
            Self::All(hits) => pieces(hits, first, |out, ray, hits| {
                let hits = if hits.is_empty() { &[Hit::MISS] } else { hits.as_slice() };
                for hit in hits {
                    match format {
                        Format::Csv => csv(out, ray, hit),
                        Format::Raw => {
                            out.extend(ray.to_le_bytes());
                            raw(out, hit);
                        }
                    }
                }
            }),
        }
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

/// Writes each answer, given the number of its ray, on all threads.
fn pieces<T: Sync>(
    answers: &[T],
    first: u64,
    write: impl Fn(&mut Vec<u8>, u64, &T) + Sync,
) -> Vec<Vec<u8>> {
    const PIECE: usize = 1024;
    let pieces = answers.par_chunks(PIECE).enumerate().map(|(piece, answers)| {
        let mut out = Vec::new();
        for (ray, answer) in (first + (piece * PIECE) as u64..).zip(answers) {
            write(&mut out, ray, answer);
        }
        out
    });
    pieces.collect()
}

/// A line `ray,triangle,t,u,v`.
fn csv(out: &mut Vec<u8>, ray: u64, hit: &Hit) {
    let line = if hit.is_hit() {
        let [t, u, v] = [hit.t, hit.u, hit.v].map(Decimal);
        format!("{ray},{},{t},{u},{v}\n", hit.triangle)
    } else {
        format!("{ray},,,,\n")
    };
    out.extend(line.bytes());
}

/// A record of 32 bytes.
fn raw(out: &mut Vec<u8>, hit: &Hit) {
    // No triangle is all ones, which is -1.
    out.extend(hit.triangle.to_le_bytes());
    for number in [hit.t, hit.u, hit.v] {
        out.extend(number.to_le_bytes());
    }
}
