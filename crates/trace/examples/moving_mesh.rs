//! Refits the hierarchy of a moving mesh in each frame, and rebuilds it once it is worn:
//! `cargo run --release --example moving_mesh`.

use std::time::Instant;

use intertri::{Hit, Ray, Triangle};
use intertri_trace::Bvh;

/// Returns a column of squares, twisted by `turn`.
fn column(turn: f32) -> Vec<Triangle> {
    let (around, up) = (200, 200);
    let corner = |i: usize, j: usize| {
        let y = j as f32 / up as f32 * 4.0 - 2.0;
        let a = (i % around) as f32 / around as f32 * 2.0 * std::f32::consts::PI;
        // The column is elliptic and also bent sideways.
        let (x, z) = (a.cos() + (turn * y).sin(), 0.2 * a.sin());
        let (s, c) = (turn * y).sin_cos();
        [x * c - z * s, y, x * s + z * c]
    };
    let square = |i: usize, j: usize| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)];
        [Triangle([a, b, c]), Triangle([b, d, c])]
    };
    (0..up).flat_map(|j| (0..around).flat_map(move |i| square(i, j))).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let start = Instant::now();
    let mut bvh = Bvh::new(&column(0.0))?;
    println!("{} triangles, built in {:.1} ms", bvh.len(), start.elapsed().as_secs_f64() * 1e3);

    let pixel = |i: usize| {
        let (x, y) = ((i % 512) as f32 / 256.0 - 1.0, 1.0 - (i / 512) as f32 / 256.0);
        Ray::new([0.0, 0.0, -9.0], [x * 0.4, y * 0.4, 1.0])
    };
    let rays: Vec<Ray> = (0..512 * 512).map(pixel).collect();
    let mut hits = vec![Hit::MISS; rays.len()];
    for frame in 0..10 {
        let triangles = column(frame as f32 * 0.5);
        let start = Instant::now();
        let refit = bvh.refit(&triangles)?;
        let refitted = start.elapsed().as_secs_f64();
        let start = Instant::now();
        bvh.query().closest_batch_into(&rays, &mut hits);
        let traced = start.elapsed().as_secs_f64();
        println!(
            "frame {frame}: refitted in {:.1} ms, costs {:.2} times as much, traced in {:.1} ms",
            refitted * 1e3,
            refit.ratio(),
            traced * 1e3
        );

        // A worn tree returns the same results as a new tree, but a new tree may be faster.
        if refit.is_worn() {
            let anew = Bvh::new(&triangles)?;
            assert_eq!(anew.closest(&rays[99_000]), hits[99_000].some());
            println!("         rebuilt");
            bvh = anew;
        }
    }
    Ok(())
}
