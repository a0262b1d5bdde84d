//! Finds the first triangle that a ray hits, using only the kernel:
//! `cargo run --example first_hit`.

use intertri::{Mode, Ray, Triangle};

fn main() {
    // A tetrahedron, and a ray through it.
    let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let mesh = faces.map(|face: [usize; 3]| Triangle(face.map(|i| corners[i])));
    let ray = Ray::new([1.0, 0.5, -1.0], [0.0, 0.0, 2.0]);

    let mode = Mode::exact();
    let hit = mode.closest(&mesh, &ray).expect("the ray hits the tetrahedron");
    assert_eq!((hit.triangle, hit.t), (0, 0.5));
    println!("face {} at t = {}, weights {} and {}", hit.triangle, hit.t, hit.u, hit.v);

    // Other queries: list all hits in order of t, find the closest hit in an interval, and test
    // whether there is any hit.
    for hit in mode.all(&mesh, &ray) {
        println!("crosses face {} at {:?}", hit.triangle, hit.point(&ray));
    }
    let inside = ray.between(0.6, 5.0);
    assert_eq!(mode.closest(&mesh, &inside).map(|hit| hit.triangle), Some(3));
    assert!(!mode.any(&mesh, &ray.between(2.0, 5.0)));

    // No ray slips through, not even at a corner.
    assert!(mode.any(&mesh, &Ray::new([4.0, 0.0, -1.0], [0.0, 0.0, 1.0])));
}
