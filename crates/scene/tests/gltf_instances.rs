//! Tests that glTF nodes that share a mesh, and nodes with `EXT_mesh_gpu_instancing`, are loaded as
//! instances, and that flattening the instances yields the same mesh as loading the model flat.

use std::time::{Duration, Instant};

use intertri_scene::{
    InstancedMesh, LoadedInstances, LoadedModel, SceneGeometry, load_instances, load_model,
};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::gltf_scenes::{File, skinned};

/// Returns the instances of a file, after checking that their triangles equal those of the
/// flattened model in f64, bit for bit.
#[track_caller]
fn instances(file: &File) -> InstancedMesh {
    let folder = TempDir::new().unwrap();
    file.write(folder.path());
    let path = folder.path().join("a.gltf");
    let loaded = load_instances(&path).unwrap();
    let flat: LoadedModel<f64> = load_model(&path).unwrap();
    assert_eq!((&loaded.notes, &loaded.files), (&flat.notes, &flat.files));
    assert_eq!(loaded.clone().flatten().unwrap().mesh, flat.mesh);

    let LoadedInstances { model, .. } = loaded;
    let bits = |corners: [[f64; 3]; 3]| corners.map(|corner| corner.map(f64::to_bits));
    let mut expected = (0..flat.mesh.triangles.len()).map(|i| bits(flat.mesh.corners(i)));
    for (i, instance) in model.instances.iter().enumerate() {
        for triangle in 0..model.meshes[instance.mesh as usize].triangles.len() {
            assert_eq!(Some(bits(model.triangle(i, triangle).0)), expected.next());
        }
    }
    assert!(expected.next().is_none() && model.triangles() == flat.mesh.triangles.len() as u64);
    assert_eq!(model.bounding_box(), flat.mesh.bounds());
    model
}

#[track_caller]
fn refused(file: &File, words: &str) {
    let folder = TempDir::new().unwrap();
    file.write(folder.path());
    let loaded = load_instances(&folder.path().join("a.gltf")).map(|_| "a model");
    let error = loaded.unwrap_err().to_string();
    assert!(error.contains(words) && !error.contains('\n'), "{error} / {words}");
}

/// Returns a node with an arbitrary transform and with instances given by these attributes.
fn copies(attributes: &Value) -> Value {
    json!([{"mesh": 0, "rotation": [0.6, 0, 0, 0.8], "translation": [0.1, 7, 1], "scale": [1, 3, 0.3],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}])
}

#[test]
fn nodes_that_share_a_mesh_are_instances() {
    let mut file = File::new(&json!([
        {"mesh": 0, "translation": [0.1, 0.2, 0.3], "children": [1]},
        {"mesh": 0, "rotation": [0.6, 0, 0, 0.8], "scale": [0.1, 0.7, 3]},
        {"mesh": 0, "scale": [1, 1, -1]},
        {"mesh": 0}
    ]));
    let model = instances(&file);
    // The mirrored instance has its own mesh, with flipped triangles.
    let meshes: Vec<u32> = model.instances.iter().map(|instance| instance.mesh).collect();
    assert_eq!((meshes, model.meshes.len()), (vec![0, 0, 1, 0], 2));
    assert!(model.is_shared());
    assert_eq!(model.meshes[1].triangles, [[0, 2, 1]]);
    assert_eq!(model.instances[3].matrix, InstancedMesh::IDENTITY);
    let [.., x] = [0.1_f32, 0.2, 0.3].map(f64::from);
    assert_eq!(model.instances[0].matrix[11], x);

    // Nodes with the same morph weights share a mesh; nodes with different weights do not.
    let up = file.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": up}]);
    for node in [0, 3] {
        file.json["nodes"][node]["weights"] = json!([0.3]);
    }
    let meshes = |file: &File| -> Vec<u32> {
        instances(file).instances.iter().map(|instance| instance.mesh).collect()
    };
    assert_eq!(meshes(&file), [0, 1, 2, 0]);
    // Weights that have no target are ignored, and nodes may repeat the mesh's default weights.
    file.json["nodes"][3]["weights"] = json!([0.3, 5]);
    assert_eq!(meshes(&file), [0, 1, 2, 0]);
    file.json["meshes"][0]["weights"] = json!([0.3, 7, 8]);
    assert_eq!(meshes(&file), [0, 0, 1, 0]);
    file.json["nodes"][0]["weights"] = json!([]);
    assert_eq!(meshes(&file), [0, 1, 2, 1]);
}

