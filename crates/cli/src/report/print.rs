//! Prints reports to standard output.

use std::fmt;
use std::io::{self, Write};

use serde::Serialize;

use crate::error::{Error, Result};
use crate::io::standard_output;

/// Prints a report on standard output: a few lines of text, or only JSON.
pub(crate) fn print(report: &(impl Serialize + fmt::Display), json: bool) -> Result<()> {
    let text = if json {
        serde_json::to_string_pretty(report).map_err(|error| Error::at("report", error))?
    } else {
        report.to_string()
    };
    writeln!(io::stdout(), "{text}").map_err(|cause| {
        Error::at(standard_output::NAME, format!("cannot write the report: {cause}"))
    })
}

/// Prints a warning on standard error.
pub(crate) fn tell(note: &str) {
    // If standard error is closed, there is nowhere to print it.
    let _ = writeln!(io::stderr(), "intertri: {note}");
}
