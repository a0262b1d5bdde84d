//! Loads the shared models, and generates the other scenes.

use std::path::{Path, PathBuf};

use intertri_scene::{Camera, Light, Mesh, Scene};
use rayon::prelude::*;

use crate::solids::solid;

/// The names of the scenes.
pub const SCENES: [&str; 11] = [
    "bunny", "kitchen", "sphere", "fandisk", "spot", "suzanne", "teapot", "built-in", "box",
    "boxes", "terrain",
];

/// The names of the closed generated scenes.
pub const CLOSED: [&str; 5] = ["cube", "icosahedron", "torus", "sphere-1000", "sphere"];

/// The triangle counts of the spheres in the growth chart.
pub const GROWTH: [u32; 6] = [100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000];

/// The number of parts that each edge of an octahedron is divided into. The sphere has 8 × 405² =
/// 1,312,200 triangles.
const SPHERE: u32 = 405;
/// The number of squares along each side of the terrain, which has 2 × 2236² = 9,999,392 triangles.
const TERRAIN: u32 = 2236;

/// Creates a scene by its name: one of [`SCENES`], `sphere-` followed by the approximate number of
/// triangles, or the path to a model.
pub fn scene(name: &str) -> Result<Scene, String> {
    let of = |mesh| Scene::of(mesh, 1.0).map_err(|e| format!("{name}: {e}"));
    if let Some(mesh) = solid(name) {
        return of(mesh);
    }
    let count = name.strip_prefix("sphere-").and_then(|count| count.parse::<f64>().ok());
    match name {
        "built-in" => Ok(Scene::built_in()),
        "box" => cornell_box(),
        "boxes" => of(boxes(12)),
        "sphere" => of(displaced_sphere(SPHERE)),
        "terrain" => terrain(),
        _ if count.is_some() => {
            let side = (count.unwrap_or(0.0) / 8.0).sqrt().round().clamp(1.0, 5000.0);
            of(displaced_sphere(side as u32))
        }
        "bunny" => of(model("stanford-bunny.obj")?),
        "kitchen" => kitchen(),
        "fandisk" | "spot" | "suzanne" | "teapot" => of(model(&format!("{name}.obj"))?),
        path => of(intertri_scene::load(Path::new(path)).map_err(|e| e.to_string())?),
    }
}

/// Loads one of the shared models.
fn model(file: &str) -> Result<Mesh, String> {
    intertri_scene::load(&folder().join(file))
        .map_err(|e| format!("{e}; set INTERTRI_MODELS to the folder"))
}

/// Returns the folder of the shared models.
fn folder() -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models");
    std::env::var_os("INTERTRI_MODELS").map_or(beside, PathBuf::from)
}

/// Returns the paths of all shared models, sorted.
pub fn models() -> Result<Vec<String>, String> {
    let folder = folder();
    let failed = |e| format!("{}: {e}; set INTERTRI_MODELS to the folder", folder.display());
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(&folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.extension().is_some_and(|extension| extension == "obj") {
            paths.push(path.to_string_lossy().into_owned());
        }
    }
    paths.sort();
    Ok(paths)
}

/// Returns the name of a scene in a table. For a path, that is the file name without its extension.
pub fn short(name: &str) -> String {
    Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Returns the kitchen seen from inside, under a lamp.
fn kitchen() -> Result<Scene, String> {
    let mesh = model("kitchen.obj")?;
    let camera = Camera::new([3.0, 1.7, 2.0], [-0.6, 0.9, -1.2], Camera::UP, 60.0);
    let camera = camera.map_err(|e| e.to_string())?;
    Ok(Scene { mesh, camera, light: Light::Point { position: [0.6, 2.3, 0.3] }, texture: None })
}

/// Returns a Cornell box with 36 triangles, open toward the viewer: five walls, a lamp and two
/// blocks.
fn cornell_box() -> Result<Scene, String> {
    let mut mesh = Mesh::default();
    let mut quad = |corners: [[f32; 3]; 4]| {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    };
    // Creates the wall at one end of an axis, for a room from -1 to 1.
    let wall = |axis: usize, end: f32, half: f32| {
        [[-half, -half], [half, -half], [half, half], [-half, half]].map(|[u, v]| {
            let mut p = [end; 3];
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u, v);
            p
        })
    };
    for (axis, end) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0)] {
        quad(wall(axis, end, 1.0));
    }
    quad(wall(1, 0.98, 0.3));
    // Add a short block and a tall one, rotated about the vertical axis.
    for (centre, half, turn) in [
        ([0.35, -0.7, 0.35], [0.3, 0.3, 0.3], [0.96, -0.28]),
        ([-0.35, -0.4, -0.3], [0.3, 0.6, 0.3], [0.96, 0.28]),
    ] {
        for (axis, end) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0), (2, 1.0)] {
            quad(wall(axis, end, 1.0).map(|p| {
                let [x, y, z] = [0, 1, 2].map(|k| p[k] * half[k]);
                let [c, s]: [f32; 2] = turn;
                [centre[0] + c * x + s * z, centre[1] + y, centre[2] - s * x + c * z]
            }));
        }
    }
    let camera = Camera::new([0.0, 0.0, 3.6], [0.0; 3], Camera::UP, 42.0);
    let camera = camera.map_err(|e| e.to_string())?;
    Ok(Scene { mesh, camera, light: Light::Point { position: [0.0, 0.9, 0.0] }, texture: None })
}

