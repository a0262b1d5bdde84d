//! Reads ASCII and binary STL files.
//!
//! This reader does not use the `stl_io` crate, because that crate reads only one solid from a file
//! with several, mistakes a binary file that begins with the word `solid` for ASCII, does not
//! report the line of an error, and does not check sizes. Its only remaining use would be to parse
//! records of twelve numbers.

use std::io::{BufRead, Read, Seek};

use super::builder::MeshBuilder;
use super::error::{Fault, fault, quote};
use super::lines::Lines;
use super::notes::Notes;
use super::text::{skip_mark, without_mark};
use crate::coordinate::Coordinate;
use crate::mesh::Mesh;

/// The number of bytes before the first triangle of a binary file: free text, then the triangle
/// count.
const HEADER: usize = 84;
/// The number of bytes per triangle: a normal, three corners, and two unused bytes.
const TRIANGLE: usize = 50;

/// The first word of an ASCII file, in upper or lower case.
const SOLID: &[u8] = b"solid";

/// Reads all solids from a file of the given size.
pub(super) fn read<S: Coordinate>(
    mut input: impl BufRead + Seek,
    size: u64,
) -> Result<(Mesh<S>, Notes), Fault> {
    let mut start = Vec::new();
    input.by_ref().take(HEADER as u64).read_to_end(&mut start)?;
    let mut builder = MeshBuilder::numbered_from(0);
    if is_ascii(&start, size) {
        input.rewind()?;
        skip_mark(&mut input)?;
        ascii(Lines::new(input), &mut builder)?;
    } else {
        binary(&start, input, size, &mut builder)?;
    }
    builder.finish()
}

/// Reads the triangles after the header of a binary file of the given size.
fn binary<S: Coordinate>(
    header: &[u8],
    mut input: impl Read,
    size: u64,
    builder: &mut MeshBuilder<S>,
) -> Result<(), Fault> {
    let Some(promised) = promised(header) else {
        return fault("is neither an ascii nor a binary STL");
    };
    let mut triangles = (promised - HEADER as u64) / TRIANGLE as u64;
    if promised > size {
        return fault(format!(
            "its header promises {triangles} triangles, which take {promised} bytes, but the file \
             has {size}; it is cut off or not an STL"
        ));
    }
    // A program that does not know the number of triangles in advance may write a number that is
    // too small. More triangles are read if the number is 0, or if whole triangles fill the rest of
    // the file.
    let behind = size - promised;
    if behind >= TRIANGLE as u64 && (triangles == 0 || behind.is_multiple_of(TRIANGLE as u64)) {
        let more = behind / TRIANGLE as u64;
        let what = format!("triangles beyond the {triangles} that the header promises, also read");
        builder.notes.add(what, more, None);
        triangles += more;
    }
    let over = size - HEADER as u64 - triangles * TRIANGLE as u64;
    if over > 0 {
        builder.notes.add("bytes after the last triangle, skipped", over, None);
    }
    for _ in 0..triangles {
        let mut record = [0; TRIANGLE];
        input.read_exact(&mut record)?;
        let (numbers, _) = record.as_chunks::<4>();
        let number = |i: usize| S::from(f32::from_le_bytes(numbers[i]));
        let corner = |i: usize| [number(i), number(i + 1), number(i + 2)];
        add([corner(3), corner(6), corner(9)], builder)?;
    }
    Ok(())
}

/// Returns whether a file with these first bytes and this size is an STL.
pub(super) fn looks_like(start: &[u8], size: u64) -> bool {
    is_ascii(start, size) || promised(start) == Some(size)
}

/// Returns whether the file is ASCII. An ASCII file begins with `solid`, but so may the free text
/// of a binary file. A binary file has the size that its header implies or, if it is damaged, at
/// least one zero byte in its free text or count.
fn is_ascii(start: &[u8], size: u64) -> bool {
    let text = without_mark(start).trim_ascii_start();
    text.get(..SOLID.len()).is_some_and(|word| word.eq_ignore_ascii_case(SOLID))
        && promised(start) != Some(size)
        && start.iter().take(HEADER).all(|&byte| byte != 0)
}

/// Returns the size of a binary file according to the number of triangles in its header.
fn promised(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..HEADER)?.try_into().ok()?;
    Some(HEADER as u64 + u64::from(u32::from_le_bytes(count)) * TRIANGLE as u64)
}

/// The first words of the statements that make up a facet, each on its own line.
const FACET: [&str; 7] = ["facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet"];

/// Reads solids made of facets. Words may be in upper or lower case; names and normals are ignored.
fn ascii<S: Coordinate>(
    mut lines: Lines<impl BufRead>,
    builder: &mut MeshBuilder<S>,
) -> Result<(), Fault> {
    // The next expected statement of a facet, or `None` between solids.
    let mut next = None;
    let mut corners = [[S::ZERO; 3]; 3];
    while lines.advance()? {
        let text = lines.text();
        let mut words = text.split_ascii_whitespace();
        let Some(word) = words.next().map(str::to_ascii_lowercase) else { continue };
        builder.line = Some(lines.number);
        let wrong = |cause: String| Err(Fault { line: Some(lines.number), cause });
        next = match next {
            None if word.starts_with("solid") => Some(0),
            None => return wrong(format!("{} instead of the expected solid", quote(&word))),
            Some(0) if word == "endsolid" => None,
            Some(place) if word != FACET[place] => {
                return wrong(format!("{} instead of the expected {}", quote(&word), FACET[place]));
            }
            Some(place) => {
                if let Some(corner) = place.checked_sub(2).and_then(|i| corners.get_mut(i)) {
                    let numbers: Option<Vec<S>> = words.map(|word| word.parse().ok()).collect();
                    match numbers.and_then(|numbers| <[S; 3]>::try_from(numbers).ok()) {
                        Some(numbers) => *corner = numbers,
                        None => {
                            return wrong(format!("{} is not a vertex x y z", quote(text.trim())));
                        }
                    }
                }
                if place + 1 == FACET.len() {
                    add(corners, builder).map_err(|fault| fault.at(lines.number))?;
                }
                Some((place + 1) % FACET.len())
            }
        };
    }
    match next {
        None => Ok(()),
        // If the file ends between facets, nothing is lost.
        Some(0) => {
            builder.notes.add("solids without endsolid, read as far as they go", 1, builder.line);
            Ok(())
        }
        Some(_) => fault("the file is cut off in the middle of a facet")
            .map_err(|fault: Fault| fault.at(lines.number)),
    }
}

fn add<S: Coordinate>(corners: [[S; 3]; 3], builder: &mut MeshBuilder<S>) -> Result<(), Fault> {
    let first = builder.vertices() as u32;
    for corner in corners {
        builder.position(corner)?;
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
