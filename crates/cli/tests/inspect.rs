//! Tests that `inspect` reports open edges, flipped triangles and duplicates.

use crate::common::TestFolder;

const CORNERS: &str = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\n";

fn text(place: &TestFolder, faces: &str) -> String {
    place.put("m.obj", format!("{CORNERS}{faces}"));
    String::from_utf8(place.ok("inspect m.obj")).unwrap()
}

#[test]
fn defects_are_counted_and_named() {
    let place = TestFolder::new();
    let closed = text(&place, "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    assert_eq!(closed, "           4 triangles of m.obj\n             the model is closed\n");

    let open = text(&place, "f 1 3 2\nf 1 2 4\nf 1 4 3\n");
    assert!(
        open.contains("3 open edges, which belong to only one triangle: the first from "),
        "{open}"
    );
    assert!(open.ends_with("the model is not closed\n"), "{open}");

    let turned = text(&place, "f 2 3 1\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    let line = "3 edges between triangles with opposite orientations: \
                the first from [4.0, 0.0, 0.0] to [0.0, 4.0, 0.0], in triangle 0\n";
    assert!(turned.contains(line), "{turned}");

    let doubled = text(&place, "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 3 2 1\n");
    assert!(
        doubled.contains("3 edges of three or more triangles that do not pair up"),
        "{doubled}"
    );
    let line =
        "1 triangles that repeat others the same way round: the first is 4, which repeats 0\n";
    assert!(doubled.contains(line), "{doubled}");
}

/// Decimals are compared as written, even if they are not exact in f32. Two corners are the same if
/// their coordinates are equal.
#[test]
fn the_numbers_are_those_of_the_file() {
    let place = TestFolder::new();
    // The second face has its own vertices. The coordinate `z` is either 3 or so close to 3 that
    // f32 cannot represent the difference.
    let faces = |z: &str| {
        format!(
            "v 148376.213 528980.447 0\nv 148380.213 528980.447 0\nv 148380.213 528980.447 3\n\
             v 148376.213 528980.447 0\nv 148380.213 528980.447 {z}\nv 148380.213 528980.447 0\nf 1 2 3\nf 4 5 6\n"
        )
    };
    for (z, closed, open, opposed) in [("3", true, 0, 1), ("3.00000001", false, 4, 0)] {
        place.put("m.obj", faces(z));
        let report = place.ok("inspect m.obj --json");
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        assert_eq!(
            (&report["is_closed"], &report["triangles"]),
            (&closed.into(), &2.into()),
            "{report}"
        );
        assert_eq!(
            (&report["open"]["count"], &report["opposed"]["count"]),
            (&open.into(), &opposed.into()),
            "{report}"
        );
        assert_eq!(report["scalar"], "f64");
    }
    assert!(!place.ok("build m.obj -o m.itri --json").is_empty());
    let saved = String::from_utf8(place.ok("inspect m.itri")).unwrap();
    assert!(saved.contains("4 open edges"), "{saved}");
}

/// The text names the first edge or triangle of each kind. JSON lists all of them, in the order of
/// the triangles.
#[test]
fn json_lists_every_defect() {
    let place = TestFolder::new();
    // The slanted face is missing, the second face is flipped, and the first face appears three
    // times.
    let faces = "f 1 3 2\nf 2 1 4\nf 1 4 3\nf 3 2 1\nf 1 2 3\n";
    place.put("m.obj", format!("{CORNERS}{faces}"));
    let report: serde_json::Value =
        serde_json::from_slice(&place.ok("inspect m.obj --json")).unwrap();
    let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    let edge = |triangle: usize, from: [f64; 3], to: [f64; 3]| serde_json::json!({ "triangle": triangle, "from": from, "to": to });
    let expected = [
        ("open", vec![edge(1, z, x), edge(2, z, y)]),
        ("turned", vec![edge(1, o, z)]),
        ("uneven", vec![edge(0, y, x), edge(0, x, o)]),
    ];
    for (defect, edges) in expected {
        assert_eq!(report[defect]["count"], edges.len(), "{defect}: {report}");
        assert_eq!(report[defect]["edges"], serde_json::json!(edges), "{defect}");
    }
    let repeats = |triangle: usize| serde_json::json!([{ "triangle": triangle, "repeats": 0 }]);
    assert_eq!(report["doubled"]["triangles"], repeats(3), "{report}");
    assert_eq!(report["opposed"]["triangles"], repeats(4), "{report}");
}

#[test]
fn what_is_no_model_is_an_error() {
    let place = TestFolder::new();
    place.fails("inspect none.obj", 1, &["none.obj"]);
    place.put("m.obj", format!("{CORNERS}f 1 2 9\n"));
    place.fails("inspect m.obj", 1, &["m.obj:5", "vertex 9"]);
}
