//! Protects input files from being overwritten.

use std::io;
use std::path::Path;

use crate::error::{Error, Result};
use crate::io::standard_output;

/// Returns an error if `output` is one of the input files, even under a different path. If `output`
/// is `None`, checks standard output instead. `-` among the inputs means standard input.
pub(crate) fn refuse_same_file(output: Option<&Path>, inputs: &[&Path]) -> Result<()> {
    let to = output.map_or_else(|| of_stream(io::stdout()), of_path);
    for input in inputs {
        let stdin = input.as_os_str() == "-";
        let from = if stdin { of_stream(io::stdin()) } else { of_path(input) };
        if to.is_some() && to == from {
            let output = output.map_or_else(
                || standard_output::NAME.to_owned(),
                |path| path.display().to_string(),
            );
            let input =
                if stdin { "the standard input".to_owned() } else { input.display().to_string() };
            let what =
                format!("{output}: is the same file as {input}, which is an input; choose another");
            return Err(Error::usage(what));
        }
    }
    Ok(())
}

#[cfg(unix)]
use unix::{of_path, of_stream};

/// Regular files, identified by device and inode.
#[cfg(unix)]
mod unix {
    use std::fs::{self, File, Metadata};
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;
    use std::path::Path;

    pub(super) fn of_path(path: &Path) -> Option<(u64, u64)> {
        of(&fs::metadata(path).ok()?)
    }

    pub(super) fn of_stream(stream: impl AsFd) -> Option<(u64, u64)> {
        let file = File::from(stream.as_fd().try_clone_to_owned().ok()?);
        of(&file.metadata().ok()?)
    }

    fn of(metadata: &Metadata) -> Option<(u64, u64)> {
        metadata.is_file().then(|| (metadata.dev(), metadata.ino()))
    }
}

/// Files, identified by their path with links resolved. Other systems offer nothing better without
/// `unsafe`.
#[cfg(not(unix))]
fn of_path(path: &Path) -> Option<std::path::PathBuf> {
    path.is_file().then(|| path.canonicalize().ok())?
}

#[cfg(not(unix))]
fn of_stream<S>(_: S) -> Option<std::path::PathBuf> {
    None
}
