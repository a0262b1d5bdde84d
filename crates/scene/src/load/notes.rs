//! Notes about a model: what was skipped, repaired, or guessed when its file was read.

use std::borrow::Cow;
use std::fmt;

/// A note about one kind of problem in a file: what was skipped, repaired, or guessed, and how
/// often.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The kind of problem and what was done, such as
    /// `faces with fewer than three corners, skipped`.
    pub what: Cow<'static, str>,
    /// The number of occurrences.
    pub count: u64,
    /// In a text file, the line of the first occurrence, counted from 1.
    pub line: Option<u64>,
}

/// Formats a note like `faces with fewer than three corners, skipped: 2 (the first in line 5)`.
impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.what, self.count)?;
        match self.line {
            Some(line) if self.count > 1 => write!(f, " (the first in line {line})"),
            Some(line) => write!(f, " (in line {line})"),
            None => Ok(()),
        }
    }
}

/// The notes about a model, one per kind, in order of first occurrence.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Notes(Vec<Note>);

impl Notes {
    /// Adds `count` occurrences of one kind of problem, the first of which is in `line`.
    ///
    /// ```
    /// let mut notes = intertri_scene::Notes::default();
    /// notes.add("faces with fewer than three corners, skipped", 1, Some(5));
    /// notes.add("faces with fewer than three corners, skipped", 1, Some(9));
    /// let [note] = notes.as_slice() else { panic!() };
    /// assert_eq!(note.to_string(), "faces with fewer than three corners, skipped: 2 (the first in line 5)");
    /// ```
    pub fn add(&mut self, what: impl Into<Cow<'static, str>>, count: u64, line: Option<u64>) {
        let what = what.into();
        match self.0.iter_mut().find(|note| note.what == what) {
            Some(note) => note.count += count,
            None => self.0.push(Note { what, count, line }),
        }
    }

    /// Returns the notes, in order of first occurrence.
    pub fn as_slice(&self) -> &[Note] {
        &self.0
    }

    /// Adds all notes from another list.
    pub(super) fn extend(&mut self, others: Self) {
        for Note { what, count, line } in others.0 {
            self.add(what, count, line);
        }
    }
}
