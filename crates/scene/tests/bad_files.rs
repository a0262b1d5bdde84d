//! Tests that an invalid file causes a one-line error with the file, the line, and the cause, but
//! no panic and no large allocation.

use std::fs;
use std::path::Path;

use intertri_scene::{load, read};
use tempfile::TempDir;

/// Returns the error message for a file with this name and content, without the folder.
fn message(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    let error = load(&path).expect_err("an invalid file must not load").to_string();
    assert!(!error.contains('\n'), "the message has more than one line: {error}");
    let begin = format!("{}/", folder.path().display());
    error
        .strip_prefix(&begin)
        .unwrap_or_else(|| panic!("the message lacks the file name: {error}"))
        .into()
}

/// Checks that a message begins with `begin` and contains `part`.
#[track_caller]
fn says(message: &str, begin: &str, part: &str) {
    assert!(
        message.starts_with(begin) && message.contains(part),
        "{message:?} / {begin:?} {part:?}"
    );
}

const V: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn what_is_no_file() {
    let folder = TempDir::new().unwrap();
    let missing = load(&folder.path().join("missing.obj")).unwrap_err().to_string();
    let cause = if cfg!(windows) { "" } else { "No such file" };
    assert!(missing.contains(&format!("missing.obj: cannot read it: {cause}")), "{missing}");
    let error = load(folder.path()).unwrap_err().to_string();
    assert!(error.contains("is a folder"), "{error}");
    if Path::new("/dev/zero").exists() {
        // Reading this device would never end.
        let error = load(Path::new("/dev/zero")).unwrap_err().to_string();
        assert_eq!(
            error,
            "/dev/zero: is not a regular file; give a model file (.obj, .ply, .stl, .gltf or .glb)"
        );
    }
}

#[test]
fn what_is_no_model() {
    for name in ["a.obj", "a.ply", "a.stl", "a"] {
        assert_eq!(message(name, ""), format!("{name}: the file is empty"));
    }
    let text = "Dear reader,\n\nthis is a letter and not a model. It has words, no vertices, and no \
                faces at all.\nYours\n";
    says(&message("a.obj", text), "a.obj: it has no triangle", "is it a model?");
    says(&message("a.ply", text), "a.ply:1: the PLY header is damaged", "'ply'");
    says(&message("a.stl", text), "a.stl: its header promises", "not an STL");
    says(&message("a.stl", "short"), "a.stl: is neither", "STL");
    says(&message("a.txt", text), "a.txt: is neither OBJ nor PLY nor STL", "give");
    let noise: Vec<u8> =
        (0..5000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    for name in ["a.obj", "a.ply", "a.stl", "a"] {
        says(&message(name, &noise), name, ": ");
    }
}

#[test]
fn models_without_triangles() {
    says(&message("a.obj", V), "a.obj: it has no triangle", "");
    says(&message("a.obj", format!("{V}l 1 2 3\np 1\n")), "a.obj: it has no triangle", "");
    says(&message("a.stl", "solid x\nendsolid x\n"), "a.stl: it has no triangle", "");
    says(&message("a.stl", [0; 84]), "a.stl: it has no triangle", "");
    let ply = ply("ascii", 0, 0, "");
    says(&message("a.ply", ply), "a.ply: it has no triangle", "");
    let cloud = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
                 property float z\nend_header\n0 0 0\n";
    says(&message("a.ply", cloud), "a.ply: the PLY header has no element face", "point cloud");
}

#[test]
fn obj_faults_name_their_line() {
    let cases = [
        ("f 1 2 4", "4: a face refers to vertex 4, but there are 3, numbered from 1"),
        ("f 1 2 0", "4: a face refers to vertex 0"),
        ("f 1 2 -4", "4: a face refers to vertex -4, but there are 3 so far, numbered from 1"),
        ("f 1 2 -9223372036854775808", "4: a face refers to vertex -9223372036854775808"),
        ("f 1 2 9223372036854775807", "4: a face refers to vertex 9223372036854775807"),
        ("f 1 2 4294967296", "4: a face refers to vertex 4294967296"),
        ("f 1 2 99999999999999999999", "4: \"99999999999999999999\" is not the number"),
        ("f 1/x 2/1 3/1", "4: \"x\" is not the number of a texture coordinate"),
        ("f 1 2 x", "4: \"x\" is not the number of a vertex"),
        ("f 1 2 3/1/1/1", "4: a face has the corner \"3/1/1/1\""),
        ("f 1 2 3//1/1", "4: a face has the corner \"3//1/1\""),
        ("f 1 2 3//z", "4: a face has the corner \"3//z\""),
        ("\n# hm\nv 1 2", "6: a number is missing"),
        ("v 1 2 3,5\nf 1 2 4", "4: \"3,5\" is not a number"),
        ("v 1 2 nan\nf 1 2 4", "4: the vertex (1, 2, NaN) is not finite"),
        ("v 1 -inf 3\nf 1 2 4", "4: the vertex (1, -inf, 3) is not finite"),
        ("v 1e39 0 0\nf 1 2 4", "4: the vertex (inf, 0, 0) is not finite in f32"),
        ("v 1 \\\n2 \\\n3x\nf 1 2 4", "4: \"3x\" is not a number"),
        ("v 1 2 3 \\\n\nf 1 2 9", "6: a face refers to vertex 9, but there are 4"),
    ];
    for (fault, expected) in cases {
        says(&message("a.obj", format!("{V}{fault}\nf 1 2 3\n")), &format!("a.obj:{expected}"), "");
    }
    // A one-megabyte word that contains a bell character is shortened and escaped.
    let text = format!("v 0 0 \x07{}\nv 0 0 0\nf 1 1 2\n", "9x".repeat(500_000));
    let long = message("a.obj", text);
    says(&long, "a.obj:1: \"\\u{7}9x9x", "\"... is not a number");
    assert!(long.len() < 120);
}

/// Returns a PLY file that declares this many vertices and triangles, with this payload.
fn ply(format: &str, vertices: u64, faces: u64, payload: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uint int vertex_indices\n\
         end_header\n{payload}"
    )
}

