//! Tests the `exact` engine through the compiled binary: it is the default, handles shared edges by
//! either rule, and agrees with the oracle.

use crate::common::TestFolder;
use serde_json::Value;

fn report(place: &TestFolder, arguments: &str) -> Value {
    serde_json::from_slice(&place.ok(&format!("{arguments} --json"))).unwrap()
}

fn text(place: &TestFolder, arguments: &str) -> String {
    String::from_utf8(place.ok(arguments)).unwrap()
}

/// Creates a folder with a square whose two triangles share a diagonal, and rays through the
/// diagonal from either side.
fn square() -> TestFolder {
    let place = TestFolder::new();
    place.put("m.obj", "v 0 0 5\nv 1 0 5\nv 0 1 5\nv 1 1 5\nf 1 2 3\nf 4 3 2\n");
    place.put("r.csv", "ox,oy,oz,dx,dy,dz\n.5,.5,0,0,0,1\n.5,.5,9,0,0,-1\n9,9,9,0,0,1\n");
    place
}

#[test]
fn it_is_the_default_and_has_no_threshold() {
    let place = square();
    for (command, grid) in [
        ("render m.obj --size 16x12", ""),
        ("trace m.obj --rays r.csv -o a.csv", "--grid-bounds 0,0,0,9,9,9"),
    ] {
        let told = report(&place, command);
        assert_eq!((&told["engine"], &told["threshold"]), (&"exact".into(), &Value::Null));
        let told = report(&place, &format!("{command} --engine certified"));
        assert_eq!((&told["engine"], &told["threshold"]), (&"certified".into(), &1e-9.into()));
        let told = report(&place, &format!("{command} --engine fixed {grid}"));
        assert_eq!((&told["engine"], &told["threshold"]), (&"fixed".into(), &Value::Null));
    }
    // The threshold applies to the drawing engine, which is not exact here.
    place.ok("render m.obj --size 16x12 --engine certified --threshold 0 --check exact");
    place.ok("render m.obj --size 16x12 --engine raster --threshold 0");
}

#[test]
fn a_shared_edge_is_hit_twice_and_crossed_once() {
    let place = square();
    let all = text(&place, "trace m.obj --rays r.csv --all");
    let hits = "0,0,5,0.5,0.5\n0,1,5,0.5,0.5\n1,0,4,0.5,0.5\n1,1,4,0.5,0.5\n2,,,,\n";
    assert_eq!(all, format!("ray,triangle,t,u,v\n{hits}"));

    for engine in ["--engine exact", "--engine fixed --grid-bounds 0,0,0,9,9,9"] {
        let crossings = text(&place, &format!("trace m.obj --rays r.csv --crossings {engine}"));
        let lines: Vec<&str> = crossings.lines().collect();
        assert_eq!((lines.len(), lines[0]), (4, "ray,triangle,t,u,v,side"), "{crossings}");
        // The first ray runs along the normal, the second against it.
        assert!(lines[1].starts_with("0,") && lines[1].ends_with(",5,0.5,0.5,1"), "{crossings}");
        assert!(lines[2].starts_with("1,") && lines[2].ends_with(",4,0.5,0.5,-1"), "{crossings}");
        assert_eq!(lines[3], "2,,,,,");
    }
}

