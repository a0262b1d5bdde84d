//! Tests that malformed files are read if nothing has to be guessed, and are never misread
//! silently. For each kind of problem, the program prints one line that says what was omitted,
//! repaired or guessed, and how often.

use crate::common::{TestFolder, one_line};

/// Rays that point straight down: one at the lower right half of the unit square, one at its upper
/// left half, and one beside the square.
const DOWN: &str = "ox,oy,oz,dx,dy,dz\n0.75,0.25,5,0,0,-1\n0.25,0.75,5,0,0,-1\n3,3,5,0,0,-1\n";

/// The vertices of the square, counter-clockwise.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// Creates a folder with a model of the given name, and with rays down onto the square.
fn with(name: &str, model: impl AsRef<[u8]>) -> TestFolder {
    let place = TestFolder::new();
    place.put(name, model).put("down.csv", DOWN);
    place
}

/// Returns the triangles that the three rays hit, as in the answers: `0,1,` stands for two hits and
/// a miss.
fn hits(answers: &[u8]) -> String {
    let text = String::from_utf8_lossy(answers);
    text.lines().skip(1).map(|line| line.split(',').nth(1).unwrap()).collect::<Vec<_>>().join(",")
}

/// Checks that a model is read without a message, even with `--strict`.
#[track_caller]
fn reads(name: &str, model: impl AsRef<[u8]>, expected: &str) {
    let place = with(name, model);
    let line = format!("trace {name} --rays down.csv --strict");
    assert_eq!(hits(&place.ok(&line)), expected, "{name}");
}

/// Checks that a model is read with one message that begins with `said`, that the report contains
/// the note, and that `--strict` turns it into an error.
#[track_caller]
fn notes(name: &str, model: impl AsRef<[u8]>, expected: &str, said: &str) {
    let place = with(name, model);
    let line = format!("trace {name} --rays down.csv");
    let output = place.run(&line);
    one_line(&line, &output, 0, &[&format!("intertri: {name}: {said}")]);
    assert_eq!(hits(&output.stdout), expected, "{name}");

    let report = place.run(&format!("{line} -o out.csv --json"));
    let json: serde_json::Value = serde_json::from_slice(&report.stdout).unwrap();
    let [note] = json["notes"].as_array().unwrap().as_slice() else { panic!("{json}") };
    let count = note["count"].as_u64().unwrap();
    assert!(said.starts_with(&format!("{}: {count}", note["what"].as_str().unwrap())), "{note}");

    place.fails(&format!("{line} --strict"), 1, &[name, said, "--strict"]);
}

/// Checks that a model is refused.
#[track_caller]
fn refuses(name: &str, model: impl AsRef<[u8]>, words: &[&str]) {
    with(name, model).fails(&format!("trace {name} --rays down.csv"), 1, words);
}

#[test]
fn obj_words_in_place_of_numbers_are_errors_where_a_triangle_needs_them() {
    for word in
        ["1.#INF", "-1.#IND", "1.#QNAN", "1.#J", "nan(ind)", "-nan(ind)", "1,5", "0x10", "1_0"]
    {
        for line in [format!("v {word} 1 0"), format!("v 1 {word} 0"), format!("v 1 1 {word}")] {
            let model = format!("v 0 0 0\nv 1 0 0\n{line}\nv 0 1 0\nf 1 2 3 4\n");
            refuses("m.obj", model, &["m.obj:3: ", &format!("{word:?} is not a number")]);
        }
        // The answers do not depend on a fourth number, on normals, or on unused vertices.
        reads("m.obj", format!("{SQUARE}v 1 {word} 1\nf 1 2 3 4\n"), "0,1,");
        reads(
            "m.obj",
            SQUARE.replace("v 1 1 0", &format!("v 1 1 0 {word}")) + "f 1 2 3 4\n",
            "0,1,",
        );
        reads("m.obj", format!("{SQUARE}vn {word} 0 1\nf 1//1 2//1 3//1 4//1\n"), "0,1,");
    }
    refuses("m.obj", format!("{SQUARE}v nan 0 0\nf 1 2 3 5\n"), &["m.obj:5: ", "is not finite"]);
    reads("m.obj", format!("{SQUARE}v nan nan nan\nv 1e39 inf 0\nf 1 2 3 4\n"), "0,1,");
    // A comment may follow any statement.
    reads("m.obj", format!("#\n{SQUARE}f 1 2 3 4# quad\n#f 1 2\n"), "0,1,");
}

