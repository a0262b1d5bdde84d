//! Traces a million rays against a mesh: `cargo run --release --example million_rays`.

use std::time::Instant;

use intertri::Ray;
use intertri_trace::{BuildError, Bvh};

fn main() -> Result<(), BuildError> {
    // A wavy sea, given by vertex positions and three indices per triangle.
    let side = 257_u32;
    let wave = |x: u32, z: u32| {
        let (x, z) = (x as f32 / 16.0, z as f32 / 16.0);
        [x, 0.4 * (x * 1.7).sin() * (z * 1.3).cos(), z]
    };
    let positions: Vec<[f32; 3]> = (0..side * side).map(|i| wave(i % side, i / side)).collect();
    let squares = (0..side - 1).flat_map(|z| (0..side - 1).map(move |x| z * side + x));
    let triangles: Vec<[u32; 3]> =
        squares.flat_map(|i| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]]).collect();
    let sea = Bvh::from_indexed(&positions, &triangles)?;

    // A camera with 1024×1024 pixels. Consecutive rays belong to neighbouring pixels.
    let pixel = |i: u32| {
        let (x, y) = ((i % 1024) as f32 / 512.0 - 1.0, 1.0 - (i / 1024) as f32 / 512.0);
        Ray::new([8.0, 3.0, -4.0], [x, y - 0.6, 1.2])
    };
    let rays: Vec<Ray> = (0..1024 * 1024).map(pixel).collect();

    let start = Instant::now();
    let hits = sea.closest_batch(&rays);
    let seconds = start.elapsed().as_secs_f64();
    let seen = hits.iter().filter(|hit| hit.is_hit()).count();
    println!("{} triangles, {} rays, {seen} hits", sea.len(), rays.len());
    println!("{:.1} million rays per second", rays.len() as f64 / seconds * 1e-6);

    // A single query returns the same hit.
    assert_eq!(hits[600_000].some(), sea.closest(&rays[600_000]));
    Ok(())
}
