//! Pictures and reports of the real binary.

mod common;

use common::{MODEL, Place};
use serde_json::Value;

#[test]
fn the_built_in_scene_is_the_reference_s_in_every_pixel() {
    let place = Place::new();
    let report = place.ok("render --size 96x72 --check reference --json");
    let report: Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(report["check"]["differing_pixels"], 0);
    assert_eq!(report["check"]["engine"], "reference");
    assert_eq!(report["rays"], 96 * 72);
    assert_eq!(report["model"], Value::Null);
    // It is neither all backdrop nor all floor.
    assert!((3000..6500).contains(&report["hits"].as_u64().unwrap()), "{report}");
    assert_eq!(report["hits"], report["shadow_rays"]);
    assert_eq!(place.names(), ["intertri.diff.png", "intertri.png"]);
}

#[test]
fn all_engines_draw_the_same_picture_byte_for_byte() {
    let place = Place::new();
    place.put("m.obj", MODEL);
    for engine in ["certified", "double", "reference"] {
        place.ok(&format!("render m.obj --size 61x45 --engine {engine} -o {engine}.png"));
    }
    assert_eq!(place.read("certified.png"), place.read("double.png"));
    assert_eq!(place.read("certified.png"), place.read("reference.png"));
    assert_eq!(place.read("certified.png")[..8], *b"\x89PNG\r\n\x1a\n");
}

#[test]
fn options_change_the_picture() {
    let place = Place::new();
    place.put("m.obj", MODEL);
    // Of the built-in scene, and of a model.
    let mut pictures = Vec::new();
    for (i, options) in [
        "",
        "m.obj",
        "m.obj --fov 20",
        "m.obj --eye 3,3,-4",
        "--shadows none",
        "--view -1,0.4,-1",
        "--view -1,0.4,-1 --up 0,0,1",
        "--fov 20",
        "--eye 3,3,-4",
        "--eye 3,3,-4 --target 0,1,0",
    ]
    .iter()
    .enumerate()
    {
        place.ok(&format!("render --size 61x45 -o {i}.png {options}"));
        pictures.push(place.read(&format!("{i}.png")));
    }
    for (i, picture) in pictures.iter().enumerate() {
        assert!(!pictures[..i].contains(picture), "picture {i} is not new");
    }
}

#[test]
fn the_summary_is_for_people() {
    let place = Place::new();
    let text = String::from_utf8(place.ok("render --size 16x12")).unwrap();
    for word in ["intertri.png: 16x12", "10,804 triangles", "192 rays", "load", "build", "write"] {
        assert!(text.contains(word), "no {word:?} in {text}");
    }
}

#[test]
fn help_is_on_the_standard_output() {
    let place = Place::new();
    for arguments in ["--help", "render --help", "trace --help", "-h", "--version"] {
        assert!(!place.ok(arguments).is_empty());
    }
}
