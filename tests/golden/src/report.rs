//! The report: a machine's answers and the committed ones.

use std::fmt::{self, Write};

use intertri::simd::Level;

use crate::{SECTIONS, Section, differences, hash};

/// How many of the lines that differ are printed.
const SHOWN: usize = 5;

/// A section at a level: what this machine computes, and what is committed.
#[derive(Clone, Debug)]
pub struct Row {
    /// The section's name.
    pub section: &'static str,
    /// The level's name.
    pub level: &'static str,
    /// How many lines this machine computes.
    pub lines: usize,
    /// One number for all of them.
    pub here: u64,
    /// One number for all committed ones.
    pub committed: u64,
    /// The lines that differ: here, and committed.
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

    /// Whether every line is the committed one.
    pub fn is_same(&self) -> bool {
        self.differences.is_empty()
    }
}

/// A line of a table, and some of what differs.
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

/// Every section at every level of this machine, as a table; and whether all is the same.
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
            writeln!(text, "{row}").expect("text");
            same &= row.is_same();
        }
    }
    (text, same)
}
