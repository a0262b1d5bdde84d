//! Tests that the program uses the numbers as written in the files, and counts those that it
//! rounds.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::common::TestFolder;

/// A wall that runs east in UTM coordinates, where adjacent f32 values are up to 6.3 cm apart.
const WALL: &str = "v 148376.213 528980.447 0\nv 148380.213 528980.447 0\nv 148380.213 528980.447 3\n\
                    v 148376.213 528980.447 3\nf 1 2 3\nf 1 3 4\n";

/// Rays that run north and south, from a point a centimetre north of the wall and from a point a
/// centimetre south of it.
const NEAR: &str = "ox,oy,oz,dx,dy,dz\n148377,528980.457,1,0,1,0\n148377,528980.457,1,0,-1,0\n\
                    148377,528980.437,1,0,1,0\n148377,528980.437,1,0,-1,0\n";

fn text(place: &TestFolder, arguments: &str) -> String {
    String::from_utf8(place.ok(arguments)).unwrap()
}

fn report(place: &TestFolder, arguments: &str) -> Value {
    serde_json::from_slice(&place.ok(&format!("{arguments} --json"))).unwrap()
}

/// Issue 48 of mikedh/trimesh: two of the four rays in `NEAR` were answered incorrectly unless f64
/// was requested.
#[test]
fn a_wall_in_utm_coordinates_is_where_the_file_says() {
    let place = TestFolder::new();
    place.put("wall.obj", WALL).put("near.csv", NEAR);
    assert_eq!(
        text(&place, "trace wall.obj --rays near.csv --any"),
        "ray,hit\n0,0\n1,1\n2,1\n3,0\n"
    );
    for query in ["", "--any", "--all", "--crossings", "--raw"] {
        let [default, double] = ["", "--scalar f64"]
            .map(|scalar| place.ok(&format!("trace wall.obj --rays near.csv {query} {scalar}")));
        assert_eq!(default, double, "{query}");
    }
    // The answers are the same regardless of the type that an ASCII PLY declares for its decimals.
    let lines =
        |first| WALL.split_terminator('\n').filter_map(move |line| line.strip_prefix(first));
    let vertices = lines("v ").collect::<Vec<_>>().join("\n");
    place.put(
        "wall.ply",
        format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
             property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
             {vertices}\n3 0 1 2\n3 0 2 3\n"
        ),
    );
    assert_eq!(
        text(&place, "trace wall.ply --rays near.csv"),
        text(&place, "trace wall.obj --rays near.csv")
    );
    // A hierarchy that is built without `--scalar` also keeps the numbers.
    place.ok("build wall.obj -o wall.itri");
    assert_eq!(
        text(&place, "trace wall.itri --rays near.csv"),
        text(&place, "trace wall.obj --rays near.csv")
    );
    let told = report(&place, "trace wall.obj --rays near.csv -o a.csv");
    assert_eq!(told["scalar"], "f64");
    assert_eq!(told["rounded"]["model"], json!({"numbers": 0, "by_up_to": 0.0}));
    assert_eq!(told["rounded"]["rays"], json!({"numbers": 0, "by_up_to": 0.0}));
}

/// A model whose nonzero coordinates are all inexact in f32.
const DECIMALS: &str = "v 0.1 0.1 0.3\nv 1.1 0.1 0.3\nv 0.1 1.1 0.3\nf 1 2 3\n";
/// A model whose coordinates are all exact in f32.
const BINARY: &str = "v 0 0 0.25\nv 1 0 0.25\nv 0 1 0.75\nf 1 2 3\n";

/// Returns the t in the first line of answers.
fn t(answers: &str) -> f64 {
    answers.lines().nth(1).unwrap().split(',').nth(2).unwrap().parse().unwrap()
}

