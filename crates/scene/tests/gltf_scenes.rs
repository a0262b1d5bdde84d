//! Tests how glTF nodes, skins, and extensions affect triangles, and where buffers may be stored.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use intertri_scene::{LoadedModel, load_model};
use serde_json::{Value, json};
use tempfile::TempDir;

/// The corners of a triangle.
type Triangle = [[f32; 3]; 3];

/// A glTF file, initially with a single triangle at (0,0,0), (1,0,0), (0,1,0), and the bytes of its
/// buffer. Tests may add to both.
pub(crate) struct File {
    pub(crate) json: Value,
    bytes: Vec<u8>,
}

impl File {
    pub(crate) fn new(nodes: &Value) -> Self {
        let mut file = Self {
            json: json!({"asset": {"version": "2.0"}, "nodes": nodes, "accessors": [], "bufferViews": []}),
            bytes: vec![],
        };
        file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        file.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": 0}}]}]);
        file
    }

    /// Adds bytes as a buffer view and returns its index.
    fn view(&mut self, bytes: impl IntoIterator<Item = u8>) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let view =
            json!({"buffer": 0, "byteOffset": offset, "byteLength": self.bytes.len() - offset});
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        self.add("bufferViews", view)
    }

    /// Adds a table of floats and returns its index.
    pub(crate) fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let view = self.view(numbers.iter().flat_map(|x| x.to_le_bytes()));
        let count = numbers.len()
            / match kind {
                "SCALAR" => 1,
                "VEC3" => 3,
                "VEC4" => 4,
                _ => 16,
            };
        self.add(
            "accessors",
            json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind}),
        )
    }

    pub(crate) fn add(&mut self, table: &str, entry: Value) -> usize {
        let table = self.json.as_object_mut().unwrap().entry(table).or_insert_with(|| json!([]));
        let table = table.as_array_mut().unwrap();
        table.push(entry);
        table.len() - 1
    }

    pub(crate) fn attribute(&mut self, name: &str, table: usize) {
        self.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(table);
    }

    pub(crate) fn write(&self, folder: &Path) {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": "a.bin"}]);
        fs::write(folder.join("a.bin"), &self.bytes).unwrap();
        fs::write(folder.join("a.gltf"), json.to_string()).unwrap();
    }

    /// Returns the triangles' corners and the notes, or the error.
    fn load(&self) -> Result<(Vec<Triangle>, Vec<String>), String> {
        let folder = TempDir::new().unwrap();
        self.write(folder.path());
        let model: LoadedModel = load_model(&folder.path().join("a.gltf")).map_err(|e| e.cause)?;
        let corners = (0..model.mesh.triangles.len()).map(|i| model.mesh.corners(i)).collect();
        Ok((corners, model.notes.as_slice().iter().map(ToString::to_string).collect()))
    }

    /// Returns the triangles after checking that the file causes no notes.
    #[track_caller]
    fn triangles(&self) -> Vec<Triangle> {
        let (triangles, notes) = self.load().unwrap();
        assert_eq!(notes, [""; 0]);
        triangles
    }

    #[track_caller]
    fn refused(&self, words: &str) {
        let error = self.load().unwrap_err();
        assert!(error.contains(words), "{error} / {words}");
    }
}

const TRIANGLE: Triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn moved(by: [f32; 3]) -> Triangle {
    TRIANGLE.map(|p| [0, 1, 2].map(|k| p[k] + by[k]))
}

#[test]
fn mirrors_turn_the_winding() {
    // Nodes with and without mirroring, and whether they flip the winding.
    for (nodes, turned) in [
        (json!([{"mesh": 0, "scale": [1, 1, -1]}]), true),
        (json!([{"mesh": 0, "scale": [-1, -1, 1]}]), false),
        (json!([{"mesh": 0, "scale": [-1, -1, -1]}]), true),
        (json!([{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 1, 1]}]), true),
        (json!([{"children": [1], "scale": [1, -1, 1]}, {"mesh": 0, "scale": [1, 1, -1]}]), false),
        (
            json!([{"children": [1], "scale": [1, -1e-30, 1]}, {"mesh": 0, "scale": [1, 1e-30, 1]}]),
            true,
        ),
        (json!([{"mesh": 0, "rotation": [1, 0, 0, 0]}]), false),
    ] {
        // A triangle, and a square as a strip and as a fan.
        let mut file = File::new(&nodes);
        file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
        for (mode, positions) in [(4, 0), (5, 1), (6, 1)] {
            file.json["meshes"][0]["primitives"][0] =
                json!({"attributes": {"POSITION": positions}, "mode": mode});
            let mut plain = File { json: file.json.clone(), bytes: file.bytes.clone() };
            plain.json["nodes"] = json!([{"mesh": 0}]);
            let of = |file: &File| {
                let folder = TempDir::new().unwrap();
                file.write(folder.path());
                load_model::<f64>(&folder.path().join("a.gltf")).unwrap().mesh.triangles
            };
            let turn = |[a, b, c]: [u32; 3]| if turned { [a, c, b] } else { [a, b, c] };
            let expected: Vec<_> = of(&plain).into_iter().map(turn).collect();
            assert_eq!(of(&file), expected, "{nodes} {mode}");
        }
    }
}

