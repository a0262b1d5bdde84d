//! Wavefront OBJ: `v`, `vt` and `f`, read line by line.
//!
//! A reader of our own, because the kept crates lose what is promised here. `tobj` 4.0 names no line
//! in its errors, renumbers positions object by object, mixes lines with faces, and does unchecked
//! arithmetic on texture indices; `obj` 0.10 counts lines from 0, checks no index against the tables,
//! takes a wrong texture index for none, and keeps no line to name once the check is made outside.

use std::io::BufRead;
use std::str::FromStr;

use super::builder::{MeshBuilder, push};
use super::error::{Fault, fault, quote};
use super::lines::Lines;
use crate::coordinate::Coordinate;
use crate::mesh::Mesh;

/// Reads all objects and groups into one mesh, faces in the order of the file.
pub(super) fn read<S: Coordinate>(input: impl BufRead) -> Result<Mesh<S>, Fault> {
    let mut lines = Lines::after(0, input);
    let mut model = Model::default();
    loop {
        let first = lines.number + 1;
        if !lines.advance_joined()? {
            return Ok(model.builder.mesh);
        }
        model.statement(&lines.text()).map_err(|fault| fault.at(first))?;
    }
}

/// Whether some line of a file's beginning is a vertex.
pub(super) fn looks_like(start: &[u8]) -> bool {
    start.split(|byte| matches!(byte, b'\n' | b'\r')).any(|line| line.starts_with(b"v "))
}

/// What was read so far. The tables grow with the file, because a negative index counts back from
/// where it stands.
#[derive(Default)]
struct Model<S> {
    builder: MeshBuilder<S>,
    uvs: Vec<[f32; 2]>,
    /// The corners of the current face, kept here to spare allocations.
    corners: Vec<u32>,
    corner_uvs: Vec<[f32; 2]>,
}

impl<S: Coordinate> Model<S> {
    /// One statement; all but vertices, texture coordinates and faces is skipped.
    fn statement(&mut self, text: &str) -> Result<(), Fault> {
        // A comment may follow a statement.
        let text = text.split('#').next().unwrap_or_default();
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let position = [number(&mut words)?, number(&mut words)?, number(&mut words)?];
                self.builder.position(position)
            }
            Some("vt") => {
                // The second coordinate may be missing: it is 0 then, says the format.
                let u = number(&mut words)?;
                let mut rest = words.peekable();
                let v = if rest.peek().is_some() { number(&mut rest)? } else { 0.0 };
                push(&mut self.uvs, [u, v])
            }
            Some("f") => self.face(words),
            _ => Ok(()),
        }
    }

    /// A face: corners `v`, `v/vt`, `v//vn` or `v/vt/vn`. Normals are not needed, so not looked up.
    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        self.corners.clear();
        self.corner_uvs.clear();
        for word in words {
            let mut fields = word.split('/');
            let vertex = fields.next().unwrap_or_default();
            self.corners.push(index(vertex, self.builder.mesh.positions.len(), "vertex")? as u32);
            if let Some(uv) = fields.next().filter(|field| !field.is_empty()) {
                self.corner_uvs.push(self.uvs[index(uv, self.uvs.len(), "texture coordinate")?]);
            }
            let normal = fields.next().filter(|field| !field.is_empty());
            if normal.is_some_and(|field| field.parse::<i64>().is_err()) || fields.next().is_some()
            {
                return fault(format!("a face has the corner {}, not v/vt/vn", quote(word)));
            }
        }
        // A face has texture coordinates at all of its corners or at none.
        if self.corner_uvs.len() != self.corners.len() {
            self.corner_uvs.clear();
        }
        self.builder.polygon(&self.corners, &self.corner_uvs)
    }
}

/// The next word as a number.
fn number<'a, N: FromStr>(words: &mut impl Iterator<Item = &'a str>) -> Result<N, Fault> {
    match words.next().map(|word| (word, word.parse())) {
        Some((_, Ok(number))) => Ok(number),
        Some((word, Err(_))) => fault(format!("{} is not a number", quote(word))),
        None => fault("a number is missing; v needs three, vt one"),
    }
}

/// An index into a table of `count` entries so far: from 1 up, or from -1 down for the last.
fn index(word: &str, count: usize, what: &str) -> Result<usize, Fault> {
    let Ok(index) = word.parse::<i64>() else {
        return fault(format!("{} is not the number of a {what}", quote(word)));
    };
    let place = if index < 0 { index.checked_add(count as i64) } else { index.checked_sub(1) };
    match place.and_then(|place| usize::try_from(place).ok()) {
        Some(place) if place < count => Ok(place),
        _ => fault(format!("a face names {what} {index}, but there are {count} so far, from 1 on")),
    }
}
