//! PLY, ascii and binary, by the crate `ply-rs-bw`, element by element.

use std::io::{BufRead, ErrorKind};

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::builder::{MeshBuilder, push};
use super::error::{Fault, fault, quote};
use super::lines::Lines;
use crate::coordinate::Coordinate;
use crate::mesh::Mesh;

/// The names under which texture coordinates are found.
const UVS: [[&str; 2]; 3] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];
/// The names under which a face has its corners.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// The elements that make triangles.
const FACES: [&str; 2] = ["face", "tristrips"];

/// No header is longer; the usual ones have some hundred bytes.
const LONGEST_HEADER: u64 = 1 << 20;

/// Reads vertices and faces; other elements are skipped.
pub(super) fn read<S: Coordinate>(mut input: impl BufRead) -> Result<Mesh<S>, Fault> {
    let beginning = input.fill_buf()?;
    if beginning.starts_with(b"ply\r") && !beginning.starts_with(b"ply\r\n") {
        return fault("its lines end in carriage returns alone; save it with line feeds");
    }
    let parser = Parser::<Element>::new();
    let mut reader = Reader::new(input.take(LONGEST_HEADER));
    let header = parser.read_header(&mut reader);
    let line = reader.line() as u64;
    let input = reader.into_inner();
    let mut header = header.map_err(|error| Fault {
        line: error.line().map(|line| line as u64),
        cause: match input.limit() {
            0 => format!("the PLY header has more than {LONGEST_HEADER} bytes; is it a model?"),
            _ => format!("the PLY header is damaged: {}", first_line(&error)),
        },
    })?;
    let has_uvs = check(&header)?;
    if matches!(header.encoding, Encoding::Ascii) {
        keep_decimals(&mut header);
    }

    // Element by element: nothing is kept that is not needed, and no count sizes an allocation.
    let mut lines = Lines::after(line - 1, input.into_inner());
    let mut builder = MeshBuilder::default();
    let mut uvs = Vec::new();
    for def in header.elements.values() {
        for i in 0..def.count {
            let element = match header.encoding {
                Encoding::Ascii => ascii(&parser, &mut lines, def, i),
                Encoding::BinaryLittleEndian => parser
                    .read_little_endian_element(lines.input(), def)
                    .map_err(|error| damaged(&error, def, i)),
                Encoding::BinaryBigEndian => parser
                    .read_big_endian_element(lines.input(), def)
                    .map_err(|error| damaged(&error, def, i)),
            };
            let added = element.and_then(|element| match def.name.as_str() {
                "vertex" => {
                    if has_uvs {
                        push(&mut uvs, element.uv.map(|x| x as f32))?;
                    }
                    builder.position(element.position.map(S::nearest))
                }
                "face" => face(&mut builder, &element, &uvs),
                "tristrips" => strips(&mut builder, &element, &uvs),
                _ => Ok(()),
            });
            added.map_err(|fault| match header.encoding {
                Encoding::Ascii => fault.at(lines.number),
                _ => Fault { cause: format!("{} {i}: {}", def.name, fault.cause), ..fault },
            })?;
        }
    }
    Ok(builder.mesh)
}

/// Reads the decimals of a text in f64, also where the header calls them `float`: exporters do that for numbers with
/// more digits than f32 has, such as UTM coordinates.
fn keep_decimals(header: &mut Header) {
    for property in header.elements.values_mut().flat_map(|def| def.properties.values_mut()) {
        if matches!(property.data_type, PropertyType::Scalar(ScalarType::Float)) {
            property.data_type = PropertyType::Scalar(ScalarType::Double);
        }
    }
}

/// Whether the header announces what a mesh needs; says whether vertices have texture coordinates.
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
    // Elements that take no bytes could be promised without end.
    if let Some(def) = header.elements.values().find(|def| def.properties.is_empty()) {
        return fault(format!(
            "the PLY header has an element {} without properties",
            quote(&def.name)
        ));
    }
    Ok(UVS.iter().any(|names| names.iter().all(|name| has("vertex", name))))
}

/// The next line as an element.
fn ascii(
    parser: &Parser<Element>,
    lines: &mut Lines<impl BufRead>,
    def: &ElementDef,
    i: usize,
) -> Result<Element, Fault> {
    if !lines.advance()? {
        return cut_off(def, i);
    }
    let text = lines.text();
    parser.read_ascii_element(&text, def).or_else(|_| {
        fault(format!("{} is not what the header announces for a {}", quote(&text), def.name))
    })
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
        "the file is cut off: the header promises {} of {}, it has {i}",
        def.count, def.name
    ))
}

/// The crate's messages have several lines, of which the first says it.
fn first_line(error: &ParseError) -> String {
    let text = error.to_string();
    let message =
        text.split_once(": ").filter(|_| error.line().is_some()).map_or(&*text, |(_, m)| m);
    quote(message.lines().next().unwrap_or_default().trim_end_matches('.'))
}

/// A polygon.
fn face<S: Coordinate>(
    builder: &mut MeshBuilder<S>,
    element: &Element,
    uvs: &[[f32; 2]],
) -> Result<(), Fault> {
    let corners = element.corners.iter().flatten().map(|&corner| u32::try_from(corner));
    let corners = corners.collect::<Result<Vec<u32>, _>>();
    let (Some(_), Ok(corners)) = (&element.corners, corners) else {
        return fault("a face has an index that is negative or no whole number");
    };
    builder.polygon(&corners, &uvs_of(&corners, uvs))
}

/// Strips of triangles, -1 between them: Stanford's scans have them.
fn strips<S: Coordinate>(
    builder: &mut MeshBuilder<S>,
    element: &Element,
    uvs: &[[f32; 2]],
) -> Result<(), Fault> {
    let Some(corners) = &element.corners else {
        return fault("a strip has an index that is no whole number");
    };
    for strip in corners.split(|&corner| corner == -1) {
        let strip =
            strip.iter().map(|&corner| u32::try_from(corner)).collect::<Result<Vec<_>, _>>();
        let Ok(strip) = strip else {
            return fault("a strip has an index that is negative, and not -1, which ends a strip");
        };
        builder.strip(&strip, &uvs_of(&strip, uvs))?;
    }
    Ok(())
}

/// The texture coordinates of corners. An index out of range has none; the builder tells of it.
fn uvs_of(corners: &[u32], uvs: &[[f32; 2]]) -> Vec<[f32; 2]> {
    corners.iter().filter_map(|&corner| uvs.get(corner as usize).copied()).collect()
}

/// A list of whole numbers.
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

/// A number of any type, which f64 has room for.
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

/// What is wanted of a vertex, of a face and of strips.
struct Element {
    position: [f64; 3],
    uv: [f64; 2],
    corners: Option<Vec<i64>>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self { position: [0.0; 3], uv: [0.0; 2], corners: Some(Vec::new()) }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let place = match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            _ if UVS.iter().any(|names| names[0] == name) => &mut self.uv[0],
            _ if UVS.iter().any(|names| names[1] == name) => &mut self.uv[1],
            _ if CORNERS.contains(&name) => {
                self.corners = whole(&value);
                return PropertyAccessResult::Set;
            }
            _ => return PropertyAccessResult::Ignored,
        };
        let Some(number) = number(&value) else {
            return PropertyAccessResult::UnsupportedType;
        };
        *place = number;
        PropertyAccessResult::Set
    }
}
