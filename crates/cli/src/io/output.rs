//! Where bytes go: the standard output, or a file that appears only when it is whole.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;

use crate::error::{Error, Result};

/// A sink of bytes.
pub(crate) struct Output {
    /// For error messages.
    name: String,
    sink: Box<dyn Write + Send>,
    /// The unfinished file, and the path it will take.
    partial: Option<(PathBuf, PathBuf)>,
}

impl Output {
    /// Opens a file, or the standard output.
    ///
    /// A file's bytes go to a hidden file beside it, which takes the name upon [`Output::finish`]. So a
    /// run that fails leaves an older file as it was, and a file may be both read and written. A
    /// device or a pipe is written directly.
    pub(crate) fn open(path: Option<&Path>) -> Result<Self> {
        let Some(path) = path else {
            let name = "standard output".to_owned();
            return match standard_output() {
                Ok(sink) => Ok(Self { name, sink, partial: None }),
                Err(cause) => Err(Error::at(name, format!("cannot write the answers: {cause}"))),
            };
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
        let partial = (!special).then(|| {
            // A link stays; the file that it leads to is replaced.
            let path = fs::canonicalize(path).unwrap_or_else(|_| path.into());
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let hidden = path.with_file_name(format!(".{name}.{}.partial", process::id()));
            (hidden, path)
        });
        match File::create(partial.as_ref().map_or(path, |(hidden, _)| hidden)) {
            Ok(file) => Ok(Self { name, sink: Box::new(file), partial }),
            Err(cause) => Err(Error::at(name, format!("cannot write the answers: {cause}"))),
        }
    }

    /// Writes all of `bytes`.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.sink.write_all(bytes);
        written.map_err(|cause| self.refused(&cause))
    }

    /// Gives the file its name.
    pub(crate) fn finish(mut self) -> Result<()> {
        let mut done = self.sink.flush();
        if let (Ok(()), Some((hidden, path))) = (&done, &self.partial) {
            done = fs::rename(hidden, path);
            if done.is_ok() {
                self.partial = None;
            }
        }
        done.map_err(|cause| self.refused(&cause))
    }

    fn refused(&self, cause: &io::Error) -> Error {
        let why = match cause.kind() {
            io::ErrorKind::BrokenPipe => "was closed before it had all answers".to_owned(),
            _ => format!("cannot write the answers: {cause}"),
        };
        Error::at(&self.name, why)
    }
}

/// The standard output, unbuffered. `io::stdout` buffers by lines: it would look for line ends in raw answers,
/// and write what follows the last one separately.
#[cfg(unix)]
fn standard_output() -> io::Result<Box<dyn Write + Send>> {
    use std::os::fd::AsFd;
    Ok(Box::new(File::from(io::stdout().as_fd().try_clone_to_owned()?)))
}

#[cfg(not(unix))]
fn standard_output() -> io::Result<Box<dyn Write + Send>> {
    Ok(Box::new(io::stdout()))
}

impl Drop for Output {
    fn drop(&mut self) {
        if let Some((hidden, _)) = &self.partial {
            // The error that led here has been reported.
            let _ = fs::remove_file(hidden);
        }
    }
}
