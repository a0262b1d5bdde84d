//! Counts how many of a million points are inside a mesh, and estimates the mesh's volume:
//! `cargo run --release --example contains`.

use std::f32::consts::TAU;
use std::time::Instant;

use intertri::Triangle;
use intertri_trace::{Containment, Solid, SolidError};

/// Returns a torus about the y axis, with corners counter-clockwise as seen from outside.
fn torus(around: usize, across: usize, large: f32, small: f32) -> Vec<Triangle> {
    let corner = |i: usize, j: usize| {
        // The last ring equals the first, bit for bit, so that the mesh is closed.
        let (i, j) = ((i % around) as f32, (j % across) as f32);
        let (a, b) = (i / around as f32 * TAU, j / across as f32 * TAU);
        let radius = large + small * b.cos();
        [radius * a.cos(), small * b.sin(), radius * a.sin()]
    };
    let squares = (0..around * across).map(|k| (k / across, k % across));
    let halves = squares.flat_map(|(i, j)| {
        let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j), corner(i + 1, j + 1)];
        [Triangle::new(a, b, c), Triangle::new(d, c, b)]
    });
    halves.collect()
}

fn main() -> Result<(), SolidError> {
    let mesh = torus(512, 256, 2.0, 0.75);
    let solid = Solid::new(&mesh)?;

    // A grid of points in the box around the torus.
    let at = |i: usize, cells: usize, size: f32| ((i as f32 + 0.5) / cells as f32 - 0.5) * size;
    let point =
        |i: usize| [at(i % 128, 128, 6.0), at(i / 128 % 64, 64, 2.0), at(i / 8192, 128, 6.0)];
    let points: Vec<[f32; 3]> = (0..1 << 20).map(point).collect();

    let start = Instant::now();
    let contains = solid.contains_batch(&points);
    let seconds = start.elapsed().as_secs_f64();
    let inside = contains.iter().filter(|&&contains| contains).count();
    let volume = inside as f32 / points.len() as f32 * 6.0 * 2.0 * 6.0;
    let exact = TAU / 2.0 * 0.75 * 0.75 * TAU * 2.0;
    println!("{} triangles, {} points, {inside} inside", mesh.len(), points.len());
    println!("{:.1} million points per second", points.len() as f64 * 1e-6 / seconds);
    println!("volume {volume:.2}; a true torus has {exact:.2}");
    assert!((volume / exact - 1.0).abs() < 0.01);

    // The test is exact: a vertex is on the surface, and the next f32 away from the axis is
    // outside.
    let [x, y, z] = mesh[0].0[0];
    assert_eq!(solid.classify([x, y, z]), Containment::Surface);
    assert_eq!(solid.classify([x.next_up(), y, z]), Containment::Outside);
    assert_eq!(solid.classify([x.next_down(), y, z]), Containment::Inside(1));

    // For a mesh with a hole, the error reports an open edge.
    println!("{}", Solid::new(&mesh[1..]).unwrap_err());
    Ok(())
}
