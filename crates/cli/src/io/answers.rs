//! The formats of answers: CSV and raw records.

use std::fmt;
use std::io::{self, Write};

use clap::ValueEnum;
use intertri::{Crossing, Hit};

use crate::error::{Error, Result};
use crate::io::numbers::Decimal;

/// The query for each ray.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Query {
    Closest,
    Any,
    All,
    Crossings,
}

/// The format of the answers.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Format {
    /// A header line, then one line per answer
    Csv,
    /// Little-endian records
    Raw,
}

impl Format {
    /// Returns the header before the first answer.
    pub(crate) fn header(self, query: Query) -> &'static [u8] {
        match (self, query) {
            (Self::Raw, _) => b"",
            (Self::Csv, Query::Any) => b"ray,hit\n",
            (Self::Csv, Query::Crossings) => b"ray,triangle,t,u,v,side\n",
            (Self::Csv, _) => b"ray,triangle,t,u,v\n",
        }
    }

    /// Adds the closest hit of a ray, or a miss.
    pub(crate) fn closest(self, out: &mut Vec<u8>, ray: u64, hit: &Hit) -> Result<()> {
        let added = match self {
            Self::Csv => writeln!(Text(out), "{ray},{}", Cells(hit)),
            Self::Raw => Text(out).write_all(&raw(hit)),
        };
        added.map_err(|_| too_long(ray))
    }

    /// Adds whether a ray hit anything.
    pub(crate) fn any(self, out: &mut Vec<u8>, ray: u64, hit: bool) -> Result<()> {
        let added = match self {
            Self::Csv => writeln!(Text(out), "{ray},{}", u8::from(hit)),
            Self::Raw => Text(out).write_all(&[u8::from(hit)]),
        };
        added.map_err(|_| too_long(ray))
    }

    /// Adds every hit of a ray, or a miss.
    pub(crate) fn all(self, out: &mut Vec<u8>, ray: u64, hits: &[Hit]) -> Result<()> {
        let hits = if hits.is_empty() { &[Hit::MISS] } else { hits };
        let mut out = Text(out);
        let added = hits.iter().try_for_each(|hit| match self {
            Self::Csv => writeln!(out, "{ray},{}", Cells(hit)),
            Self::Raw => {
                out.write_all(&ray.to_le_bytes())?;
                out.write_all(&raw(hit))
            }
        });
        added.map_err(|_| too_long(ray))
    }

    /// Adds every crossing of a ray with its side (1 if it leaves, -1 if it enters), or a miss.
    pub(crate) fn crossings(
        self,
        out: &mut Vec<u8>,
        ray: u64,
        crossings: &[Crossing],
    ) -> Result<()> {
        let sided = crossings.iter().map(|c| (&c.hit, if c.leaves { 1 } else { -1 }));
        let miss = crossings.is_empty().then_some((&Hit::MISS, 0));
        let mut out = Text(out);
        let added = sided.chain(miss).try_for_each(|(hit, side)| match self {
            Self::Csv if side == 0 => writeln!(out, "{ray},{},", Cells(hit)),
            Self::Csv => writeln!(out, "{ray},{},{side}", Cells(hit)),
            Self::Raw => {
                out.write_all(&ray.to_le_bytes())?;
                out.write_all(&raw(hit))?;
                out.write_all(&i64::to_le_bytes(side))
            }
        });
        added.map_err(|_| too_long(ray))
    }
}

/// A buffer whose writes return an error if memory runs out. That can happen because one ray may
/// hit every triangle of a large model.
struct Text<'a>(&'a mut Vec<u8>);

impl Write for Text<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.try_reserve(bytes.len()).map_err(|_| io::ErrorKind::OutOfMemory)?;
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Returns the error for a ray whose answers do not fit in memory.
fn too_long(ray: u64) -> Error {
    Error::no_memory(format_args!("the answers of ray {ray}"))
}

/// The cells `triangle,t,u,v` of a hit. They are all empty for a miss.
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

/// Returns the raw 32-byte record of a hit.
fn raw(hit: &Hit) -> [u8; 32] {
    let triangle = if hit.is_hit() { i64::from(hit.triangle) } else { -1 };
    let [t, u, v] = [hit.t, hit.u, hit.v].map(f64::to_le_bytes);
    bytemuck::cast([triangle.to_le_bytes(), t, u, v])
}
