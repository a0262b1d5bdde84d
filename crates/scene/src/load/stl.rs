//! STL, ascii and binary, by the crate `stl_io`.
//!
//! The crate reads one solid. What is done around it: telling ascii from binary by size, because many
//! binary files begin with the word `solid` too; checking the promised size; several ascii solids in
//! one file; and the line of an error, which the crate does not know.

use std::io::{Cursor, Read};

use super::{Builder, Fault, fault};
use crate::mesh::Mesh;

/// Bytes before the first triangle of a binary file: a free text, then the number of triangles.
const HEADER: usize = 84;
/// Bytes of one triangle.
const TRIANGLE: u64 = 50;
/// Lines of one triangle in ascii that are not blank: facet, outer loop, 3 vertex, endloop, endfacet.
const FACET_LINES: usize = 7;

/// Reads all solids.
pub(super) fn read(mut input: impl Read) -> Result<Mesh, Fault> {
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes)?;
    let mut builder = Builder::default();
    let size = bytes.len() as u64;
    if is_ascii(&bytes, size) {
        ascii(&bytes, &mut builder)?;
    } else {
        match promised(&bytes) {
            Some(promised) if promised <= size => binary(bytes, &mut builder)?,
            Some(promised) => {
                return fault(format!(
                    "its header promises {} triangles, which take {promised} bytes, but the file has \
                     {size}; it is cut off or no STL",
                    (promised - HEADER as u64) / TRIANGLE
                ));
            }
            None => return fault("is neither an ascii nor a binary STL"),
        }
    }
    Ok(builder.mesh)
}

/// Whether a file of that beginning and size is an STL.
pub(super) fn looks_like(start: &[u8], size: u64) -> bool {
    is_ascii(start, size) || promised(start) == Some(size)
}

/// Whether it is an ascii file: it begins with `solid`, and is not a binary one whose free text does.
/// That has the promised size or, when it is damaged, at least a zero byte in its free text or count.
fn is_ascii(start: &[u8], size: u64) -> bool {
    start.trim_ascii_start().starts_with(b"solid")
        && promised(start) != Some(size)
        && start.iter().take(HEADER).all(|&byte| byte != 0)
}

/// How large a binary file is by the number of triangles in its header.
fn promised(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..HEADER)?.try_into().ok()?;
    Some(HEADER as u64 + u64::from(u32::from_le_bytes(count)) * TRIANGLE)
}

fn binary(mut bytes: Vec<u8>, builder: &mut Builder) -> Result<(), Fault> {
    // The free text must not begin like an ascii file, or the crate takes it for one.
    bytes[0] = 0;
    let mut input = Cursor::new(bytes);
    for triangle in stl_io::create_stl_reader(&mut input)? {
        add(&triangle?, builder)?;
    }
    Ok(())
}

fn ascii(bytes: &[u8], builder: &mut Builder) -> Result<(), Fault> {
    // Cut the lines that are not blank, with their numbers, into solids.
    let lines = bytes.split(|&byte| byte == b'\n').zip(1..).map(|(line, n)| (line.trim_ascii(), n));
    let lines: Vec<(&[u8], u64)> = lines.filter(|(line, _)| !line.is_empty()).collect();
    let mut rest = &lines[..];
    while !rest.is_empty() {
        let end = rest.iter().skip(1).position(|(line, _)| line.starts_with(b"solid"));
        let (solid_lines, others) = rest.split_at(end.map_or(rest.len(), |end| end + 1));
        solid(solid_lines, builder)?;
        rest = others;
    }
    Ok(())
}

/// One ascii solid, by its lines.
fn solid(lines: &[(&[u8], u64)], builder: &mut Builder) -> Result<(), Fault> {
    // The name goes, because the crate knows no solid without one.
    let mut text = b"solid \n".to_vec();
    for (line, _) in &lines[1..] {
        text.extend_from_slice(line);
        text.push(b'\n');
    }
    // Facet k takes the lines from 1 + 7 k on: there is the line of whatever is wrong with it.
    let line = |facet: usize| lines[(1 + facet * FACET_LINES).min(lines.len() - 1)].1;
    let mut facets = 0;
    let mut input = Cursor::new(text);
    for triangle in stl_io::create_stl_reader(&mut input)? {
        let added = triangle.map_err(|error| Fault {
            line: None,
            cause: format!("the facet that begins here is damaged: {error}"),
        });
        added.and_then(|t| add(&t, builder)).map_err(|fault| fault.at(line(facets)))?;
        facets += 1;
    }
    // Its first line, its facets and `endsolid`: what comes after would be dropped silently.
    if let Some((_, line)) = lines.get(2 + facets * FACET_LINES) {
        return Err(Fault { line: Some(*line), cause: "there is text after endsolid".into() });
    }
    Ok(())
}

fn add(triangle: &stl_io::Triangle, builder: &mut Builder) -> Result<(), Fault> {
    let first = builder.mesh.positions.len() as u32;
    for vertex in triangle.vertices {
        builder.position(vertex.0)?;
    }
    builder.polygon(&[first, first + 1, first + 2], &[])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_binary_file_without_zero_bytes_is_known_by_its_size() {
        let mut start = b"solid as a rock".to_vec();
        start.resize(HEADER - 4, b' ');
        start.extend(0x0101_0101_u32.to_le_bytes());
        let size = 84 + 0x0101_0101 * 50;
        assert!(!is_ascii(&start, size) && looks_like(&start, size));
        assert!(is_ascii(&start, size + 1));
    }
}
