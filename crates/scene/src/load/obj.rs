//! Reads the `v`, `vt`, and `f` statements of Wavefront OBJ files, line by line.
//!
//! No maintained crate meets the requirements. `tobj` 4.0 does not report the line of an error,
//! renumbers positions object by object, mixes lines with faces, and does unchecked arithmetic on
//! texture indices. `obj` 0.10 counts lines from 0, does not check indices against the tables,
//! ignores a wrong texture index, and keeps no line numbers for later checks.

use std::io::BufRead;
use std::str::{FromStr, SplitAsciiWhitespace};

use super::builder::{MeshBuilder, NO_UV};
use super::error::{Fault, fault, quote};
use super::lines::Lines;
use super::notes::Notes;
use crate::coordinate::Coordinate;
use crate::mesh::Mesh;

/// Statements that define curves and surfaces without triangles, in the current syntax and in the
/// syntax of version 2.11. Statements that only describe curves and surfaces are in [`OTHERS`].
const SURFACES: [&str; 8] = ["curv", "curv2", "surf", "bsp", "bzp", "cdc", "cdp", "res"];

/// Statements that read or run another file.
const CALLS: [&str; 2] = ["call", "csh"];

/// Statements that end with names. A name may end in a backslash, like the path of a Windows
/// folder.
const NAMES: [&str; 7] = ["g", "o", "usemtl", "mtllib", "usemap", "maplib", "mg"];

/// Statements that define neither triangles nor free-form curves or surfaces.
const OTHERS: [&str; 24] = [
    "vn",
    "vp",
    "p",
    "l",
    "s",
    "cstype",
    "deg",
    "bmat",
    "step",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
];

/// Reads all objects and groups into one mesh, with faces in the order of the file.
pub(super) fn read<S: Coordinate>(input: impl BufRead) -> Result<(Mesh<S>, Notes), Fault> {
    let mut lines = Lines::new(input);
    let mut model =
        Model { builder: MeshBuilder::numbered_from(1), corners: vec![], corner_uvs: vec![] };
    while lines.advance()? {
        let first = lines.number;
        model.builder.line = Some(first);
        join_continued(&mut lines)?;
        model.statement(&lines.text()).map_err(|fault| fault.at(first))?;
    }
    model.builder.finish()
}

/// Returns whether one of a file's first lines is a vertex.
pub(super) fn looks_like(start: &[u8]) -> bool {
    start.split(|byte| matches!(byte, b'\n' | b'\r')).any(|line| line.starts_with(b"v "))
}

/// Joins a line that ends in a backslash with the next line. A backslash at the end of a comment or
/// a name does not continue the line.
fn join_continued(lines: &mut Lines<impl BufRead>) -> Result<(), Fault> {
    let word = lines.bytes().trim_ascii_start();
    let word = word.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    if NAMES.iter().any(|name| name.as_bytes() == word) {
        return Ok(());
    }
    let mut from = 0;
    loop {
        // Trailing blanks are removed, including those before blank lines.
        let piece = lines.bytes().get(from..).unwrap_or_default();
        if !piece.ends_with(b"\\") || comment(piece).is_some() {
            return Ok(());
        }
        from = lines.bytes().len();
        if !lines.join()? {
            return Ok(());
        }
    }
}

/// Returns the position at which a comment begins, if there is one. A `#` after a decimal point
/// does not begin a comment: some programs write `1.#INF` and `-1.#IND` for infinity and NaN.
fn comment(text: &[u8]) -> Option<usize> {
    (0..text.len()).find(|&i| text[i] == b'#' && (i == 0 || text[i - 1] != b'.'))
}

/// The model read so far.
struct Model<S> {
    builder: MeshBuilder<S>,
    /// The corners of the current face, kept here to avoid allocations.
    corners: Vec<u32>,
    corner_uvs: Vec<u32>,
}

