//! Reads ASCII and binary PLY files, element by element. The `ply-rs-bw` crate reads the header and
//! binary elements. ASCII elements are parsed here, because the crate rejects numbers that are not
//! finite even in unused properties.

use std::io::{BufRead, ErrorKind};

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::builder::MeshBuilder;
use super::error::{Fault, fault, quote};
use super::lines::Lines;
use super::notes::Notes;
use crate::coordinate::Coordinate;
use crate::mesh::Mesh;

/// The possible names of the two properties that hold texture coordinates.
const UVS: [[&str; 2]; 3] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];
/// The possible names of the property that holds the corners of a face.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// The elements that contain triangles.
const FACES: [&str; 2] = ["face", "tristrips"];

/// The maximum length of a header, in bytes. Typical headers take a few hundred bytes.
const LONGEST_HEADER: usize = 1 << 20;

/// Reads vertices, faces, and strips, and skips other elements.
pub(super) fn read<S: Coordinate>(mut input: impl BufRead) -> Result<(Mesh<S>, Notes), Fault> {
    let beginning = input.fill_buf()?;
    let has_returns = beginning.starts_with(b"ply\r") && !beginning.starts_with(b"ply\r\n");
    let mut lines = if has_returns { Lines::of_returns(input) } else { Lines::new(input) };
    let header = header(&mut lines)?;
    let has_uvs = check(&header)?;

    // Read element by element, so that nothing unnecessary is kept and no allocation is sized by a
    // count in the header.
    let parser = Parser::<Element>::new();
    let mut builder = MeshBuilder::numbered_from(0);
    for def in header.elements.values() {
        for i in 0..def.count {
            let element = match header.encoding {
                Encoding::Ascii => ascii(&mut lines, def, i),
                Encoding::BinaryLittleEndian => parser
                    .read_little_endian_element(lines.input()?, def)
                    .map_err(|error| damaged(&error, def, i)),
                Encoding::BinaryBigEndian => parser
                    .read_big_endian_element(lines.input()?, def)
                    .map_err(|error| damaged(&error, def, i)),
            };
            if matches!(header.encoding, Encoding::Ascii) {
                builder.line = Some(lines.number);
            }
            let added = element.and_then(|element| match def.name.as_str() {
                "vertex" => vertex(&mut builder, element, has_uvs),
                "face" => face(&mut builder, &element, has_uvs),
                "tristrips" => strips(&mut builder, &element, has_uvs),
                _ => Ok(()),
            });
            added.map_err(|fault| match header.encoding {
                Encoding::Ascii => fault.at(lines.number),
                _ => Fault { cause: format!("{} {i}: {}", def.name, fault.cause), ..fault },
            })?;
        }
    }
    builder.finish()
}

/// Reads the header. Its lines may end in a line feed, a carriage return, or both, and may be
/// blank.
fn header(lines: &mut Lines<impl BufRead>) -> Result<Header, Fault> {
    let mut text = String::new();
    while lines.advance()? {
        // Replace a blank line with an empty comment, so that line numbers stay correct.
        let line = if lines.bytes().is_empty() { "comment".into() } else { lines.text() };
        text.push_str(&line);
        text.push('\n');
        if text.len() > LONGEST_HEADER {
            return fault(format!(
                "the PLY header has more than {LONGEST_HEADER} bytes; is it a model?"
            ));
        }
        if line == "end_header" || lines.number == 1 && line != "ply" {
            break;
        }
    }
    let header = Parser::<Element>::new().read_header(&mut Reader::new(text.as_bytes()));
    header.map_err(|error| Fault {
        line: error.line().map(|line| line as u64),
        cause: format!("the PLY header is damaged: {}", first_line(&error)),
    })
}

/// Checks that the header declares everything a mesh needs. Returns whether vertices have texture
/// coordinates.
fn check(header: &Header) -> Result<bool, Fault> {
    let has = |element: &str, property: &str| {
        header.elements.get(element).is_some_and(|def| def.properties.contains_key(property))
    };
    if !["x", "y", "z"].iter().all(|axis| has("vertex", axis)) {
        return fault("the PLY header has no element vertex with x, y and z");
    }
    if !FACES.iter().any(|element| CORNERS.iter().any(|name| has(element, name))) {
        return fault(
            "the PLY header has no element face, and no tristrips, with vertex_indices; is it a \
             point cloud?",
        );
    }
    // Without this check, a header could declare any number of elements that take up no bytes.
    if let Some(def) = header.elements.values().find(|def| def.properties.is_empty()) {
        return fault(format!(
            "the PLY header has an element {} without properties",
            quote(&def.name)
        ));
    }
    Ok(UVS.iter().any(|names| names.iter().all(|name| has("vertex", name))))
}

/// Reads the next non-blank line as an element.
fn ascii(lines: &mut Lines<impl BufRead>, def: &ElementDef, i: usize) -> Result<Element, Fault> {
    if !lines.advance_to_text()? {
        return cut_off(def, i);
    }
    let text = lines.text();
    element(&text, def).map_or_else(
        || fault(format!("{} is not what the header announces for a {}", quote(&text), def.name)),
        Ok,
    )
}

/// Parses an element from its words. Unused properties may contain any words, such as `nan`.
fn element(text: &str, def: &ElementDef) -> Option<Element> {
    let mut words = text.split_ascii_whitespace();
    let mut element = Element::new();
    for property in def.properties.values() {
        match &property.data_type {
            PropertyType::Scalar(kind) => {
                let word = words.next()?;
                if let Some(place) = element.place(&property.name) {
                    let number = scalar(word, kind);
                    *place = number.unwrap_or(f64::NAN);
                    if number.is_none() {
                        element.broken = Some(format!("{} is not a number", quote(word)));
                    }
                }
            }
            PropertyType::List(..) => {
                let count: usize = words.next()?.parse().ok()?;
                let is_used = CORNERS.contains(&&*property.name);
                let mut corners = Vec::new();
                for _ in 0..count {
                    let word = words.next()?;
                    if is_used {
                        corners.push(word.parse().ok()?);
                    }
                }
                if is_used {
                    element.corners = Some(corners);
                }
            }
        }
    }
    words.next().is_none().then_some(element)
}

