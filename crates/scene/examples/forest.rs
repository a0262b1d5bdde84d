//! Writes a GLB file of a forest: the ground, and a thousand instances of one tree with about a
//! thousand triangles.
//!
//! ```sh
//! cargo run --release -p intertri-scene --example forest -- forest.glb 1000
//! cargo run --release -p intertri-cli -- render forest.glb
//! ```

use std::f32::consts::TAU;
use std::fs;
use std::process::ExitCode;

/// The number of vertices in a ring around the trunk.
const AROUND: usize = 40;

/// A mesh under construction.
#[derive(Default)]
struct Shape {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl Shape {
    /// Adds a horizontal ring of vertices and returns the index of its first vertex. Every other
    /// vertex has its radius multiplied by `star`.
    fn ring(&mut self, height: f32, radius: f32, star: f32) -> u32 {
        let first = self.positions.len() as u32;
        for i in 0..AROUND {
            let (sin, cos) = (TAU * i as f32 / AROUND as f32).sin_cos();
            let radius = if i % 2 == 0 { radius } else { radius * star };
            self.positions.push([radius * cos, height, radius * sin]);
        }
        first
    }

    /// Adds a surface through rings, each given by its height and radius.
    fn tube(&mut self, rings: &[(f32, f32)], star: f32) {
        let rings: Vec<u32> = rings.iter().map(|&(y, r)| self.ring(y, r, star)).collect();
        for pair in rings.windows(2) {
            for i in 0..AROUND as u32 {
                let next = (i + 1) % AROUND as u32;
                let [a, b] = [pair[0] + i, pair[0] + next];
                let [c, d] = [pair[1] + next, pair[1] + i];
                self.indices.extend([a, d, c, a, c, b]);
            }
        }
    }
}

/// Returns a fir tree: a trunk and six tiers of branches.
fn tree() -> Shape {
    let mut tree = Shape::default();
    tree.tube(&[(0.0, 0.16), (0.9, 0.12)], 1.0);
    for i in 0..6 {
        let (low, size) = (0.7 + 0.55 * i as f32, 1.25 - 0.18 * i as f32);
        tree.tube(&[(low, size), (low + 0.35, 0.55 * size), (low + 1.0, 0.02)], 0.75);
    }
    tree
}

/// Pseudorandom numbers in `0.0..1.0`, the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
}

/// The binary chunk of the file, and the JSON of the buffer views and accessors in the chunk.
#[derive(Default)]
struct Chunk {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Chunk {
    fn floats<const N: usize>(&mut self, rows: &[[f32; N]]) {
        let kind = format!("VEC{N}");
        self.add(rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()), 5126, rows.len(), &kind);
    }

    fn indices(&mut self, indices: &[u32]) {
        self.add(indices.iter().flat_map(|x| x.to_le_bytes()), 5125, indices.len(), "SCALAR");
    }

    fn add(&mut self, bytes: impl Iterator<Item = u8>, component: u32, count: usize, kind: &str) {
        let (view, offset) = (self.views.len(), self.bytes.len());
        self.bytes.extend(bytes);
        let length = self.bytes.len() - offset;
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#));
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component},"count":{count},"type":"{kind}"}}"#
        ));
    }
}

/// Returns the bytes of a GLB file that contains a forest with this many trees.
fn forest(trees: usize) -> Vec<u8> {
    let (tree, mut numbers, mut chunk) = (tree(), Numbers(1), Chunk::default());
    let side = (trees as f32).sqrt().ceil() as usize;
    let (mut places, mut turns, mut sizes) = (vec![], vec![], vec![]);
    for i in 0..trees {
        let [x, z] = [i % side, i / side].map(|k| 2.6 * (k as f32 + 0.8 * numbers.next()));
        places.push([x, 0.0, z]);
        let (sin, cos) = (0.5 * TAU * numbers.next()).sin_cos();
        turns.push([0.0, sin, 0.0, cos]);
        let size = 0.6 + 0.8 * numbers.next();
        sizes.push([size, size * (0.8 + 0.5 * numbers.next()), size]);
    }
    let [low, high] = [-3.0, 2.6 * side as f32 + 3.0];
    chunk.floats(&tree.positions);
    chunk.indices(&tree.indices);
    chunk.floats(&[[low, 0.0, low], [low, 0.0, high], [high, 0.0, high], [high, 0.0, low]]);
    chunk.indices(&[0, 1, 2, 0, 2, 3]);
    chunk.floats(&places);
    chunk.floats(&turns);
    chunk.floats(&sizes);
    let Chunk { bytes, views, accessors } = chunk;
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["EXT_mesh_gpu_instancing"],"buffers":[{{"byteLength":{}}}],"bufferViews":[{}],"accessors":[{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}},{{"primitives":[{{"attributes":{{"POSITION":2}},"indices":3}}]}}],"nodes":[{{"mesh":1}},{{"mesh":0,"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":4,"ROTATION":5,"SCALE":6}}}}}}}}]}}"#,
        bytes.len(),
        views.join(","),
        accessors.join(",")
    );
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let length = 12 + 8 + json.len() + 8 + bytes.len();
    let mut file = b"glTF".to_vec();
    file.extend([2, length as u32, json.len() as u32].map(u32::to_le_bytes).concat());
    file.extend(b"JSON");
    file.extend(json.bytes());
    file.extend((bytes.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(bytes);
    file
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let (path, trees) = (arguments.next(), arguments.next().map_or(Ok(1000), |n| n.parse()));
    let (Some(path), Ok(trees)) = (path, trees) else {
        eprintln!("usage: forest FILE.glb [TREES]");
        return ExitCode::FAILURE;
    };
    match fs::write(&path, forest(trees)) {
        Ok(()) => {
            let each = tree().indices.len() / 3;
            println!("{path}: {trees} trees of {each} triangles");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{path}: {error}");
            ExitCode::FAILURE
        }
    }
}