impl<S: Coordinate> Model<S> {
    /// Reads one statement.
    fn statement(&mut self, text: &str) -> Result<(), Fault> {
        let text = &text[..comment(text.as_bytes()).unwrap_or(text.len())];
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("v") => self.vertex(words),
            Some("vt") => {
                // The second coordinate may be missing; the format then defines it as 0.
                let mut words = words.peekable();
                let u = number(words.next());
                let v = if words.peek().is_some() { number(words.next()) } else { Ok(0.0) };
                // Texture coordinates are optional, so an invalid number is not an error.
                self.builder.uv([u, v].map(|x| x.unwrap_or(f32::NAN)))
            }
            // `fo` is an old name for `f`.
            Some("f" | "fo") => self.face(words),
            Some(word) => {
                self.pass(word);
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// Reads a vertex: three numbers, which may be followed by a weight or colours.
    fn vertex(&mut self, mut words: SplitAsciiWhitespace<'_>) -> Result<(), Fault> {
        let words = [words.next(), words.next(), words.next()];
        if words.contains(&None) {
            return fault("a number is missing; v needs three");
        }
        match words.map(number) {
            [Ok(x), Ok(y), Ok(z)] => self.builder.position([x, y, z]),
            numbers => {
                let cause = numbers.into_iter().find_map(Result::err).unwrap_or_default();
                self.builder.broken_position(cause)
            }
        }
    }

    /// Reads a face with corners `v`, `v/vt`, `v//vn`, or `v/vt/vn`. Normals are not needed, so
    /// they are not looked up.
    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        self.corners.clear();
        self.corner_uvs.clear();
        let mut has_uvs = false;
        for word in words {
            let mut fields = word.split('/');
            let vertex = fields.next().unwrap_or_default();
            let index = place(vertex, self.builder.vertices(), "vertex")?;
            self.corners.push(index.map_err(|count| Fault {
                line: None,
                cause: format!(
                    "a face refers to vertex {vertex}, but there are {count} so far, numbered from 1"
                ),
            })?);
            let uv = fields.next().filter(|field| !field.is_empty());
            has_uvs |= uv.is_some();
            let uv = uv.map(|uv| place(uv, self.builder.uvs(), "texture coordinate"));
            self.corner_uvs.push(uv.transpose()?.and_then(Result::ok).unwrap_or(NO_UV));
            let normal = fields.next().filter(|field| !field.is_empty());
            if normal.is_some_and(|field| field.parse::<i64>().is_err()) || fields.next().is_some()
            {
                return fault(format!("a face has the corner {}, not v/vt/vn", quote(word)));
            }
        }
        if !has_uvs {
            self.corner_uvs.clear();
        }
        self.builder.polygon(&self.corners, &self.corner_uvs)
    }

    /// Skips a statement, adding a note if it may have defined a surface.
    fn pass(&mut self, word: &str) {
        let what = if SURFACES.contains(&word) {
            "statements of free-form curves and surfaces, skipped"
        } else if CALLS.contains(&word) {
            "statements that call other files, skipped"
        } else if NAMES.contains(&word) || OTHERS.contains(&word) {
            return;
        } else {
            "unknown statements, skipped"
        };
        self.builder.notes.add(what, 1, self.builder.line);
    }
}

/// Parses a word as a number, or returns an error message.
fn number<N: FromStr>(word: Option<&str>) -> Result<N, String> {
    let word = word.unwrap_or_default();
    word.parse().map_err(|_| format!("{} is not a number", quote(word)))
}

/// Returns the 0-based position of an index in a table that has `count` entries so far. Indices
/// count up from 1, or down from -1 for the last entry. Positions beyond the last entry may be
/// filled later. For an index that can never become valid, the inner result is an `Err` with the
/// count.
fn place(word: &str, count: usize, what: &str) -> Result<Result<u32, usize>, Fault> {
    let Ok(index) = word.parse::<i64>() else {
        return fault(format!("{} is not the number of a {what}", quote(word)));
    };
    let place = if index < 0 { index.checked_add(count as i64) } else { index.checked_sub(1) };
    let place = place.and_then(|place| u32::try_from(place).ok()).filter(|&place| place != NO_UV);
    Ok(place.ok_or(count))
}
