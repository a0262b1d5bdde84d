//! The golden answers: the answers of every mode on fixed scenes, which must be the same bit for
//! bit on any machine.
//!
//! A line consists of a scene, a mode, a query, the number of hits (or of crossings, or of points
//! inside), and a hash of all bits of the answers. Each [`Section`] keeps its lines in a separate
//! file, so a new section does not change the others. CONTRIBUTING.md states when a line may
//! change.
//!
//! ```
//! use intertri::simd::Level;
//!
//! for level in Level::all() {
//!     for section in intertri_golden::SECTIONS {
//!         assert_eq!(section.differences(level), []);
//!     }
//! }
//! ```

mod digest;
mod doubles;
mod grid;
mod lists;
mod modes;
mod nearest;
mod report;
mod saved;
mod scenes;
mod solid64;
#[cfg(target_arch = "wasm32")]
pub mod wasm;

use std::fmt;

use intertri::simd::Level;

use digest::Digest;
pub use report::{Row, report};

/// A group of answers that are computed here and compared with committed ones.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// The name, a single word.
    pub name: &'static str,
    /// The path to the file of lines, relative to this crate.
    pub file: &'static str,
    golden: &'static str,
    answers: fn(Level) -> Vec<Line>,
}

/// Defines a section from its name, its file, and the function that computes its lines.
macro_rules! section {
    ($name:literal, $file:literal, $answers:expr) => {
        Section {
            name: $name,
            file: $file,
            golden: include_str!(concat!("../", $file)),
            answers: $answers,
        }
    };
}

/// All sections. To add one, add a file of answers (empty at first), a function that computes them,
/// and a row here.
pub const SECTIONS: &[Section] = &[
    section!("modes", "answers.txt", modes::answers),
    section!("fixed", "fixed.txt", grid::answers),
    section!("doubles", "doubles.txt", doubles::answers),
    section!("lists", "lists.txt", lists::answers),
    section!("nearest", "nearest.txt", nearest::answers),
    section!("saved", "saved.txt", saved::answers),
    section!("solid64", "solid64.txt", solid64::answers),
];

impl Section {
    /// Computes the lines at a level.
    pub fn answers(&self, level: Level) -> Vec<Line> {
        (self.answers)(level)
    }

    /// Returns the committed lines.
    pub fn golden(&self) -> impl Iterator<Item = &'static str> {
        self.golden.lines()
    }

    /// Returns a hash of all committed lines.
    pub fn golden_hash(&self) -> u64 {
        hash(self.golden())
    }

    /// Returns the lines that differ, as pairs of a computed line and a committed line.
    pub fn differences(&self, level: Level) -> Vec<(String, String)> {
        differences(&self.answers(level), self.golden())
    }
}

/// Returns the computed and committed lines that differ. If one side has fewer lines, the missing
/// ones are empty.
pub fn differences<'a>(
    lines: &[Line],
    golden: impl Iterator<Item = &'a str>,
) -> Vec<(String, String)> {
    let mut lines = lines.iter().map(Line::to_string);
    let mut golden = golden.map(str::to_owned);
    let pairs = std::iter::from_fn(|| match (lines.next(), golden.next()) {
        (None, None) => None,
        (here, golden) => Some((here.unwrap_or_default(), golden.unwrap_or_default())),
    });
    pairs.filter(|(here, golden)| here != golden).collect()
}

/// Returns a hash of lines as they appear in a file.
pub fn hash(lines: impl Iterator<Item = impl AsRef<str>>) -> u64 {
    let mut digest = Digest::new();
    for line in lines {
        line.as_ref().bytes().chain([b'\n']).for_each(|byte| digest.word(byte.into()));
    }
    digest.hash
}

/// A summary of the answers to a query on a scene in a mode.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    scene: String,
    mode: String,
    query: String,
    hits: u64,
    hash: u64,
}

impl Line {
    fn new(scene: &str, mode: &str, query: &str, digest: &Digest) -> Self {
        let [scene, mode, query] = [scene, mode, query].map(str::to_owned);
        Self { scene, mode, query, hits: digest.hits, hash: digest.hash }
    }
}

/// Formats the line as in the files: `scene | mode | query | hits | hash`.
impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, mode, query, hits, hash } = self;
        write!(f, "{scene} | {mode} | {query} | {hits} | {hash:#018x}")
    }
}
