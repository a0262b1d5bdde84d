//! Tests that the program ends with a one-line error and exit code 1 wherever memory runs out.
#![cfg(target_os = "linux")]

use crate::common;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::process::{Command, Output};

use crate::common::{MODEL, TestFolder};

/// Writes a sheet of `2 * cells * cells` triangles, as a binary PLY.
fn sheet(place: &TestFolder, name: &str, cells: u32) {
    let mut file = BufWriter::new(File::create(place.path(name)).unwrap());
    let (side, faces) = (cells + 1, 2 * cells * cells);
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float \
         y\nproperty float z\nelement face {faces}\nproperty list uchar int vertex_indices\n\
         end_header\n",
        side * side
    )
    .unwrap();
    for i in 0..side * side {
        let (x, y) = (i % side, i / side);
        let point = [x as f32, y as f32, (x * y % 7) as f32];
        file.write_all(point.map(f32::to_le_bytes).as_flattened()).unwrap();
    }
    for i in 0..cells * cells {
        let a = i / cells * side + i % cells;
        for corners in [[a, a + 1, a + side], [a + 1, a + side + 1, a + side]] {
            file.write_all(&[3]).unwrap();
            file.write_all(corners.map(u32::to_le_bytes).as_flattened()).unwrap();
        }
    }
}

/// Runs the program with a limit on its address space, in kilobytes. If it hangs, it is killed after ten
/// minutes. A backtrace is requested, because it may need memory that is not there.
fn within(place: &TestFolder, kilobytes: u32, arguments: &str) -> Output {
    shell_within(place, kilobytes, arguments).output().unwrap()
}

fn shell_within(place: &TestFolder, kilobytes: u32, arguments: &str) -> Command {
    let mut shell = Command::new("timeout");
    shell
        .current_dir(place.path(""))
        .args(["-s", "KILL", "600", "sh", "-c"])
        .env("RUST_BACKTRACE", "1");
    shell.arg(format!("ulimit -v {kilobytes} && exec \"$0\" {arguments}"));
    shell.arg(env!("CARGO_BIN_EXE_intertri"));
    shell
}

/// Checks that the run succeeded or ended with the proper error. Returns whether it failed.
fn ends_well(place: &TestFolder, kilobytes: u32, arguments: &str) -> bool {
    let output = within(place, kilobytes, arguments);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    let told = format!("{kilobytes} KB: {arguments}: {error}");
    match output.status.code() {
        Some(0) => assert_eq!(error, "", "{told}"),
        // If a small allocation fails, the standard library or the C library reports the failure.
        Some(1) if error.starts_with("memory allocation of ") => {}
        Some(1) if error.contains("Fatal glibc error: ") => {}
        Some(1) => assert!(error.starts_with("intertri: ") && error.lines().count() == 1, "{told}"),
        code => panic!("{code:?}: {told}"),
    }
    output.status.code() == Some(1)
}

#[test]
fn three_million_faces_in_300_megabytes() {
    let place = TestFolder::new();
    sheet(&place, "m.ply", 1225);
    place.put("rays.csv", "ox,oy,oz,dx,dy,dz\n0.25,0.375,-9,0,0,1\n");
    for engine in ["certified", "fixed", "reference"] {
        let line = format!("trace m.ply --rays rays.csv --engine {engine} -o a.csv");
        let output = within(&place, 300_000, &line);
        common::one_line(&line, &output, 1, &["m.ply", "memory"]);
    }
    let output = within(&place, 360_000, "render m.ply --size 8x6");
    common::one_line("render", &output, 1, &["3001250 triangles", "memory"]);
    assert_eq!(place.names(), ["m.ply", "rays.csv"]);
}

#[test]
fn any_limit_ends_in_one_line() {
    let place = TestFolder::new();
    sheet(&place, "m.ply", 200);
    place.put("rays.csv", "ox,oy,oz,dx,dy,dz\n0.25,0.375,-9,0,0,1\n");
    for line in [
        "trace m.ply --rays rays.csv -o a.csv --any",
        "trace m.ply --rays rays.csv -o a.csv --any --engine fixed --grid-bounds 0,0,-9,0,0,0",
        "render m.ply --size 320x240 --shadows volumes --wire",
        "bench m.ply --size 32x24 --turns 1 --rays rays.csv",
    ] {
        // Below the first limit, there is not enough memory for the program to start.
        let least = (5000..100_000)
            .step_by(5000)
            .find(|&kilobytes| within(&place, kilobytes, "trace --help").status.code() == Some(0));
        let limits = least.unwrap()..100_000;
        let ended = limits.step_by(5003).filter(|&limit| ends_well(&place, limit, line)).count();
        assert!(ended > 2, "{ended}: {line}");
        assert!(place.names().iter().all(|name| !name.ends_with(".partial")));
    }
}

