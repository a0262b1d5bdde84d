//! Tests the independent rasterizer through the compiled binary: the z-buffer, shadow volumes,
//! checks against rays, wire drawings and textures.

use crate::common;
use crate::common::{MODEL, TestFolder};
use intertri_scene::Image;
use serde_json::Value;

fn report(place: &TestFolder, arguments: &str) -> Value {
    serde_json::from_slice(&place.ok(&format!("{arguments} --json"))).unwrap()
}

#[test]
fn every_engine_and_every_shadow_pass_both_checks() {
    let place = TestFolder::new();
    // A floor, and a triangle above it.
    let floor = "v -4 0 -4\nv -4 0 4\nv 4 0 4\nv 4 0 -4\nf 1 2 3 4\n";
    place.put("m.obj", format!("{floor}v -1 1.5 -1\nv 1.5 1 0\nv 0 2 1.5\nf 5 6 7\n"));
    for engine in ["exact", "certified", "reference", "raster"] {
        for shadows in ["rays", "volumes", "none"] {
            for check in ["exact", "certified", "raster"] {
                let report = report(
                    &place,
                    &format!(
                        "render m.obj --size 61x45 --engine {engine} \
                         --shadows {shadows} --check {check}"
                    ),
                );
                let what = format!("{engine} {shadows} {check}: {report}");
                let own = ["rays", "volumes"][usize::from(check == "raster")];
                let by = if shadows == "none" { "none" } else { own };
                assert_eq!(report["check"]["shadows"], by, "{what}");
                assert!(report["check"]["differing_pixels"].as_u64().unwrap() < 3, "{what}");
                assert_eq!(report["dark"].as_u64().unwrap() > 5, shadows != "none", "{what}");
                assert_eq!(report["shadow_rays"].as_u64().unwrap() > 0, shadows == "rays");
            }
        }
    }
}

#[test]
fn rasterizer_and_rays_draw_the_same_built_in_scene() {
    let place = TestFolder::new();
    let report =
        report(&place, "render --size 320x240 --engine raster --shadows volumes --check certified");
    let check = &report["check"];
    assert_eq!(check["differing_pixels"], check["excused_pixels"], "{report}");
    assert!(check["differing_pixels"].as_u64().unwrap() < 10, "{report}");
    assert!(report["dark"].as_u64().unwrap() > 5000, "{report}");
    assert_eq!(report["shadow_rays"], 0);
    assert_eq!(place.names(), ["intertri.diff.png", "intertri.png"]);
}

#[test]
fn a_difference_that_nothing_excuses_fails() {
    // With this threshold, the rays count as parallel to the floor, but the z-buffer still draws
    // it.
    let place = TestFolder::new();
    place.put("m.obj", "v -9 0 -9\nv 9 0 -9\nv 0 0 9\nf 1 2 3\n");
    let look = "render m.obj --size 60x40 --eye 0,0.4,12 --target 0,0,0 --threshold 0.2";
    for (engine, check) in [("certified", "raster"), ("raster", "certified")] {
        let arguments = format!("{look} --engine {engine} --check {check}");
        let output = place.run(&arguments);
        common::one_line(&arguments, &output, 1, &["intertri.diff.png", "pixels differ"]);
        assert_eq!(place.names(), ["intertri.diff.png", "intertri.png", "m.obj"]);
    }
    // The engines that trace rays also agree with each other in this case.
    place.ok(&format!("{look} --engine reference --check certified"));
}

#[test]
fn what_the_rasterizer_cannot_do_is_refused() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL).put("r.csv", "ox,oy,oz,dx,dy,dz\n0,0,0,0,0,1\n");
    place.fails("trace m.obj --rays r.csv --engine raster", 2, &["raster", "no rays"]);
    for options in ["--engine raster", "--shadows volumes", "--wire", "--check raster"] {
        let arguments = format!("render m.obj --size 20000x2 {options}");
        place.fails(&arguments, 1, &["20000x2", "16384"]);
    }
    // The engines that trace rays accept this size.
    place.ok("render m.obj --size 20000x2");
    place.fails("render m.obj --wire=all", 2, &["--wire"]);
}

