//! Tests `intertri trace` through the compiled binary, with files of rays.

use crate::common;
use std::io::Read;
use std::process::Stdio;

use crate::common::{MODEL, TestFolder};
use intertri::Ray;

/// Returns rays that hit no triangle, one triangle or several, and some invalid rays.
fn rays() -> Vec<Ray> {
    let mut rays = vec![
        Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]),
        Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, -1.0]),
        Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]).between(5.0, 5.5),
        Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]).between(0.0, 5.0),
        Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 3.0]).between(2.0, 2.5),
        Ray::new([f32::NAN, 0.0, 0.0], [0.0, 0.0, 1.0]),
        Ray::new([0.0, 0.0, 0.0], [0.0, 0.0, f32::INFINITY]),
    ];
    let wave = |i: f32, k: f32| (i * k).sin();
    rays.extend((0..3000).map(|i| i as f32).map(|i| {
        Ray::new([wave(i, 0.7), wave(i, 1.3), 0.1], [wave(i, 2.1) * 0.1, wave(i, 0.3) * 0.1, 1.7])
    }));
    rays
}

fn csv(rays: &[Ray]) -> String {
    let mut text = String::from("ox,oy,oz,t_min,dx,dy,dz,t_max\n");
    for ray in rays {
        // Write all digits, because a decimal stands for the nearest f64.
        let cells = bytemuck::cast::<Ray, [f32; 8]>(*ray).map(|x| f64::from(x).to_string());
        text += &(cells.join(",") + "\n");
    }
    text
}

fn raw(rays: &[Ray]) -> Vec<u8> {
    let numbers: &[f32] = bytemuck::cast_slice(rays);
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Creates a folder with the model, and with the rays in both formats.
fn place() -> TestFolder {
    let place = TestFolder::new();
    place.put("m.obj", MODEL).put("rays.csv", csv(&rays())).put("rays.f32", raw(&rays()));
    place
}

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap()
}

/// Returns the cells of each line except the first.
fn cells(csv: &str) -> Vec<Vec<&str>> {
    csv.lines().skip(1).map(|line| line.split(',').collect()).collect()
}

/// Converts a line of CSV to a `--raw` record.
fn record(cells: &[&str]) -> Vec<u8> {
    let triangle: i64 = if cells[1].is_empty() { -1 } else { cells[1].parse().unwrap() };
    let miss = if cells[1].is_empty() { ["inf", "0", "0"] } else { [cells[2], cells[3], cells[4]] };
    let numbers = miss.map(|x| x.parse::<f64>().unwrap());
    [triangle.to_le_bytes().to_vec(), numbers.iter().flat_map(|x| x.to_le_bytes()).collect()]
        .concat()
}

#[test]
fn the_first_answers_are_those_of_the_geometry() {
    let answers = text(place().ok("trace m.obj --rays rays.csv"));
    let lines: Vec<&str> = answers.lines().take(8).collect();
    let expected = ["ray,triangle,t,u,v", "0,0,5,0.25,0.25", "1,,,,", "2,0,5,0.25,0.25", "3,,,,"];
    assert_eq!(lines[..5], expected);
    assert!(lines[5].starts_with("4,1,2.3333333333333335,0.25"), "{}", lines[5]);
    assert_eq!(lines[6..], ["5,,,,", "6,,,,"]);
}

#[test]
fn csv_and_raw_agree_to_the_last_bit_both_ways() {
    let place = place();
    let answers = text(place.ok("trace m.obj --rays rays.csv"));
    assert_eq!(place.ok("trace m.obj --rays rays.f32"), answers.as_bytes());
    let from_csv: Vec<u8> = cells(&answers).iter().flat_map(|cells| record(cells)).collect();
    assert_eq!(from_csv.len(), rays().len() * 32);
    assert_eq!(place.ok("trace m.obj --rays rays.csv --raw"), from_csv);
    assert_eq!(place.ok("trace m.obj --rays rays.f32 --raw"), from_csv);
}

#[test]
fn engines_of_one_arithmetic_answer_the_same_bytes() {
    let place = place();
    for ask in ["", "--any", "--all", "--raw", "--threshold 0", "--threshold 2.3"] {
        let certified = format!("trace m.obj --rays rays.f32 {ask} --engine certified");
        let answers = place.ok(&certified);
        let others = place.ok(&format!("trace m.obj --rays rays.f32 {ask} --engine reference"));
        assert!(answers == others, "{ask}");
    }
    let certified = "trace m.obj --rays rays.f32 --engine certified";
    let [usual, large] = ["1e-9", "6"].map(|x| place.ok(&format!("{certified} --threshold {x}")));
    assert_ne!(usual, large);
}