#[test]
fn obj_comments_and_names_that_end_in_a_backslash_end_there() {
    for line in
        ["# made from C:\\models\\", "usemtl C:\\mat\\", "o a\\", "g a b\\", "mtllib \\\\host\\"]
    {
        let model = format!("{line}\nv 9 9 9\n{SQUARE}{line}\nf -4 -3 -2 -1\n{line}");
        reads("m.obj", model, "0,1,");
    }
    reads("m.obj", SQUARE.replace("v 1 1 0", "v 1 1 0 # in D:\\") + "f 1 2 3 4", "0,1,");
    // Statements with numbers continue after a backslash, if anything follows.
    reads("m.obj", format!("{SQUARE}f 1 2 \\\n3 \\\n  4 # all \\\nf 1 2 3\n"), "0,1,");
    reads("m.obj", format!("{SQUARE}f 1 2 3 4 \\"), "0,1,");
}

#[test]
fn obj_statements_of_surfaces_are_read_or_counted() {
    reads("m.obj", format!("{SQUARE}fo 1 2 3 4\nf 1 2 3\n"), "0,1,");
    let surface = "cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\nend\nsurf 0 1 0 1 1 2 3 4\n";
    notes(
        "m.obj",
        format!("{SQUARE}f 1 2 3 4\n{surface}curv 0 1 1 2\n"),
        "0,1,",
        "statements of free-form curves and surfaces, skipped: 3 (the first in line 8)",
    );
    notes(
        "m.obj",
        format!("{SQUARE}f 1 2 3 4\ncall more.obj\n"),
        "0,1,",
        "statements that call other files, skipped: 1 (in line 6)",
    );
    notes(
        "m.obj",
        format!("{SQUARE}F 1 2 3\nf 1 2 3 4\n"),
        "0,1,",
        "unknown statements, skipped: 1 (in line 5)",
    );
}

#[test]
fn faces_of_fewer_than_three_corners_are_left_out() {
    let said = "faces with fewer than three corners, skipped: ";
    let model = format!("{SQUARE}f 1 2\nf 1 2 3 4\nf 3\nf\n");
    notes("m.obj", model, "0,1,", &format!("{said}3 (the first in line 5)"));
    let faces = "4 0 1 2 3\n0\n2 0 1\n";
    notes("m.ply", ply("ascii", 3, faces), "0,1,", &format!("{said}2 (the first in line 15)"));
    refuses("m.obj", format!("{SQUARE}f 1 2\n"), &["m.obj: it has no triangle"]);
}

#[test]
fn obj_faces_may_come_before_what_they_name() {
    reads("m.obj", format!("f 1 2 3 4\n{SQUARE}"), "0,1,");
    reads("m.obj", format!("v 0 0 0\nf 1 2 3\n{}f 1 3 4\n", &SQUARE[8..]), "0,1,");
    reads("m.obj", format!("{SQUARE}f 1/1 2/2 3/3 4/4\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"), "0,1,");
    refuses(
        "m.obj",
        format!("f 1 2 5\n{SQUARE}"),
        &["m.obj:1: a face refers to vertex 5, but there are 4, numbered from 1"],
    );
    // Negative indices count back from the current position.
    refuses("m.obj", format!("f -1 -2 -3\n{SQUARE}"), &["m.obj:1: a face refers to vertex -1"]);
}

