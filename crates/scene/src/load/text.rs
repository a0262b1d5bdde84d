//! Handles byte order marks, which some editors put at the beginning of a text file.

use std::io::{BufRead, Read, Seek, SeekFrom};

use super::error::{Fault, fault};

/// The UTF-8 byte order mark.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Returns the first bytes of a file without the byte order mark, if there is one.
pub(super) fn without_mark(start: &[u8]) -> &[u8] {
    start.strip_prefix(MARK).unwrap_or(start)
}

/// Skips the UTF-8 byte order mark at the beginning of a file, if there is one. Returns an error if
/// the file begins with a UTF-16 byte order mark.
pub(super) fn skip_mark(input: &mut (impl BufRead + Seek)) -> Result<(), Fault> {
    let mut start = Vec::new();
    input.by_ref().take(MARK.len() as u64).read_to_end(&mut start)?;
    if start.starts_with(b"\xff\xfe") || start.starts_with(b"\xfe\xff") {
        return fault("is text in UTF-16; save it as UTF-8");
    }
    let mark = if start == MARK { MARK.len() as u64 } else { 0 };
    input.seek(SeekFrom::Start(mark))?;
    Ok(())
}
