//! Builds a hierarchy, saves it, and loads it again: `cargo run --release --example saved_scene`.

use std::fs::{self, File};
use std::time::Instant;

use intertri::Ray;
use intertri_trace::Bvh;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A wavy sea of half a million triangles.
    let side = 513_u32;
    let wave = |x: u32, z: u32| {
        let (x, z) = (x as f32 / 16.0, z as f32 / 16.0);
        [x, 0.4 * (x * 1.7).sin() * (z * 1.3).cos(), z]
    };
    let positions: Vec<[f32; 3]> = (0..side * side).map(|i| wave(i % side, i / side)).collect();
    let squares = (0..side - 1).flat_map(|z| (0..side - 1).map(move |x| z * side + x));
    let triangles: Vec<[u32; 3]> =
        squares.flat_map(|i| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]]).collect();
    let start = Instant::now();
    let sea = Bvh::from_indexed(&positions, &triangles)?;
    println!("{} triangles, built in {:.1} ms", sea.len(), start.elapsed().as_secs_f64() * 1e3);

    // Write the hierarchy to a file and read it back.
    let path = std::env::temp_dir().join(format!("sea-{}.itri", std::process::id()));
    sea.write_to(File::create(&path)?)?;
    let bytes = fs::metadata(&path)?.len();
    let start = Instant::now();
    let loaded: Bvh = Bvh::load(&path)?;
    println!("{bytes} bytes, loaded in {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
    fs::remove_file(&path)?;

    let ray = Ray::new([8.0, 3.0, 8.0], [0.1, -1.0, 0.2]);
    assert_eq!(loaded.closest(&ray), sea.closest(&ray));

    // A damaged file results in a one-line error.
    let mut saved = sea.to_bytes();
    saved[123_456] ^= 1;
    println!("{}", Bvh::<f32>::from_bytes(&saved).unwrap_err());
    Ok(())
}
