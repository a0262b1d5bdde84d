//! The formats of answers: CSV and raw records.

use std::fmt;
use std::io::Write;

use clap::ValueEnum;
use intertri::{Crossing, Hit};

use crate::io::numbers::Decimal;

/// The query for each ray.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Query {
    Closest,
    Any,
    All,
    Crossings,
}

/// How answers are written down.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Format {
    /// A line of names, and a line an answer
    Csv,
    /// Little-endian records
    Raw,
}

impl Format {
    /// The header before the first answer.
    pub(crate) fn header(self, query: Query) -> &'static [u8] {
        match (self, query) {
            (Self::Raw, _) => b"",
            (Self::Csv, Query::Any) => b"ray,hit\n",
            (Self::Csv, Query::Crossings) => b"ray,triangle,t,u,v,side\n",
            (Self::Csv, _) => b"ray,triangle,t,u,v\n",
        }
    }

    /// Adds the closest hit of a ray, or its miss.
    pub(crate) fn closest(self, out: &mut Vec<u8>, ray: u64, hit: &Hit) {
        match self {
            Self::Csv => line(out, format_args!("{ray},{}", Cells(hit))),
            Self::Raw => out.extend_from_slice(&raw(hit)),
        }
    }

    /// Adds whether a ray hits anything.
    pub(crate) fn any(self, out: &mut Vec<u8>, ray: u64, hit: bool) {
        match self {
            Self::Csv => line(out, format_args!("{ray},{}", u8::from(hit))),
            Self::Raw => out.push(u8::from(hit)),
        }
    }

    /// Adds every hit of a ray, or its miss.
    pub(crate) fn all(self, out: &mut Vec<u8>, ray: u64, hits: &[Hit]) {
        let hits = if hits.is_empty() { &[Hit::MISS] } else { hits };
        for hit in hits {
            match self {
                Self::Csv => line(out, format_args!("{ray},{}", Cells(hit))),
                Self::Raw => {
                    out.extend_from_slice(&ray.to_le_bytes());
                    out.extend_from_slice(&raw(hit));
                }
            }
        }
    }

    /// Adds every crossing of a ray with its side, 1 if it leaves and -1 if it enters, or its miss.
    pub(crate) fn crossings(self, out: &mut Vec<u8>, ray: u64, crossings: &[Crossing]) {
        let sided = crossings.iter().map(|c| (&c.hit, if c.leaves { 1 } else { -1 }));
        match self {
            Self::Csv if crossings.is_empty() => {
                line(out, format_args!("{ray},{},", Cells(&Hit::MISS)));
            }
            Self::Csv => {
                sided
                    .for_each(|(hit, side)| line(out, format_args!("{ray},{},{side}", Cells(hit))));
            }
            Self::Raw => {
                let miss = crossings.is_empty().then_some((&Hit::MISS, 0));
                for (hit, side) in sided.chain(miss) {
                    out.extend_from_slice(&ray.to_le_bytes());
                    out.extend_from_slice(&raw(hit));
                    out.extend_from_slice(&i64::to_le_bytes(side));
                }
            }
        }
    }
}

/// The cells `triangle,t,u,v` of a hit; all empty for a miss.
struct Cells<'a>(&'a Hit);

impl fmt::Display for Cells<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(hit) = self;
        if hit.is_hit() {
            let [t, u, v] = [hit.t, hit.u, hit.v].map(Decimal);
            write!(f, "{},{t},{u},{v}", hit.triangle)
        } else {
            f.write_str(",,,")
        }
    }
}

fn line(out: &mut Vec<u8>, text: fmt::Arguments<'_>) {
    // Writing to memory cannot fail.
    let _ = writeln!(out, "{text}");
}

/// A record of 32 bytes.
fn raw(hit: &Hit) -> [u8; 32] {
    let triangle = if hit.is_hit() { i64::from(hit.triangle) } else { -1 };
    let [t, u, v] = [hit.t, hit.u, hit.v].map(f64::to_le_bytes);
    bytemuck::cast([triangle.to_le_bytes(), t, u, v])
}
