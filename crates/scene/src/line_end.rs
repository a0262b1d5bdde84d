//! Reads lines of text that end in a line feed, a carriage return, or both.

use std::io::{self, BufRead, ErrorKind};

/// The end of the last line that was read.
///
/// A carriage return ends a line immediately, even if a line feed may follow, because a program
/// that sends rays through a pipe may wait for the result before it continues. If a line feed
/// follows, the next line begins after the line feed.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum LineEnd {
    /// The line ended with a line feed, or no line has been read yet.
    #[default]
    Feed,
    /// The line ended with a carriage return, which a line feed may follow.
    ReturnAndPerhapsFeed,
    /// The line ended with a carriage return, as every line of the text does. A line feed that
    /// follows is not part of the line end.
    Return,
}

impl LineEnd {
    /// Skips a line feed that belongs to the end of the last line.
    pub(crate) fn pass(&mut self, input: &mut impl BufRead) -> io::Result<()> {
        if *self == Self::ReturnAndPerhapsFeed {
            if fill(input)?.first() == Some(&b'\n') {
                input.consume(1);
            }
            *self = Self::Feed;
        }
        Ok(())
    }

    /// Returns whether the available bytes contain a whole line, including its end.
    pub(crate) fn has_line(self, bytes: &[u8]) -> bool {
        let bytes = match (self, bytes) {
            (Self::ReturnAndPerhapsFeed, [b'\n', rest @ ..]) => rest,
            _ => bytes,
        };
        bytes.iter().any(|byte| matches!(byte, b'\n' | b'\r'))
    }
}

/// Appends the next line, without its end, to `line`. Returns false at the end of the text. Stops
/// within the line once `line` has more than `longest` bytes.
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

/// Returns the bytes that have arrived but have not been read yet. Waits if there are none, unless
/// the input has ended.
fn fill(input: &mut impl BufRead) -> io::Result<&[u8]> {
    // `fill_buf` is called twice because the loop cannot return a borrow.
    while let Err(error) = input.fill_buf() {
        if error.kind() != ErrorKind::Interrupted {
            return Err(error);
        }
    }
    input.fill_buf()
}
