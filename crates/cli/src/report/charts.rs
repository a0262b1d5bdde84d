//! The output folder for charts: images and tables, each with the date and the machine.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use intertri_lab::draw::{Section, Svg, page, png};
use intertri_lab::{machine, tables};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::io::output::Output;

/// The date and the machine of the measurements.
#[derive(Clone, Serialize)]
pub(crate) struct Machine {
    date: String,
    cpu: String,
    rustc: String,
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { date, cpu, rustc } = self;
        write!(f, "{date}; {cpu}; {rustc}")
    }
}

/// A folder for output files.
pub(crate) struct ChartFolder {
    folder: PathBuf,
    pub(crate) machine: Machine,
    files: Vec<PathBuf>,
    start: Instant,
}

/// The files that were written, the machine, and the duration of the run.
#[derive(Serialize)]
pub(crate) struct Written {
    pub(crate) machine: Machine,
    seconds: f64,
    files: Vec<PathBuf>,
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for file in &self.files {
            writeln!(f, "{}", file.display())?;
        }
        write!(f, "{:.1} seconds", self.seconds)
    }
}

impl ChartFolder {
    /// Creates the folder if it does not exist.
    pub(crate) fn new(folder: &Path) -> Result<Self> {
        let start = Instant::now();
        fs::create_dir_all(folder).map_err(|cause| {
            Error::at(folder.display(), format!("cannot create this folder: {cause}"))
        })?;
        let machine = Machine {
            date: machine::date(),
            cpu: machine::cpu(),
            rustc: machine::rustc().to_owned(),
        };
        Ok(Self { folder: folder.to_owned(), machine, files: Vec::new(), start })
    }

    /// Writes a chart as SVG and PNG.
    pub(crate) fn picture(&mut self, name: &str, svg: &Svg) -> Result<()> {
        self.write(&format!("{name}.svg"), svg.to_string().as_bytes())?;
        let pixels = png(svg).map_err(|cause| Error::at(format!("{name}.png"), cause))?;
        self.write(&format!("{name}.png"), &pixels)
    }

    /// Writes a table as CSV. Its first line names the machine and describes the table.
    pub(crate) fn table<T: Serialize>(&mut self, name: &str, rows: &[T], what: &str) -> Result<()> {
        let table = tables::csv(rows).map_err(|cause| Error::at(name, cause))?;
        let text = format!("# {}; {what}\n{table}", self.machine);
        self.write(&format!("{name}.csv"), text.as_bytes())
    }

    /// Writes all sections to one HTML page.
    pub(crate) fn page(&mut self, name: &str, title: &str, sections: &[Section<'_>]) -> Result<()> {
        let text = page(title, &self.machine.to_string(), sections);
        self.write(&format!("{name}.html"), text.as_bytes())
    }

    fn write(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.folder.join(format!("{}-{name}", self.machine.date));
        let mut output = Output::open(Some(&path))?;
        output.write(bytes)?;
        output.finish()?;
        self.files.push(path);
        Ok(())
    }

    /// Finishes the run, and returns the list of files.
    pub(crate) fn finish(self) -> Written {
        let Self { machine, files, start, .. } = self;
        Written { machine, files, seconds: start.elapsed().as_secs_f64() }
    }
}
