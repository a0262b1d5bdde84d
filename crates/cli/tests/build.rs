//! Saved hierarchies: the same answers and pictures as the model that they were built over.

mod common;

use common::{MODEL, Place};

const RAYS: &str = "ox,oy,oz,dx,dy,dz\n0,0,0,0.02,0.03,1\n0,0,0,0.5,0.25,1\n0.25,0.25,0,0,0,1\n";

#[test]
fn a_saved_hierarchy_is_a_model() {
    let place = Place::new();
    // One triangle has no area: it keeps its number.
    let model = format!("{MODEL}f 1 1 2\nf 4 6 5\n");
    place.put("m.obj", &model).put("rays.csv", RAYS);
    let report = place.ok("build m.obj -o m.itri --json");
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(report["triangles"], 6);
    assert_eq!(report["bytes"], place.read("m.itri").len());

    for engine in ["exact", "certified", "double", "reference", "fixed", "oracle"] {
        for query in ["", "--any", "--all"] {
            let of = |model: &str| {
                place.ok(&format!("trace {model} --rays rays.csv --engine {engine} {query}"))
            };
            assert_eq!(of("m.obj"), of("m.itri"), "{engine} {query}");
        }
    }
    place.ok("render m.obj -o a.png --size 64x48 --engine exact");
    place.ok("render m.itri -o b.png --size 64x48 --engine exact --check raster");
    assert_eq!(place.read("a.png"), place.read("b.png"));
    place.ok("bench m.itri --size 8x8 --turns 1");
    place.ok("advise m.itri --size 16x16 --tolerance 100%");

    // Built again from itself, it is the same.
    place.ok("build m.itri -o n.itri");
    assert_eq!(place.read("m.itri"), place.read("n.itri"));
}

#[test]
fn what_is_no_saved_hierarchy_is_one_line() {
    let place = Place::new();
    place.put("m.obj", MODEL);
    place.ok("build m.obj -o m.itri");
    let whole = place.read("m.itri");
    place.put("short.itri", &whole[..whole.len() - 1]);
    let mut damaged = whole.clone();
    damaged[700] ^= 1;
    place.put("damaged.itri", &damaged);
    let mut newer = whole.clone();
    newer[8] = 9;
    place.put("newer.itri", &newer);
    place.put("nothing.obj", "v 0 0 0\nv 1 0 0\nf 1 2 1\n");
    place.ok("build nothing.obj -o nothing.itri");
    let cases = [
        ("short", "cut off"),
        ("damaged", "checksum"),
        ("newer", "later version"),
        ("nothing", "no triangle in it that can be hit"),
    ];
    for (name, word) in cases {
        let name = format!("{name}.itri");
        for command in ["render", "build -o out.itri", "advise", "bench"] {
            place.fails(&format!("{command} {name}"), 1, &[&name, word]);
        }
    }
    place.fails("build m.obj -o m.obj", 2, &["m.obj"]);
    place.fails("build m.obj -o no/where.itri", 1, &["where.itri", "folder"]);
    assert!(!place.names().contains(&"out.itri".to_owned()));
}
