//! Tests that `render` traces glTF files with shared meshes as instances, and that the image is the
//! same as for the flattened model.

use std::time::{Duration, Instant};

use serde_json::Value;

use crate::common::TestFolder;

/// Returns a GLB file with a bumpy sheet and a floor without texture coordinates. Two nodes place
/// the sheet, one of which mirrors it; another places `copies` more instances, half of them
/// mirrored.
fn glb(copies: usize) -> Vec<u8> {
    let (mut bytes, mut views, mut accessors) = (vec![], vec![], vec![]);
    let mut add = |rows: &[f32], kind: &str, width: usize| {
        let (view, offset) = (views.len(), bytes.len());
        bytes.extend(rows.iter().flat_map(|x| x.to_le_bytes()));
        let length = bytes.len() - offset;
        views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#));
        let count = rows.len() / width;
        accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":5126,"count":{count},"type":"{kind}"}}"#
        ));
    };
    // The sheet is a triangle strip.
    let sheet = (0..34).map(|i| [0.11 * i as f32, (0.9 * i as f32).sin(), (i % 2) as f32]);
    let uvs = (0..34).map(|i| [0.07 * i as f32, (i % 2) as f32]);
    add(sheet.collect::<Vec<_>>().as_flattened(), "VEC3", 3);
    add(uvs.collect::<Vec<_>>().as_flattened(), "VEC2", 2);
    let side = 40.0;
    add(&[-9.0, -2.0, -9.0, side, -2.0, -9.0, 0.0, -2.0, side], "VEC3", 3);
    let (mut places, mut turns, mut sizes) = (vec![], vec![], vec![]);
    for i in 0..copies {
        let angle = 2.4 * i as f32;
        places.push([2.7 * (i % 10) as f32, 0.3 * angle.sin(), 1.9 * (i / 10) as f32]);
        turns.push([angle.sin(), 0.3, 0.1, angle.cos()]);
        sizes.push([1.0, 0.7, if i % 2 == 0 { 1.3 } else { -0.9 }]);
    }
    add(places.as_flattened(), "VEC3", 3);
    add(turns.as_flattened(), "VEC4", 4);
    add(sizes.as_flattened(), "VEC3", 3);
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}}}],"bufferViews":[{}],"accessors":[{}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"mode":5}}]}},{{"primitives":[{{"attributes":{{"POSITION":2}}}}]}}],
        "nodes":[{{"mesh":0,"translation":[0.1,2,-3]}},{{"mesh":0,"scale":[1,-1,2],"translation":[7,2,-3]}},{{"mesh":1}},
        {{"mesh":0,"rotation":[0.6,0,0,0.8],"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":3,"ROTATION":4,"SCALE":5}}}}}}}}]}}"#,
        bytes.len(),
        views.join(","),
        accessors.join(",")
    );
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let length = 12 + 8 + json.len() + 8 + bytes.len();
    let mut file = b"glTF".to_vec();
    file.extend([2, length as u32, json.len() as u32].map(u32::to_le_bytes).concat());
    file.extend(b"JSON");
    file.extend(json.bytes());
    file.extend((bytes.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(bytes);
    file
}

/// Renders with these arguments and returns the JSON report.
fn report(place: &TestFolder, arguments: &str) -> Value {
    serde_json::from_slice(&place.ok(&format!("render {arguments} --json"))).unwrap()
}

#[test]
fn instances_draw_the_picture_of_the_flattened_model() {
    let place = TestFolder::new();
    place.put("m.glb", glb(60));
    for (i, options) in [
        "",
        "--shadows none",
        "--sun 1,2,0.5",
        "--light 3,8,1",
        "--eye 9,4,-9",
        "--texture xor",
        "--view 0.2,1,-0.4 --up 0,0,1 --fov 60",
    ]
    .iter()
    .enumerate()
    {
        let size = "m.glb --size 203x151";
        let instances = report(&place, &format!("{size} {options} -o {i}.png"));
        assert_eq!(instances["instances"]["instances"], 63, "{instances}");
        // The sheet, the mirrored sheet, and the floor.
        assert_eq!(instances["instances"]["meshes"], 3);
        assert_eq!(instances["instances"]["mesh_triangles"], 32 + 32 + 1);
        // With `--check`, the model is flattened. Here, the check compares the engine with itself.
        let flat =
            report(&place, &format!("{size} {options} -o flat{i}.png --scalar f64 --check exact"));
        assert_eq!(flat["instances"], Value::Null);
        for same in ["triangles", "hits", "dark", "shadow_rays", "scalar"] {
            assert_eq!(instances[same], flat[same], "{same}, {options}");
        }
        let rays = instances["rays"].as_u64().unwrap();
        assert!(instances["hits"].as_u64().unwrap() > rays / 10, "{options}");
        assert!(
            place.read(&format!("{i}.png")) == place.read(&format!("flat{i}.png")),
            "{options}: the images differ"
        );
    }
}

/// A glTF file of less than 1 kB that places 40000 instances of a mesh with 39999 vertices. Almost
/// all vertices are zeros, which take up no bytes. Placing the camera and the light must not visit
/// every vertex of every instance.
#[test]
fn a_small_file_with_many_instances_of_many_vertices_is_drawn() {
    let place = TestFolder::new();
    place.put(
        "m.gltf",
        r#"{"asset":{"version":"2.0"},
        "buffers":[{"byteLength":48,"uri":"data:application/octet-stream;base64,AQAAAAIAAAAAAIA/AAAAAAAAAAAAAAAAAACAPwAAAAABAAAAAAAAAAAAAAAAAIA/"}],
        "bufferViews":[{"buffer":0,"byteLength":8},{"buffer":0,"byteOffset":8,"byteLength":24},
        {"buffer":0,"byteOffset":32,"byteLength":4},{"buffer":0,"byteOffset":36,"byteLength":12}],
        "accessors":[{"componentType":5126,"count":39999,"type":"VEC3","sparse":{"count":2,
        "indices":{"bufferView":0,"componentType":5125},"values":{"bufferView":1}}},
        {"componentType":5126,"count":40000,"type":"VEC3","sparse":{"count":1,
        "indices":{"bufferView":2,"componentType":5125},"values":{"bufferView":3}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":1}}}}]}"#,
    );
    let start = Instant::now();
    for options in ["", "--eye 3,4,9", "--sun 1,2,0.5"] {
        let report = report(&place, &format!("m.gltf --size 4x3 {options}"));
        assert_eq!(report["instances"]["instances"], 40000, "{options}");
    }
    // Visiting every vertex would take minutes.
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
}

#[test]
fn instances_are_used_where_they_can_be() {
    let place = TestFolder::new();
    place.put("m.glb", glb(3));
    for (options, is_instanced) in [
        ("", true),
        ("--scalar f64", true),
        ("--scalar f32", false),
        ("--engine certified", false),
        ("--engine oracle", false),
        ("--wire", false),
        ("--shadows volumes", false),
        ("--check oracle", false),
    ] {
        let report = report(&place, &format!("m.glb --size 20x15 {options}"));
        assert_eq!(report["instances"].is_object(), is_instanced, "{options}");
    }
    let text = String::from_utf8(place.ok("render m.glb --size 40x30")).unwrap();
    assert!(text.contains("6 instances (unique meshes: 3, unique triangles: 65)"), "{text}");
    let seconds = report(&place, "m.glb")["seconds"].clone();
    assert!(seconds["load"].as_f64().unwrap() > 0.0 && seconds["trace"].as_f64().unwrap() > 0.0);
}
