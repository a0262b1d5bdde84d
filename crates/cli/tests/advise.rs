//! Tests that the predictions of `advise` are never too optimistic, and that bad input results in a
//! one-line error.

use std::path::{Path, PathBuf};

use crate::common::{MODEL, TestFolder};
use serde_json::Value;

fn advice(place: &TestFolder, arguments: &str) -> Value {
    serde_json::from_slice(&place.ok(arguments)).unwrap()
}

/// Checks that no bound is below the number of wrong pixels in the sample. Returns the names of the
/// choices that are within the tolerance.
fn sound(report: &Value) -> Vec<String> {
    let mut enough = vec![];
    for choice in report["choices"].as_array().unwrap() {
        let number = |name: &str| choice[name].as_u64().unwrap();
        let (frame, sample) = (number("wrong_at_most"), number("wrong_in_sample_at_most"));
        assert!(number("wrong_in_sample") <= sample && sample <= frame, "{choice}");
        assert_eq!(choice["enough"], frame <= report["tolerance"].as_u64().unwrap(), "{choice}");
        if choice["enough"] == true {
            enough.push(choice["name"].as_str().unwrap().to_owned());
        }
    }
    enough
}

#[test]
fn the_well_known_models_are_never_worse_than_predicted() {
    let folder = std::env::var_os("INTERTRI_MODELS").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models"),
        PathBuf::from,
    );
    let place = TestFolder::new();
    for name in ["stanford-bunny", "fandisk", "spot", "suzanne", "teapot", "kitchen"] {
        let path = folder.join(format!("{name}.obj"));
        if !path.exists() {
            println!("no model at {}: skipped; set INTERTRI_MODELS", path.display());
            continue;
        }
        let line = format!("advise {} --size 160x120 --json", path.display());
        let report = advice(&place, &line);
        assert_eq!(report["sample"], 160 * 120);
        let enough = sound(&report);
        println!("{name}: {enough:?}");
        assert_eq!(report["take"].as_str(), enough.first().map(String::as_str));
    }
}

#[test]
fn more_tolerance_takes_fewer_bits() {
    let place = TestFolder::new();
    let mut bits = vec![];
    for tolerance in ["0", "1%", "20%"] {
        let report =
            advice(&place, &format!("advise --size 160x120 --tolerance {tolerance} --json"));
        let enough = sound(&report);
        let take = report["take"].as_str().unwrap();
        assert_eq!(take, enough[0]);
        // With a tolerance of 0, only the choice that is never wrong is good enough.
        assert_eq!(take == "exact", tolerance == "0", "{take}");
        assert!(enough.contains(&"exact".to_owned()), "{enough:?}");
        let choices = report["choices"].as_array().unwrap();
        let chosen = choices.iter().find(|choice| choice["name"] == take).unwrap();
        bits.push(chosen["bits_a_vertex"].as_u64().unwrap());
    }
    assert!(bits[0] > bits[1] && bits[1] > bits[2], "{bits:?}");
}

#[test]
fn a_small_model_gets_a_small_threshold() {
    let place = TestFolder::new();
    // Scale the whole model down to a trillionth.
    let scale = |line: &str| match line.strip_prefix("v ") {
        None => format!("{line}\n"),
        Some(point) => {
            let scaled = point.split(' ').map(|x| x.parse::<f64>().unwrap() * 1e-12);
            format!("v {}\n", scaled.map(|x| format!("{x:e}")).collect::<Vec<_>>().join(" "))
        }
    };
    let model = MODEL.lines().map(scale).collect::<Vec<_>>().concat();
    place.put("small.obj", model).put("usual.obj", MODEL);
    let small = advice(&place, "advise small.obj --size 64x48 --json");
    let usual = advice(&place, "advise usual.obj --size 64x48 --json");
    assert_eq!((&usual["threshold"], &usual["needs"]["lost"]), (&Value::from(1e-9), &0.into()));
    assert!(small["threshold"].as_f64().unwrap() < 1e-11, "{small}");
    assert_eq!(small["needs"]["lost"], small["needs"]["hits"]);
    sound(&small);

    let text = String::from_utf8(place.ok("advise small.obj --size 64x48")).unwrap();
    for words in ["take ", "the default, 1e-9, would lose", "wrong pixels", "certified"] {
        assert!(text.contains(words), "no {words:?} in {text}");
    }
}

#[test]
fn bad_tolerances_are_refused() {
    let place = TestFolder::new();
    for bad in ["-1", "1.5", "101%", "-1%", "nan%", "many", ""] {
        let line = format!("advise --size 8x8 --tolerance={bad}");
        place.fails(&line, 2, &["--tolerance", "0.1%"]);
    }
    place.fails("advise missing.obj", 1, &["missing.obj"]);
}

#[test]
fn the_advice_tells_the_bound_of_its_choice_not_the_tolerance() {
    let place = TestFolder::new();
    for tolerance in ["0", "0.1%", "1%", "20%"] {
        let line = format!("advise --size 160x120 --tolerance {tolerance}");
        let report = advice(&place, &format!("{line} --json"));
        let choices = report["choices"].as_array().unwrap();
        let chosen = choices.iter().find(|choice| choice["name"] == report["take"]).unwrap();
        let bound = match chosen["wrong_at_most"].as_u64().unwrap() {
            0 => "no pixel can be wrong".to_owned(),
            1 => "at most 1 pixel can be wrong".to_owned(),
            bound => format!("at most {bound} pixels can be wrong"),
        };
        let text = String::from_utf8(place.ok(&line)).unwrap();
        let take = text.lines().find(|line| line.starts_with("take ")).unwrap();
        assert!(take.contains(&format!("{}: {bound}", report["take"].as_str().unwrap())), "{take}");
    }
}

#[test]
fn speeds_are_those_of_the_rays_that_bench_measures() {
    let place = TestFolder::new();
    let text = String::from_utf8(place.ok("advise --size 160x120")).unwrap();
    assert!(text.contains("primary rays"), "{text}");
    let [advise, bench] = ["advise --size 160x120 --json", "bench --size 160x120 --turns 1 --json"]
        .map(|line| serde_json::from_slice::<Value>(&place.ok(line)).unwrap());
    assert_eq!(advise["rays"], bench["rates"][0]["count"]);
    assert_eq!(
        (&bench["rates"][0]["rays"], &advise["rays"]),
        (&"primary".into(), &(160 * 120).into())
    );
}
