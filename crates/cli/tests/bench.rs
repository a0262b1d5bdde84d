//! Tests `bench` through the compiled binary: every engine traces every kind of ray, and all except
//! `fixed` report the same number of hits.

use crate::common::{MODEL, TestFolder};
use serde_json::Value;

#[test]
fn all_engines_answer_all_kinds_of_rays() {
    let place = TestFolder::new();
    let rays = "ox,oy,oz,dx,dy,dz\n0.25,0.25,0,0,0,1\n0.25,0.25,6,0,0,1\n50,0,0,0,0,1\n";
    place.put("m.obj", MODEL).put("rays.csv", rays);
    let line = "bench m.obj --size 24x18 --turns 2 --rays rays.csv --json";
    let report: Value = serde_json::from_slice(&place.ok(line)).unwrap();
    assert_eq!((&report["triangles"], &report["turns"]), (&4.into(), &2.into()));

    let rates = report["rates"].as_array().unwrap();
    assert_eq!(rates.len(), 4 * 4);
    for (four, kind) in rates.chunks(4).zip(["primary", "shadow", "diffuse", "file"]) {
        let engines: Vec<_> = four.iter().map(|rate| rate["engine"].as_str().unwrap()).collect();
        assert_eq!(engines, ["exact", "certified", "fixed", "reference"]);
        for rate in four {
            assert_eq!(rate["rays"], kind);
            assert!(rate["million_a_second"].as_f64().unwrap() > 0.0, "{rate}");
            // This model is so small that the reference also traces all rays.
            if rate["engine"] != "fixed" {
                assert_eq!(rate["hits"], four[0]["hits"], "{rate}");
            }
        }
        assert_eq!(four[3]["times_the_reference"], 1.0);
    }
    assert_eq!(rates[12]["hits"], 2);
    assert!(rates[0]["hits"].as_u64() > Some(50), "{}", rates[0]);

    let text = String::from_utf8(place.ok("bench m.obj --size 24x18 --turns 1")).unwrap();
    for words in ["4 triangles", "million a second", "diffuse    fixed"] {
        assert!(text.contains(words), "no {words:?} in {text}");
    }
    assert_eq!(place.names(), ["m.obj", "rays.csv"]);
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    place.fails("bench m.obj --turns 0", 2, &["--turns"]);
    place.fails("bench missing.obj", 1, &["missing.obj"]);
    place.fails("bench m.obj --size 8x8 --rays missing.csv", 1, &["missing.csv"]);
}

#[test]
fn rates_of_slow_engines_have_digits() {
    let place = TestFolder::new();
    // With this many triangles, the scalar loop traces only a few hundred rays per second.
    let triangle = |i: u32| {
        let (x, y) = (i % 400, i / 400);
        format!("v {x} {y} 0\nv {x}.5 {y} 0\nv {x} {y}.5 0\nf -3 -2 -1\n")
    };
    place.put("m.obj", (0..150_000).map(triangle).collect::<String>());
    let text = String::from_utf8(place.ok("bench m.obj --size 8x6 --turns 1")).unwrap();
    let reference = text.lines().filter(|line| line.contains(" reference "));
    let mut lines = 0;
    for line in reference {
        let rate = line.split_whitespace().nth(2).unwrap();
        let digits = rate.trim_start_matches(['0', '.']).trim_end_matches("e-").len();
        assert!(digits >= 3 && rate.parse::<f64>().unwrap() > 0.0, "{line}");
        lines += 1;
    }
    assert!(lines > 0, "{text}");
}
