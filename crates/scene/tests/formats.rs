//! Tests the meshes read from valid files in every format.

use std::fs;
use std::path::PathBuf;

use intertri_scene::{Mesh, load, read};
use tempfile::TempDir;

/// Loads a file with this name and content.
fn mesh(name: &str, bytes: impl AsRef<[u8]>) -> Mesh {
    let folder = TempDir::new().unwrap();
    let path: PathBuf = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    load(&path).unwrap_or_else(|error| panic!("{error}"))
}

const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.25]];

#[test]
fn obj_fans_keep_the_order_of_the_file() {
    let text = "mtllib nowhere.mtl\no one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.25\n\
                usemtl none\nf 4 3 2 1\np 1\nl 1 2 3\no two\nv 5 5 5 1.0\ng group\ns off\n\
                f 5 1 2 # a comment\nf 1//1 2//1 3//1 4//1 5//1\n";
    let mesh = mesh("a.obj", text);
    assert_eq!(mesh.positions[..4], SQUARE);
    assert_eq!(mesh.positions[4], [5.0; 3]);
    let expected = [[3, 2, 1], [3, 1, 0], [4, 0, 1], [0, 1, 2], [0, 2, 3], [0, 3, 4]];
    assert_eq!(mesh.triangles, expected);
    assert_eq!(mesh.corner_uvs, None);
}

#[test]
fn obj_negative_indices_count_back_from_the_last_vertex_so_far() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nvt 0.5 0.25\nv 0 1 0.25\nvt 1\nvt 0 1\n\
                f -4/-1 -1/-2 -3/-3\n";
    let mesh = mesh("a.obj", text);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 3, 1]]);
    // The first face has no texture coordinates, so it gets zeros.
    let uvs = mesh.corner_uvs.unwrap();
    assert_eq!(uvs, [[[0.0; 2]; 3], [[0.0, 1.0], [1.0, 0.0], [0.5, 0.25]]]);
}

#[test]
fn obj_texture_coordinates_follow_the_fan_and_stay_in_step_with_faces_without() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.25\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                f 1/1 2/2 3/3 4/4\nf 1 2 3\nf 3/3 2/2/7 1/1\nf 1/1 2/2 3/3 4\n";
    // A face has texture coordinates at all of its corners or at none.
    let none = [[0.0; 2]; 3];
    let uvs = mesh("a.obj", text).corner_uvs.unwrap();
    let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    assert_eq!(uvs, [[a, b, c], [a, c, d], none, [c, b, a], none, none]);
}

#[test]
fn obj_survives_what_editors_do_to_it() {
    // The file has a byte order mark, carriage returns, tabs, joined lines, a name that is not
    // UTF-8, and no final line end.
    let text =
        b"\xef\xbb\xbfv 0 0 0\r\n\tv\t1 0 0\r\no caf\xe9\r\nv 1 \\\r\n 1 0\r\nf 1 2 \\\r\n 3";
    let mesh = mesh("A.OBJ", text);
    assert_eq!(mesh.positions, SQUARE[..3]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn positions_have_the_nearest_f32_and_are_not_welded() {
    let text = "v 0.1 16777217 1e-45\nv 0.1 16777217 1e-45\nv -0 3.4028235e38 1e-60\nf 1 2 3\n";
    let mesh = mesh("a.obj", text);
    let expected = [0.1_f32, 16_777_216.0, f32::from_bits(1)].map(f32::to_bits);
    assert_eq!(mesh.positions[0].map(f32::to_bits), expected);
    assert_eq!(mesh.positions[1].map(f32::to_bits), expected);
    assert_eq!(mesh.positions[2].map(f32::to_bits), [-0.0, f32::MAX, 0.0].map(f32::to_bits));
}

/// Returns the header for a square with texture coordinates, and with an edge element between the
/// vertices and the faces.
fn ply_header(format: &str, real: &str, list: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment by hand\nelement vertex 4\nproperty {real} x\n\
         property {real} y\nproperty {real} z\nproperty uchar red\nproperty {real} s\n\
         property {real} t\nelement edge 1\nproperty int vertex1\nproperty int vertex2\n\
         element face 2\nproperty list {list} vertex_indices\nend_header\n"
    )
}

fn check_square(mesh: &Mesh) {
    assert_eq!(mesh.positions, SQUARE);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [3, 1, 0]]);
    let [a, b, c, d] = SQUARE.map(|[x, y, _]| [x * 2.0, y]);
    assert_eq!(mesh.corner_uvs.as_deref(), Some(&[[a, b, c], [a, c, d], [d, b, a]][..]));
}

