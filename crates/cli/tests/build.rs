//! Tests that saved hierarchies give the same answers and images as the models they were built
//! from.

use intertri::{Triangle, Triangle64};
use intertri_trace::Bvh;

use crate::common::{MODEL, TestFolder};

/// Four corners of a wall in UTM coordinates, where adjacent f32 values are up to 6.3 cm apart.
const WALL: &str = "v 148376.213 528980.447 0\nv 148380.213 528980.447 0\nv 148380.213 528980.447 3\n\
                    v 148376.213 528980.447 3\nf 1 2 3\nf 1 1 2\nf 1 3 4\n";

/// Rays that run north and south, from a point a millimetre north of the wall and from a point a
/// millimetre south of it.
const NEAR: &str = "ox,oy,oz,dx,dy,dz\n148377,528980.448,1,0,1,0\n148377,528980.448,1,0,-1,0\n\
                    148377,528980.446,1,0,1,0\n148377,528980.446,1,0,-1,0\n";

/// A view of the wall.
const LOOK: &str =
    "--size 48x36 --eye 148377.2,528985.4,1.7 --target 148378.2,528980.4,1.5 --up 0,0,1";

const RAYS: &str = "ox,oy,oz,dx,dy,dz\n0,0,0,0.02,0.03,1\n0,0,0,0.5,0.25,1\n0.25,0.25,0,0,0,1\n";

#[test]
fn a_saved_hierarchy_is_a_model() {
    let place = TestFolder::new();
    // One triangle has no area, but it keeps its index.
    let model = format!("{MODEL}f 1 1 2\nf 4 6 5\n");
    place.put("m.obj", &model).put("rays.csv", RAYS);
    let report = place.ok("build m.obj -o m.itri --json");
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(report["triangles"], 6);
    assert_eq!(report["bytes"], place.read("m.itri").len());

    for engine in ["exact", "certified", "reference", "fixed", "oracle"] {
        for query in ["", "--any", "--all"] {
            let of = |model: &str| {
                let scalar = if engine == "exact" { "" } else { "--scalar f32" };
                let rays = "--rays rays.csv";
                place.ok(&format!("trace {model} {rays} --engine {engine} {query} {scalar}"))
            };
            assert_eq!(of("m.obj"), of("m.itri"), "{engine} {query}");
        }
    }
    place.ok("render m.obj -o a.png --size 64x48 --engine exact");
    place.ok("render m.itri -o b.png --size 64x48 --engine exact --check raster");
    assert_eq!(place.read("a.png"), place.read("b.png"));
    place.ok("bench m.itri --size 8x8 --turns 1");
    place.ok("advise m.itri --size 16x16 --tolerance 100%");

    // Building a saved hierarchy again results in the same file.
    place.ok("build m.itri -o n.itri");
    assert_eq!(place.read("m.itri"), place.read("n.itri"));
}

/// A file may contain several meshes with masks if another program saved it through the library.
/// `intertri` treats the meshes as one.
#[test]
fn several_meshes_are_one_model() {
    let triangle = |x: f32| Triangle::new([x, -1.0, 5.0], [x + 1.0, -1.0, 5.0], [x, 1.0, 5.0]);
    let meshes = [[triangle(-2.0), triangle(-1.0)], [triangle(0.0), triangle(1.0)]];
    let mut bvh = Bvh::from_meshes(&meshes.each_ref().map(|mesh| &mesh[..])).unwrap();
    bvh.set_mask(1, 0);
    let place = TestFolder::new();
    place.put("m.itri", bvh.to_bytes());
    place.put(
        "rays.csv",
        "ox,oy,oz,dx,dy,dz\n-0.9,-0.5,0,0,0,1\n0.1,-0.5,0,0,0,1\n1.1,-0.5,0,0,0,1\n",
    );
    for engine in ["exact", "certified", "oracle", "reference"] {
        let line = format!("trace m.itri --rays rays.csv --engine {engine} --scalar f32");
        let told = place.ok(&line);
        let told = String::from_utf8(told).unwrap();
        let triangle = |line: &str| line.split(',').nth(1).unwrap().to_owned();
        let triangles: Vec<_> = told.lines().skip(1).map(triangle).collect();
        assert_eq!(triangles, ["1", "2", "3"], "{engine}: {told}");
    }
}

