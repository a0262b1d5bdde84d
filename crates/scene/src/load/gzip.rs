//! Files in gzip, whatever model is in them.

use std::io::{BufRead, ErrorKind, Read};
use std::path::{Path, PathBuf};

use flate2::bufread::MultiGzDecoder;

use super::error::{Fault, fault};

/// How a file in gzip begins.
pub(super) const MAGIC: &[u8] = b"\x1f\x8b";

/// A file may unpack to that much, whatever its size,
const SURE: u64 = 64 << 20;
/// and a larger one to so many times its size: models shrink to a tenth, and few to a fiftieth.
const RATIO: u64 = 100;

/// Unpacks a file of that size. Memory is linear in the size: a bomb ends in an error.
pub(super) fn unpack(input: impl BufRead, size: u64) -> Result<Vec<u8>, Fault> {
    let most = size.saturating_mul(RATIO).max(SURE);
    let mut bytes = Vec::new();
    let read = MultiGzDecoder::new(input).take(most + 1).read_to_end(&mut bytes);
    match read {
        Ok(_) if bytes.len() as u64 > most => fault(format!(
            "the gzip unpacks to more than {RATIO} times its {size} bytes; if you trust it, unpack it \
             first (gunzip)"
        )),
        Ok(_) => Ok(bytes),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
            fault("the gzip is cut off; copy the file again")
        }
        Err(error) => fault(format!("the gzip is damaged ({error}); copy the file again")),
    }
}

/// The name of what is in a file of that name: `a.obj` for `a.obj.gz`.
pub(super) fn inner(path: &Path) -> PathBuf {
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("gz") => path.with_extension(""),
        _ => path.into(),
    }
}