/// Parses a word as a number of the given type. Decimals are read in f64 even if the header
/// declares them as `float`, because exporters declare `float` even for numbers with more digits
/// than f32 can hold, such as UTM coordinates.
fn scalar(word: &str, kind: &ScalarType) -> Option<f64> {
    match kind {
        ScalarType::Float | ScalarType::Double => word.parse().ok(),
        _ => word.parse::<i64>().ok().map(|x| x as f64),
    }
}

fn damaged(error: &ParseError, def: &ElementDef, i: usize) -> Fault {
    let cause = match error.kind() {
        ErrorKind::UnexpectedEof => return cut_off::<()>(def, i).unwrap_err(),
        _ => first_line(error),
    };
    Fault { line: None, cause }
}

fn cut_off<T>(def: &ElementDef, i: usize) -> Result<T, Fault> {
    fault(format!(
        "the file is cut off: the header promises {} of element {}, but the file has {i}",
        def.count, def.name
    ))
}

/// Returns the first line of the crate's message, which contains the cause.
fn first_line(error: &ParseError) -> String {
    let text = error.to_string();
    let message =
        text.split_once(": ").filter(|_| error.line().is_some()).map_or(&*text, |(_, m)| m);
    quote(message.lines().next().unwrap_or_default().trim_end_matches('.'))
}

fn vertex<S: Coordinate>(
    builder: &mut MeshBuilder<S>,
    element: Element,
    has_uvs: bool,
) -> Result<(), Fault> {
    if has_uvs {
        builder.uv(element.uv.map(|x| x as f32))?;
    }
    match element.broken {
        Some(cause) if element.position.iter().any(|x| x.is_nan()) => {
            builder.broken_position(cause)
        }
        _ => builder.position(element.position.map(S::nearest)),
    }
}

/// Adds a polygon. Its vertices may come later in the file.
fn face<S: Coordinate>(
    builder: &mut MeshBuilder<S>,
    element: &Element,
    has_uvs: bool,
) -> Result<(), Fault> {
    let corners = element.corners.iter().flatten().map(|&corner| u32::try_from(corner));
    let corners = corners.collect::<Result<Vec<u32>, _>>();
    let (Some(_), Ok(corners)) = (&element.corners, corners) else {
        return fault("a face has an index that is negative or not a whole number");
    };
    builder.polygon(&corners, if has_uvs { &corners } else { &[] })
}

/// Adds strips of triangles, separated by -1, as in Stanford's scans.
fn strips<S: Coordinate>(
    builder: &mut MeshBuilder<S>,
    element: &Element,
    has_uvs: bool,
) -> Result<(), Fault> {
    let Some(corners) = &element.corners else {
        return fault("a strip has an index that is not a whole number");
    };
    for strip in corners.split(|&corner| corner == -1) {
        let strip =
            strip.iter().map(|&corner| u32::try_from(corner)).collect::<Result<Vec<_>, _>>();
        let Ok(strip) = strip else {
            return fault("a strip has an index that is negative, and not -1, which ends a strip");
        };
        builder.strip(&strip, if has_uvs { &strip } else { &[] })?;
    }
    Ok(())
}

/// Converts a property to a list of integers.
fn whole(value: &Property) -> Option<Vec<i64>> {
    fn wide<T: Copy + Into<i64>>(list: &[T]) -> Vec<i64> {
        list.iter().map(|&x| x.into()).collect()
    }
    Some(match value {
        Property::ListChar(list) => wide(list),
        Property::ListUChar(list) => wide(list),
        Property::ListShort(list) => wide(list),
        Property::ListUShort(list) => wide(list),
        Property::ListInt(list) => wide(list),
        Property::ListUInt(list) => wide(list),
        _ => return None,
    })
}

/// Converts a property to a number. f64 can represent the values of every type.
fn number(value: &Property) -> Option<f64> {
    Some(match *value {
        Property::Char(x) => x.into(),
        Property::UChar(x) => x.into(),
        Property::Short(x) => x.into(),
        Property::UShort(x) => x.into(),
        Property::Int(x) => x.into(),
        Property::UInt(x) => x.into(),
        Property::Float(x) => x.into(),
        Property::Double(x) => x,
        _ => return None,
    })
}

/// The properties that are read from vertices, faces, and strips.
struct Element {
    position: [f64; 3],
    uv: [f64; 2],
    corners: Option<Vec<i64>>,
    /// The error for a number that cannot be parsed.
    broken: Option<String>,
}

impl Element {
    /// Returns where to store a property's value, or `None` if the property is not needed.
    fn place(&mut self, name: &str) -> Option<&mut f64> {
        Some(match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            _ if UVS.iter().any(|names| names[0] == name) => &mut self.uv[0],
            _ if UVS.iter().any(|names| names[1] == name) => &mut self.uv[1],
            _ => return None,
        })
    }
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self { position: [0.0; 3], uv: [0.0; 2], corners: Some(Vec::new()), broken: None }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if CORNERS.contains(&name) {
            self.corners = whole(&value);
            return PropertyAccessResult::Set;
        }
        let Some(place) = self.place(name) else { return PropertyAccessResult::Ignored };
        let Some(number) = number(&value) else { return PropertyAccessResult::UnsupportedType };
        *place = number;
        PropertyAccessResult::Set
    }
}