/// The largest allocations, which hold the rays, their origins and the answers, report an error
/// wherever memory runs out.
#[test]
fn rays_that_are_measured_end_in_one_line_of_the_program() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    let limits = (30_000..).step_by(10_007).take(12);
    let mut told = vec![];
    for limit in limits {
        let output = within(&place, limit, "bench m.obj --size 1024x768 --turns 1");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        let small = |bytes: &str| bytes.parse::<usize>().is_ok_and(|bytes| bytes < 1 << 20);
        match error.strip_prefix("memory allocation of ").and_then(|e| e.split(' ').next()) {
            Some(bytes) => assert!(small(bytes), "{limit} KB: {error}"),
            None => told.extend(error.lines().map(str::to_owned)),
        }
    }
    // If memory is used up before the threads start, starting them fails.
    let is_known =
        |line: &str| ["more memory than is available", "thread"].iter().any(|w| line.contains(w));
    assert!(told.iter().all(|line| is_known(line)), "{told:?}");
    assert!(told.iter().any(|line| line.contains("rays")), "{told:?}");
}

/// A ray may hit every triangle, so its hits and their text grow with the model.
#[test]
fn one_ray_that_hits_everything_ends_in_one_line() {
    let place = TestFolder::new();
    let corners = "v 0 0 5\nv 1 0 5\nv 0 1 5\n";
    place.put("m.obj", format!("{corners}{}", "f 1 2 3\n".repeat(20_000)));
    let rays = "0.123456789,0.234567891,4,0,0,1\n".repeat(16);
    place.put("rays.csv", format!("ox,oy,oz,dx,dy,dz\n{rays}"));
    for ask in
        ["--all", "--all --raw", "--crossings", "--all --engine fixed --grid-bounds 0,0,4,1,1,6"]
    {
        let line = format!("trace m.obj --rays rays.csv {ask} -o a.csv");
        let without = "trace m.obj --rays rays.csv --any -o a.csv";
        let enough = |line: &str, limit| within(&place, limit, line).status.success();
        let least = (10_000..).step_by(5000).find(|&limit| enough(without, limit)).unwrap();
        let mut told = vec![];
        for limit in (least..400_000).step_by(3000) {
            let output = within(&place, limit, &line);
            if output.status.success() {
                break;
            }
            let error = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(1), "{limit} KB: {line}: {error}");
            if let Some(rest) = error.strip_prefix("memory allocation of ") {
                let bytes: usize = rest.split(' ').next().unwrap().parse().unwrap();
                assert!(bytes < 1 << 20, "{limit} KB: {line}: {error}");
            }
            told.push(error);
        }
        let known = |e: &&String| e.contains("the answers of ray ") || e.contains("for the hits");
        assert!(told.iter().filter(known).count() > 2, "{line}: {told:?}");
    }
}

/// Steps through the limits at which threads start but find too little memory, a few pages at a
/// time, because the range where a new thread finds no memory for its signal stack is narrow.
#[test]
fn no_limit_makes_the_program_hang() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL).put("rays.csv", "ox,oy,oz,dx,dy,dz\n0,0,0,0,0,1\n");
    let line = "trace m.obj --rays rays.csv -o a.csv";
    // With few threads, the limits that matter are the same on every machine.
    let run = |limit| {
        let mut shell = shell_within(&place, limit, line);
        shell.env("RAYON_NUM_THREADS", "2").output().unwrap()
    };
    let error = |output: &Output| String::from_utf8_lossy(&output.stderr).into_owned();
    let starts = |&limit: &u32| error(&run(limit)).contains("cannot start a thread");
    let least = (10_000..).step_by(500).find(starts).unwrap();
    let enough = (least..400_000).step_by(8).find(|&limit| {
        let output = run(limit);
        let (code, error) = (output.status.code(), error(&output));
        assert!(matches!(code, Some(0 | 1)), "{limit} KB: {code:?} {error}");
        assert!(!error.contains("internal error"), "{limit} KB: {error}");
        code == Some(0)
    });
    assert!(enough.is_some());
}

#[test]
fn rays_take_no_more_memory_the_more_there_are() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    // 320 MB of zeros, in a sparse file.
    File::create(place.path("many.f32")).unwrap().set_len(10_000_000 * 32).unwrap();
    for engine in ["certified", "fixed", "reference"] {
        let line = format!("trace m.obj --rays many.f32 --any --raw --engine {engine}");
        let output = within(&place, 300_000, &line);
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{engine}");
        assert!(output.stdout == vec![0; 10_000_000], "{engine}");
    }
}

#[test]
fn a_thread_that_cannot_start_ends_in_one_line() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL).put("rays.csv", "ox,oy,oz,dx,dy,dz\n0,0,0,0,0,1\n");
    for line in ["trace m.obj --rays rays.csv", "render --size 8x6"] {
        let stack = (1_u64 << 44).to_string();
        let output = place.command(line).env("RUST_MIN_STACK", stack).output().unwrap();
        common::one_line(line, &output, 1, &["thread"]);
    }
}
