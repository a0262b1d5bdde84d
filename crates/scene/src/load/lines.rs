//! Reads text files line by line, with a limit on the length of a line.

use std::borrow::Cow;
use std::io::BufRead;

use super::error::{Fault, fault};
use crate::line_end::{LineEnd, read_line};

/// The maximum length of a line, in bytes: about twice the length of a face with a million corners.
const LONGEST: usize = 1 << 24;

/// A text file, read line by line.
pub(super) struct Lines<R> {
    input: R,
    line: Vec<u8>,
    end: LineEnd,
    /// The number of the last line that was read, counted from 1.
    pub(super) number: u64,
}

impl<R: BufRead> Lines<R> {
    /// Creates a line reader for a text file.
    pub(super) fn new(input: R) -> Self {
        Self { input, line: Vec::new(), end: LineEnd::default(), number: 0 }
    }

    /// Creates a line reader for a text file in which every line ends in a carriage return. A line
    /// feed after a carriage return is not part of the line end.
    pub(super) fn of_returns(input: R) -> Self {
        Self { end: LineEnd::Return, ..Self::new(input) }
    }

    /// Returns the input, positioned after the last line that was read.
    pub(super) fn input(&mut self) -> Result<&mut R, Fault> {
        self.end.pass(&mut self.input)?;
        Ok(&mut self.input)
    }

    /// Reads the next line. Returns false at the end of the file.
    pub(super) fn advance(&mut self) -> Result<bool, Fault> {
        self.line.clear();
        self.append()
    }

    /// Reads the next line that is not blank. Returns false at the end of the file.
    pub(super) fn advance_to_text(&mut self) -> Result<bool, Fault> {
        while self.advance()? {
            if !self.line.is_empty() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Replaces the last byte of the line with a blank and appends the next line. Returns false if
    /// there is no next line.
    pub(super) fn join(&mut self) -> Result<bool, Fault> {
        if let Some(last) = self.line.last_mut() {
            *last = b' ';
        }
        self.append()
    }

    /// Returns the line without trailing blanks.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.line
    }

    /// Returns the line without trailing blanks, as text. All the text that the readers use is
    /// ASCII, but names may be in any encoding.
    pub(super) fn text(&self) -> Cow<'_, str> {
        String::from_utf8_lossy(&self.line)
    }

    /// Appends the next line of the file to the current line, and removes trailing blanks.
    fn append(&mut self) -> Result<bool, Fault> {
        let read = read_line(&mut self.input, &mut self.line, &mut self.end, LONGEST)?;
        if !read {
            return Ok(false);
        }
        self.number += 1;
        if self.line.len() > LONGEST {
            let cause = format!("a line of more than {LONGEST} bytes; is it a model?");
            return fault(cause).map_err(|fault: Fault| fault.at(self.number));
        }
        self.line.truncate(self.line.trim_ascii_end().len());
        Ok(true)
    }
}