#[test]
fn missing_texture_coordinates_are_not_an_error() {
    let said =
        "faces whose texture coordinates are missing or not finite, read without them: 1 (in line ";
    for (uvs, face, line) in [
        ("vn 0 0 1\n", "f 1/1/1 2/2/1 3/3/1 4/4/1", 6),
        ("vt 0 0\n", "f 1/0/0 2/0/0 3/0/0 4/0/0", 6),
        ("vt nan nan\n", "f 1/1 2/1 3/1 4/1", 6),
        ("vt 1.#IND 0\n", "f 1/1 2/1 3/1 4/1", 6),
        ("vt\n", "f 1/1 2/1 3/1 4/1", 6),
        ("vt 0 0\n", "f 1/1 2/1 3 4/1", 6),
        ("vt 0 0\n", "f 1/1 2/1 3/-2 4/1", 6),
        ("vt 0 0\n", "f 1/1 2/1 3/99999999999 4/1", 6),
    ] {
        notes("m.obj", format!("{SQUARE}{uvs}{face}\n"), "0,1,", &format!("{said}{line})"));
    }
    // Unused texture coordinates may have any value.
    reads("m.obj", format!("{SQUARE}vt nan nan\nf 1 2 3 4\n"), "0,1,");
}

/// Returns a PLY of the square with ASCII vertices, and with a header that states `format` and this
/// number of faces.
fn ply(format: &str, faces: usize, payload: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n\
         0 0 0\n1 0 0\n1 1 0\n0 1 0\n{payload}"
    )
}

const FACE: &str = "4 0 1 2 3\n";

#[test]
fn unused_ply_properties_need_not_be_numbers() {
    for word in ["nan", "-nan", "inf", "-nan(ind)", "1.#IND", "none"] {
        let model = ply("ascii", 1, FACE)
            .replace("property float z\n", "property float z\nproperty float quality\n")
            .replace(" 0\n", &format!(" 0 {word}\n"));
        reads("m.ply", model, "0,1,");
    }
    let unused =
        ply("ascii", 1, FACE).replace("vertex 4", "vertex 5").replace("4 0", "nan 1.#INF 0\n4 0");
    reads("m.ply", unused, "0,1,");
    let used = ply("ascii", 1, FACE).replace("1 1 0\n", "1 1.#INF 0\n");
    refuses("m.ply", used, &["m.ply:12: \"1.#INF\" is not a number"]);
}

#[test]
fn ply_elements_lines_and_line_ends_come_in_any_order_and_form() {
    let model = ply("ascii", 1, FACE);
    let (header, payload) = model.split_once("end_header\n").unwrap();
    let (vertices, face) = payload.split_at(payload.len() - FACE.len());
    let (start, elements) = header.split_at(header.find("element").unwrap());
    let (vertex, list) = elements.split_at(elements.find("element face").unwrap());
    reads("m.ply", format!("{start}{list}{vertex}end_header\n{face}{vertices}"), "0,1,");
    let blank = format!("{start}\n{vertex}\n\n{list}\nend_header\n\n{vertices}\n \n{face}\n");
    reads("m.ply", &blank, "0,1,");
    for end in ["\r", "\r\n"] {
        reads("m.ply", blank.replace('\n', end), "0,1,");
    }
    let late = format!("{start}{list}{vertex}end_header\n4 0 1 2 4\n{vertices}");
    refuses(
        "m.ply",
        late,
        &["m.ply:10: a face refers to vertex 4, but there are 4, numbered from 0"],
    );
}