#[test]
fn crossings_of_a_closed_mesh_sum_to_its_winding_number() {
    let place = TestFolder::new();
    let cube = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 0 0 4\nv 4 0 4\nv 4 4 4\nv 0 4 4\n\
                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    place.put("m.obj", cube);
    // Rays from inside and from outside, toward corners, edges, diagonals and points in between.
    let mut rays = String::from("ox,oy,oz,dx,dy,dz\n");
    let steps = || (0..9).flat_map(|x| (0..9).flat_map(move |y| (0..9).map(move |z| [x, y, z])));
    for origin in [[1, 1, 2], [-2, -4, -6]] {
        for to in steps().filter(|to| to.iter().any(|x| x % 8 == 0)) {
            let dir = [0, 1, 2].map(|k| to[k] - 2 * origin[k]);
            let numbers = [origin, dir].concat().iter().map(i32::to_string).collect::<Vec<_>>();
            rays += &(numbers.join(",") + "\n");
        }
    }
    place.put("r.csv", &rays);
    let count = rays.lines().count() - 1;
    for engine in ["exact", "fixed --grid-bounds -8,-8,-8,8,8,8"] {
        let line = format!("trace m.obj --rays r.csv --crossings --engine {engine}");
        let (mut sums, mut bytes) = (vec![0; count], Vec::new());
        for line in text(&place, &line).lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let ray: usize = cells[0].parse().unwrap();
            let side: i64 = cells[5].parse().unwrap_or(0);
            sums[ray] += side;
            bytes.extend(ray.to_le_bytes());
            bytes.extend(cells[1].parse().unwrap_or(-1_i64).to_le_bytes());
            for (cell, miss) in cells[2..5].iter().zip([f64::INFINITY, 0.0, 0.0]) {
                bytes.extend(cell.parse().unwrap_or(miss).to_le_bytes());
            }
            bytes.extend(side.to_le_bytes());
        }
        assert!(sums[..count / 2].iter().all(|&sum| sum == 1), "{engine}: {sums:?}");
        assert!(sums[count / 2..].iter().all(|&sum| sum == 0), "{engine}: {sums:?}");
        assert_eq!(bytes.len() % 48, 0);
        assert!(place.ok(&format!("{line} --raw")) == bytes, "{engine}");
    }
}

#[test]
fn the_oracle_has_every_bit_of_it() {
    let place = square();
    let told = report(&place, "render --size 24x18 --check oracle");
    assert_eq!(told["check"]["differing_pixels"], 0);
    assert_eq!(told["check"]["largest_distance"], 0.0);
    assert_eq!(told["check"]["engine"], "oracle");
    assert!(told["hits"].as_u64() > Some(200) && told["dark"].as_u64() > Some(10), "{told}");
    for ask in ["", " --any", " --all"] {
        let line = format!("trace m.obj --rays r.csv{ask}");
        assert_eq!(text(&place, &line), text(&place, &format!("{line} --engine oracle")));
    }
}

#[test]
fn other_engines_may_differ_where_the_oracle_says_so() {
    let place = TestFolder::new();
    for light in ["", " --sun 0,1,0"] {
        for engines in [["exact", "certified"], ["reference", "exact"], ["oracle", "certified"]] {
            let [engine, check] = engines;
            let size = if engine == "oracle" { "16x12" } else { "160x120" };
            let line = format!("render --size {size}{light} --engine {engine} --check {check}");
            let check = &report(&place, &line)["check"];
            assert_eq!(check["differing_pixels"], check["excused_pixels"], "{line}: {check}");
            // Exact shadow rays start on the surface, whereas other shadow rays end a
            // ten-thousandth of the distance before it.
            assert!(check["differing_pixels"].as_u64() < Some(25), "{line}: {check}");
        }
    }
    for check in ["raster", "fixed"] {
        let check = &report(&place, &format!("render --size 160x120 --check {check}"))["check"];
        assert_eq!(check["differing_pixels"], check["excused_pixels"], "{check}");
    }

    // Only `exact` draws a model that the default threshold hides.
    place.put("tiny.obj", "v 0 0 0\nv 1e-10 0 0\nv 0 1e-10 0\nf 1 2 3\n");
    for line in ["--check certified", "--engine certified --threshold 1e-9 --check exact"] {
        let told = report(&place, &format!("render tiny.obj --size 61x45 {line}"));
        let check = &told["check"];
        assert_eq!(check["differing_hits"], check["excused_hits"], "{check}");
        assert!(check["excused_hits"].as_u64() > Some(100), "{told}");
    }
    // The rasterizer has no threshold either when it is compared with `exact`.
    place.ok("render tiny.obj --size 61x45 --check raster");
}
