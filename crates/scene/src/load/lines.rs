//! Lines of text, numbered and of bounded length.

use std::borrow::Cow;
use std::io::{self, BufRead};

use super::error::{Fault, fault};

/// No line is longer: a face of a million corners takes half of it.
const LONGEST: usize = 1 << 24;

/// A text, line by line.
pub(super) struct Lines<R> {
    input: R,
    line: Vec<u8>,
    /// The number of the line last read, from 1.
    pub(super) number: u64,
}

impl<R: BufRead> Lines<R> {
    /// The lines that follow line `number`.
    pub(super) fn after(number: u64, input: R) -> Self {
        Self { input, line: Vec::new(), number }
    }

    /// The input behind the lines that were read.
    pub(super) fn input(&mut self) -> &mut R {
        &mut self.input
    }

    /// Reads the next line; false at the end of the file.
    pub(super) fn advance(&mut self) -> Result<bool, Fault> {
        self.line.clear();
        self.append()
    }

    /// Reads the next line, those that end in a backslash joined with their next.
    pub(super) fn advance_joined(&mut self) -> Result<bool, Fault> {
        self.line.clear();
        while self.append()? {
            match self.line.last_mut() {
                Some(end) if *end == b'\\' => *end = b' ',
                _ => return Ok(true),
            }
        }
        // The file may end in a backslash: then what was joined so far is its last line.
        Ok(!self.line.is_empty())
    }

    /// The line without blanks at its end. What is read of a model is ASCII, but names may be in any
    /// encoding.
    pub(super) fn text(&self) -> Cow<'_, str> {
        String::from_utf8_lossy(&self.line)
    }

    /// Reads up to the next line end: a line feed, a carriage return, or both.
    fn append(&mut self) -> Result<bool, Fault> {
        let (mut any, mut end) = (false, None);
        while end.is_none() {
            let bytes = fill(&mut self.input)?;
            if bytes.is_empty() {
                break;
            }
            any = true;
            end =
                bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r')).map(|i| (i, bytes[i]));
            let (taken, used) = end.map_or((bytes.len(), bytes.len()), |(i, _)| (i, i + 1));
            self.line.extend_from_slice(&bytes[..taken]);
            self.input.consume(used);
            if self.line.len() > LONGEST {
                self.number += 1;
                let cause = format!("a line of more than {LONGEST} bytes; is it a model?");
                return fault(cause).map_err(|fault: Fault| fault.at(self.number));
            }
        }
        if !any {
            return Ok(false);
        }
        if matches!(end, Some((_, b'\r'))) && fill(&mut self.input)?.first() == Some(&b'\n') {
            self.input.consume(1);
        }
        self.number += 1;
        self.line.truncate(self.line.trim_ascii_end().len());
        Ok(true)
    }
}

/// What has come of the input and is not yet read.
fn fill(input: &mut impl BufRead) -> io::Result<&[u8]> {
    // Asked for twice, because a loop could not give away what it has borrowed.
    while let Err(error) = input.fill_buf() {
        if error.kind() != io::ErrorKind::Interrupted {
            return Err(error);
        }
    }
    input.fill_buf()
}
