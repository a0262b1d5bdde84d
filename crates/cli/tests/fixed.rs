//! Tests the `fixed` engine through the compiled binary: its grid, check, and errors.

use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

use crate::common::{MODEL, TestFolder};
use serde_json::Value;

fn report(place: &TestFolder, arguments: &str) -> Value {
    serde_json::from_slice(&place.ok(arguments)).unwrap()
}

#[test]
fn a_grid_of_wrong_bits_is_refused() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL).put("rays.csv", "ox,oy,oz,dx,dy,dz\n0,0,0,0,0,1\n");
    for command in ["render m.obj", "trace m.obj --rays rays.csv"] {
        for (bits, words) in [
            ("0", "choose 1 to 20"),
            ("21", "choose 1 to 20"),
            ("4000000000", "choose 1 to 20"),
            ("-3", "whole number from 1 to 20"),
            ("2.5", "whole number from 1 to 20"),
            ("fine", "whole number from 1 to 20"),
            ("99999999999999999999", "whole number from 1 to 20"),
        ] {
            let line = format!("{command} --engine fixed --grid {bits}");
            place.fails(&line, 2, &["--grid", bits, words]);
        }
    }
    assert_eq!(place.names(), ["m.obj", "rays.csv"]);
}

#[test]
fn a_fine_grid_changes_few_pixels_and_a_coarse_one_many_and_none_fails() {
    let place = TestFolder::new();
    let mut changed = vec![];
    for grid in [20, 12, 5] {
        let line = format!("render --size 96x72 --check fixed --grid {grid} --json");
        let report = report(&place, &line);
        let (check, on) = (&report["check"], &report["grid"]);
        assert_eq!(check["engine"], "fixed");
        assert_eq!(check["excused_pixels"], check["differing_pixels"]);
        changed.push(check["differing_pixels"].as_u64().unwrap());

        // Snapping moves points by at most half a step, which also moves some hits.
        assert_eq!(on["bits"], grid);
        let number = |of: &Value, name: &str| of[name].as_f64().unwrap();
        assert!(number(on, "moved") <= number(on, "step") / 2.0, "{on}");
        assert!(number(on, "strays") > 0.0, "{on}");
        assert!(number(check, "largest_distance") > 0.0, "{check}");
    }
    println!("{changed:?} of {}", 96 * 72);
    assert!(changed[0] < 20 && changed[0] < changed[1] && changed[1] < changed[2], "{changed:?}");
    assert!(changed[2] > 500, "{changed:?}");
    assert_eq!(place.names(), ["intertri.diff.png", "intertri.png"]);

    // The check also works the other way round. If both engines use the same grid, nothing differs
    // and nothing is excused.
    let other =
        report(&place, "render --size 96x72 --engine fixed --grid 5 --check certified --json");
    assert_eq!(other["check"]["differing_pixels"], changed[2]);
    let same = report(&place, "render --size 96x72 --engine fixed --grid 5 --check fixed --json");
    assert_eq!(same["check"]["differing_pixels"], 0);
    assert_eq!(same["check"]["largest_distance"], 0.0);
    let none = report(&place, "render --size 16x12 --json");
    assert_eq!(none["grid"], Value::Null);
}

#[test]
fn the_summary_names_the_grid() {
    let place = TestFolder::new();
    let text = String::from_utf8(
        place.ok("render --size 64x48 --engine fixed --grid 6 --check certified"),
    );
    let text = text.unwrap();
    for words in
        ["engine fixed", "6 grid bits", "a step is", "moved by up to", "of them are excused"]
    {
        assert!(text.contains(words), "no {words:?} in {text}");
    }
}

/// Compares lines by ray, triangle and t exactly, and by u and v approximately, because `fixed`
/// rounds u and v only once, unlike other engines.
fn same(a: &[u8], b: &[u8]) {
    let [a, b] = [a, b].map(String::from_utf8_lossy);
    assert_eq!(a.lines().count(), b.lines().count());
    for (a, b) in a.lines().zip(b.lines()) {
        let [a, b]: [Vec<&str>; 2] = [a, b].map(|line| line.split(',').collect());
        assert_eq!(a[..3.min(a.len())], b[..3.min(b.len())], "{a:?} {b:?}");
        for (a, b) in a.iter().zip(&b).skip(3) {
            let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
            assert!(a == b || close(a.parse().unwrap(), b.parse().unwrap()), "{a:?} {b:?}");
        }
    }
}