#[test]
fn any_is_whether_there_is_a_closest() {
    let place = place();
    let closest = text(place.ok("trace m.obj --rays rays.f32"));
    let any = text(place.ok("trace m.obj --rays rays.f32 --any"));
    assert_eq!(any.lines().next(), Some("ray,hit"));
    let expected: Vec<bool> = cells(&closest).iter().map(|cells| !cells[1].is_empty()).collect();
    let found: Vec<bool> = cells(&any).iter().map(|cells| cells[1] == "1").collect();
    assert_eq!(found, expected);
    let bytes: Vec<u8> = expected.iter().map(|&hit| u8::from(hit)).collect();
    assert_eq!(place.ok("trace m.obj --rays rays.f32 --any --raw"), bytes);
    assert!(expected.contains(&true) && expected.contains(&false));
}

#[test]
fn all_has_a_line_a_hit_and_the_closest_among_them() {
    let place = place();
    let closest = text(place.ok("trace m.obj --rays rays.f32"));
    let all = text(place.ok("trace m.obj --rays rays.f32 --all"));
    let (closest, lines) = (cells(&closest), cells(&all));
    for (ray, closest) in closest.iter().enumerate() {
        let hits: Vec<_> = lines.iter().filter(|cells| cells[0] == ray.to_string()).collect();
        assert!(hits.contains(&closest), "ray {ray}");
        let t = |cells: &[&str]| cells[2].parse::<f64>().unwrap_or(0.0);
        let triangle = |cells: &[&str]| cells[1].parse::<u64>().unwrap_or(0);
        assert!(hits.is_sorted_by_key(|cells| (t(cells), triangle(cells))));
        let near = hits.iter().filter_map(|cells| cells[2].parse::<f64>().ok()).reduce(f64::min);
        assert_eq!(near, closest[2].parse().ok());
    }
    assert!(lines.len() > closest.len());

    let with_ray = |cells: &Vec<&str>| {
        [cells[0].parse::<i64>().unwrap().to_le_bytes().to_vec(), record(cells)].concat()
    };
    let bytes: Vec<u8> = lines.iter().flat_map(with_ray).collect();
    assert_eq!(place.ok("trace m.obj --rays rays.f32 --all --raw"), bytes);
}

#[test]
fn columns_may_come_in_any_order_and_the_interval_may_be_left_out() {
    let place = place();
    let csv = "\"DZ\", dy ,dx,oz,oy,ox\r\n1,0,0,0,0.25,0.25\r\n\r\n\" 1 \",0,0,0,5e-1,.25\r\n";
    let answers = text(place.put("odd.csv", csv).ok("trace m.obj --rays odd.csv"));
    assert_eq!(answers, "ray,triangle,t,u,v\n0,0,5,0.25,0.25\n1,0,5,0.25,0.5\n");
}

#[test]
fn more_rays_than_a_batch_come_through_a_pipe_in_order() {
    let place = place();
    let many = rays().repeat(60);
    assert!(many.len() > 2 << 16);
    let once = place.ok("trace m.obj --rays rays.f32 --raw");
    assert!(
        place.ok_with_input("trace m.obj --rays - --rays-format raw --raw", &raw(&many))
            == once.repeat(60)
    );
    let answers = text(place.ok_with_input("trace m.obj --rays -", csv(&many).as_bytes()));
    assert!(answers.lines().last().unwrap().starts_with(&format!("{},", many.len() - 1)));
    assert_eq!(answers.lines().count(), many.len() + 1);
}

#[test]
fn no_rays_get_no_answers() {
    let place = place();
    place.put("none.f32", "").put("none.csv", "ox,oy,oz,dx,dy,dz\n");
    for rays in ["none.f32", "none.csv"] {
        assert_eq!(text(place.ok(&format!("trace m.obj --rays {rays}"))), "ray,triangle,t,u,v\n");
    }
}

#[test]
fn an_older_file_is_replaced_and_a_report_follows() {
    let place = place();
    let answers = place.ok("trace m.obj --rays rays.csv");
    let report = place.put("a.csv", "old").ok("trace m.obj --rays rays.csv -o a.csv --json");
    assert_eq!(place.read("a.csv"), answers);
    assert_eq!(place.names(), ["a.csv", "m.obj", "rays.csv", "rays.f32"]);
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(report["rays"], rays().len());
    assert_eq!(report["triangles"], 4);
    let hits = text(answers).lines().skip(1).filter(|line| !line.ends_with(",,,,")).count();
    assert_eq!(report["hits"], hits);
}

#[test]
#[cfg(unix)]
fn a_reader_that_leaves_ends_it_with_one_line() {
    let place = place();
    place.put("many.f32", raw(&rays().repeat(60)));
    let arguments = "trace m.obj --rays many.f32";
    let mut command = place.command(arguments);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut first = [0; 18];
    child.stdout.take().unwrap().read_exact(&mut first).unwrap();
    assert_eq!(&first, b"ray,triangle,t,u,v");
    let output = child.wait_with_output().unwrap();
    common::one_line(arguments, &output, 1, &["standard output", "closed"]);
}
