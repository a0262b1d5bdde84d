//! The formats of answers: CSV and raw records.

use std::fmt;
use std::io::Write;

use clap::ValueEnum;
use intertri::Hit;

use crate::io::numbers::Decimal;

/// What each ray is asked.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Query {
    Closest,
    Any,
    All,
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
    /// What stands before the first answer.
    pub(crate) fn header(self, query: Query) -> &'static [u8] {
        match (self, query) {
            (Self::Raw, _) => b"",
            (Self::Csv, Query::Any) => b"ray,hit\n",
            (Self::Csv, _) => b"ray,triangle,t,u,v\n",
        }
    }

    /// Adds the closest hit of a ray, or its miss.
    pub(crate) fn closest(self, out: &mut Vec<u8>, ray: u64, hit: &Hit) {
        match self {
            Self::Csv => csv(out, ray, hit),
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
                Self::Csv => csv(out, ray, hit),
                Self::Raw => {
                    out.extend_from_slice(&ray.to_le_bytes());
                    out.extend_from_slice(&raw(hit));
                }
            }
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
    // Writing to memory cannot fail.
    let _ = writeln!(out, "{text}");
}

/// A record of 32 bytes.
fn raw(hit: &Hit) -> [u8; 32] {
    let triangle = if hit.is_hit() { i64::from(hit.triangle) } else { -1 };
    let [t, u, v] = [hit.t, hit.u, hit.v].map(f64::to_le_bytes);
    bytemuck::cast([triangle.to_le_bytes(), t, u, v])
}
