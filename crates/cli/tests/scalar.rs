//! Tests `--scalar` through the compiled binary: what the program reads, answers, draws and refuses
//! in f64, and what it rounds in f32.

use std::fmt::Write;
use std::io::Write as _;

use crate::common::TestFolder;
use serde_json::Value;

/// The easting of a surveyed wall, in metres, where adjacent f32 values are 1.6 cm apart.
const EAST: f64 = 148_376.213;
/// The northing of the wall, in metres, where adjacent f32 values are 6.3 cm apart.
const NORTH: f64 = 528_980.447;

/// The four corners of a wall that runs east, 4 m long and 3 m high.
const WALL: [[f64; 3]; 4] =
    [[EAST, NORTH, 0.0], [EAST + 4.0, NORTH, 0.0], [EAST + 4.0, NORTH, 3.0], [EAST, NORTH, 3.0]];

fn obj() -> String {
    let vertex = |[x, y, z]: [f64; 3]| format!("v {x} {y} {z}\n");
    WALL.map(vertex).concat() + "f 1 2 3\nf 1 3 4\n"
}

/// Returns rays that start at these distances north of the wall, with `way` as the north component
/// of their direction.
fn csv(offsets: &[f64], way: f64) -> String {
    let mut text = String::from("ox,oy,oz,dx,dy,dz\n");
    for off in offsets {
        writeln!(text, "{},{},1.25,0,{way},0", EAST + 1.0, NORTH + off).unwrap();
    }
    text
}

fn text(place: &TestFolder, arguments: &str) -> String {
    String::from_utf8(place.ok(arguments)).unwrap()
}

