//! Fuzzes the model loaders. Whatever a file contains, reading it must return a model or a one-line
//! error.

use std::fmt::Write;
use std::path::Path;

use intertri::TriangleOf;
use intertri_scene::{LoadError, Mesh, read};

use super::input::Input;

/// Reads the bytes as a model file, or builds a mesh from them, writes it to files and reads them
/// back. The first byte selects the format or the round trip.
pub fn models(bytes: &[u8]) {
    let Some((&first, file)) = bytes.split_first() else { return };
    if first >= 0x80 {
        return written(file);
    }
    let name = ["a.obj", "a.ply", "a.stl", "a", "a.gltf", "a.glb"][first as usize % 6];
    let result = model(name, file);
    if name == "a.obj" {
        // The style of line endings must not change the result, and a final line ending must not
        // change whether the file is valid.
        if !file.contains(&b'\r') {
            let lines = file.split(|&b| b == b'\n').collect::<Vec<_>>();
            // Unused vertices may have NaN coordinates, so compare the results as text, in which
            // all NaNs are equal.
            let result = format!("{result:?}");
            for end in [&b"\r\n"[..], b"\r"] {
                assert_eq!(format!("{:?}", model(name, &lines.join(end))), result);
            }
        }
        assert_eq!(model(name, &[file, b"\n"].concat()).is_ok(), result.is_ok());
    }
}

/// Reads a model. The mesh must be valid. If it is small and its coordinates are finite, it must be
/// unchanged after it is written and read again. An error message must be a single line.
fn model(name: &str, bytes: &[u8]) -> Result<Mesh, LoadError> {
    let result = read(Path::new(name), bytes);
    match &result {
        Ok(mesh) => {
            // A glTF file can refer to the same data several times, so the model can be larger than
            // the file.
            let most = bytes.len() + if name.starts_with("a.gl") { 1 << 24 } else { 0 };
            assert!(!mesh.triangles.is_empty() && mesh.triangles.len() <= most);
            assert!(mesh.positions.len() <= most);
            assert!(mesh.points().all(|point| point.iter().all(|x| x.is_finite())));
            assert_eq!(mesh.to_triangles().len(), mesh.triangles.len());
            let uvs = mesh.corner_uvs.as_ref();
            assert!(uvs.is_none_or(|uvs| uvs.len() == mesh.triangles.len()));
            let is_finite = mesh.positions.as_flattened().iter().all(|x| x.is_finite());
            if is_finite && mesh.triangles.len() + mesh.positions.len() < 200 {
                again(mesh);
            }
        }
        Err(error) => {
            let lines = bytes.split(|b| matches!(b, b'\n' | b'\r')).count() as u64;
            assert!(error.line.is_none_or(|line| (1..=lines + 1).contains(&line)), "{error}");
            let text = error.to_string();
            assert!(text.starts_with(name) && text.len() < 300, "{text}");
            assert!(!text.contains(char::is_control), "{text:?}");
        }
    }
    result
}

/// Builds a mesh with finite coordinates, writes it as OBJ, PLY, and STL, and reads it back.
fn written(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let count = 1 + input.below(8);
    let finite = |x: f32| if x.is_finite() { x } else { 0.5 };
    let positions = (0..count).map(|_| input.point().map(finite)).collect();
    let triangles =
        (0..=input.below(8)).map(|_| [(); 3].map(|()| input.below(count) as u32)).collect();
    again(&Mesh { positions, triangles, ..Mesh::default() });
}

/// Writes a mesh as OBJ, PLY, and STL, and checks that it reads back unchanged.
fn again(mesh: &Mesh) {
    let Mesh { positions, triangles, .. } = mesh;
    let mut obj = String::new();
    let mut ascii = header("ascii", mesh);
    for [x, y, z] in positions {
        writeln!(obj, "v {x} {y:e} {z}").unwrap();
        writeln!(ascii, "{x:e} {y} {z:e}").unwrap();
    }
    for [a, b, c] in triangles {
        writeln!(obj, "f {} {}/ {}//1", a + 1, b + 1, i64::from(*c) - positions.len() as i64)
            .unwrap();
        writeln!(ascii, "3 {a} {b} {c}").unwrap();
    }
    let [mut little, mut big] =
        ["little", "big"].map(|end| header(&format!("binary_{end}_endian"), mesh).into_bytes());
    for x in positions.as_flattened() {
        little.extend(x.to_le_bytes());
        big.extend(x.to_be_bytes());
    }
    for corners in triangles {
        little.push(3);
        big.push(3);
        little.extend(corners.map(u32::to_le_bytes).as_flattened());
        big.extend(corners.map(u32::to_be_bytes).as_flattened());
    }
    let files = [
        ("a.obj", obj.into_bytes()),
        ("a.ply", ascii.into_bytes()),
        ("b.ply", little),
        ("c.ply", big),
    ];
    for (name, file) in files {
        let found = read(Path::new(name), &file).unwrap_or_else(|e| panic!("{e}\n{mesh:?}"));
        assert_eq!((&found.positions, &found.triangles), (positions, triangles), "{name}");
    }

    // In STL, triangles do not share corners.
    let mut stl = vec![b' '; 80];
    let mut ascii = String::from("solid a b\n");
    stl.extend((triangles.len() as u32).to_le_bytes());
    for TriangleOf(corners) in mesh.to_triangles() {
        stl.extend([0; 12]);
        stl.extend(corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        stl.extend([0; 2]);
        ascii += "facet normal 0 0 1\nouter loop\n";
        for [x, y, z] in corners {
            writeln!(ascii, "vertex {x} {y:e} {z:e}").unwrap();
        }
        ascii += "endloop\nendfacet\n";
    }
    ascii += "endsolid\n";
    for (name, file) in [("a.stl", stl), ("b.stl", ascii.into_bytes())] {
        let found = read(Path::new(name), &file).unwrap_or_else(|e| panic!("{e}\n{mesh:?}"));
        assert_eq!(found.to_triangles(), mesh.to_triangles(), "{name}");
    }
}

fn header(format: &str, mesh: &Mesh) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty \
         float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )
}