#[test]
fn ply_faults_in_text_name_their_line() {
    let ascii = |faces, payload: &str| message("a.ply", ply("ascii", 3, faces, payload));
    let v = "0 0 0\n1 0 0\n0 1 0\n";
    let cases = [
        (
            1,
            "0 0 0\n1 0\n0 1 0\n3 0 1 2\n".into(),
            "11: \"1 0\" is not what the header announces for a vertex",
        ),
        (1, "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n".into(), "11: the vertex (1, 0, NaN) is not finite"),
        (1, "0 0 0\n1 0 1.\n0 1 ,0\n3 0 1 2\n".into(), "12: \",0\" is not a number"),
        (1, "0 0 0\n1 0 1e39\n0 1 0\n3 0 1 2\n".into(), "11: the vertex (1, 0, inf) is not finite"),
        (
            1,
            format!("{v}3 0 1 3\n"),
            "13: a face refers to vertex 3, but there are 3, numbered from 0",
        ),
        (1, format!("{v}3 0 1 -1\n"), "13: a face has an index that is negative"),
        (1, format!("{v}4 0 1 2\n"), "13: \"4 0 1 2\" is not what the header announces for a face"),
        (1, format!("{v}4294967295 0 1 2\n"), "13: \"4294967295 0 1 2\" is not"),
        (
            2,
            format!("{v}3 0 1 2\n"),
            "13: the file is cut off: the header promises 2 of element face, but the file has 1",
        ),
        (
            u64::MAX,
            format!("{v}3 0 1 2\n"),
            "13: the file is cut off: the header promises 18446744073709551615",
        ),
    ];
    for (faces, payload, expected) in cases {
        says(&ascii(faces, &payload), &format!("a.ply:{expected}"), "");
    }
}

