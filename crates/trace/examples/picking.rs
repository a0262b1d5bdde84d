//! Finds which of 10,000 moving objects is under the mouse, sixty times per second:
//! `cargo run --release --example picking`.

use std::sync::Arc;
use std::time::Instant;

use intertri::{Ray64, Triangle};
use intertri_trace::{Bvh, Scene};

/// Returns a torus of a few thousand triangles.
fn torus() -> Vec<Triangle> {
    let (around, across) = (64, 32);
    let corner = |i: usize, j: usize| {
        let turn = |i: usize, n: usize| (i % n) as f32 / n as f32 * std::f32::consts::TAU;
        let (a, b) = (turn(i, around), turn(j, across));
        let r = 1.0 + 0.4 * b.cos();
        [r * a.cos(), 0.4 * b.sin(), r * a.sin()]
    };
    let square = |i: usize, j: usize| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)];
        [Triangle([a, c, b]), Triangle([b, c, d])]
    };
    (0..across).flat_map(|j| (0..around).flat_map(move |i| square(i, j))).collect()
}

/// Returns the placement of an object at a given time. Objects are on a grid, rotate about their
/// own axes, and bob up and down.
fn placement(object: usize, time: f64) -> [f64; 12] {
    let (x, z) = ((object % 100) as f64 * 3.0 - 150.0, (object / 100) as f64 * 3.0);
    let y = (time + 0.1 * x + 0.07 * z).sin();
    let (s, c) = (time + object as f64).sin_cos();
    [c, -s, 0.0, x, s, c, 0.0, y, 0.0, 0.0, 1.0, z]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = Arc::new(Bvh::new(&torus())?);
    let mut scene = Scene::new();
    let objects: Vec<_> = (0..10_000)
        .map(|object| scene.add(mesh.clone(), placement(object, 0.0)))
        .collect::<Result<_, _>>()?;
    println!("{} objects of {} triangles", scene.len(), mesh.len());

    let milliseconds = |since: Instant| since.elapsed().as_secs_f64() * 1e3;
    for frame in 0..10 {
        let time = f64::from(frame) / 60.0;
        let start = Instant::now();
        for (number, &object) in objects.iter().enumerate() {
            scene.place(object, placement(number, time))?;
        }
        let placed = milliseconds(start);
        let start = Instant::now();
        let snapshot = scene.commit()?;
        let committed = milliseconds(start);

        // The mouse moves across the image of a camera above the field.
        let mouse = 0.1 * f64::from(frame) - 0.45;
        let start = Instant::now();
        let picked = snapshot.closest(&Ray64::new([0.0, 40.0, -40.0], [mouse, -0.5, 1.0]));
        let asked = milliseconds(start);
        let name =
            picked.map_or("nothing".into(), |hit| format!("object {}", hit.instance.index()));
        println!(
            "frame {frame}: placed in {placed:.2} ms, committed in {committed:.2} ms, picked {name} in {asked:.4} ms"
        );
    }
    Ok(())
}