#[test]
fn instances_are_copies() {
    let node = |attributes: Value| json!([{"mesh": 0, "translation": [0, 0, 1], "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}]);
    let mut file = File::new(&node(json!({"TRANSLATION": 1, "SCALE": 2, "ROTATION": 3})));
    file.floats("VEC3", &[0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 20.0, 0.0]);
    file.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 1.0, -1.0]);
    file.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    file.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    file.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let large = TRIANGLE.map(|[x, y, z]| [x * 2.0 + 10.0, y * 2.0, z + 1.0]);
    let [a, b, c] = moved([0.0, 20.0, 1.0]);
    assert_eq!(file.triangles(), [moved([0.0, 0.0, 1.0]), large, [a, c, b]]);

    file.json["nodes"] = node(json!({"TRANSLATION": 1}));
    assert_eq!(file.triangles().len(), 3);
    file.json["nodes"] = node(json!({"TRANSLATION": 1, "SCALE": 0, "_ID": 1}));
    assert_eq!(file.triangles().len(), 3);
    file.json["nodes"] = node(json!({"TRANSLATION": 9}));
    file.refused("accessor 9, for instances, does not exist");
    file.json["nodes"] = node(json!({"TRANSLATION": "x"}));
    file.refused("not an accessor");
    file.json["nodes"] = json!([{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {}}}]);
    file.refused("has no attributes");
    file.floats("VEC3", &[0.0; 6]);
    file.json["nodes"] = node(json!({"TRANSLATION": 1, "SCALE": 4}));
    file.refused("different lengths");
    // A table of zeros takes up no bytes, and no memory is reserved for it.
    let sparse = json!({"componentType": 5126, "count": 1_u64 << 60, "type": "VEC3", "sparse": {"count": 0,
        "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}}});
    let endless = file.add("accessors", sparse);
    file.json["nodes"] = node(json!({"TRANSLATION": endless}));
    file.refused("repeats its meshes");
    file.json["nodes"] = json!([{"mesh": 0}]);
    file.attribute("POSITION", endless);
    file.refused("repeats its meshes");
}

#[test]
fn hidden_nodes_and_all_below_them_are_left_out() {
    let hidden = |visible: Value| json!({"KHR_node_visibility": {"visible": visible}});
    let file = File::new(&json!([
        {"children": [1, 3], "extensions": hidden(json!(true))},
        {"children": [2], "mesh": 0, "extensions": hidden(json!(false))},
        {"mesh": 0},
        {"mesh": 0, "translation": [5, 0, 0]}
    ]));
    assert_eq!(file.triangles(), [moved([5.0, 0.0, 0.0])]);
}

/// Returns a file with a skin. Its two joints, at x = 10 and x = 20, are both bound at 0, and the
/// mesh's node is elsewhere.
pub(crate) fn skinned(shares: &[f32]) -> File {
    let mut file = File::new(&json!([
        {"mesh": 0, "skin": 0, "translation": [0, 0, 99]},
        {"children": [2], "translation": [10, 0, 0]},
        {"translation": [10, 0, 0]}
    ]));
    let joints = file.view([0_u8, 1, 0, 0].repeat(3));
    let joints = file.add(
        "accessors",
        json!({"bufferView": joints, "componentType": 5121, "count": 3, "type": "VEC4"}),
    );
    let shares = file.floats("VEC4", shares);
    file.attribute("JOINTS_0", joints);
    file.attribute("WEIGHTS_0", shares);
    file.json["skins"] = json!([{"joints": [1, 2]}]);
    file
}

#[test]
fn joints_place_a_skinned_mesh_and_not_its_node() {
    let all_first = [1.0, 0.0, 0.0, 0.0].repeat(3);
    let mut file = skinned(&all_first);
    assert_eq!(file.triangles(), [moved([10.0, 0.0, 0.0])]);
    let halves = [0.5, 0.5, 0.0, 0.0].repeat(3);
    assert_eq!(skinned(&halves).triangles(), [moved([15.0, 0.0, 0.0])]);
    // Weights need not sum to 1, for instance if a file stores them in units of 1/255. Only their
    // ratios matter.
    let twice = [1.0, 1.0, 0.0, 0.0].repeat(3);
    assert_eq!(skinned(&twice).triangles(), [moved([15.0, 0.0, 0.0])]);

    // If the mesh is bound at the joints' positions, it stays where it was modelled.
    let matrix = |x: f32| {
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [-x, 0.0, 0.0, 1.0]]
    };
    let inverse = file.floats("MAT4", [matrix(10.0), matrix(20.0)].as_flattened().as_flattened());
    file.json["skins"][0]["inverseBindMatrices"] = json!(inverse);
    assert_eq!(file.triangles(), [TRIANGLE]);
    // A joint that mirrors flips the winding.
    file.json["nodes"][1]["scale"] = json!([1, 1, -1]);
    let [a, b, c] = TRIANGLE;
    assert_eq!(file.triangles(), [[a, c, b]]);

    file.json["skins"][0]["joints"] = json!([1]);
    assert_eq!(file.triangles().len(), 1);
    file.json["skins"][0]["joints"] = json!([1, 2, 2]);
    file.refused("fewer inverse bind matrices");
    file.json["skins"][0]["joints"] = json!([1, 7]);
    file.refused("joint 7 does not exist");
    file.json["nodes"][0]["skin"] = json!(3);
    file.refused("skin 3: does not exist");
    let mut file = skinned(&halves);
    file.json["skins"][0]["joints"] = json!([1]);
    file.refused("refers to joint 1, which its skin lacks");
}

#[test]
fn a_skin_without_joints_is_placed_by_its_node_and_counted() {
    let mut file = skinned(&[1.0; 12]);
    file.json["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
    let (triangles, notes) = file.load().unwrap();
    assert_eq!(triangles, [moved([0.0, 0.0, 99.0])]);
    assert_eq!(notes, ["skinned primitives without joints and weights, placed by their nodes: 1"]);
}

#[test]
fn morph_targets_go_as_far_as_their_weights() {
    let mut file = File::new(&json!([{"mesh": 0}]));
    let up = file.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    let aside = file.floats("VEC3", &[4.0, 0.0, 0.0].repeat(3));
    file.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{"POSITION": up}, {"POSITION": aside}]);
    assert_eq!(file.triangles(), [TRIANGLE]);
    file.json["meshes"][0]["weights"] = json!([1.0, 0.0]);
    assert_eq!(file.triangles(), [moved([0.0, 0.0, 2.0])]);
    // A node's weights replace those of its mesh.
    file.json["nodes"][0]["weights"] = json!([0.5, 0.25]);
    assert_eq!(file.triangles(), [moved([1.0, 0.0, 1.0])]);
}

#[test]
fn sparse_tables_replace_rows() {
    let mut file = File::new(&json!([{"mesh": 0}]));
    let rows = file.view([1, 2]);
    let values = file.view([7.0_f32, 8.0, 9.0, 4.0, 5.0, 6.0].iter().flat_map(|x| x.to_le_bytes()));
    file.json["accessors"][0]["sparse"] = json!({"count": 2,
        "indices": {"bufferView": rows, "componentType": 5121}, "values": {"bufferView": values}});
    let replaced = [[0.0, 0.0, 0.0], [7.0, 8.0, 9.0], [4.0, 5.0, 6.0]];
    assert_eq!(file.triangles(), [replaced]);
    // Without a buffer view, the other rows are zeros.
    file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(file.triangles(), [replaced]);

    let wrong = |part: &str, to: Value, words: &str| {
        let mut file = File { json: file.json.clone(), bytes: file.bytes.clone() };
        *file.json["accessors"][0]["sparse"].pointer_mut(part).unwrap() = to;
        file.refused(words);
    };
    wrong("/count", json!(3), "accessor 0, for positions, reaches beyond its buffer view");
    wrong("/count", json!(u64::MAX), "reaches beyond");
    wrong("/values/bufferView", json!(9), "there is no buffer view 9");
    wrong("/indices/componentType", json!(5123), "reaches beyond");
    wrong("/indices/componentType", json!(5126), "type that glTF does not define");
    file.json["accessors"][0]["count"] = json!(2);
    file.refused("sparse indices that do not ascend or are out of range");
    file.json["accessors"][0]["count"] = json!(3);
    let at = file.json["bufferViews"][rows]["byteOffset"].as_u64().unwrap() as usize;
    file.bytes[at + 1] = 1;
    file.refused("do not ascend");
}

#[test]
fn extensions_are_known_or_named() {
    let mut file = File::new(&json!([{"mesh": 0}]));
    for name in ["EXT_mesh_features", "KHR_materials_unlit", "KHR_mesh_quantization", "VRMC_vrm"] {
        file.json["extensionsUsed"] = json!([name]);
        file.json["extensionsRequired"] = json!([name]);
        assert_eq!(file.triangles(), [TRIANGLE], "{name}");
    }
    for (name, words) in [
        ("KHR_draco_mesh_compression", "compressed with Draco"),
        ("EXT_meshopt_compression", "compressed with meshopt"),
        ("ACME_bend", "needs an extension that is not supported"),
    ] {
        file.json["extensionsRequired"] = json!([name]);
        file.refused(&format!("{words} ({name:?}); export the model without it"));
    }
    // A file that does not require an extension can be read without it, because the file also
    // stores any compressed meshes uncompressed.
    file.json["extensionsRequired"] = json!([]);
    file.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression", "EXT_meshopt_compression"]);
    assert_eq!(file.triangles(), [TRIANGLE]);
    file.json["extensionsUsed"] = json!(["ACME_bend", "KHR_xmp", "ACME_\u{7}"]);
    let (triangles, notes) = file.load().unwrap();
    assert_eq!(triangles, [TRIANGLE]);
    assert_eq!(
        notes,
        ["extensions that may change shapes, ignored (\"ACME_bend\", \"ACME_\\u{7}\"): 2"]
    );
}

#[test]
fn corners_that_make_no_triangle_are_counted() {
    for (mode, count, triangles, over) in
        [(4, 5, 1, 2), (4, 6, 2, 0), (5, 4, 2, 0), (6, 2, 0, 2), (5, 1, 0, 1)]
    {
        let mut file = File::new(&json!([{"mesh": 0}]));
        let more = file.floats(
            "VEC3",
            &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].repeat(2).as_flattened()
                [..3 * count],
        );
        file.json["meshes"][0]["primitives"] = json!([{"attributes": {"POSITION": 0}},
            {"attributes": {"POSITION": more}, "mode": mode}]);
        let (found, notes) = file.load().unwrap();
        // The first triangle comes from the primitive that all these files share.
        assert_eq!(found.len(), 1 + triangles, "{mode} {count}");
        let said = format!("corners that do not form a whole triangle, skipped: {over}");
        assert_eq!(notes, Vec::from_iter((over > 0).then_some(said)));
    }
}

