//! Computes how far a million points are from a solid, and on which side:
//! `cargo run --release --example signed_distance`.

use std::f32::consts::PI;
use std::time::Instant;

use intertri::Triangle;
use intertri_trace::{Solid, SolidError};

fn main() -> Result<(), SolidError> {
    // A closed torus: two triangles for each square, counter-clockwise as seen from outside.
    let (around, across) = (256, 128);
    let corner = |i: usize, j: usize| {
        let a = (i % around) as f32 * 2.0 * PI / around as f32;
        let b = (j % across) as f32 * 2.0 * PI / across as f32;
        let radius = 1.0 + 0.4 * b.cos();
        [radius * a.cos(), 0.4 * b.sin(), radius * a.sin()]
    };
    let square = |i: usize, j: usize| {
        let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j), corner(i + 1, j + 1)];
        [Triangle([a, b, c]), Triangle([c, b, d])]
    };
    let torus: Vec<Triangle> =
        (0..around).flat_map(|i| (0..across).flat_map(move |j| square(i, j))).collect();
    let solid = Solid::new(&torus)?;

    // A grid with 100 points per side.
    let at = |i: usize| (i as f32 - 49.5) / 30.0;
    let points: Vec<[f32; 3]> =
        (0..1_000_000).map(|i| [at(i % 100), at(i / 100 % 100), at(i / 10_000)]).collect();
    let start = Instant::now();
    let distances = solid.signed_distance_batch(&points);
    let seconds = start.elapsed().as_secs_f64();

    let inside = distances.iter().filter(|&&distance| distance < 0.0).count();
    println!("{} triangles, {} points, {inside} inside", torus.len(), points.len());
    println!("{:.2} million points per second", points.len() as f64 / seconds * 1e-6);
    let cell = 30.0_f64.powi(-3);
    println!("volume {:.3}; the round torus has {:.3}", inside as f64 * cell, 2.0 * 9.8696 * 0.16);

    // Find the closest point and its triangle.
    let closest = solid.bvh().closest_point([0.0, 3.0, 0.0], f64::INFINITY);
    println!("{closest:?}");
    Ok(())
}