/// In a file whose header lines end in carriage returns, the first byte of the data may be a line
/// feed.
#[test]
fn ply_binary_behind_lines_that_end_in_carriage_returns() {
    let header = ply("binary_little_endian", 1, "").split("0 0 0").next().unwrap().to_owned();
    let mut face: Vec<u8> = vec![4];
    face.extend([0_i32, 1, 2, 3].map(i32::to_le_bytes).as_flattened());
    // `first` is the smallest nonzero f32 whose first byte, in little-endian order, is a line feed.
    let first = f32::from_le_bytes([b'\n', 0, 0, 0]);
    let mut bytes: Vec<u8> = vec![];
    for point in [[first, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
        bytes.extend(point.map(f32::to_le_bytes).as_flattened());
    }
    for end in ["\n", "\r", "\r\n"] {
        let model = [header.replace('\n', end).as_bytes(), &bytes, &face].concat();
        reads("m.ply", model, "0,1,");
    }
}

/// Two facets, the halves of the square.
const FACETS: &str = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n\
    endloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 1 0\nvertex 0 1 0\n\
    endloop\nendfacet\n";

/// Returns a binary STL of the square's two triangles, with a header that states `promised`
/// triangles.
fn stl(promised: u32) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(promised.to_le_bytes());
    for [b, c] in [[[1.0, 0.0], [1.0, 1.0]], [[1.0, 1.0], [0.0, 1.0_f32]]] {
        for [x, y] in [[0.0, 0.0], [0.0, 0.0], b, c] {
            bytes.extend([x, y, 0.0].map(f32::to_le_bytes).as_flattened());
        }
        bytes.extend([0, 0]);
    }
    bytes
}

#[test]
fn stl_words_are_in_any_case_and_the_last_end_may_be_missing() {
    let text = format!("solid Q\n{FACETS}endsolid Q\n");
    for name in ["m.stl", "m"] {
        reads(name, text.to_uppercase(), "0,1,");
        reads(name, text.replace("solid", "Solid"), "0,1,");
    }
    let said = "solids without endsolid, read as far as they go: 1 (in line 15)";
    notes("m.stl", format!("solid Q\n{FACETS}"), "0,1,", said);
    refuses(
        "m.stl",
        format!("solid Q\n{}", FACETS.trim_end_matches("endloop\nendfacet\n")),
        &["m.stl:", "cut off in the middle"],
    );
    let broken =
        format!("solid Q\n{FACETS}endsolid\n").replace("1 1 0\nendloop", "1 1.#IND 0\nendloop");
    refuses("m.stl", broken, &["m.stl:6: ", "is not a vertex x y z"]);
}

#[test]
fn stl_headers_may_promise_too_few_triangles() {
    reads("m.stl", stl(2), "0,1,");
    let said = |promised, more| {
        format!("triangles beyond the {promised} that the header promises, also read: {more}")
    };
    notes("m.stl", stl(0), "0,1,", &said(0, 2));
    notes("m.stl", stl(1), "0,1,", &said(1, 1));
    // Bytes that do not form a whole triangle are omitted.
    let over = |bytes: &[u8], more| [bytes, &vec![b'x'; more][..]].concat();
    notes("m.stl", over(&stl(2), 7), "0,1,", "bytes after the last triangle, skipped: 7");
    notes("m.stl", over(&stl(1), 7), "0,,", "bytes after the last triangle, skipped: 57");
    refuses("m.stl", stl(3), &["m.stl: its header promises 3 triangles", "cut off or not an STL"]);
    refuses("m.stl", stl(u32::MAX), &["m.stl: its header promises 4294967295 triangles"]);
}

#[test]
fn what_follows_a_gzip_is_left_out() {
    use std::io::Write;
    let pack = |text: &str| {
        let mut gzip = flate2::write::GzEncoder::new(vec![], flate2::Compression::fast());
        gzip.write_all(text.as_bytes()).unwrap();
        gzip.finish().unwrap()
    };
    let model = format!("{SQUARE}f 1 2 3 4\n");
    let (whole, halves) = (pack(&model), [pack(&model[..20]), pack(&model[20..])].concat());
    for packed in [whole, halves, [pack(""), pack(&model)].concat()] {
        reads("m.obj.gz", &packed, "0,1,");
        reads("m.obj.gz", [&packed[..], &[0; 512]].concat(), "0,1,");
        let tail = [&packed[..], b"trailing"].concat();
        notes("m.obj.gz", tail, "0,1,", "bytes after the end of the gzip, skipped: 8");
        refuses("m.obj.gz", &packed[..packed.len() - 3], &["the gzip is cut off"]);
    }
}