#[test]
fn a_hierarchy_saved_in_f64_is_a_model_in_f64() {
    let place = TestFolder::new();
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

    // Building a saved hierarchy again results in the same file. This model needs f64, so it is
    // saved in f64 by default, and its answers differ in f32.
    place.ok("build m.itri -o n.itri");
    assert_eq!(place.read("m.itri"), place.read("n.itri"));
    place.ok("build m.obj -o n.itri");
    assert_eq!(place.read("m.itri"), place.read("n.itri"));
    place.ok("build m.obj -o single.itri --scalar f32");
    assert_ne!(trace("single.itri --any"), trace("m.itri --any"));
}

/// A hierarchy that was saved in one scalar can be traced in the other.
#[test]
fn a_saved_hierarchy_is_a_model_in_the_other_scalar_too() {
    let place = TestFolder::new();
    place.put("m.obj", WALL).put("rays.csv", NEAR);
    place.ok("build m.obj -o double.itri");
    place.ok("build m.obj -o single.itri --scalar f32");
    let report = |line: &str| -> serde_json::Value {
        serde_json::from_slice(&place.run(&format!("{line} --json")).stdout).unwrap()
    };
    let trace = |model: &str| format!("trace {model} --rays rays.csv -o a.csv");
    // Rounding the f64 file gives the same hierarchy as saving in f32. Nine corners have two
    // coordinates each that are not exact in f32.
    for (model, scalar, engine) in
        [("double.itri", "--scalar f32", "exact"), ("double.itri", "", "certified")]
    {
        let told = report(&format!("{} {scalar} --engine {engine}", trace(model)));
        let want = place.read("a.csv");
        assert_eq!(
            (&told["scalar"], &told["rounded"]["model"]["numbers"]),
            (&"f32".into(), &18.into())
        );
        place.run(&format!("{} --scalar f32 --engine {engine}", trace("single.itri")));
        assert_eq!(place.read("a.csv"), want);
    }
    // Widening the f32 file keeps its rounded numbers, and does not round the rays.
    let told = report(&trace("single.itri"));
    assert_eq!((&told["scalar"], &told["rounded"]["rays"]["numbers"]), (&"f64".into(), &0.into()));
    assert_eq!(told["rounded"]["model"]["numbers"], 0);
    for command in ["bench --turns 1 --size 8x6", "advise --size 8x6 --tolerance 100%"] {
        let told = report(&format!("{command} double.itri"));
        assert_eq!(told["rounded"]["model"]["numbers"], 18, "{told}");
    }
    for option in ["--wire", "--shadows volumes", "--engine raster", "--check certified"] {
        let told = report(&format!("render double.itri --size 8x6 {option}"));
        assert_eq!(told["scalar"], "f32", "{option}: {told}");
        assert_eq!(told["rounded"]["model"]["numbers"], 18, "{option}: {told}");
    }
    place.ok("build double.itri -o back.itri --scalar f32");
    assert_eq!(place.read("back.itri"), place.read("single.itri"));
}

#[test]
fn what_is_no_saved_hierarchy_is_one_line() {
    for scalar in ["f32", "f64"] {
        unsaved_is_one_line(scalar);
    }
}

fn unsaved_is_one_line(scalar: &str) {
    let place = TestFolder::new();
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
    let nothing = match scalar {
        "f64" => Bvh::<f64>::new(&[Triangle64([[f64::NAN; 3]; 3])]).unwrap().to_bytes(),
        _ => Bvh::<f32>::new(&[Triangle([[f32::NAN; 3]; 3])]).unwrap().to_bytes(),
    };
    place.put("nothing.itri", &nothing);
    // A triangle with zero area is stored, even though no ray hits it.
    place.put("flat.obj", "v 0 0 0\nv 1 0 0\nf 1 2 1\n");
    place.ok(&format!("build flat.obj -o flat.itri --scalar {scalar}"));
    place.ok("render flat.itri -o flat.png --size 8x8");
    let cases = [
        ("short", "cut off"),
        ("damaged", "checksum"),
        ("newer", "newer version"),
        ("nothing", "has no finite triangle"),
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
