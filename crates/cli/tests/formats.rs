//! Tests that the program never guesses the format of rays or answers if it is ambiguous.

use crate::common;
use crate::common::{MODEL, TestFolder};

/// Three rays: a hit, a miss, and a ray whose interval ends before the first triangle.
const NUMBERS: [[f32; 8]; 3] = [
    [0.25, 0.25, 0.0, 0.0, 0.0, 0.0, 1.0, f32::INFINITY],
    [50.0, 0.25, 0.0, 0.0, 0.0, 0.0, 1.0, f32::INFINITY],
    [0.25, 0.25, 0.0, 0.0, 0.0, 0.0, 1.0, 4.5],
];
const ANSWERS: &str = "ray,triangle,t,u,v\n0,0,5,0.25,0.25\n1,,,,\n2,,,,\n";
const HEADER: &str = "ox,oy,oz,t_min,dx,dy,dz,t_max\n";

fn csv() -> String {
    let line = |ray: &[f32; 8]| ray.map(|x| x.to_string()).join(",") + "\n";
    HEADER.to_owned() + &NUMBERS.iter().map(line).collect::<String>()
}

fn raw() -> Vec<u8> {
    NUMBERS.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn raw64() -> Vec<u8> {
    NUMBERS.as_flattened().iter().flat_map(|&x| f64::from(x).to_le_bytes()).collect()
}

fn place() -> TestFolder {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    place
}

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap()
}

#[test]
fn a_byte_order_mark_and_blank_lines_before_the_names_are_no_binary() {
    let place = place();
    for start in ["\u{feff}", "\n", " \r\n\n", "\u{feff}\n\n"] {
        let csv = format!("{start}{}", csv());
        for name in ["rays.csv", "rays", "rays.txt"] {
            place.put(name, &csv);
            assert_eq!(text(place.ok(&format!("trace m.obj --rays {name}"))), ANSWERS, "{start:?}");
        }
        assert_eq!(text(place.ok_with_input("trace m.obj --rays -", csv.as_bytes())), ANSWERS);
    }
}

#[test]
fn raw_rays_that_begin_as_text_are_raw() {
    let place = place();
    // The bytes of the first numbers are letters and a line end.
    let mut rays = b"aaaabbbbccc\n".to_vec();
    rays.extend(&raw()[12..32]);
    rays.extend(&raw()[32..]);
    place.put("rays.f32", &rays).put("rays", &rays);
    let answers = text(place.ok("trace m.obj --rays rays.f32"));
    assert_eq!(answers.lines().count(), 4, "{answers}");
    assert_eq!(text(place.ok("trace m.obj --rays rays --rays-format raw")), answers);
    place.fails("trace m.obj --rays rays", 1, &["rays: ", "--rays-format"]);
}

#[test]
fn the_option_names_any_format_whatever_the_name_or_the_beginning() {
    let place = place();
    place.put("a.bin", csv()).put("b.bin", raw()).put("c.bin", raw64());
    place.put("a.f32", csv()).put("b.csv", raw()).put("c.f32", raw64());
    for (format, names) in
        [("csv", ["a.bin", "a.f32"]), ("raw", ["b.bin", "b.csv"]), ("raw64", ["c.bin", "c.f32"])]
    {
        for name in names {
            let line = format!("trace m.obj --rays {name} --rays-format {format}");
            assert_eq!(text(place.ok(&line)), ANSWERS, "{line}");
        }
        let line = format!("trace m.obj --rays - --rays-format {format}");
        assert_eq!(text(place.ok_with_input(&line, &place.read(names[0]))), ANSWERS, "{line}");
    }
    place.fails("trace m.obj --rays b.bin --rays-format f16", 2, &["f16", "csv, raw, raw64"]);
}

#[test]
fn the_ending_of_a_name_decides() {
    let place = place();
    place.put("a.CSV", csv()).put("a.f32", raw()).put("a.F64", raw64());
    for name in ["a.CSV", "a.f32", "a.F64"] {
        assert_eq!(text(place.ok(&format!("trace m.obj --rays {name}"))), ANSWERS, "{name}");
    }
    // An empty file is neither CSV, which needs at least a header line, nor raw.
    place.put("none.csv", "").put("none.f32", "").put("none", "");
    place.fails("trace m.obj --rays none.csv", 1, &["none.csv", "names"]);
    assert_eq!(text(place.ok("trace m.obj --rays none.f32")), "ray,triangle,t,u,v\n");
    place.fails("trace m.obj --rays none", 1, &["none: ", "--rays-format"]);
}

#[test]
fn what_nothing_tells_is_refused_from_a_pipe_too() {
    let place = place();
    for (name, bytes) in
        [("a", raw()), ("b", raw64()), ("c", b"ox,oy,oz,dx,dy,wz\n1,2,3,4,5,6\n".to_vec())]
    {
        place.put(name, &bytes);
        place.fails(&format!("trace m.obj --rays {name}"), 1, &[name, "--rays-format"]);
        let mut command = place.command("trace m.obj --rays -");
        let input = std::fs::File::open(place.path(name)).unwrap();
        let output = command.stdin(input).output().unwrap();
        common::one_line("from a pipe", &output, 1, &["<stdin>: ", "--rays-format"]);
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn a_record_of_raw64_is_64_bytes_rounded_to_f32() {
    let place = place();
    place.put("cut.f64", &raw64()[..100]);
    place.fails("trace m.obj --rays cut.f64", 1, &["cut.f64: ", "36 bytes", "64 bytes"]);
    // Both files contain the same value of 0.1, and the second ray of each file hits nothing: one
    // starts at infinity, and the other too far away.
    let ray = [0.1, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0, f64::INFINITY];
    let far = [1e300, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0, f64::INFINITY];
    let bytes: Vec<u8> = [ray, far].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    place.put("a.f64", bytes).put("a.csv", "ox,oy,oz,dx,dy,dz\n0.1,0.1,0,0,0,1\ninf,0.1,0,0,0,1\n");
    assert_eq!(place.ok("trace m.obj --rays a.f64"), place.ok("trace m.obj --rays a.csv"));
}

#[test]
fn answers_are_csv_or_raw() {
    let place = place();
    place.put("rays.csv", csv());
    for ask in ["", " --any", " --all"] {
        let line = format!("trace m.obj --rays rays.csv{ask}");
        let (csv, raw) = (place.ok(&line), place.ok(&format!("{line} --raw")));
        assert_ne!(csv, raw);
        assert_eq!(place.ok(&format!("{line} --format csv")), csv);
        assert_eq!(place.ok(&format!("{line} --format raw")), raw);
    }
    place.fails("trace m.obj --rays rays.csv --format xml", 2, &["xml", "csv, raw"]);
    place.fails("trace m.obj --rays rays.csv --raw --format csv", 2, &["--raw", "--format"]);
}

#[test]
fn bench_reads_rays_as_trace_does() {
    let place = place();
    place.put("rays.bin", raw64());
    place.fails("bench m.obj --size 8x6 --turns 1 --rays rays.bin", 1, &["--rays-format"]);
    let line = "bench m.obj --size 8x6 --turns 1 --rays rays.bin --rays-format raw64";
    assert!(text(place.ok(line)).contains("file "));
}
