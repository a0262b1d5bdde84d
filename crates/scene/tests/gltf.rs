//! Tests which triangles glTF nodes yield, and that invalid numbers in a file cause errors.

use std::path::Path;

use intertri_scene::{LoadedModel, Mesh, load_model, read};
use tempfile::TempDir;

/// Returns the corners of the unit square as f32, then as u8, then the indices 0, 1, 2, 3.
fn bytes() -> Vec<u8> {
    let points = [[0_u8, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]];
    let mut bytes: Vec<u8> =
        points.as_flattened().iter().flat_map(|&x| f32::from(x).to_le_bytes()).collect();
    for [x, y, z] in points {
        bytes.extend([x * 255, y * 255, z, 0]);
    }
    bytes.extend([0, 1, 2, 3]);
    bytes
}

const ACCESSORS: &str = r#""bufferViews":[{"buffer":0,"byteLength":48},
    {"buffer":0,"byteOffset":48,"byteLength":16,"byteStride":4},
    {"buffer":0,"byteOffset":64,"byteLength":4}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
    {"bufferView":1,"componentType":5121,"normalized":true,"count":4,"type":"VEC3"},
    {"bufferView":2,"componentType":5121,"count":4,"type":"SCALAR"},
    {"bufferView":1,"componentType":5121,"normalized":true,"count":4,"type":"VEC2"}],
    "buffers":[{"byteLength":68}]"#;

/// Returns a GLB with this JSON and [`bytes`].
fn glb(json: &str) -> Vec<u8> {
    let bin = bytes();
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((28 + json.len() as u32 + bin.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json.as_bytes()), (b"BIN\0", &bin)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}

/// Returns a file with these primitives. `rest` contains the nodes and any other members.
fn file(primitives: &str, rest: &str) -> Vec<u8> {
    glb(&format!(
        r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{primitives}]}}],{rest},{ACCESSORS}}}"#
    ))
}

const NODE: &str = r#""nodes":[{"mesh":0}]"#;
const SQUARE: &str = r#"{"attributes":{"POSITION":0},"mode":5}"#;

fn mesh(bytes: &[u8]) -> Mesh {
    read(Path::new("a.glb"), bytes).unwrap_or_else(|error| panic!("{error}"))
}

fn says(bytes: &[u8], words: &str) {
    let error = read(Path::new("a.glb"), bytes).unwrap_err().to_string();
    assert!(error.starts_with("a.glb: ") && error.contains(words), "{error} / {words}");
}