/// Multiples of one half are points on every grid used here, so snapping moves nothing.
#[test]
fn rays_are_answered_on_a_grid_with_room_for_their_origins() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    let mut rays = String::from("ox,oy,oz,t_min,dx,dy,dz,t_max\n");
    for line in [
        "-1.5,-1,1,0,1.75,1.25,4,inf",
        "-1.5,-1,1,0,1.75,1.25,4,1",
        "-1.5,-1,1,1,1.75,1.25,4,1.5",
        "0.5,7,-7,0,0,-1.25,2,inf",
        "5,5,-7,0,-1,-0.5,3,5",
        "-9.5,0,0,0,0,0,1,inf",
        "nan,0,0,0,0,0,1,inf",
        "inf,0,0,0,0,0,1,inf",
        "0,0,0,0,0,0,0,inf",
        "0,0,0,0,0,nan,1,inf",
        "0,0,0,nan,0,0,1,inf",
        "0,0,0,9,0,0,1,9",
    ] {
        rays.push_str(line);
        rays.push('\n');
    }
    place.put("rays.csv", &rays);
    let room = "--engine fixed --grid-bounds -9.5,-9,-7,9,9,9";
    for verb in ["", " --any", " --all"] {
        let line = format!("trace m.obj --rays rays.csv{verb}");
        let certified = place.ok(&line);
        for grid in [20, 8, 5] {
            let fixed = place.ok(&format!("{line} {room} --grid {grid}"));
            same(&certified, &fixed);
        }
    }
    let text = String::from_utf8(place.ok(&format!("trace m.obj --rays rays.csv {room} -o a.csv")));
    assert!(text.unwrap().contains("moved by up to 0.0e0"));
    assert_eq!(place.names(), ["a.csv", "m.obj", "rays.csv"]);
}

/// Returns rays that start near the model, at points that lie on no grid.
fn near(count: usize) -> String {
    let wave = |i: usize, k: f32| (i as f32 * k).sin();
    let ray =
        |i| format!("{},{},6,{},{},1\n", wave(i, 0.7), wave(i, 1.3), wave(i, 2.1), wave(i, 0.3));
    (0..count).map(ray).collect()
}

#[test]
fn a_ray_is_answered_the_same_whatever_else_is_in_the_file() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    let header = "ox,oy,oz,dx,dy,dz\n";
    let (rays, far) = (near(10_000), "1e8,0,6,0,0,1\n");
    place.put("near.csv", format!("{header}{rays}"));
    place.put("far.csv", format!("{header}{rays}{far}{rays}"));
    for ask in ["", " --any", " --all"] {
        let alone =
            place.ok(&format!("trace m.obj --rays near.csv --engine fixed --scalar f32{ask}"));
        let alone = String::from_utf8(alone).unwrap();
        let line = format!("trace m.obj --rays far.csv --engine fixed --scalar f32{ask}");
        // The error names the ray, and no output file remains.
        place.fails(
            &format!("{line} -o a.csv"),
            1,
            &["far.csv: ", "ray 10000 ", "--grid-bounds", "--skip-outside"],
        );
        assert_eq!(place.names(), ["far.csv", "m.obj", "near.csv"]);

        // With `--skip-outside`, rays that start outside the grid are misses, and the program
        // counts them.
        let output = place.run(&format!("{line} --skip-outside"));
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), told.lines().count()), (Some(0), 1), "{told}");
        assert!(
            told.starts_with("intertri: ")
                && told.contains("outside the grid and therefore hit nothing: 1"),
            "{told}"
        );
        let all = String::from_utf8(output.stdout).unwrap();
        assert!(all.starts_with(&alone));
        let rest = |text: &str| {
            text.lines().map(|line| line.split_once(',').unwrap().1.to_owned()).collect::<Vec<_>>()
        };
        let (alone, all) = (rest(&alone), rest(&all));
        let n = alone.len() - 1;
        assert_eq!(all.len(), 2 * n + 2);
        assert!(all[n + 1] == ",,," || all[n + 1] == "0", "{}", all[n + 1]);
        assert!(all[n + 2..] == alone[1..]);
    }
    let line = "trace m.obj --rays far.csv --engine fixed --skip-outside -o a.csv --json";
    let output = place.run(line);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["outside"], &report["rays"]), (&1.into(), &20_001.into()));
    // A grid that is large enough accepts these rays.
    let roomy =
        "trace m.obj --rays far.csv --engine fixed --scalar f32 --any --grid-bounds 0,0,0,1e8,0,0";
    assert_eq!(String::from_utf8(place.ok(roomy)).unwrap().lines().count(), 20_002);
}

#[test]
fn rays_from_a_pipe_are_answered_as_they_come() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    let mut command = place.command("trace m.obj --rays - --engine fixed --any");
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    input.write_all(b"ox,oy,oz,dx,dy,dz\n0.25,0.25,6,0,0,1\n").unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert_eq!(lines.next().unwrap().unwrap(), "ray,hit");
    assert_eq!(lines.next().unwrap().unwrap(), "0,1");
    drop(input);
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
