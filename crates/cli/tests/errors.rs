//! Tests that the program answers every invalid input with an exit code and one line that says what
//! is wrong and where, and never panics.

use crate::common;
use crate::common::{MODEL, NO_SUCH_FILE, TestFolder};

/// Checks that `trace` and `render` report a bad model in the same way.
fn bad_model(name: &str, bytes: &[u8], words: &[&str]) {
    let place = TestFolder::new();
    place.put(name, bytes).put("rays.csv", "ox,oy,oz,dx,dy,dz\n0,0,0,0,0,1\n");
    place.fails(&format!("render {name}"), 1, words);
    place.fails(&format!("trace {name} --rays rays.csv"), 1, words);
    place.fails(&format!("trace {name} --rays rays.csv -o out.csv"), 1, words);
    // Neither command leaves an image or answers behind, complete or partial.
    let mut left = [name, "rays.csv"];
    left.sort_unstable();
    assert_eq!(place.names(), left);
}

#[test]
fn a_missing_file() {
    TestFolder::new().fails("render no.obj", 1, &["no.obj: ", NO_SUCH_FILE]);
}

#[test]
fn a_folder() {
    let place = TestFolder::new();
    std::fs::create_dir(place.path("folder.obj")).unwrap();
    place.fails("render folder.obj", 1, &["folder.obj: ", "folder"]);
}

#[test]
fn an_empty_file() {
    for name in ["empty.obj", "empty.ply", "empty.stl", "empty"] {
        bad_model(name, b"", &[name, ": the file is empty"]);
    }
}

#[test]
fn text_that_is_no_model() {
    bad_model("poem.txt", b"Tiger, tiger\nburning bright\n", &["poem.txt: ", "neither OBJ"]);
    bad_model("poem.obj", b"Tiger, tiger\nburning bright\n", &["poem.obj"]);
    bad_model("poem.ply", b"Tiger, tiger\nburning bright\n", &["poem.ply"]);
    bad_model("poem.stl", b"Tiger, tiger\nburning bright\n", &["poem.stl"]);
}

#[test]
fn a_truncated_binary_ply() {
    let mut ply = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\n\
        property float x\nproperty float y\nproperty float z\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n"
        .to_vec();
    let whole = ply.len() + 3 * 12 + 13;
    ply.extend([0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|x| x.to_le_bytes()));
    ply.push(3);
    ply.extend([0i32, 1, 2].iter().flat_map(|x| x.to_le_bytes()));
    assert_eq!(ply.len(), whole);
    TestFolder::new().put("a.ply", &ply).ok("render a.ply --size 8x6");

    for end in [whole - 1, whole - 10, whole - 20] {
        bad_model("cut.ply", &ply[..end], &["cut.ply: "]);
    }
    // The header states more elements than the file contains.
    let text =
        String::from_utf8_lossy(&ply[..whole - 49]).replace("vertex 3", "vertex 99999999999");
    bad_model("big.ply", text.as_bytes(), &["big.ply: "]);
}

#[test]
fn an_stl_that_promises_four_billion_triangles() {
    let mut stl = vec![0; 80];
    stl.extend(u32::MAX.to_le_bytes());
    stl.extend([0; 50]);
    bad_model("big.stl", &stl, &["big.stl: "]);
}

#[test]
fn indices_out_of_range() {
    for face in ["f 1 2 4", "f 0 1 2", "f -4 -2 -1", "f 1 2 99999999999999999999"] {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{face}\n");
        bad_model("index.obj", text.as_bytes(), &["index.obj:4: "]);
    }
}

#[test]
fn coordinates_that_are_not_finite() {
    for number in ["nan", "inf", "-inf", "1e309"] {
        let text = format!("v 0 0 0\nv 1 0 {number}\nv 0 1 0\nf 1 2 3\n");
        bad_model("wild.obj", text.as_bytes(), &["wild.obj:2: "]);
    }
}

#[test]
fn no_triangle() {
    bad_model("points.obj", b"v 0 0 0\nv 1 0 0\n", &["points.obj: ", "no triangle"]);
}

