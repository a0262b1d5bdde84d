//! Tests the same model in every format: the compiled binary must draw byte-for-byte the same image
//! from each file.

use std::io::Write;

use crate::common::{NO_SUCH_FILE, TestFolder};
use flate2::Compression;
use flate2::write::GzEncoder;

/// A pyramid with a square base. All other files in these tests contain the same pyramid.
const OBJ: &str = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nv 0 1.5 0\n\
                   f 1 2 3\nf 1 3 4\nf 2 5 3\nf 3 5 4\nf 4 5 1\nf 1 5 2\n";
const POINTS: [[f32; 3]; 5] =
    [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [0.0, 1.5, 0.0]];
const FACES: [[u16; 3]; 6] = [[0, 1, 2], [0, 2, 3], [1, 4, 2], [2, 4, 3], [3, 4, 0], [0, 4, 1]];

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(bytes).unwrap();
    gzip.finish().unwrap()
}

/// Returns the pyramid's positions, at half size and moved, followed by its indices.
fn buffer() -> Vec<u8> {
    let small = POINTS.as_flattened().iter().map(|x| x / 2.0 - 4.0);
    let mut bytes: Vec<u8> = small.flat_map(f32::to_le_bytes).collect();
    bytes.extend(FACES.as_flattened().iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

/// Returns a glTF whose nodes undo the changes to the positions.
fn gltf(uri: &str) -> String {
    let uri = if uri.is_empty() { String::new() } else { format!("\"uri\":\"{uri}\",") };
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":1,"scenes":[{{"nodes":[]}},{{"nodes":[1]}}],
        "nodes":[{{"mesh":0,"translation":[4,4,4]}},{{"children":[0],"scale":[2,2,2]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":0}},
                                  {{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":5,"type":"VEC3"}},
                     {{"bufferView":1,"componentType":5123,"count":18,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":60}},
                       {{"buffer":0,"byteOffset":60,"byteLength":36}}],
        "buffers":[{{{uri}"byteLength":96}}]}}"#
    )
}

fn glb(json: &str, bin: &[u8]) -> Vec<u8> {
    let json = format!("{json:<0$}", json.len().next_multiple_of(4));
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((28 + json.len() as u32 + bin.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json.as_bytes()), (b"BIN\0", bin)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}

fn ply(format: &str, faces: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
         property float z\n{faces}\nend_header\n"
    )
}

/// Returns the pyramid's positions, one per line.
fn points() -> String {
    POINTS.map(|[x, y, z]| format!("{x} {y} {z}\n")).concat()
}

/// Returns a PLY with strips for the base and the sides, separated by -1.
fn strips(text: bool) -> Vec<u8> {
    let faces = "element tristrips 1\nproperty list int int vertex_indices";
    let list = [1, 0, 2, 3, -1, 0, 4, 1, -1, 1, 4, 2, -1, 2, 4, 3, -1, 3, 4, 0];
    if text {
        let list = list.map(|i| i.to_string()).join(" ");
        return format!("{}{}20 {list}\n", ply("ascii", faces), points()).into_bytes();
    }
    let mut file = ply("binary_big_endian", faces).into_bytes();
    file.extend(POINTS.as_flattened().iter().flat_map(|x| x.to_be_bytes()));
    file.extend(20_i32.to_be_bytes());
    file.extend(list.iter().flat_map(|i: &i32| i.to_be_bytes()));
    file
}

/// Draws each file, and checks that all images are the same.
fn same_picture(place: &TestFolder, names: &[&str]) {
    place.put("whole.obj", OBJ).ok("render whole.obj --size 120x90 -o whole.png");
    for name in names {
        place.ok(&format!("render {name} --size 120x90 -o other.png"));
        assert!(place.read("other.png") == place.read("whole.png"), "{name}");
    }
}

#[test]
fn gltf_with_nodes_scenes_and_buffers_of_every_kind() {
    let place = TestFolder::new();
    let base64 = "data:application/octet-stream;base64,";
    let inline = format!("{base64}{}", encoded(&buffer()));
    place.put("inline.gltf", gltf(&inline)).put("beside.gltf", gltf("the%20bytes.bin"));
    place.put("the bytes.bin", buffer()).put("one.glb", glb(&gltf(""), &buffer()));
    place.put("any", gltf(&inline)).put("some", glb(&gltf(""), &buffer()));
    same_picture(&place, &["inline.gltf", "beside.gltf", "one.glb", "any", "some"]);
}

/// Encodes bytes in base64.
fn encoded(bytes: &[u8]) -> String {
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let triples = bytes.chunks(3).map(|triple| {
        assert_eq!(triple.len(), 3, "no padding here");
        triple.iter().fold(0, |bits, &byte| bits << 8 | usize::from(byte))
    });
    let digit = |bits: usize, i: usize| char::from(digits[bits >> (18 - 6 * i) & 63]);
    triples.flat_map(|bits| (0..4).map(move |i| digit(bits, i))).collect()
}

#[test]
fn ply_with_strips_and_with_polygons() {
    let place = TestFolder::new();
    let faces = "element face 5\nproperty list uchar int vertex_indices";
    let polygons = "4 0 1 2 3\n3 1 4 2\n3 2 4 3\n3 3 4 0\n3 0 4 1\n";
    place.put("polygons.ply", format!("{}{}{polygons}", ply("ascii", faces), points()));
    place.put("text.ply", strips(true)).put("binary.ply", strips(false));
    same_picture(&place, &["polygons.ply", "text.ply", "binary.ply"]);
}

#[test]
fn any_format_in_gzip_by_its_magic() {
    let place = TestFolder::new();
    let mut stl = vec![b' '; 80];
    stl.extend((FACES.len() as u32).to_le_bytes());
    for face in FACES {
        stl.extend([0; 12]);
        stl.extend(face.iter().flat_map(|&i| POINTS[usize::from(i)]).flat_map(f32::to_le_bytes));
        stl.extend([0; 2]);
    }
    place.put("a.obj.gz", gzip(OBJ.as_bytes())).put("b.obj", gzip(OBJ.as_bytes()));
    place.put("c.gz", gzip(OBJ.as_bytes())).put("d.PLY.GZ", gzip(&strips(false)));
    place.put("e.stl.gz", gzip(&stl)).put("f.glb.gz", gzip(&glb(&gltf(""), &buffer())));
    place.put("beside.gltf.gz", gzip(gltf("buffer.bin").as_bytes())).put("buffer.bin", buffer());
    // Consecutive gzip members form one file.
    let (head, tail) = OBJ.split_at(40);
    place.put("g.obj.gz", [gzip(head.as_bytes()), gzip(tail.as_bytes())].concat());
    let names = ["a.obj.gz", "b.obj", "c.gz", "d.PLY.GZ", "e.stl.gz", "f.glb.gz", "g.obj.gz"];
    same_picture(&place, &names);
    same_picture(&place, &["beside.gltf.gz"]);
}

#[test]
fn texts_with_other_line_ends_and_byte_order_marks() {
    let place = TestFolder::new();
    let mark = "\u{feff}";
    let facets = FACES.map(|face| {
        let corners = face.map(|i| {
            let [x, y, z] = POINTS[usize::from(i)];
            format!("vertex {x} {y} {z}\n")
        });
        format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", corners.concat())
    });
    let stl = format!("solid a\n{}endsolid a\n", facets.concat());
    let base64 = "data:application/octet-stream;base64,";
    place.put("a.obj", OBJ.replace('\n', "\r")).put("b.obj", OBJ.replace('\n', "\r\n"));
    place.put("c.obj", format!("{mark}{OBJ}")).put("d", format!("{mark}#\r{OBJ}"));
    place.put("e.stl", format!("{mark}{stl}")).put("f.stl", stl.replace('\n', "\r"));
    place.put("g.ply", [mark.as_bytes(), &strips(true)].concat());
    place.put("h.gltf", format!("{mark}{}", gltf(&format!("{base64}{}", encoded(&buffer())))));
    place.put("i.stl.gz", gzip(format!("{mark}{stl}").as_bytes()));
    let names = ["a.obj", "b.obj", "c.obj", "d", "e.stl", "f.stl", "g.ply", "h.gltf", "i.stl.gz"];
    same_picture(&place, &names);
    let utf16 = OBJ.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>();
    place.put("wide.obj", [&b"\xff\xfe"[..], &utf16].concat());
    place.fails("render wide.obj", 1, &["wide.obj: ", "UTF-16", "UTF-8"]);
}

#[test]
fn what_is_refused_names_the_cause() {
    let place = TestFolder::new();
    let whole = gltf("");
    let needs = |name: &str| {
        let required = format!("{{\"extensionsRequired\":[\"{name}\"],");
        glb(&whole.replacen('{', &required, 1), &buffer())
    };
    place.put("draco.glb", needs("KHR_draco_mesh_compression"));
    place.put("meshopt.glb", needs("EXT_meshopt_compression")).put("odd.glb", needs("EXT_odd"));
    place.fails("render draco.glb", 1, &["draco.glb: ", "Draco", "export"]);
    place.fails("render meshopt.glb", 1, &["meshopt.glb: ", "meshopt", "export"]);
    place.fails("render odd.glb", 1, &["odd.glb: ", "EXT_odd", "not supported"]);
    place.put("old.gltf", whole.replace("2.0", "1.0"));
    place.fails("render old.gltf", 1, &["old.gltf: ", "glTF \"1.0\"", "version 2"]);
    place.put("lost.gltf", gltf("nowhere.bin"));
    place.fails("render lost.gltf", 1, &["lost.gltf: ", "nowhere.bin", NO_SUCH_FILE]);
    for uri in ["../up.bin", "/etc/hostname", "http://a/b.bin"] {
        place.put("away.gltf", gltf(uri));
        place.fails("render away.gltf", 1, &["away.gltf: ", uri, "folder"]);
    }
    place.put("cut.glb", &glb(&whole, &buffer())[..300]);
    place.fails("render cut.glb", 1, &["cut.glb: ", "cut off"]);
    place.put("text.gltf", "{\"asset\": 3}").put("cut.obj.gz", &gzip(OBJ.as_bytes())[..50]);
    place.fails("render text.gltf", 1, &["text.gltf:1: ", "JSON"]);
    place.fails("render cut.obj.gz", 1, &["cut.obj.gz: ", "gzip", "cut off"]);
    place.put("twice.obj.gz", gzip(&gzip(OBJ.as_bytes())));
    place.fails("render twice.obj.gz", 1, &["twice.obj.gz: ", "a gzip in a gzip", "gunzip"]);
}

#[test]
fn a_bomb_ends_in_one_line() {
    let place = TestFolder::new();
    // 80 MB of empty lines, compressed to 80 kB.
    place.put("bomb.obj.gz", gzip(&vec![b'\n'; 80 << 20]));
    place.fails("render bomb.obj.gz", 1, &["bomb.obj.gz: ", "more than 100 times", "gunzip"]);
}