#[test]
fn ply_ascii() {
    let text = ply_header("ascii", "float", "uchar int")
        + "0 0 0 9 0 0\n1 0 0 9 2 0\n1 1 0 9 2 1\n0 1 0.25 9 0 1\n0 1\n4 0 1 2 3\n3 3 1 0\n";
    check_square(&mesh("a.ply", text));
}

#[test]
fn ply_binary_of_both_byte_orders_and_other_types() {
    let mut little = ply_header("binary_little_endian", "float", "uchar uint").into_bytes();
    let mut big = ply_header("binary_big_endian", "double", "int short").into_bytes();
    for [x, y, z] in SQUARE {
        for (i, value) in [x, y, z, x * 2.0, y].into_iter().enumerate() {
            if i == 3 {
                little.push(9);
                big.push(9);
            }
            little.extend(value.to_le_bytes());
            big.extend(f64::from(value).to_be_bytes());
        }
    }
    for index in [0_i32, 1] {
        little.extend(index.to_le_bytes());
        big.extend(index.to_be_bytes());
    }
    for face in [&[0_u8, 1, 2, 3][..], &[3, 1, 0]] {
        little.push(face.len() as u8);
        big.extend((face.len() as i32).to_be_bytes());
        for &corner in face {
            little.extend(u32::from(corner).to_le_bytes());
            big.extend(i16::from(corner).to_be_bytes());
        }
    }
    check_square(&mesh("a.ply", little));
    check_square(&mesh("a.ply", big));
}

#[test]
fn ply_strips_are_wound_alike_and_end_at_minus_one() {
    let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
                property float z\nproperty float u\nproperty float v\nelement tristrips 2\n\
                property list int int vertex_indices\nend_header\n\
                0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n1 1 0 1 1\n2 1 0 2 1\n\
                8 0 1 2 3 -1 1 4 3\n6 -1 0 1 1 3 -1\n";
    let mesh = mesh("a.ply", text);
    // Triangles that use a vertex twice are skipped.
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3], [1, 4, 3]]);
    let uvs = mesh.corner_uvs.unwrap();
    assert_eq!(uvs[1], [[0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]);
    let bad = |from: &str, to: &str| read("a.ply".as_ref(), text.replace(from, to).as_bytes());
    let error = bad("1 4 3", "1 -2 3").unwrap_err().to_string();
    assert!(error.starts_with("a.ply:17: a strip has an index that is negative"), "{error}");
    let error = bad("1 4 3", "1 5 3").unwrap_err().to_string();
    assert!(error.starts_with("a.ply:17: a face refers to vertex 5, but there are 5"), "{error}");
}

/// Returns a binary STL file with this many triangles, whose free text begins with `text`.
fn stl_binary(text: &str, triangles: u8) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes[..text.len()].copy_from_slice(text.as_bytes());
    bytes.extend(u32::from(triangles).to_le_bytes());
    for i in 0..triangles {
        for value in [0.0, 0.0, 1.0, f32::from(i), 0.0, 0.1, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([0, 0]);
    }
    bytes
}

#[test]
fn stl_binary_also_where_it_begins_with_solid() {
    for text in ["exported", "solid exported"] {
        let mesh = mesh("a.stl", stl_binary(text, 3));
        assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
        assert_eq!(mesh.positions[6..], [[2.0, 0.0, 0.1], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    }
}

#[test]
fn stl_binary_whose_bytes_could_all_be_text() {
    let mut bytes = stl_binary("solid", 1);
    for (number, value) in bytes[84..84 + 48].chunks_exact_mut(4).zip([0.5_f32, 2.0].iter().cycle())
    {
        number.copy_from_slice(&value.to_le_bytes());
    }
    assert!(bytes.is_ascii());
    assert_eq!(mesh("a.stl", bytes).positions, [[2.0, 0.5, 2.0], [0.5, 2.0, 0.5], [2.0, 0.5, 2.0]]);
}

const FACET: &str = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n\n  vertex 1 0 0\n  \
                     vertex 0 1 2.5e-1\n endloop\nendfacet\n";

#[test]
fn stl_ascii_with_and_without_a_name_and_several_solids() {
    let text =
        format!("solid\n{FACET}endsolid\n\nsolid two words\n{FACET}{FACET}endsolid two words");
    let mesh = mesh("a.stl", text);
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
    assert_eq!(mesh.positions[6..], [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.25]]);
}

#[test]
fn a_name_without_a_known_ending_is_read_by_its_content() {
    assert_eq!(mesh("model", "# hello\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").triangles.len(), 1);
    assert_eq!(mesh("a.txt", format!("solid x\n{FACET}endsolid x\n")).triangles.len(), 1);
    assert_eq!(mesh("a.bin", stl_binary("exported", 2)).triangles.len(), 2);
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n\
               0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n";
    assert_eq!(mesh("a.dat", ply).triangles, [[0, 1, 2]]);
}