#[test]
fn f32_rounds_where_it_is_asked_for_and_is_counted() {
    let place = TestFolder::new();
    place.put("m.obj", DECIMALS).put("r.csv", "ox,oy,oz,dx,dy,dz\n0.3,0.3,0,0.01,0.02,0.7\n");
    let [default, single, double] = ["", "--scalar f32", "--scalar f64"]
        .map(|scalar| text(&place, &format!("trace m.obj --rays r.csv {scalar}")));
    assert_eq!(default, double);
    assert!((t(&default) - 0.3 / 0.7).abs() < 1e-16);
    assert_eq!(t(&single), f64::from(0.3_f32) / f64::from(0.7_f32));

    let told = report(&place, "trace m.obj --rays r.csv --scalar f32 -o a.csv");
    let moved = |x: f64| (f64::from(x as f32) - x).abs();
    assert_eq!(told["scalar"], "f32");
    for (name, numbers, by_up_to) in [("model", 9, moved(1.1)), ("rays", 5, moved(0.3))] {
        let rounded = &told["rounded"][name];
        assert_eq!(rounded["numbers"], numbers, "{told}");
        assert!((rounded["by_up_to"].as_f64().unwrap() - by_up_to).abs() < 1e-20, "{told}");
    }
    let told = text(&place, "trace m.obj --rays r.csv --scalar f32 -o a.csv");
    for words in
        ["9 coordinates of the model were rounded", "5 numbers of the rays", "up to 2.4e-8"]
    {
        assert!(told.contains(words), "{told}");
    }
    // If nothing is rounded, there is no message.
    place.put("m.obj", BINARY).put("r.csv", "ox,oy,oz,dx,dy,dz\n0.25,0.125,0,0.5,0.25,2\n");
    let told = text(&place, "trace m.obj --rays r.csv --scalar f32 -o a.csv");
    assert!(!told.contains("rounded"), "{told}");
}

#[test]
fn engines_in_f32_say_what_they_round() {
    let place = TestFolder::new();
    place.put("m.obj", DECIMALS).put("r.csv", "ox,oy,oz,dx,dy,dz\n0.3,0.3,0,0.01,0.02,0.7\n");
    for engine in ["certified", "reference", "fixed --grid-bounds 0,0,0,1,1,1"] {
        let line = format!("trace m.obj --rays r.csv --engine {engine}");
        let output = place.run(&line);
        let words =
            ["supports only f32", "9 coordinates of the model", "5 numbers of the rays", "2.4e-8"];
        crate::common::one_line(&line, &output, 0, &words);
        // Requesting f32 explicitly suppresses the message, and changes no answer.
        assert_eq!(place.ok(&format!("{line} --scalar f32")), output.stdout);
        let output = place.run(&format!("{line} -o a.csv --json"));
        let told: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(
            (&told["scalar"], &told["rounded"]["model"]["numbers"]),
            (&"f32".into(), &9.into())
        );
    }
    for line in ["render m.obj --size 8x6", "bench m.obj --size 8x6 --turns 1 --rays r.csv"] {
        let told = report(&place, line);
        assert_eq!(told["rounded"]["model"]["numbers"], 9, "{told}");
        let rays = if line.contains("--rays") { 5 } else { 0 };
        assert_eq!(told["rounded"]["rays"]["numbers"], rays, "{told}");
        assert!(text(&place, line).contains("9 coordinates of the model were rounded"));
    }
    let told = report(&place, "advise m.obj --size 8x6 --tolerance 100%");
    assert_eq!(told["rounded"]["model"]["numbers"], 9, "{told}");
    assert_eq!(report(&place, "build m.obj -o m.itri")["rounded"]["model"]["numbers"], 0);
    let told = report(&place, "build m.obj -o m.itri --scalar f32");
    assert_eq!(told["rounded"]["model"]["numbers"], 9, "{told}");
    assert_eq!(report(&place, "render --size 8x6")["rounded"]["model"]["numbers"], 0);
}

