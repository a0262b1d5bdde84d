//! Prints reports to standard output.

use std::fmt;
use std::io::{self, BufWriter, Write};

use serde::Serialize;

use crate::error::{Error, Result};
use crate::io::standard_output;

/// Prints a report on standard output, as a few lines of text or as JSON.
pub(crate) fn print(report: &(impl Serialize + fmt::Display), json: bool) -> Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    let written = if json {
        serde_json::to_writer_pretty(&mut out, report).map_err(io::Error::from)
    } else {
        write!(out, "{report}")
    };
    written.and_then(|()| writeln!(out)).and_then(|()| out.flush()).map_err(|cause| {
        Error::at(standard_output::NAME, format!("cannot write the report: {cause}"))
    })
}

/// Prints a warning on standard error.
pub(crate) fn tell(note: &str) {
    // If standard error is closed, the warning is lost.
    let _ = writeln!(io::stderr(), "intertri: {note}");
}
