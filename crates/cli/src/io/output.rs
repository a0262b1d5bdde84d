//! The output: standard output, or a file that appears only once it is complete.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use intertri_scene::PartialFile;

use crate::error::{Error, Result};
use crate::io::standard_output;

/// A destination for bytes: standard output, a file, a device or a pipe.
pub(crate) struct Output {
    /// The name, for error messages.
    name: String,
    sink: Sink,
}

enum Sink {
    Stream(Box<dyn Write + Send>),
    File(PartialFile),
}

impl Output {
    /// Opens a file, or standard output if no path is given.
    ///
    /// A regular file is written as a [`PartialFile`]: if the run fails or is interrupted, an
    /// existing file stays unchanged. A device or a pipe is written directly.
    pub(crate) fn open(path: Option<&Path>) -> Result<Self> {
        let Some(path) = path else {
            let sink = Sink::Stream(standard_output::open()?);
            return Ok(Self { name: standard_output::NAME.to_owned(), sink });
        };
        let name = path.display().to_string();
        let refuse = |why: &str| Err(Error::at(&name, why));
        if path.is_dir() {
            return refuse("is a folder; give the name of a file");
        }
        if path.file_name().is_none() {
            return refuse("is not the name of a file; give one");
        }
        if path.parent().is_some_and(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()) {
            return refuse("its folder does not exist; create it or choose another");
        }

        let special = fs::metadata(path).is_ok_and(|metadata| !metadata.is_file());
        let sink = if special {
            File::create(path).map(|file| Sink::Stream(Box::new(file)))
        } else {
            PartialFile::create(path).map(Sink::File)
        };
        match sink {
            Ok(sink) => Ok(Self { name, sink }),
            Err(cause) => Err(Error::at(name, format!("cannot write the answers: {cause}"))),
        }
    }

    /// Writes all of `bytes`.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<()> {
        let written = match &mut self.sink {
            Sink::Stream(stream) => stream.write_all(bytes),
            Sink::File(file) => file.write_all(bytes),
        };
        written.map_err(|cause| refused(&self.name, &cause))
    }

    /// Completes the output. A regular file then appears under its final name.
    pub(crate) fn finish(self) -> Result<()> {
        let done = match self.sink {
            Sink::Stream(mut stream) => stream.flush(),
            Sink::File(file) => file.finish(),
        };
        done.map_err(|cause| refused(&self.name, &cause))
    }
}

fn refused(name: &str, cause: &io::Error) -> Error {
    let why = match cause.kind() {
        io::ErrorKind::BrokenPipe => "was closed before all answers were written".to_owned(),
        _ => format!("cannot write the answers: {cause}"),
    };
    Error::at(name, why)
}