/// Returns a grid of boxes, `n` along each axis, separated by gaps as wide as the boxes, like city
/// blocks.
fn boxes(n: u32) -> Mesh {
    // One face at each end of each axis, counter-clockwise as seen from outside. A corner's index
    // has one bit per axis.
    const FACES: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut mesh = Mesh::default();
    for i in 0..n.pow(3) {
        let first = mesh.positions.len() as u32;
        let cell = [i % n, i / n % n, i / n / n];
        let corner =
            |corner: u32| [0, 1, 2].map(|k| cell[k] as f32 + 0.5 * (corner >> k & 1) as f32);
        mesh.positions.extend((0..8).map(corner));
        for face in FACES {
            let [a, b, c, d] = face.map(|corner| first + corner);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// Returns a bumpy sphere. Each face of an octahedron is divided into `n * n` triangles, so the
/// sphere has `8 * n * n` triangles. Along a common edge, the points of both faces have the same
/// bits.
fn displaced_sphere(n: u32) -> Mesh {
    let row = |i: u32| i * (i + 1) / 2;
    let mut mesh = Mesh::default();
    for face in 0..8 {
        let first = mesh.positions.len() as u32;
        let signs = [0, 1, 2].map(|axis| if face >> axis & 1 == 0 { 1.0 } else { -1.0 });
        let point = |i: u32, j: u32| {
            let p = [n - i, i - j, j].map(f64::from);
            let p = [0, 1, 2].map(|axis| signs[axis] * p[axis]);
            let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
            let p = p.map(|x| x / length);
            let radius = 1.0 + 0.12 * mountains(p.map(|x| 3.0 * x + 50.0), 7);
            p.map(|x| (x * radius) as f32)
        };
        let rows: Vec<Vec<_>> =
            (0..=n).into_par_iter().map(|i| (0..=i).map(|j| point(i, j)).collect()).collect();
        mesh.positions.extend(rows.into_iter().flatten());
        for i in 0..n {
            for j in 0..=i {
                let (a, b) = (first + row(i) + j, first + row(i + 1) + j);
                mesh.triangles.push([a, b, b + 1]);
                if j < i {
                    mesh.triangles.push([a, b + 1, a + 1]);
                }
            }
        }
    }
    mesh
}

/// Returns a hilly landscape, seen from one of its hills toward the horizon.
fn terrain() -> Result<Scene, String> {
    let n = TERRAIN;
    let height = |x: f64, z: f64| 0.25 * mountains([4.0 * x + 50.0, 20.0, 4.0 * z + 50.0], 9);
    let at = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    let row = |i: u32| {
        let point = |j| [at(j) as f32, height(at(j), at(i)) as f32, at(i) as f32];
        (0..=n).map(point).collect::<Vec<_>>()
    };
    let rows: Vec<_> = (0..=n).into_par_iter().map(row).collect();
    let mut triangles = Vec::with_capacity(2 * (n * n) as usize);
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            let b = a + n + 1;
            triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    let mesh = Mesh { positions: rows.concat(), triangles, ..Mesh::default() };
    let camera = Camera::new([0.7, 0.45, 0.95], [-0.1, 0.0, -0.1], Camera::UP, 50.0);
    let camera = camera.map_err(|e| e.to_string())?;
    Ok(Scene { mesh, camera, light: Light::Point { position: [-3.0, 2.5, 1.0] }, texture: None })
}

/// Returns noise with several octaves, roughly from -1 to 1. It is computed with only `+ - * /`, so
/// it has the same bits on every machine.
fn mountains(p: [f64; 3], octaves: u32) -> f64 {
    let octave = |k: u32| {
        let scale = f64::from(1_u32 << k);
        // The shift prevents the lattices of the octaves from coinciding.
        noise(p.map(|x| x * scale + 0.37 * f64::from(k))) / scale
    };
    (0..octaves).map(octave).sum()
}

/// Smoothly interpolates random values at the points of the integer lattice.
fn noise(p: [f64; 3]) -> f64 {
    let cell = p.map(|x| x as i64);
    let s = [0, 1, 2].map(|k| {
        let f = p[k] - cell[k] as f64;
        f * f * (3.0 - 2.0 * f)
    });
    let value = |corner: i64| random([0, 1, 2].map(|k| (cell[k] + (corner >> k & 1)) as u64));
    let mix = |a: f64, b: f64, s: f64| a + (b - a) * s;
    let along_x = |corner| mix(value(corner), value(corner + 1), s[0]);
    let along_y = |corner| mix(along_x(corner), along_x(corner + 2), s[1]);
    mix(along_y(0), along_y(4), s[2])
}

/// Returns a random number in `-1..1` that depends only on the arguments.
pub fn random([x, y, z]: [u64; 3]) -> f64 {
    let mut h = x.wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ y.wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
        ^ z.wrapping_mul(0x1656_67B1_9E37_79F9);
    for _ in 0..2 {
        h = (h ^ (h >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    }
    h ^= h >> 32;
    (h >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}