#[test]
fn ply_faults_in_the_header() {
    let good = ply("ascii", 3, 1, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    let cases = [
        ("property float y", "property quark y", "a.ply:5: the PLY header is damaged"),
        (
            "property float y",
            "property float w",
            "a.ply: the PLY header has no element vertex with",
        ),
        ("vertex_indices", "corners", "a.ply: the PLY header has no element face"),
        ("element vertex 3", "element vertex -3", "a.ply:3: the PLY header is damaged"),
        ("element vertex 3", "element vertex 99999999999999999999", "a.ply:3: the PLY header"),
        ("format ascii 1.0\n", "", "a.ply: the PLY header is damaged: \"No format"),
        (
            "element face",
            "element nothing 9999999999999\nelement face",
            "a.ply: the PLY header has an element \"nothing\" without",
        ),
    ];
    for (from, to, expected) in cases {
        says(&message("a.ply", good.replace(from, to)), expected, "");
    }
    let header = good.split("end_header").next().unwrap();
    says(&message("a.ply", header), "a.ply:9: the PLY header is damaged", "end of file");
}

#[test]
fn ply_binary_faults() {
    let header = |format, vertices, faces| ply(format, vertices, faces, "").into_bytes();
    let mut whole = header("binary_little_endian", 3, 1);
    let start = whole.len();
    for value in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        whole.extend(value.to_le_bytes());
    }
    for value in [3_u32, 0, 1, 2] {
        whole.extend(value.to_le_bytes());
    }
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("whole.ply");
    fs::write(&path, &whole).unwrap();
    assert_eq!(load(&path).unwrap().triangles, [[0, 1, 2]]);

    // The file is invalid wherever it is cut off.
    for length in start..whole.len() {
        let message = message("a.ply", &whole[..length]);
        says(&message, "a.ply: ", "the file is cut off: the header promises");
    }
    // Overwrite one number at a time.
    let with = |place: usize, value: u32| {
        let mut bytes = whole.clone();
        bytes[start + place..start + place + 4].copy_from_slice(&value.to_le_bytes());
        message("a.ply", bytes)
    };
    says(&with(16, f32::NAN.to_bits()), "a.ply: the vertex (1, NaN, 0) is not finite", "");
    says(&with(0, f32::INFINITY.to_bits()), "a.ply: the vertex (inf, 0, 0)", "");
    says(&with(36, u32::MAX), "a.ply: face 0: the file is cut off", "");
    says(&with(36, 2), "a.ply: it has no triangle", "");
    says(&with(48, 3), "a.ply: a face refers to vertex 3, but there are 3, numbered from 0", "");
    says(&with(48, u32::MAX), "a.ply: face 0: a face has an index that is negative", "");

    // Huge counts do not cause large allocations, and reading fails immediately.
    for format in ["binary_little_endian", "binary_big_endian", "ascii"] {
        let message = message("a.ply", header(format, u64::MAX, u64::MAX));
        says(&message, "a.ply:", "the file is cut off");
    }
}