#[test]
fn copies_are_instances() {
    let mut file = File::new(&copies(&json!({"TRANSLATION": 1, "SCALE": 2, "ROTATION": 3})));
    file.floats("VEC3", &[0.0, 0.3, 0.0, 10.0, 0.1, 0.0, 0.0, 20.0, 0.7]);
    file.floats("VEC3", &[1.0, 0.1, 1.0, 2.0, 2.0, 2.0, 1.0, 1.0, -1.0]);
    file.floats("VEC4", &[0.1, 0.7, 0.0, 0.7, 0.0, 0.0, 0.0, 1.0, 0.0, 0.5, 0.1, 1.0]);
    let model = instances(&file);
    assert_eq!((model.meshes.len(), model.instances.len()), (2, 3));
    for attribute in ["TRANSLATION", "SCALE"] {
        file.json["nodes"] = copies(&json!({attribute: 1}));
        assert_eq!(instances(&file).instances.len(), 3);
    }
    // If only one of two meshes has texture coordinates, the other gets zeros.
    let uvs = file.floats("VEC3", &[0.5; 6]);
    file.json["accessors"][uvs]["type"] = json!("VEC2");
    file.json["accessors"][uvs]["count"] = json!(3);
    let with_uvs = json!({"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": uvs}}]});
    file.add("meshes", with_uvs);
    file.add("nodes", json!({"mesh": 1}));
    assert_eq!(instances(&file).meshes.len(), 2);
}

#[test]
fn skinned_meshes_are_instances_of_their_own() {
    let mut file = skinned(&[0.3, 0.7, 0.0, 0.0].repeat(3));
    file.json["nodes"].as_array_mut().unwrap().push(json!({"mesh": 0, "skin": 0}));
    let model = instances(&file);
    assert_eq!((model.meshes.len(), model.instances.len()), (2, 2));
    assert!(!model.is_shared());
}