/// If all numbers are exact in f32, every path through the program gives the same answers.
#[test]
fn f32_is_taken_where_nothing_is_lost_and_no_answer_shows_it() {
    let place = TestFolder::new();
    let wave = |i: usize, k: f64| (i as f64 * k).sin() as f32;
    // A sheet whose corners are exact in f32, with rays toward corners, edges and other points.
    let corner = |i: usize| [(i % 9) as f32 / 3.0, (i / 9) as f32 / 3.0, wave(i, 0.7) / 5.0];
    let mut model = String::new();
    for [x, y, z] in (0..81).map(|i| corner(i).map(f64::from)) {
        writeln!(model, "v {x:e} {y:e} {z:e}").unwrap();
    }
    for i in (0..72).filter(|i| i % 9 < 8) {
        writeln!(model, "f {} {} {} {}", i + 1, i + 2, i + 11, i + 10).unwrap();
    }
    place.put("m.obj", &model);
    let rays: Vec<[f32; 8]> = (0..2000)
        .map(|i| {
            let origin = [wave(i, 1.3), wave(i, 2.1), 3.0 + wave(i, 0.3)];
            let [a, b] = [corner(i % 81), corner((i % 81).saturating_sub(1))];
            let share = [0.0, 0.5, wave(i, 0.9).abs()][i % 3];
            let dir = [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * share - origin[k]);
            [origin[0], origin[1], origin[2], 0.0, dir[0], dir[1], dir[2], f32::INFINITY]
        })
        .collect();
    place
        .put("r.f32", rays.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>());
    let wide: Vec<f64> = rays.as_flattened().iter().map(|&x| f64::from(x)).collect();
    place.put("r.f64", wide.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>());
    let line = |ray: &[f64]| ray.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n";
    let lines: String = wide.chunks(8).map(line).collect();
    place.put("r.csv", format!("ox,oy,oz,t_min,dx,dy,dz,t_max\n{lines}"));
    place.ok("build m.obj -o m.itri");
    place.ok("build m.obj -o m64.itri --scalar f64");

    let told = |rays: &str| report(&place, &format!("trace m.obj --rays {rays} -o a.csv"));
    assert_eq!(told("r.f32")["scalar"], "f32");
    assert_eq!(
        (&told("r.csv")["scalar"], &told("r.f64")["scalar"]),
        (&"f64".into(), &"f64".into())
    );
    assert!(told("r.f32")["hits"].as_u64() > Some(1500), "{}", told("r.f32"));
    for query in ["", "--any", "--all", "--crossings", "--raw"] {
        let want = place.ok(&format!("trace m.obj --rays r.f32 {query}"));
        for model in ["m.obj", "m.itri", "m64.itri"] {
            for rays in ["r.f32", "r.f64", "r.csv"] {
                for scalar in ["", "--scalar f32", "--scalar f64"] {
                    let line = format!("trace {model} --rays {rays} {query} {scalar}");
                    assert!(place.ok(&line) == want, "{line}");
                }
            }
        }
    }
    // A single inexact coordinate is not rounded, even if all rays are exact.
    place.put("m.obj", model.replacen("v 0e0 0e0 ", "v 1e-50 0e0 ", 1));
    let told = report(&place, "trace m.obj --rays r.f32 -o a.csv");
    assert_eq!((&told["scalar"], &told["rounded"]["model"]["numbers"]), (&"f64".into(), &0.into()));
    let told = report(&place, "trace m.obj --rays r.f32 -o a.csv --scalar f32");
    let rounded = &told["rounded"]["model"];
    assert_eq!(rounded["numbers"], 1);
    assert!((rounded["by_up_to"].as_f64().unwrap() / 1e-50 - 1.0).abs() < 1e-9, "{told}");
    place.put("m.obj", DECIMALS);
    let want = place.ok("trace m.obj --rays r.csv");
    assert_eq!(place.ok("trace m.obj --rays r.f32"), want);
    assert_ne!(place.ok("trace m.obj --rays r.f32 --scalar f32"), want);

    // An inexact ray changes neither the other answers nor their format.
    place
        .put("more.csv", format!("ox,oy,oz,t_min,dx,dy,dz,t_max\n{lines}0.1,0.1,3,0,0,0,-1,inf\n"));
    place.put("m.obj", &model);
    let want = text(&place, "trace m.obj --rays r.f32");
    assert!(text(&place, "trace m.obj --rays more.csv").starts_with(&want));
}

#[test]
fn a_number_beyond_f32_is_an_error_that_names_it_and_not_an_infinity() {
    let place = TestFolder::new();
    place.put("m.obj", BINARY);
    let ray = |x: f64| [0.25, 0.125, 0.0, 0.0, x, 0.0, 1.0, f64::INFINITY].map(f64::to_le_bytes);
    place.put("r.f64", [ray(0.0), ray(-1e39), ray(1e40)].as_flattened().concat());
    place.put("r.csv", "ox,oy,oz,dx,dy,dz\n0.25,0.125,0,0,0,1\n0.25,0.125,0,-1e39,0,1\n");
    for engine in ["--scalar f32", "--engine certified"] {
        let line = format!("trace m.obj --rays r.f64 {engine} -o a.csv");
        place.fails(&line, 1, &["r.f64: ", "ray 1: dx: -1e39", "range of f32", "f64"]);
        let line = format!("trace m.obj --rays r.csv {engine} -o a.csv");
        place.fails(&line, 1, &["r.csv:3: ", "dx: -1e39", "range of f32", "f64"]);
    }
    place.fails("bench m.obj --size 8x6 --rays r.f64", 1, &["ray 1: dx: -1e39"]);
    assert_eq!(text(&place, "trace m.obj --rays r.f64 --any"), "ray,hit\n0,1\n1,0\n2,0\n");
}