#[test]
fn rays_in_lines_that_end_in_carriage_returns() {
    let place = with("m.obj", format!("{SQUARE}f 1 2 3 4\n"));
    let whole = place.ok("trace m.obj --rays down.csv");
    for end in ["\r", "\r\n", "\n\r", "\r\r"] {
        place.put("rays.csv", DOWN.replace('\n', end));
        assert_eq!(place.ok("trace m.obj --rays rays.csv"), whole, "{end:?}");
        let input = place.read("rays.csv");
        assert_eq!(place.ok_with_input("trace m.obj --rays -", &input), whole, "{end:?}");
    }
    place.put("rays.csv", "ox,oy,oz,dx,dy,dz\r0,0,0,0,0,1\r\r0,0,0,0,0,x\r");
    place.fails("trace m.obj --rays rays.csv -o out.csv", 1, &["rays.csv:4: ", "is not a number"]);
}

/// A tiny model at the origin and a distant model both lose digits in f32, but the program prints a
/// different message for each.
#[test]
fn tiny_and_distant_models_have_different_messages() {
    let place = TestFolder::new();
    place.put("m.obj", "v 0 0 0\nv 1e-44 0 0\nv 0 1e-44 0\nf 1 2 3\n");
    let line = "render m.obj --size 8x6 -o a.png";
    one_line(line, &place.run(line), 0, &["is so small that", "--scalar f64"]);
    place.put("m.obj", "v 0 0 1000000000.3\nv 1 0 1e9\nv 0 1 1e9\nf 1 2 3\n");
    one_line(line, &place.run(line), 0, &["is so far from the origin that", "--scalar f64"]);
}

/// Writes a glTF with unit cubes, placed by the given nodes. The corners of each face run
/// counter-clockwise as seen from outside.
fn cubes(place: &TestFolder, nodes: &str) {
    let corners = (0..8_u8).flat_map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f32::from));
    let faces: [[u16; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.map(|[a, b, c, d]| [a, b, c, a, c, d]);
    let mut bytes: Vec<u8> = corners.flat_map(f32::to_le_bytes).collect();
    bytes.extend(triangles.as_flattened().iter().flat_map(|i| i.to_le_bytes()));
    place.put("cube.bin", bytes).put(
        "cubes.gltf",
        format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3"}},
            {{"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}}],
            "bufferViews":[{{"buffer":0,"byteLength":96}},
            {{"buffer":0,"byteOffset":96,"byteLength":72}}],
            "buffers":[{{"byteLength":168,"uri":"./cube.bin"}}]}}"#
        ),
    );
}

/// The sides of a ray's crossings sum to the number of solids that the ray starts in.
#[test]
fn crossings_of_mirrored_nodes_add_up_like_others() {
    let place = TestFolder::new();
    place.put("r.csv", "ox,oy,oz,dx,dy,dz\n0.7,0.4,0.2,0,0,1\n0.2,0.4,0.2,1,0.1,0.05\n1.2,0.4,0.2,0,0,1\n9,9,9,0,0,1\n");
    for (nodes, expected) in [
        (r#"{"mesh":0}"#, [1, 1, 0, 0]),
        (r#"{"mesh":0,"scale":[-1,1,1],"translation":[1,0,0]}"#, [1, 1, 0, 0]),
        (r#"{"mesh":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,-1,0, 0,0,1,1]}"#, [1, 1, 0, 0]),
        (r#"{"mesh":0},{"mesh":0,"scale":[-1,1,1],"translation":[1.5,0,0]}"#, [2, 1, 1, 0]),
    ] {
        cubes(&place, nodes);
        let text = place.ok("trace cubes.gltf --rays r.csv --crossings --strict");
        let mut sums = [0; 4];
        for line in String::from_utf8(text).unwrap().lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            sums[cells[0].parse::<usize>().unwrap()] += cells[5].parse::<i32>().unwrap_or(0);
        }
        assert_eq!(sums, expected, "{nodes}");
    }
}
