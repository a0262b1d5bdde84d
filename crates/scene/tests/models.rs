//! Tests that well-known models load completely. The models are not part of the repository. If a
//! model is missing, the tests print a message and skip the model.

use std::path::{Path, PathBuf};

use intertri_scene::{Mesh, Scene, load};

fn model(name: &str) -> Option<Mesh> {
    let folder = std::env::var_os("INTERTRI_MODELS").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models"),
        PathBuf::from,
    );
    let path = folder.join(name);
    if !path.exists() {
        println!(
            "no model at {}: skipped; set INTERTRI_MODELS to the models' folder",
            path.display()
        );
        return None;
    }
    Some(load(&path).unwrap_or_else(|error| panic!("{error}")))
}

#[test]
fn models_have_the_counts_of_their_files() {
    // There is one position per `v` line, and each `f` line has two fewer triangles than corners.
    // The lines were counted independently of the reader.
    let expected = [
        ("stanford-bunny.obj", 35_947, 69_451, false),
        ("fandisk.obj", 6_475, 12_946, false),
        ("spot.obj", 2_930, 5_856, true),
        ("suzanne.obj", 507, 32 + 2 * 468, false),
        ("teapot.obj", 3_644, 6_320, false),
        ("kitchen.obj", 74_303, 56_939, true),
    ];
    for (name, positions, triangles, textured) in expected {
        let Some(mesh) = model(name) else { continue };
        assert_eq!(mesh.positions.len(), positions, "{name}");
        assert_eq!(mesh.triangles.len(), triangles, "{name}");
        assert_eq!(mesh.corner_uvs.as_ref().map(Vec::len), textured.then_some(triangles), "{name}");
        assert_eq!(mesh.to_triangles().len(), triangles, "{name}");

        // Check that the model can be framed and lit.
        let scene = Scene::of(mesh, 4.0 / 3.0).unwrap();
        assert!(
            scene.camera.eye().iter().chain(&scene.light.origin([0.0; 3])).all(|x| x.is_finite())
        );
    }
}

#[test]
fn the_bunny_has_the_bits_of_its_file() {
    let Some(mesh) = model("stanford-bunny.obj") else { return };
    let expected = ["-0.037830", "0.127940", "0.004475"].map(|text| text.parse::<f32>().unwrap());
    assert_eq!(mesh.positions[0].map(f32::to_bits), expected.map(f32::to_bits));
}
