//! Tests light positions through the compiled binary: traced shadow rays, shadow volumes, and the
//! check that compares them.

use crate::common;
use crate::common::TestFolder;
use serde_json::Value;

/// A floor, a triangle above it, and an open box on the floor.
const MODEL: &str = "v -4 0 -4\nv -4 0 4\nv 4 0 4\nv 4 0 -4\nf 1 2 3 4\n\
                     v -1 1.5 -1\nv 1.5 1 0\nv 0 2 1.5\nf 5 6 7\n\
                     v 2 0 2\nv 3 0 2\nv 3 0 3\nv 2 0 3\nv 2 1 2\nv 3 1 2\nv 3 1 3\nv 2 1 3\n\
                     f 8 9 13 12\nf 9 10 14 13\nf 10 11 15 14\nf 11 8 12 15\n";

const LIGHTS: [&str; 5] =
    ["--light 2,5,1", "--light -3,0.5,-3", "--sun 0.3,1,0.2", "--sun -9e9,2e9,1e9", "--sun 0,-1,0"];

fn place() -> TestFolder {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    place
}

fn report(place: &TestFolder, arguments: &str) -> Value {
    let arguments = format!("render m.obj --size 61x45 --json {arguments}");
    serde_json::from_slice(&place.ok(&arguments)).unwrap()
}

#[test]
fn every_engine_and_every_shadow_pass_both_checks_in_any_light() {
    let place = place();
    for light in LIGHTS {
        for engine in ["certified", "reference", "raster"] {
            for shadows in ["rays", "volumes"] {
                for check in ["reference", "raster"] {
                    let options =
                        format!("{light} --engine {engine} --shadows {shadows} --check {check}");
                    let report = report(&place, &options);
                    let differ = report["check"]["differing_pixels"].as_u64().unwrap();
                    assert!(differ < 6, "{options}: {report}");
                    assert!(report["dark"].as_u64().unwrap() > 5, "{options}: {report}");
                }
            }
        }
        let report = report(&place, &format!("{light} --engine fixed --check certified"));
        assert!(report["check"]["differing_pixels"].as_u64().unwrap() < 10, "{light}: {report}");
    }
}

#[test]
fn the_built_in_scene_passes_the_check_in_the_sun() {
    let place = TestFolder::new();
    let report = place.ok("render --size 320x240 --sun -0.5,1,0.6 --check raster --json");
    let report: Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(report["check"]["differing_pixels"], report["check"]["excused_pixels"]);
    // Exact shadow rays start on the surface, whereas volumes end a ten-thousandth of the distance
    // before it.
    assert!(report["check"]["differing_pixels"].as_u64().unwrap() < 60, "{report}");
    assert!(report["dark"].as_u64().unwrap() > 5000, "{report}");
}

#[test]
fn every_light_makes_a_picture_of_its_own() {
    let place = place();
    let mut pictures = Vec::new();
    for light in LIGHTS.iter().chain(&[""]) {
        report(&place, light);
        pictures.push(place.read("intertri.png"));
    }
    for (i, picture) in pictures.iter().enumerate() {
        assert!(!pictures[..i].contains(picture), "{i}");
    }
    // A sun is equivalent to a distant light, and the length of its direction does not matter.
    let dark = |light: &str| report(&place, light)["dark"].as_i64().unwrap();
    assert!((dark("--sun 3,10,2") - dark("--light 30,100,20")).abs() < 5);
    assert_eq!(dark("--sun 3,10,2"), dark("--sun 3e-30,1e-29,2e-30"));
}

#[test]
fn a_light_so_far_away_that_shadows_suffer_is_told_of() {
    let place = place();
    let arguments = "render m.obj --size 61x45 --engine certified --light 3e5,1e6,2e5";
    common::one_line(arguments, &place.run(arguments), 0, &["far away", "--sun X,Y,Z"]);
    place.ok(&format!("{arguments} --shadows none"));
    // Exact shadow rays start on the surface, so shadows also start there.
    let of = |arguments: &str| report(&place, &format!("--engine exact {arguments}"));
    let [far, sun] = [of("--light 3e5,1e6,2e5"), of("--sun 0.3,1,0.2")];
    assert!((far["dark"].as_i64().unwrap() - sun["dark"].as_i64().unwrap()).abs() < 5);
}

#[test]
fn lights_that_make_no_sense() {
    let place = place();
    for (options, words) in [
        ("--light 1,2,3 --sun 0,1,0", &["--light", "--sun"][..]),
        ("--sun 0,0,0", &["--sun", "not zero"]),
        ("--sun 0,nan,1", &["--sun", "finite"]),
        ("--light inf,0,0", &["--light", "finite"]),
        ("--light 1,2", &["--light", "three numbers"]),
    ] {
        place.fails(&format!("render m.obj {options}"), 2, words);
    }
}