#[test]
fn buffers_are_anywhere_in_the_models_folder_and_nowhere_else() {
    let folder = TempDir::new().unwrap();
    let model = folder.path().join("model");
    fs::create_dir_all(model.join("below")).unwrap();
    let file = File::new(&json!([{"mesh": 0}]));
    file.write(&model);
    fs::copy(model.join("a.bin"), folder.path().join("out.bin")).unwrap();
    fs::copy(model.join("a.bin"), model.join("below/b.bin")).unwrap();
    let load = |uri: &str| {
        let mut json = file.json.clone();
        json["buffers"] = json!([{"byteLength": file.bytes.len(), "uri": uri}]);
        fs::write(model.join("a.gltf"), json.to_string()).unwrap();
        load_model::<f32>(&model.join("a.gltf"))
    };
    for (uri, read) in [
        ("a.bin", "a.bin"),
        ("./a.bin", "a.bin"),
        ("sub/../a.bin", "a.bin"),
        ("below/../././a.bin", "a.bin"),
        ("%2E/a.bin", "a.bin"),
        ("below/b.bin", "below/b.bin"),
        ("below/./b.bin", "below/b.bin"),
    ] {
        assert_eq!(load(uri).unwrap().files, [model.join(read)], "{uri}");
    }
    for uri in [
        "../out.bin",
        "below/../../out.bin",
        "%2E%2E/out.bin",
        "/etc/passwd",
        "http://a.bin",
        "file:a.bin",
        ".",
        "below/..",
    ] {
        let error = load(uri).unwrap_err().to_string();
        assert!(error.contains("only files in the model's own folder are read"), "{uri}: {error}");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        symlink("../out.bin", model.join("leads-out.bin")).unwrap();
        symlink("below/b.bin", model.join("stays.bin")).unwrap();
        symlink("..", model.join("up")).unwrap();
        symlink("model", folder.path().join("linked")).unwrap();
        for uri in ["leads-out.bin", "up/out.bin"] {
            let error = load(uri).unwrap_err().to_string();
            assert!(
                error.contains("only files in the model's own folder are read"),
                "{uri}: {error}"
            );
        }
        assert_eq!(load("stays.bin").unwrap().mesh.triangles.len(), 1);
        assert_eq!(load("up/model/a.bin").unwrap().mesh.triangles.len(), 1);
        // A link to the model's folder itself does not lead out of the folder.
        assert_eq!(
            load_model::<f32>(&folder.path().join("linked/a.gltf")).unwrap().mesh.triangles.len(),
            1
        );
    }
    let mut data = String::from("DaTa:application/octet-stream,");
    for byte in &file.bytes {
        write!(data, "%{byte:02x}").unwrap();
    }
    assert_eq!(load(&data).unwrap().mesh.triangles.len(), 1);
}