#[test]
fn edges_are_drawn_over_the_picture() {
    let place = TestFolder::new();
    for (name, options) in [("none", ""), ("mesh", "--wire"), ("outline", "--wire=silhouette")] {
        place.ok(&format!("render --size 160x120 -o {name}.png {options}"));
    }
    place.ok("render --size 160x120 -o drawn.png --wire=mesh --engine raster --shadows volumes");
    let [none, mesh, outline] =
        ["none", "mesh", "outline"].map(|n| place.read(&format!("{n}.png")));
    assert!(none != mesh && mesh != outline && outline != none);
    assert!(!place.read("drawn.png").is_empty());
}

#[test]
fn textures_come_from_files_and_from_the_document() {
    let place = TestFolder::new();
    place.put("bare.obj", MODEL).put("text.png", "no picture\n");
    let quad = "v 0 0 5\nv 1 0 5\nv 1 1 5\nv 0 1 5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                f 1/1 2/2 3/3 4/4\n";
    place.put("quad.obj", quad);
    place.ok("render --size 33x21 -o picture.png");
    let mut pictures = Vec::new();
    for options in ["", "--texture xor", "--texture picture.png"] {
        place.ok(&format!("render quad.obj --size 64x48 {options}"));
        pictures.push(place.read("intertri.png"));
        place.ok(&format!("render quad.obj --size 64x48 {options} --engine raster"));
    }
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
    place.ok("render --size 64x48 --texture picture.png");

    place.fails("render bare.obj --texture xor", 1, &["bare.obj", "texture coordinates"]);
    place.fails("render quad.obj --texture text.png", 1, &["text.png", "PNG"]);
    place.fails("render quad.obj --texture quad.obj", 1, &["quad.obj", "PNG"]);
    place.fails("render quad.obj --texture nowhere.png", 1, &["nowhere.png"]);
    place.fails("render quad.obj --texture .", 1, &["regular file"]);
    let picture = place.read("picture.png");
    place.put("half.png", &picture[..picture.len() / 2]);
    place.fails("render quad.obj --texture half.png", 1, &["half.png"]);
}

#[test]
fn the_documents_pattern_can_be_seen() {
    let place = TestFolder::new();
    let corners = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    place.put("quad.obj", format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n{corners}"));
    let look = "--size 256x256 --shadows none --eye 0.5,0.5,1 --target 0.5,0.5,0";
    place.ok(&format!("render quad.obj {look} --texture xor"));
    let image = Image::read(&place.path("intertri.png")).unwrap();
    // Take a row through the middle. Its cells must be wide enough to be visible, and differ enough
    // in brightness.
    let row = &image.pixels()[128 * 256..129 * 256];
    let grey = |pixel: &[u8; 3]| i32::from(pixel[1]);
    let (dark, bright) = (row.iter().map(grey).min().unwrap(), row.iter().map(grey).max().unwrap());
    assert!(3 * dark < bright, "{dark} {bright}");
    let steps = row.windows(2).filter(|w| (grey(&w[0]) - grey(&w[1])).abs() >= 5).count();
    assert!((10..60).contains(&steps), "{steps}");
}

#[test]
fn the_two_ways_race() {
    let place = TestFolder::new();
    let report = report(&place, "crossover --quick -o charts");
    let races = report["races"].as_array().unwrap();
    assert_eq!(races.len(), 8);
    for race in races {
        assert!(race["rays"].as_f64().unwrap() > 0.0 && race["raster"].as_f64().unwrap() > 0.0);
    }
    let files = report["files"].as_array().unwrap();
    for (file, kind) in files.iter().zip(["svg", "png", "csv"]) {
        let file = file.as_str().unwrap();
        assert!(file.ends_with(&format!("crossover.{kind}")), "{file}");
        assert!(!place.read(file).is_empty());
    }
}