#[test]
fn triangles_strips_and_fans_and_nothing_of_points_and_lines() {
    let of = |primitive: &str| mesh(&file(primitive, NODE)).triangles;
    assert_eq!(of(SQUARE), [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(of(r#"{"attributes":{"POSITION":0},"indices":2,"mode":6}"#), [[0, 1, 2], [0, 2, 3]]);
    // The fourth corner is left over.
    assert_eq!(of(r#"{"attributes":{"POSITION":0},"indices":2}"#), [[0, 1, 2]]);
    for mode in 0..4 {
        let lines = format!(r#"{{"attributes":{{"POSITION":0}},"mode":{mode}}}"#);
        says(&file(&lines, NODE), "it has no triangle");
        assert_eq!(of(&format!("{lines},{SQUARE}")), [[0, 1, 2], [2, 1, 3]]);
    }
    says(&file(r#"{"attributes":{"POSITION":0},"mode":9}"#, NODE), "mode");
}

#[test]
fn integers_that_are_normalized_and_texture_coordinates() {
    let plain = mesh(&file(SQUARE, NODE));
    let quantized = mesh(&file(r#"{"attributes":{"POSITION":1,"TEXCOORD_0":3},"mode":5}"#, NODE));
    assert_eq!(plain.positions, quantized.positions);
    assert_eq!(plain.corner_uvs, None);
    // In glTF, v grows downward.
    let uvs = quantized.corner_uvs.unwrap();
    assert_eq!(uvs[0], [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
}

#[test]
fn nodes_are_walked_in_order_and_place_their_meshes() {
    let nodes = r#""nodes":[{"children":[2,1],"translation":[10,0,0]},
        {"mesh":0,"matrix":[0,1,0,0, -1,0,0,0, 0,0,1,0, 0,0,5,1]},
        {"mesh":0,"scale":[2,3,4],"rotation":[0,0,1,0]}]"#;
    for scenes in ["", r#","scenes":[{"nodes":[0]}]"#, r#","scene":0,"scenes":[{"nodes":[0]}]"#] {
        let mesh = mesh(&file(SQUARE, &format!("{nodes}{scenes}")));
        // The first mesh is rotated by half a turn and scaled; the second is rotated by a quarter
        // turn and raised.
        let near = |i: usize, wanted: [f32; 3]| {
            let found: [f32; 3] = mesh.positions[i];
            assert!((0..3).all(|k| (found[k] - wanted[k]).abs() < 1e-5), "{i}: {found:?}");
        };
        near(1, [8.0, 0.0, 0.0]);
        near(2, [10.0, -3.0, 0.0]);
        near(5, [10.0, 1.0, 5.0]);
        near(6, [9.0, 0.0, 5.0]);
        assert_eq!(mesh.triangles[2..], [[4, 5, 6], [6, 5, 7]]);
    }
}

#[test]
fn what_is_not_there_or_goes_round_is_refused() {
    let nodes = |nodes: &str| file(SQUARE, &format!("\"nodes\":[{nodes}]"));
    says(&nodes(r#"{"children":[1]},{"children":[2],"mesh":0},{"children":[1]}"#), "reached twice");
    says(&nodes(r#"{"children":[7]}"#), "node 7 does not exist; there are 1");
    says(&nodes(r#"{"mesh":4}"#), "mesh 4 does not exist; there are 1");
    says(&file(SQUARE, r#""scene":3,"nodes":[{"mesh":0}]"#), "scene 3 does not exist; there are 0");
    // Each node is a child of the previous one, ten thousand levels deep.
    let deep: Vec<String> = (1..10_000).map(|i| format!(r#"{{"children":[{i}]}}"#)).collect();
    assert_eq!(mesh(&nodes(&format!("{},{{\"mesh\":0}}", deep.join(",")))).triangles.len(), 2);

    let with = |from: &str, to: &str| {
        let whole = file(r#"{"attributes":{"POSITION":0},"indices":2}"#, NODE);
        let json = String::from_utf8_lossy(&whole);
        let json = &json[json.find('{').unwrap()..=json.rfind('}').unwrap()];
        assert!(json.contains(from), "{from}");
        glb(&json.replacen(from, to, 1))
    };
    assert!(!mesh(&with("\"count\":4", "\"count\":4")).triangles.is_empty());
    says(&with("\"count\":4", "\"count\":5"), "accessor 0, for positions, reaches beyond");
    says(&with("\"count\":4", "\"count\":18446744073709551615"), "reaches beyond");
    says(
        &with("\"byteLength\":48", "\"byteLength\":18446744073709551615"),
        "reaches beyond buffer 0",
    );
    says(&with("\"byteLength\":48", "\"byteLength\":69"), "which has 68 bytes; is a file cut off?");
    says(&with("\"bufferView\":0", "\"bufferView\":9"), "there is no buffer view 9");
    says(&with("\"bufferView\":0,", ""), "has no data; is the mesh compressed?");
    says(&with("\"buffer\":0", "\"buffer\":3"), "refers to buffer 3");
    says(&with("VEC3", "VEC2"), "has rows of type Vec2 and not Vec3");
    says(&with("\"indices\":2", "\"indices\":9"), "accessor 9, for indices, does not exist");
    says(&with("5126", "1"), "has a type that glTF does not define");
    says(&with("\"count\":4", "\"count\":3"), "its indices refer to vertex 3, but there are 3");
    says(&with("\"buffers\":[{", "\"buffers\":[{\"uri\":\"a.bin\","), "as GLB");
    says(&with("\"buffers\":[{", "\"buffers\":[{\"uri\":\"data:;base64,?\","), "data URI");
}

#[test]
fn a_mesh_that_is_repeated_without_end_is_refused() {
    // Two thousand nodes use a mesh of ten thousand primitives: about 400 kB of JSON for 80 million
    // vertices.
    let primitives = vec![r#"{"attributes":{"POSITION":0},"mode":5}"#; 10_000].join(",");
    let nodes = vec![r#"{"mesh":0}"#; 2_000].join(",");
    says(&file(&primitives, &format!("\"nodes\":[{nodes}]")), "repeats its meshes");
}

#[test]
fn damage_anywhere_is_a_model_or_one_line() {
    let good = file(r#"{"attributes":{"POSITION":1,"TEXCOORD_0":3},"indices":2}"#, NODE);
    let check = |bytes: &[u8]| match read(Path::new("a.glb"), bytes) {
        Ok(mesh) => assert!(!mesh.to_triangles().is_empty()),
        Err(error) => assert!(!error.to_string().contains(char::is_control), "{error}"),
    };
    for place in 0..good.len() {
        check(&good[..place]);
        for byte in *b"\0\n -9\"\x7f\xff" {
            let mut bytes = good.clone();
            bytes[place] = byte;
            check(&bytes);
        }
    }
}

/// A file is read only once, even if many buffers refer to it by different names.
#[test]
fn a_file_that_many_buffers_name_is_read_once() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("a.bin"), bytes()).unwrap();
    let names = ["a.bin", "%61.bin", "a%2Ebin", "%61%2Ebin"];
    let buffer = |i: usize| format!(r#"{{"byteLength":{},"uri":"{}"}}"#, i % 69, names[i % 4]);
    let buffers = (0..1000).map(|i| buffer(68 + 69 * i)).collect::<Vec<_>>().join(",");
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{SQUARE}]}}],{NODE},{ACCESSORS}}}"#
    );
    let json = json.replace(r#"{"byteLength":68}"#, &buffers);
    let path = folder.path().join("m.gltf");
    std::fs::write(&path, &json).unwrap();
    let LoadedModel::<f32> { mesh, files, .. } = load_model(&path).unwrap();
    assert_eq!((mesh.triangles.len(), files), (2, vec![folder.path().join("a.bin")]));

    // A buffer has its declared length, even if other buffers use more of the file.
    let short = json.replacen(r#""byteLength":68,"#, r#""byteLength":47,"#, 1);
    std::fs::write(&path, short).unwrap();
    let error = load_model::<f32>(&path).unwrap_err().to_string();
    assert!(error.contains("reaches beyond buffer 0, which has 47 bytes"), "{error}");
}