/// Returns the cells of each line except the first.
fn cells(csv: &str) -> Vec<Vec<String>> {
    csv.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// Issue 48 of mikedh/trimesh: rays from 10 cm to 1 nm off a wall, running away from it and toward
/// it.
#[test]
fn a_ray_that_starts_a_nanometre_off_a_wall_does_not_hit_it_and_one_toward_it_does() {
    let place = TestFolder::new();
    let offsets: Vec<f64> = (1..=9).map(|digits| 10.0_f64.powi(-digits)).collect();
    place.put("wall.obj", obj());
    place.put("out.csv", csv(&offsets, 1.0)).put("in.csv", csv(&offsets, -1.0));
    let out = cells(&text(&place, "trace wall.obj --rays out.csv --scalar f64"));
    assert!(out.iter().all(|cells| cells[1].is_empty()) && out.len() == 9, "{out:?}");
    for query in ["", "--all", "--crossings"] {
        let back =
            cells(&text(&place, &format!("trace wall.obj --rays in.csv --scalar f64 {query}")));
        assert_eq!(back.len(), 9);
        for (cells, off) in back.iter().zip(&offsets) {
            let t: f64 = cells[2].parse().unwrap();
            // The origin is rounded to f64, so t may differ slightly from the distance in the file.
            assert!((t - off).abs() < 6e-11, "{cells:?} {off}");
        }
    }
    let any = |rays| text(&place, &format!("trace wall.obj --rays {rays} --any --scalar f64"));
    assert!(any("out.csv").lines().skip(1).all(|line| line.ends_with(",0")));
    assert!(any("in.csv").lines().skip(1).all(|line| line.ends_with(",1")));
}

#[test]
fn rays_in_csv_and_raw64_are_not_rounded_and_raw_ones_are_what_they_are() {
    let place = TestFolder::new();
    let numbers = [EAST + 1.0, NORTH - 0.3, 1.25, 0.0, 0.1, 1.0 / 3.0, 0.01, 1e300];
    let csv =
        format!("ox,oy,oz,t_min,dx,dy,dz,t_max\n{}\n", numbers.map(|x| format!("{x:e}")).join(","));
    place.put("wall.obj", obj()).put("r.csv", csv);
    place.put("r.f64", numbers.map(f64::to_le_bytes).concat());
    place.put("r.f32", numbers.map(|x| (x as f32).to_le_bytes()).concat());
    let of = |rays: &str| text(&place, &format!("trace wall.obj --rays {rays} --scalar f64"));
    assert_eq!(of("r.csv"), of("r.f64"));
    let t: f64 = cells(&of("r.csv"))[0][2].parse().unwrap();
    assert!((t - 0.9).abs() < 1e-9, "{t}");
    let t: f64 = cells(&of("r.f32"))[0][2].parse().unwrap();
    let rounded = (NORTH - f64::from((NORTH - 0.3) as f32)) / f64::from(1.0_f32 / 3.0);
    assert!((t - rounded).abs() < 1e-9 && (t - 0.9).abs() > 1e-3, "{t} {rounded}");

    // A number beyond the range of f32 is valid in f64, but one beyond the range of f64 is not.
    place.put("r.csv", "ox,oy,oz,dx,dy,dz\n1e200,0,0,1e-300,0,0\n");
    assert_eq!(cells(&of("r.csv"))[0][1], "");
    let refused = |scalar: &str, word: &str| {
        let output = place.run(&format!("trace wall.obj --rays r.csv --scalar {scalar}"));
        let told = String::from_utf8(output.stderr).unwrap();
        let last = told.lines().last().unwrap();
        assert_eq!(output.status.code(), Some(1), "{told}");
        assert!(["r.csv:2", "ox", word].iter().all(|word| last.contains(word)), "{told}");
    };
    refused("f32", "range of f32");
    place.put("r.csv", "ox,oy,oz,dx,dy,dz\n1e400,0,0,1,0,0\n");
    refused("f64", "range of f64");
}

/// Reads the wall from each format, in f64 if the format supports it.
#[test]
fn models_are_read_in_f64_where_they_have_it() {
    let place = TestFolder::new();
    place.put("wall.obj", obj());
    let faces = "3 0 1 2\n3 0 2 3\n";
    let ply = |kind: &str, format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 4\nproperty {kind} x\nproperty {kind} y\n\
             property {kind} z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let vertices: String = WALL.map(|[x, y, z]| format!("{x} {y} {z}\n")).concat();
    place.put("ascii.ply", ply("double", "ascii") + &vertices + faces);
    let mut binary = ply("double", "binary_little_endian").into_bytes();
    binary.extend(WALL.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    for face in [[0, 1, 2], [0, 2, 3]] {
        binary.push(3);
        binary.extend(face.iter().flat_map(|i: &i32| i.to_le_bytes()));
    }
    place.put("binary.ply", binary);
    let facet = |t: [usize; 3]| {
        let [a, b, c] = t.map(|i| WALL[i].map(|x| x.to_string()).join(" "));
        format!(
            "facet normal 0 0 0\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n"
        )
    };
    let solid = format!("solid\n{}{}endsolid\n", facet([0, 1, 2]), facet([0, 2, 3]));
    place.put("wall.stl", solid);
    // The positions in a glTF are f32, but its nodes may place them at arbitrary positions.
    let corners = WALL.map(|[x, _, z]| [(x - EAST).round() as f32, 0.0, z as f32]);
    let bytes: Vec<u8> = corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let buffer = [bytes, vec![0, 1, 2, 0, 2, 3]].concat();
    place.put("wall.bin", &buffer);
    place.put(
        "wall.gltf",
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
            "nodes": [{{"children": [1], "translation": [148376, 528980, 0]}},
                {{"mesh": 0, "translation": [0.21875, 0.4375, 0]}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
            "accessors": [
                {{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
                {{"bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 48}},
                {{"buffer": 0, "byteOffset": 48, "byteLength": 6}}],
            "buffers": [{{"uri": "wall.bin", "byteLength": {}}}]}}"#,
            buffer.len()
        ),
    );
    // Gzip files are also read in f64.
    let mut packed = flate2::write::GzEncoder::new(vec![], flate2::Compression::fast());
    packed.write_all(obj().as_bytes()).unwrap();
    place.put("packed.obj.gz", packed.finish().unwrap());

    place.put("r.csv", csv(&[1e-9, 0.5], -1.0));
    let want = text(&place, "trace wall.obj --rays r.csv --scalar f64");
    assert!(cells(&want)[0][2].parse::<f64>().unwrap() < 1.1e-9, "{want}");
    for model in ["ascii.ply", "binary.ply", "wall.stl", "packed.obj.gz"] {
        let got = text(&place, &format!("trace {model} --rays r.csv --scalar f64"));
        assert_eq!(got, want, "{model}");
    }
    // 528980 + 0.4375 needs more digits than f32 has.
    let got = cells(&text(&place, "trace wall.gltf --rays r.csv --scalar f64"));
    let t: f64 = got[1][2].parse().unwrap();
    assert!((t - (0.5 + NORTH - 528_980.437_5)).abs() < 1e-9, "{t}");
    // A vertex beyond the range of f32.
    place.put("far.obj", "v 1e100 0 0\nv 1e100 1e99 0\nv 1e100 0 1e99\nf 1 2 3\n");
    place.put("r.csv", "ox,oy,oz,dx,dy,dz\n0,1e98,1e98,1e100,0,0\n");
    assert!(text(&place, "trace far.obj --rays r.csv --scalar f64").ends_with("\n0,0,1,0.1,0.1\n"));
    place.ok("trace far.obj --rays r.csv");
    let words = ["far.obj", "beyond the range of f32"];
    place.fails("trace far.obj --rays r.csv --scalar f32", 1, &words);
    place.fails("trace far.obj --rays r.csv --engine certified", 1, &words);
}

#[test]
fn what_is_for_f32_refuses_f64_with_the_reason() {
    let place = TestFolder::new();
    place.put("wall.obj", obj()).put("r.csv", csv(&[0.1], -1.0));
    let engines =
        [("certified", "f32 coordinates"), ("reference", "f32 coordinates"), ("fixed", "its grid")];
    for (engine, why) in engines {
        let trace = format!("trace wall.obj --rays r.csv --scalar f64 --engine {engine}");
        place.fails(&trace, 2, &["--scalar f64", engine, why, "exact or oracle"]);
        let render = format!("render wall.obj --scalar f64 --engine {engine}");
        place.fails(&render, 2, &["--scalar f64", engine, why]);
        let check = format!("render wall.obj --scalar f64 --check {engine}");
        place.fails(&check, 2, &["--scalar f64", engine, why]);
    }
    for option in ["--engine raster", "--check raster", "--wire", "--shadows volumes"] {
        let render = format!("render wall.obj --scalar f64 {option}");
        place.fails(&render, 2, &["--scalar f64", "f32 coordinates"]);
    }
    place.fails("trace wall.obj --rays r.csv --scalar f64 --threshold 0", 2, &["has none"]);
    assert!(!place.path("intertri.png").exists());
}

#[test]
fn the_oracle_gives_the_same_answers_and_the_same_picture() {
    let place = TestFolder::new();
    let offsets: Vec<f64> = (0..40).map(|i| f64::from(i).sin() * 1e-3).collect();
    place.put("wall.obj", obj()).put("r.csv", csv(&offsets, -1.0));
    for query in ["", "--all", "--any"] {
        let of = |engine| {
            text(
                &place,
                &format!("trace wall.obj --rays r.csv --scalar f64 --engine {engine} {query}"),
            )
        };
        assert_eq!(of("exact"), of("oracle"));
    }
    let eye = format!(
        "--eye {},{},1.7 --target {},{NORTH},1.5 --up 0,0,1",
        EAST + 1.0,
        NORTH + 5.0,
        EAST + 2.0
    );
    let light = format!("--light {},{},4", EAST + 3.0, NORTH + 2.0);
    let render =
        format!("render wall.obj -o w.png --size 48x36 --scalar f64 {eye} {light} --check oracle");
    let told: Value = serde_json::from_slice(&place.ok(&format!("{render} --json"))).unwrap();
    assert_eq!((&told["scalar"], &told["engine"]), (&"f64".into(), &"exact".into()));
    assert_eq!(told["check"]["differing_pixels"], 0);
    // The whole wall is lit if it is seen from the light's side.
    assert!(told["hits"].as_u64().unwrap() > 400, "{told}");
    assert_eq!((&told["dark"], &told["shadow_rays"]), (&0.into(), &told["hits"]));
}

#[test]
fn without_a_model_f64_draws_the_house() {
    let place = TestFolder::new();
    let report = |arguments: &str| -> Value {
        serde_json::from_slice(&place.ok(&format!("{arguments} --json"))).unwrap()
    };
    let told = report("render -o house.png --size 40x30 --scalar f64 --check oracle");
    assert_eq!((&told["model"], &told["check"]["differing_pixels"]), (&Value::Null, &0.into()));
    assert!(told["hits"].as_u64().unwrap() > 700 && told["dark"].as_u64().unwrap() > 20, "{told}");
    let told = report("render -o knot.png --size 40x30");
    assert_eq!((&told["scalar"], &told["triangles"]), (&"f32".into(), &10_804.into()));
}
