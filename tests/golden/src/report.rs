//! The report, which shows computed and committed answers side by side.

use std::fmt::{self, Write};

use intertri::simd::Level;

use crate::{SECTIONS, Section, differences, hash};

/// The maximum number of differing lines to print.
const SHOWN: usize = 5;

/// The result for a section at one level: how the answers computed here differ from the committed
/// ones.
#[derive(Clone, Debug)]
pub struct Row {
    /// The name of the section.
    pub section: &'static str,
    /// The name of the level.
    pub level: &'static str,
    /// The number of lines computed here.
    pub lines: usize,
    /// The hash of the lines computed here.
    pub here: u64,
    /// The hash of the committed lines.
    pub committed: u64,
    /// The lines that differ, as pairs of a computed line and a committed line.
    pub differences: Vec<(String, String)>,
}

impl Row {
    /// Computes a section at a level.
    pub fn new(section: &Section, level: Level) -> Self {
        let lines = section.answers(level);
        Self {
            section: section.name,
            level: level.name(),
            lines: lines.len(),
            here: hash(lines.iter().map(ToString::to_string)),
            committed: section.golden_hash(),
            differences: differences(&lines, section.golden()),
        }
    }

    /// Returns whether every computed line equals the committed one.
    pub fn is_same(&self) -> bool {
        self.differences.is_empty()
    }
}

/// Formats a row of the table, followed by some of the differences.
impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { section, level, lines, here, committed, differences } = self;
        let verdict = if self.is_same() { "same" } else { "DIFFERENT" };
        write!(
            f,
            "{section:<10}{level:<10}{lines:>7}  {here:#018x}  {committed:#018x}  {verdict}"
        )?;
        for (here, committed) in differences.iter().take(SHOWN) {
            write!(f, "\n  here       {here}\n  committed  {committed}")?;
        }
        Ok(())
    }
}

/// Computes every section at every level of this machine. Returns a table, and whether all lines
/// equal the committed ones.
pub fn report() -> (String, bool) {
    let (arch, os) = (std::env::consts::ARCH, std::env::consts::OS);
    let mut text = format!(
        "{arch} {os}\n{:<10}{:<10}{:>7}  {:<20}{}\n",
        "section", "level", "lines", "here", "committed"
    );
    let mut same = true;
    for section in SECTIONS {
        for level in Level::all() {
            let row = Row::new(section, level);
            writeln!(text, "{row}").expect("writing to a string succeeds");
            same &= row.is_same();
        }
    }
    (text, same)
}
