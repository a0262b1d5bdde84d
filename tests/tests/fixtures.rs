//! Replays every scene in the `fixtures` folder: scenes that have failed before or that are likely
//! to fail.
//!
//! If a test fails, you can save the scene that it prints as a file in this folder. Add a comment
//! line that explains the scene.

use crate::common;
use intertri::simd::Level;
use intertri_lab::families::FAMILIES;
use intertri_lab::rng::Rng;
use intertri_tests::{as_source, check_hierarchy, check_kernel, parse};
use std::path::Path;

#[test]
fn every_fixture_agrees_with_the_reference() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    let mut paths: Vec<_> = std::fs::read_dir(&folder)
        .expect("the folder of fixtures exists")
        .map(|entry| entry.expect("the folder can be read").path())
        .filter(|path| path.extension().is_some_and(|end| end == "txt"))
        .collect();
    paths.sort();
    assert!(paths.len() >= 5, "fixtures are missing: {paths:?}");

    let levels: Vec<Level> = Level::all().collect();
    for path in paths {
        let (name, text) =
            (path.display(), std::fs::read_to_string(&path).expect("the file is text"));
        let scene = parse(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
        let hits = check_kernel(&scene, &levels).unwrap_or_else(|e| panic!("{name}: {e}"));
        check_hierarchy(&scene, &levels).unwrap_or_else(|e| panic!("{name}: {e}"));

        // A fixture states its number of hits, so that a scene without hits is known to be
        // intentional.
        let hits = format!("# {hits} hits");
        assert!(text.lines().any(|line| line == hits), "{name} must contain the line `{hits}`");
    }
}

#[test]
fn what_is_written_reads_back_bit_for_bit() {
    let mut rng = Rng::new(11);
    for family in FAMILIES {
        let text = as_source(&common::scene(family, &mut rng, 3, 4));
        let scene = parse(&text).unwrap_or_else(|e| panic!("{}: {e}", family.name));
        assert_eq!(as_source(&scene), text);
    }
}

#[test]
fn a_wrong_line_is_named() {
    let says = |text: &str, what: &str| assert_eq!(parse(text).unwrap_err(), what);
    says("", "there is no threshold");
    says("threshold 0x0\n\nray 0x0", "line 3: expected 8 numbers, found 1");
    says("# words\ntriangle 1.0", "line 2: `1.0` is not hexadecimal like 0x3f800000");
    says("triangle 0x100000000", "line 1: `0x100000000` is not 32 bits");
    says("square 0x0", "line 1: `square` is not threshold, triangle or ray");
    says("ray", "line 1: nothing after the word");
}