#[test]
fn meshes_without_triangles_are_no_instances() {
    let mut file = File::new(&json!([{"mesh": 0}, {"mesh": 1}, {"mesh": 1}]));
    let points = json!({"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}]});
    file.add("meshes", points);
    assert_eq!(instances(&file).instances.len(), 1);
    file.json["nodes"] = json!([{"mesh": 1}]);
    refused(&file, "it has no triangle");
}

/// Instances take no memory for their triangles, so they may have more triangles in total than a
/// flattened mesh.
#[test]
fn only_flattening_repeats_triangles() {
    let mut file = File::new(&json!([]));
    let many = 3000;
    file.json["meshes"][0]["primitives"] =
        json!(vec![json!({"attributes": {"POSITION": 0}}); many]);
    file.json["nodes"] = json!(vec![json!({"mesh": 0}); 2 * many]);
    let folder = TempDir::new().unwrap();
    file.write(folder.path());
    let loaded = load_instances(&folder.path().join("a.gltf")).unwrap();
    assert_eq!(loaded.model.triangles(), 2 * (many * many) as u64);
    let error = loaded.flatten().unwrap_err().to_string();
    assert!(error.ends_with(
        "the file repeats its meshes beyond 16777216 vertices and triangles; export fewer copies"
    ), "{error}");
}

#[test]
fn hostile_instances_are_errors() {
    // A table of zeros takes up no bytes, and its count must not determine the size of an
    // allocation.
    let mut file = File::new(&json!([]));
    for (count, words) in [
        (1_u64 << 60, "repeats its meshes"),
        (u64::MAX, "repeats its meshes"),
        (1 << 23, "repeats its meshes"),
        (5_000_000, "repeats its meshes"),
    ] {
        let sparse = json!({"componentType": 5126, "count": count, "type": "VEC3", "sparse": {"count": 0,
            "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}}});
        let table = file.add("accessors", sparse);
        file.json["nodes"] = copies(&json!({"TRANSLATION": table}));
        refused(&file, words);
    }
    // Test nested scales whose product overflows, then corners that overflow when they are
    // transformed.
    let nested = |depth: usize| {
        let mut nodes: Vec<Value> =
            (1..depth).map(|i| json!({"children": [i], "scale": [1e38, 1e38, 1e38]})).collect();
        nodes.push(json!({"mesh": 0}));
        File::new(&json!(nodes))
    };
    refused(&nested(12), "places mesh 0 at coordinates that are not finite; repair the model");
    let mut file = nested(9);
    instances(&file);
    let far = file.floats("VEC3", &[3e38; 9]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(far);
    refused(&file, "the vertex (inf, inf, inf) is not finite in f64");
    // Test NaN in a table.
    let mut file = File::new(&copies(&json!({"TRANSLATION": 1})));
    file.floats("VEC3", &[f32::NAN, 0.0, 0.0]);
    refused(&file, "not finite");
}

/// Returns a file whose mesh has `count` vertices, with coordinates up to `size`, and the index of
/// the table of their positions.
fn sheet(count: usize, size: f32) -> (File, usize) {
    let mut file = File::new(&json!([]));
    let position = |i: usize| [1.0, (0.37 * i as f32).sin(), (1.1 * i as f32).cos()];
    let positions: Vec<_> = (0..count).map(|i| position(i).map(|x| size * x)).collect();
    let positions = file.floats("VEC3", positions.as_flattened());
    file.attribute("POSITION", positions);
    (file, positions)
}

/// Adds a table of zeros, which takes up no bytes, and returns its index.
fn zeros(file: &mut File, count: usize) -> usize {
    let table = json!({"componentType": 5126, "count": count, "type": "VEC3", "sparse": {"count": 0,
        "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}}});
    file.add("accessors", table)
}

fn load(file: &File) -> InstancedMesh {
    let folder = TempDir::new().unwrap();
    file.write(folder.path());
    load_instances(&folder.path().join("a.gltf")).unwrap().model
}

/// A small file can have many instances of many vertices. Bounds and cameras must not visit every
/// vertex of every instance.
#[test]
fn many_instances_are_bounded_by_the_corners_of_boxes() {
    let (vertices, many) = (4800, 4800);
    let (mut file, positions) = sheet(vertices, 1.0);
    // Use the positions as translations, too.
    for (attributes, is_rotated) in [
        (json!({"TRANSLATION": positions, "SCALE": positions}), false),
        (json!({"TRANSLATION": positions}), true),
    ] {
        file.json["nodes"] = copies(&attributes);
        if !is_rotated {
            file.json["nodes"][0]["rotation"] = json!([0, 0, 0, 1]);
        }
        let mut model = load(&file);
        assert_eq!(model.instances.len(), many);
        assert!(model.enclosing_points().count() <= 8 * many);
        let bounds = model.bounding_box().unwrap();
        let exact = |model: &InstancedMesh| {
            let mut points = model.points();
            let first = points.next().unwrap();
            points.fold([first; 2], |[min, max], p| {
                [[0, 1, 2].map(|k| p[k].min(min[k])), [0, 1, 2].map(|k| p[k].max(max[k]))]
            })
        };
        let [min, max] = exact(&model);
        if is_rotated {
            assert!((0..3).all(|k| bounds.min[k] <= min[k] && max[k] <= bounds.max[k]));
            assert!((0..3).all(|k| bounds.max[k] - bounds.min[k] <= 2.0 * (max[k] - min[k])));
        } else {
            assert_eq!([bounds.min, bounds.max], [min, max]);
        }
        // With fewer instances, the points are the vertices.
        model.instances.truncate(many / 2);
        assert!(model.enclosing_points().eq(model.points()));
        let bounds = model.bounding_box().unwrap();
        assert_eq!([bounds.min, bounds.max], exact(&model));
    }
}

/// Instances whose corners might overflow are checked corner by corner, up to a limit.
#[test]
fn checks_for_overflow_are_limited() {
    let (mut file, _) = sheet(4800, 15000.0);
    let mut nest = |count: usize| {
        let table = zeros(&mut file, count);
        let mut nodes: Vec<Value> =
            (1..9).map(|i| json!({"children": [i], "scale": [1e38, 1e38, 1e38]})).collect();
        nodes.extend(copies(&json!({"TRANSLATION": table})).as_array().unwrap().clone());
        for key in ["rotation", "scale"] {
            nodes[8].as_object_mut().unwrap().remove(key);
        }
        nodes[8]["translation"] = json!([0, 0, 0]);
        file.json["nodes"] = json!(nodes);
        file.json.clone()
    };
    let (few, many) = (nest(100), nest(4800));
    file.json = few;
    let largest = load(&file).points().flatten().fold(0.0, f64::max);
    assert!(largest > f64::MAX / 2.0 && largest.is_finite());
    file.json = many;
    refused(&file, "the file repeats its meshes");
}

/// A small file can have many morph weights and many instances of the mesh that they deform.
#[test]
fn weights_are_compared_once_per_node() {
    let mut file = File::new(&json!([]));
    let (weights, many) = (100_000, 200_000);
    let targets = json!(vec![json!({}); weights]);
    file.json["meshes"][0]["primitives"][0]["targets"] = targets;
    let table = zeros(&mut file, many);
    file.json["nodes"] = copies(&json!({"TRANSLATION": table}));
    let start = Instant::now();
    for place in ["meshes", "nodes"] {
        file.json[place][0]["weights"] = json!(vec![0; weights]);
        let model = load(&file);
        assert_eq!((model.meshes.len(), model.instances.len()), (1, many));
        file.json[place][0]["weights"] = json!([]);
    }
    // Reading the weights for each instance would take a minute even on a fast machine.
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
}

/// Replacing any byte yields either a model or a one-line error.
#[test]
fn damage_is_an_error() {
    let mut file = File::new(&copies(&json!({"TRANSLATION": 1, "ROTATION": 2})));
    file.floats("VEC3", &[0.0, 0.3, 0.0, 10.0, 0.1, 0.0]);
    file.floats("VEC4", &[0.1, 0.7, 0.0, 0.7, 0.0, 0.0, 0.0, 1.0]);
    let folder = TempDir::new().unwrap();
    file.write(folder.path());
    let path = folder.path().join("a.gltf");
    let good = std::fs::read(&path).unwrap();
    for place in 0..good.len() {
        for byte in *b"\0 -9\"]" {
            let mut bytes = good.clone();
            bytes[place] = byte;
            std::fs::write(&path, &bytes).unwrap();
            match load_instances(&path) {
                Ok(loaded) => assert!(loaded.model.triangles() > 0),
                Err(error) => assert!(!error.to_string().contains(char::is_control), "{error}"),
            }
        }
    }
}