#[test]
fn stl_faults() {
    let mut huge = [0_u8; 84 + 50];
    huge[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    says(
        &message("a.stl", huge),
        "a.stl: its header promises 4294967295 triangles, which take 214748364834 bytes, but the file \
         has 134",
        "",
    );
    let mut bad = [0_u8; 84 + 50];
    bad[80] = 1;
    bad[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    says(&message("a.stl", bad), "a.stl: the vertex (NaN, 0, 0) is not finite", "");
    says(&message("a.stl", &bad[..100]), "a.stl: its header promises 1 triangles", "cut off");
    bad[..10].copy_from_slice(b"solid cube");
    says(&message("a.stl", &bad[..100]), "a.stl: its header promises 1 triangles", "cut off");
}

#[test]
fn stl_faults_in_text_name_the_line_of_their_facet() {
    let facet = |vertex: &str| {
        format!(
            "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex {vertex}\nendloop\n\
             endfacet\n"
        )
    };
    let good = facet("0 1 0");
    for vertex in ["0 x 0", "0 1", "0 1 2 3", ""] {
        let text = format!("solid a\n{good}\n{}endsolid\n", facet(vertex));
        says(&message("a.stl", text), "a.stl:14: \"vertex", "is not a vertex x y z");
    }
    for vertex in ["0 nan 0", "0 inf 0", "0 1e39 0"] {
        let text = format!("solid a\n{good}\n{}endsolid\n", facet(vertex));
        says(&message("a.stl", text), "a.stl:16: the vertex (0, ", "is not finite");
    }
    let cut_off = "the file is cut off in the middle of a facet";
    says(&message("a.stl", format!("solid a\n{}", &good[..30])), "a.stl:3: ", cut_off);
    let text = format!("solid a\n{good}endsolid\n{good}");
    says(&message("a.stl", text), "a.stl:10: \"facet\" instead of the expected solid", "");
    let text = format!("solid a\n{good}").replace("endloop", "vertex 0 0 0");
    says(&message("a.stl", text), "a.stl:7: \"vertex\" instead of the expected endloop", "");
}

#[test]
fn a_line_or_a_header_without_end_is_refused() {
    let long = " 1".repeat(1 << 23);
    let line = "a line of more than 16777216 bytes";
    says(&message("a.obj", format!("{V}f{long}\n")), "a.obj:4: ", line);
    says(&message("a.obj", format!("{V}f{}", "\\\n ".repeat(1 << 23))), "a.obj:", line);
    says(&message("a.stl", format!("solid a\nfacet{long}")), "a.stl:2: ", line);
    says(&message("a.ply", ply("ascii", 1, 1, &format!("{long} 1"))), "a.ply:10: ", line);
    let good = ply("ascii", 3, 1, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    let comment = format!("ply\ncomment {}", &long[..1 << 20]);
    let long = good.replacen("ply", &comment, 1);
    says(&message("a.ply", long), "a.ply:", "the PLY header has more than 1048576 bytes");
}

#[test]
fn what_looks_wrong_and_is_right() {
    // The files have other line ends, no final line end, names in Latin-1, unusual number formats,
    // or a face with 100,000 corners.
    let folder = TempDir::new().unwrap();
    let saved = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        load(&path).unwrap_or_else(|e| panic!("{e}"))
    };
    let obj = saved(
        "a.obj",
        b"# \xe9t\xe9\r\no \xff\r\nv -0 1e-999 +1.\r\nv 1E0 0 0\r\nv 0 1 0\r\nf 1 2 3",
    );
    assert_eq!(obj.positions[0].map(f32::to_bits), [-0.0_f32, 0.0, 1.0].map(f32::to_bits));
    let stl = "SOLID \u{e9}\r\nFacet\r\nouter\r\nvertex 0 0 0\r\n\r\nvertex 1 0 0\r\nvertex 0 1e0 -0\r\n\
               endloop\r\nendfacet\r\nendsolid";
    assert_eq!(saved("a.stl", &stl.replace("SOLID", "solid").into_bytes()).triangles.len(), 1);
    let corners = " 1 2 3 1".repeat(25_000);
    assert_eq!(saved("b.obj", format!("{V}f{corners}\n").as_bytes()).triangles.len(), 99_998);
    let corners = " 0 1 2 0".repeat(25_000);
    let v = "0 0 0\n1 0 0\n0 1 0\n";
    let face = ply("ascii", 3, 1, &format!("{v}100000{corners}\n"));
    assert_eq!(saved("a.ply", face.as_bytes()).triangles.len(), 99_998);
}

#[test]
fn damage_anywhere_is_a_model_or_one_line() {
    // Cut off a valid file of each kind at every byte, and overwrite every byte with several other
    // values.
    let ply_text = ply("ascii", 3, 1, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    let mut ply_bytes = ply("binary_big_endian", 3, 1, "").into_bytes();
    ply_bytes.extend(
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_be_bytes).as_flattened(),
    );
    ply_bytes.extend([3_u32, 0, 1, 2].map(u32::to_be_bytes).as_flattened());
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
                 endfacet\n";
    let mut stl_bytes = vec![b' '; 80];
    stl_bytes.extend([1, 0, 0, 0]);
    stl_bytes.extend([1.0_f32; 12].map(f32::to_le_bytes).as_flattened());
    stl_bytes.extend([0, 0]);
    let files: [(&str, Vec<u8>); 5] = [
        ("a.obj", format!("o a\n{V}vt 0 0\nf 1/1 2/1 3/1\nf -1//2 -2//1 -3//1 # end\n").into()),
        ("a.ply", ply_text.into()),
        ("b.ply", ply_bytes),
        ("a.stl", format!("solid a\n{facet}endsolid a\n").into()),
        ("b.stl", stl_bytes),
    ];
    for (name, good) in files {
        let check = |bytes: &[u8]| match read(Path::new(name), bytes) {
            Ok(mesh) => assert!(!mesh.to_triangles().is_empty()),
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        };
        check(&good);
        for place in 0..good.len() {
            check(&good[..place]);
            for byte in *b"\0\n -9\\\x7f\xff" {
                let mut bytes = good.clone();
                bytes[place] = byte;
                check(&bytes);
            }
        }
    }
}
