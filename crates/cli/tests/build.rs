//! Saved hierarchies: the same answers and pictures as the model that they were built over.

use intertri::Triangle;
use intertri_trace::Bvh;

use crate::common::{MODEL, Place};

/// Four corners of a surveyor's wall in UTM coordinates, where neighbouring f32 are up to 6.3 cm apart.
const WALL: &str = "v 148376.213 528980.447 0\nv 148380.213 528980.447 0\nv 148380.213 528980.447 3\n\
                    v 148376.213 528980.447 3\nf 1 2 3\nf 1 1 2\nf 1 3 4\n";

/// A millimetre north of it, and south of it, to the north and to the south.
const NEAR: &str = "ox,oy,oz,dx,dy,dz\n148377,528980.448,1,0,1,0\n148377,528980.448,1,0,-1,0\n\
                    148377,528980.446,1,0,1,0\n148377,528980.446,1,0,-1,0\n";

/// A look at it.
const LOOK: &str =
    "--size 48x36 --eye 148377.2,528985.4,1.7 --target 148378.2,528980.4,1.5 --up 0,0,1";

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

/// A library may have saved several meshes, and masks: to the program it is one mesh of all.
#[test]
fn several_meshes_are_one_model() {
    let triangle = |x: f32| Triangle::new([x, -1.0, 5.0], [x + 1.0, -1.0, 5.0], [x, 1.0, 5.0]);
    let meshes = [[triangle(-2.0), triangle(-1.0)], [triangle(0.0), triangle(1.0)]];
    let mut bvh = Bvh::of_meshes(&meshes.each_ref().map(|mesh| &mesh[..])).unwrap();
    bvh.set_mask(1, 0);
    let place = Place::new();
    place.put("m.itri", bvh.to_bytes());
    place.put(
        "rays.csv",
        "ox,oy,oz,dx,dy,dz\n-0.9,-0.5,0,0,0,1\n0.1,-0.5,0,0,0,1\n1.1,-0.5,0,0,0,1\n",
    );
    for engine in ["exact", "certified", "oracle", "reference"] {
        let told = place.ok(&format!("trace m.itri --rays rays.csv --engine {engine}"));
        let told = String::from_utf8(told).unwrap();
        let triangle = |line: &str| line.split(',').nth(1).unwrap().to_owned();
        let triangles: Vec<_> = told.lines().skip(1).map(triangle).collect();
        assert_eq!(triangles, ["1", "2", "3"], "{engine}: {told}");
    }
}

#[test]
fn a_hierarchy_saved_in_f64_is_a_model_in_f64() {
    let place = Place::new();
    place.put("m.obj", WALL).put("rays.csv", NEAR);
    let report = place.ok("build m.obj -o m.itri --scalar f64 --json");
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert_eq!((&report["scalar"], &report["triangles"]), (&"f64".into(), &3.into()));
    assert_eq!(report["bytes"], place.read("m.itri").len());

    let trace = |arguments: &str| {
        String::from_utf8(place.ok(&format!("trace --rays rays.csv {arguments}"))).unwrap()
    };
    assert_eq!(trace("m.itri --any"), "ray,hit\n0,0\n1,1\n2,1\n3,0\n");
    for how in ["", "--any", "--all", "--crossings", "--engine oracle", "--engine oracle --all"] {
        let want = trace(&format!("m.obj --scalar f64 {how}"));
        assert_eq!(trace(&format!("m.itri {how}")), want);
        assert_eq!(trace(&format!("m.itri --scalar f64 {how}")), want);
    }
    place.ok(&format!("render m.obj -o a.png --scalar f64 {LOOK}"));
    place.ok(&format!("render m.itri -o b.png {LOOK} --check oracle"));
    assert_eq!(place.read("a.png"), place.read("b.png"));

    // Built again from itself, it is the same; in f32, it is not, which is told of.
    place.ok("build m.itri -o n.itri");
    assert_eq!(place.read("m.itri"), place.read("n.itri"));
    let told = String::from_utf8(place.run("build m.obj -o single.itri").stderr).unwrap();
    assert!(told.contains("0.0625 apart") && told.lines().count() == 1, "{told}");
    assert_ne!(trace("single.itri --any"), trace("m.itri --any"));
}

#[test]
fn what_cannot_have_a_saved_scalar_says_so() {
    let place = Place::new();
    place.put("m.obj", MODEL).put("rays.csv", RAYS);
    place.ok("build m.obj -o single.itri --scalar f32");
    place.ok("build m.obj -o double.itri --scalar f64");
    for command in ["trace --rays rays.csv", "render", "build -o out.itri"] {
        let double = format!("{command} double.itri --scalar f32");
        place.fails(&double, 1, &["double.itri", "saved in f64", "--scalar f32"]);
        let single = format!("{command} single.itri --scalar f64");
        place.fails(&single, 1, &["single.itri", "saved in f32", "--scalar f64"]);
    }
    for engine in ["certified", "double", "reference", "fixed"] {
        for command in ["trace --rays rays.csv --engine", "render --engine", "render --check"] {
            let words = ["double.itri, saved in f64", engine, "exact or oracle"];
            place.fails(&format!("{command} {engine} double.itri"), 2, &words);
        }
    }
    for option in ["--wire", "--shadows volumes", "--engine raster"] {
        let words = ["double.itri, saved in f64", "coordinates in f32"];
        place.fails(&format!("render double.itri {option}"), 2, &words);
    }
    for command in ["bench", "advise", "chart -o charts"] {
        let words = ["double.itri", "saved in f64", "build it in f32"];
        place.fails(&format!("{command} double.itri"), 1, &words);
    }
    assert!(!place.path("intertri.png").exists() && !place.path("out.itri").exists());
}

#[test]
fn what_is_no_saved_hierarchy_is_one_line() {
    for scalar in ["f32", "f64"] {
        unsaved_is_one_line(scalar);
    }
}

fn unsaved_is_one_line(scalar: &str) {
    let place = Place::new();
    place.put("m.obj", MODEL);
    place.ok(&format!("build m.obj -o m.itri --scalar {scalar}"));
    let whole = place.read("m.itri");
    place.put("short.itri", &whole[..whole.len() - 1]);
    let mut damaged = whole.clone();
    damaged[700] ^= 1;
    place.put("damaged.itri", &damaged);
    let mut newer = whole.clone();
    newer[8] = 9;
    place.put("newer.itri", &newer);
    place.put("nothing.obj", "v 0 0 0\nv 1 0 0\nf 1 2 1\n");
    place.ok(&format!("build nothing.obj -o nothing.itri --scalar {scalar}"));
    let cases = [
        ("short", "cut off"),
        ("damaged", "checksum"),
        ("newer", "later version"),
        ("nothing", "no triangle in it that can be hit"),
    ];
    for (name, word) in cases {
        let name = format!("{name}.itri");
        let both = ["render", "build -o out.itri", "advise", "bench"];
        for command in if scalar == "f32" { &both[..] } else { &both[..2] } {
            place.fails(&format!("{command} {name}"), 1, &[&name, word]);
        }
    }
    place.fails("build m.obj -o m.obj", 2, &["m.obj"]);
    place.fails("build m.obj -o no/where.itri", 1, &["where.itri", "folder"]);
    assert!(!place.names().contains(&"out.itri".to_owned()));
}