#[test]
fn a_model_too_large_to_be_looked_at() {
    let place = TestFolder::new();
    place.put("huge.obj", "v -3e38 0 0\nv 3e38 0 0\nv 0 3e38 0\nf 1 2 3\n");
    place.fails("render huge.obj", 1, &["camera", "scale the model down"]);
}

#[test]
fn names_with_control_characters_stay_on_one_line() {
    let place = TestFolder::new();
    let output = place.command("render").arg("a\nb\x1b[2J.obj").output().unwrap();
    common::one_line("a name of two lines", &output, 1, &["a\\nb", "[2J.obj"]);
    assert!(!output.stderr.contains(&0x1b));
}

#[test]
fn outputs_that_cannot_be() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL).put("rays.f32", "").put("file", "");
    std::fs::create_dir(place.path("folder.png")).unwrap();
    for command in ["render --size 8x6", "trace m.obj --rays rays.f32"] {
        place.fails(&format!("{command} -o no/such/a.png"), 1, &["no/such/a.png: ", "folder"]);
        place.fails(&format!("{command} -o folder.png"), 1, &["folder.png: ", "folder"]);
        place.fails(&format!("{command} -o file/a.png"), 1, &["file/a.png: "]);
    }
    place.fails("render -o picture.gif", 1, &["picture.gif: ", ".png"]);
    place.fails("trace m.obj --rays rays.f32 -o ..", 1, &["..: "]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL).put("rays.csv", "ox,oy,oz,dx,dy,dz\n0,0,0,0,0,1\n");
    place.fails("trace m.obj --rays rays.csv -o /dev/full", 1, &["/dev/full: ", "No space"]);
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let output = place.command("render --size 8x6").stdout(full).output().unwrap();
    common::one_line("render", &output, 1, &["standard output: "]);
}

#[test]
fn sizes() {
    let place = TestFolder::new();
    for size in ["0x0", "0x9", "100000x100000", "4294967295x4294967295"] {
        let words = ["--size", size, "at most 67108864 pixels"];
        place.fails(&format!("render --size {size}"), 2, &words);
    }
    for size in ["", "9", "9x", "x9", "axb", "9x9x9", "-9x9", "1e3x9", "9999999999x1"] {
        place.fails(&format!("render --size={size}"), 2, &["--size"]);
    }
    assert!(place.names().is_empty());
}

#[test]
fn wrong_command_lines() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL).put("rays", "");
    for (arguments, words) in [
        ("draw", ["draw", "--help"]),
        ("render a.obj b.obj", ["b.obj", "--help"]),
        ("render --colour", ["--colour", "--help"]),
        ("render --engine f32", ["f32", "certified, fixed"]),
        ("render --check f32", ["f32", "certified, fixed"]),
        ("render --shadows soft", ["soft", "rays, volumes"]),
        ("render --eye 1,2", ["--eye", "three numbers"]),
        ("render --eye a,b,c", ["--eye", "three numbers"]),
        ("render --fov wide", ["--fov", "number"]),
        ("render --fov nan", ["--fov", "between 0 and 180"]),
        ("render --fov 0", ["--fov", "between 0 and 180"]),
        ("render --fov -35", ["--fov", "between 0 and 180"]),
        ("render --fov 180", ["--fov", "between 0 and 180"]),
        ("bench --fov inf", ["--fov", "between 0 and 180"]),
        ("advise --fov NaN", ["--fov", "between 0 and 180"]),
        ("render --grid 12", ["--grid", "--engine fixed"]),
        ("render --grid 12 --check certified", ["--grid", "--check fixed"]),
        ("trace m.obj --rays rays --engine raster", ["raster", "certified, fixed"]),
        ("trace m.obj --rays rays --grid 12", ["--grid", "--engine fixed"]),
        ("trace m.obj --rays rays --grid-bounds 0,0,0,1,1,1", ["--grid-bounds", "--engine fixed"]),
        ("trace m.obj --rays rays --skip-outside", ["--skip-outside", "--engine fixed"]),
        ("trace m.obj --rays rays --engine fixed --grid-bounds 1,2", ["--grid-bounds", "six"]),
        (
            "trace m.obj --rays rays --engine fixed --grid-bounds 0,0,0,1,1,nan",
            ["--grid-bounds", "finite"],
        ),
        ("render --target 1,2,3", ["--eye", "--help"]),
        ("render --eye 1,2,3 --view 1,2,3", ["--view", "--help"]),
        ("render --threshold x", ["--threshold", "not a number"]),
        ("render --threshold -1", ["--threshold", "non-negative"]),
        ("render --threshold nan", ["--threshold", "finite"]),
        ("trace m.obj", ["--rays", "required"]),
        ("trace --rays rays", ["MODEL", "required"]),
        ("trace m.obj --rays rays --any --all", ["--any", "--all"]),
        ("trace m.obj --rays rays --any --crossings", ["--any", "--crossings"]),
        ("trace m.obj --rays rays --all --crossings", ["--all", "--crossings"]),
        (
            "trace m.obj --rays rays --crossings --engine certified",
            ["--crossings", "exact or fixed"],
        ),
        ("trace m.obj --rays rays --crossings --engine oracle", ["--crossings", "exact or fixed"]),
        ("trace m.obj --rays rays --threshold 1e-9", ["engine exact has none", "certified"]),
        ("render --threshold 1e-9", ["engine exact has none", "certified"]),
        ("render --engine exact --threshold 0 --check certified", ["--threshold", "exact"]),
        ("render --engine oracle --threshold 0", ["engine oracle has none", "certified"]),
        ("render --engine fixed --threshold 0", ["engine fixed has none", "certified"]),
        ("trace m.obj --rays rays --engine fixed --threshold 0", ["engine fixed", "certified"]),
        ("trace m.obj --rays rays --json", ["--output", "required"]),
    ] {
        place.fails(arguments, 2, &words);
    }
}

