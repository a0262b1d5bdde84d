//! Unpacks model files that are compressed with gzip.

use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use flate2::bufread::GzDecoder;

use super::error::{Fault, fault};
use super::notes::Notes;

/// The first bytes of a gzip file.
pub(super) const MAGIC: &[u8] = b"\x1f\x8b";

/// The number of bytes to which a file of any size may unpack.
const SURE: u64 = 64 << 20;
/// The factor by which a file may grow when unpacked, if this allows more than [`SURE`]. Models
/// typically compress to a tenth of their size, and few compress to a fiftieth.
const RATIO: u64 = 100;

/// Unpacks a file of the given size. Returns an error if the unpacked data would be
/// disproportionately large, so that a decompression bomb cannot exhaust memory.
///
/// A gzip file may have several consecutive members. Other data after the members is skipped with a
/// note, much as `gunzip` does. Trailing zeros, which are common padding on tapes, are skipped
/// without a note.
pub(super) fn unpack(mut input: impl Read, size: u64, notes: &mut Notes) -> Result<Vec<u8>, Fault> {
    let most = size.saturating_mul(RATIO).max(SURE);
    let (mut packed, mut bytes) = (Vec::new(), Vec::new());
    input.read_to_end(&mut packed)?;
    let mut rest = packed.as_slice();
    loop {
        let left = most + 1 - bytes.len() as u64;
        match GzDecoder::new(&mut rest).take(left).read_to_end(&mut bytes) {
            Ok(_) if bytes.len() as u64 > most => {
                return fault(format!(
                    "the gzip unpacks to more than {RATIO} times its {size} bytes; if you trust it, \
                     unpack it first (gunzip)"
                ));
            }
            Ok(_) if rest.starts_with(MAGIC) => {}
            Ok(_) => break,
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                return fault("the gzip is cut off; copy the file again");
            }
            Err(error) => {
                return fault(format!("the gzip is damaged ({error}); copy the file again"));
            }
        }
    }
    if rest.iter().any(|&byte| byte != 0) {
        notes.add("bytes after the end of the gzip, skipped", rest.len() as u64, None);
    }
    Ok(bytes)
}

/// Returns the name of a compressed file's contents: `a.obj` for `a.obj.gz`.
pub(super) fn inner(path: &Path) -> PathBuf {
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("gz") => path.with_extension(""),
        _ => path.into(),
    }
}
