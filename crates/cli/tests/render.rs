//! Tests the images and reports of `intertri render`, through the compiled binary.

use crate::common;
use crate::common::{MODEL, TestFolder};
use serde_json::Value;

#[test]
fn the_built_in_scene_is_the_reference_s_in_every_pixel() {
    let place = TestFolder::new();
    let report = place.ok("render --size 96x72 --engine certified --check reference --json");
    let report: Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(report["check"]["differing_pixels"], 0);
    assert_eq!(report["check"]["engine"], "reference");
    assert_eq!(report["rays"], 96 * 72);
    assert_eq!(report["model"], Value::Null);
    // The image is neither all background nor all floor.
    assert!((3000..6500).contains(&report["hits"].as_u64().unwrap()), "{report}");
    assert_eq!(report["hits"], report["shadow_rays"]);
    assert_eq!(place.names(), ["intertri.diff.png", "intertri.png"]);
}

#[test]
fn engines_of_one_arithmetic_draw_the_same_picture_byte_for_byte() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    for engine in ["certified", "reference"] {
        place.ok(&format!("render m.obj --size 61x45 --engine {engine} -o {engine}.png"));
    }
    assert_eq!(place.read("certified.png"), place.read("reference.png"));
    assert_eq!(place.read("certified.png")[..8], *b"\x89PNG\r\n\x1a\n");
}

#[test]
fn options_change_the_picture() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    // The options change the image of the built-in scene as well as that of a model.
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
    let place = TestFolder::new();
    let text = String::from_utf8(place.ok("render --size 16x12")).unwrap();
    for word in ["intertri.png: 16x12", "10,804 triangles", "192 rays", "load", "build", "write"] {
        assert!(text.contains(word), "no {word:?} in {text}");
    }
}

#[test]
fn the_seconds_of_the_steps_are_those_of_the_whole() {
    let place = TestFolder::new();
    for check in ["", "--check raster"] {
        let report = place.ok(&format!("render --size 2048x2048 --json {check}"));
        let report: Value = serde_json::from_slice(&report).unwrap();
        let seconds = report["seconds"].as_object().unwrap();
        let all = seconds["total"].as_f64().unwrap();
        let steps: f64 = seconds.values().map(|x| x.as_f64().unwrap()).sum::<f64>() - all;
        assert!(steps <= all && steps > 0.8 * all, "{report}");
        assert_eq!(seconds["check"].as_f64().unwrap() > 0.0, !check.is_empty(), "{report}");
    }
}

#[test]
fn a_look_straight_down_or_up_has_another_up() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    for look in ["--view 0,1,0", "--view 0,-3,0", "--eye 0,9,6 --target 0,0,6"] {
        for model in ["m.obj", ""] {
            place.ok(&format!("render {model} --size 61x45 {look}"));
        }
    }
    let text = String::from_utf8(place.ok("render m.obj --size 61x45 --view 0,1,0")).unwrap();
    assert!(text.contains(" 0,0,-1 is up"), "{text}");
    place.fails("render m.obj --view 0,1,0 --up 0,2,0", 1, &["--up", "along the line of sight"]);
    place.fails("render m.obj --up 0,0,0", 1, &["--up", "zero"]);
}

#[test]
fn what_is_up_is_said_and_can_be_turned() {
    let place = TestFolder::new();
    // A spire with a roof on one side. One model has y up, and the other has z up.
    let model = |up: fn([i32; 3]) -> [i32; 3]| {
        let points = [[-1, 0, -1], [1, 0, -1], [1, 0, 2], [0, 5, 0]].map(up);
        let lines = points.map(|[x, y, z]| format!("v {x} {y} {z}\n"));
        format!("{}f 1 2 4\nf 2 3 4\nf 3 1 4\n", lines.concat())
    };
    place.put("y.obj", model(|p| p)).put("z.obj", model(|[x, y, z]| [x, -z, y]));
    let report = |arguments: &str| -> Value {
        let text = place.ok(&format!("render --size 200x150 --json {arguments}"));
        serde_json::from_slice(&text).unwrap()
    };
    let [y, z] = ["y.obj", "z.obj --up 0,0,1"].map(report);
    assert_eq!(
        (&y["up"], &z["up"]),
        (&serde_json::json!([0., 1., 0.]), &serde_json::json!([0., 0., 1.]))
    );
    let hits = [&y, &z].map(|report| report["hits"].as_i64().unwrap());
    assert!((hits[0] - hits[1]).abs() < 10 && hits[0] > 1000, "{hits:?}");
    let text = String::from_utf8(place.ok("render z.obj --size 8x6")).unwrap();
    assert!(text.contains(" 0,1,0 is up; for a model whose z is up, add --up 0,0,1"), "{text}");
    let text = String::from_utf8(place.ok("render z.obj --size 8x6 --up 0,0,1")).unwrap();
    assert!(!text.contains("is up"), "{text}");
}

#[test]
fn a_model_as_small_as_the_threshold_is_told_of() {
    let place = TestFolder::new();
    // A floor and a triangle above it, at a scale of 2^-36, or about 1e-10.
    let model = |scale: f64| {
        let points = [
            [-4., 0., -4.],
            [-4., 0., 4.],
            [4., 0., 4.],
            [4., 0., -4.],
            [-1., 1., -1.],
            [1., 1., 0.],
        ];
        let lines = points.map(|p: [f64; 3]| {
            let [x, y, z] = p.map(|x| x * scale);
            format!("v {x:e} {y:e} {z:e}\n")
        });
        format!("{}f 1 2 3 4\nf 5 6 2\n", lines.concat())
    };
    place.put("usual.obj", model(1.0)).put("tiny.obj", model(2f64.powi(-36)));
    place.ok("render usual.obj --size 61x45 -o usual.png");
    // This model is small, but large enough for the default threshold.
    place.put("small.obj", model(2f64.powi(-20)));
    place.ok("render small.obj --size 61x45 --engine certified");
    // The exact engines have no threshold, and draw the model as it is.
    place.ok("render tiny.obj --size 61x45 -o tiny.png");
    assert!(place.read("tiny.png") == place.read("usual.png"));
    let tiny = "render tiny.obj --size 61x45 --engine certified -o tiny.png";
    let output = place.run(tiny);
    common::one_line("tiny", &output, 0, &["hides", "triangles", "shadows", "--threshold 1e-"]);
    assert!(place.read("tiny.png") != place.read("usual.png"));
    // With the recommended threshold, nothing is hidden.
    let told = String::from_utf8(output.stderr).unwrap();
    let told = told.trim_end().rsplit(' ').next().unwrap();
    place.ok(&format!("{tiny} --threshold {told}"));
    assert!(place.read("tiny.png") == place.read("usual.png"));
}

#[test]
fn help_is_on_the_standard_output() {
    let place = TestFolder::new();
    for arguments in ["--help", "render --help", "trace --help", "-h", "--version"] {
        assert!(!place.ok(arguments).is_empty());
    }
}