#[test]
fn impossible_cameras() {
    let place = TestFolder::new();
    for (arguments, word) in [
        ("--eye 1,1,1 --target 1,1,1", "same point"),
        ("--eye inf,0,0", "finite"),
        ("--up 0,0,0", "--up"),
        ("--view 0,-1,0 --up 0,1,0", "--up"),
    ] {
        place.fails(&format!("render {arguments}"), 1, &["camera: ", word]);
    }
}

#[test]
fn rays_that_are_none() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL);
    std::fs::create_dir(place.path("folder")).unwrap();
    place.fails("trace m.obj --rays no.csv", 1, &["no.csv: ", NO_SUCH_FILE]);
    place.fails("trace m.obj --rays folder", 1, &["folder: ", "folder"]);

    let header = "ox,oy,oz,dx,dy,dz";
    for (text, words) in [
        ("hello\n".to_owned(), ["rays.csv:1: ", "\"hello\" is not a column"]),
        ("ox,oy,oz,dx,dy\n".to_owned(), ["rays.csv:1: ", "dz"]),
        ("ox,oy,oz,dx,dy,dz,ox\n".to_owned(), ["rays.csv:1: ", "two columns"]),
        (format!("{header}\n0,0,0,0,0,1\n0,0,0,0,0\n"), ["rays.csv:3: ", "5 cells"]),
        (format!("{header}\n\n0,0,0,0,0,1\n0,0,zero,0,0,1\n"), ["rays.csv:4: ", "oz: \"zero\""]),
        (format!("{header}\n0,0,0,0,0,1e309\n"), ["rays.csv:2: ", "beyond the range"]),
        (format!("{header}\n0,0,0,0,0,\n"), ["rays.csv:2: ", "dz: \"\""]),
        (format!("{header}\n{}", "1".repeat(1 << 20)), ["rays.csv:2: ", "more than 4096 bytes"]),
    ] {
        place.put("rays.csv", text);
        place.fails("trace m.obj --rays rays.csv -o out.csv", 1, &words);
        assert!(!place.path("out.csv").exists());
    }
    place.put("rays.csv", [header.as_bytes(), b"\n0,0,0,0,0,\xff\n"].concat());
    place.fails("trace m.obj --rays rays.csv -o out.csv", 1, &["rays.csv:2: ", "not text"]);
}

#[test]
fn raw_rays_that_end_early() {
    let place = TestFolder::new();
    place.put("m.obj", MODEL).put("rays.f32", vec![0; 3 * 32 + 5]);
    place.fails("trace m.obj --rays rays.f32", 1, &["rays.f32: ", "5 bytes", "32 bytes"]);
}
