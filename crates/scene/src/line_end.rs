//! The ends of lines of text: a line feed, a carriage return, or both.

use std::io::{self, BufRead, ErrorKind};

/// How the line that was read last has ended.
///
/// A carriage return ends a line at once, although a line feed may follow it: a program that writes rays
/// through a pipe may wait for the answer before it goes on. The next line then begins behind that.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum LineEnd {
    /// In a line feed, or none was read.
    #[default]
    Feed,
    /// In a carriage return, to which a line feed may belong.
    ReturnAndPerhapsFeed,
    /// In a carriage return, as all lines of the text do.
    Return,
}

impl LineEnd {
    /// Steps over the line feed that belongs to the last line's end.
    pub(crate) fn pass(&mut self, input: &mut impl BufRead) -> io::Result<()> {
        if *self == Self::ReturnAndPerhapsFeed {
            if fill(input)?.first() == Some(&b'\n') {
                input.consume(1);
            }
            *self = Self::Feed;
        }
        Ok(())
    }

    /// Whether a whole line is among the bytes that have come.
    pub(crate) fn has_line(self, bytes: &[u8]) -> bool {
        let bytes = match (self, bytes) {
            (Self::ReturnAndPerhapsFeed, [b'\n', rest @ ..]) => rest,
            _ => bytes,
        };
        bytes.iter().any(|byte| matches!(byte, b'\n' | b'\r'))
    }
}

/// Appends the next line without its end to `line`; false at the end of the text. A line that becomes
/// longer than `longest` is left in the middle.
pub(crate) fn read_line(
    input: &mut impl BufRead,
    line: &mut Vec<u8>,
    last: &mut LineEnd,
    longest: usize,
) -> io::Result<bool> {
    last.pass(input)?;
    let mut any = false;
    loop {
        let bytes = fill(input)?;
        if bytes.is_empty() {
            return Ok(any);
        }
        any = true;
        let end = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        line.extend_from_slice(&bytes[..end.unwrap_or(bytes.len())]);
        let used = end.map_or(bytes.len(), |end| end + 1);
        if end.is_some_and(|end| bytes[end] == b'\r') && *last == LineEnd::Feed {
            *last = LineEnd::ReturnAndPerhapsFeed;
        }
        input.consume(used);
        if end.is_some() || line.len() > longest {
            return Ok(true);
        }
    }
}

/// The input that has arrived and is not yet read.
fn fill(input: &mut impl BufRead) -> io::Result<&[u8]> {
    // Asked for twice, because a loop could not give away what it has borrowed.
    while let Err(error) = input.fill_buf() {
        if error.kind() != ErrorKind::Interrupted {
            return Err(error);
        }
    }
    input.fill_buf()
}
