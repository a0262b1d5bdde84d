//! A room with a window, a lamp, and a one-sided screen: `cargo run --release --example select`.
//!
//! The example puts several meshes in one hierarchy and selects some of their triangles in queries:
//! by mask, by side, and by skipping earlier hits.

use std::error::Error;

use intertri::{Hit, Ray, Triangle};
use intertri_trace::{Bvh, Faces};

/// The mask bit of opaque meshes.
const SOLID: u32 = 0b001;
/// The mask bit of glass.
const GLASS: u32 = 0b010;
/// The mask bit of helper objects, such as lamps.
const HELPER: u32 = 0b100;

/// The names of the geometries, in the order of the meshes.
const NAMES: [&str; 4] = ["walls", "window", "lamp", "screen"];

/// Returns a rectangle of two triangles, with the same winding as `a`, `b`, `c`.
fn rectangle(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [Triangle; 2] {
    let d = [0, 1, 2].map(|k| a[k] + c[k] - b[k]);
    [Triangle::new(a, b, c), Triangle::new(c, d, a)]
}

fn main() -> Result<(), Box<dyn Error>> {
    let z = |z: f32| rectangle([-4.0, -4.0, z], [-4.0, 4.0, z], [4.0, 4.0, z]);
    let walls = [z(0.0), z(10.0)].concat();
    let (window, lamp) = (z(6.0), rectangle([-1.0, -1.0, 8.0], [-1.0, 1.0, 8.0], [1.0, 1.0, 8.0]));
    // The rays hit the back of the screen.
    let screen = rectangle([-4.0, -4.0, 4.0], [4.0, -4.0, 4.0], [4.0, 4.0, 4.0]);
    let mut bvh = Bvh::from_meshes(&[&walls, &window, &lamp, &screen])?;
    for (geometry, mask) in [SOLID, GLASS, SOLID | HELPER, SOLID].into_iter().enumerate() {
        bvh.set_mask(geometry, mask);
    }

    let rays: Vec<Ray> = [0.3, 2.5].map(|x| Ray::new([x, 0.2, 1.0], [0.0, 0.0, 1.0])).to_vec();
    let told = |hits: &[Hit]| {
        let name =
            |hit: &Hit| format!("{} {} at {}", NAMES[hit.geometry as usize], hit.triangle, hit.t);
        hits.iter().map(name).collect::<Vec<_>>().join(", ")
    };
    let all = bvh.all_batch(&rays)?;
    for (ray, hits) in rays.iter().zip(all.iter()) {
        println!("from {:?}: {}", ray.origin, told(hits));
    }

    // List the hits on everything except glass, with back faces culled.
    let lists = bvh.query().mask(SOLID).faces(Faces::Front).all_batch(&rays, None)?;
    println!("solid fronts: {}; {}", told(lists.of(0)), told(lists.of(1)));
    assert!(lists.items.iter().all(|hit| [0, 2].contains(&hit.geometry)));

    // Find the next hit of each ray, after the first one.
    let first = bvh.closest_batch(&rays);
    let skip: Vec<&[Hit]> = first.iter().map(std::slice::from_ref).collect();
    let next = bvh.query().skip(&skip).closest_batch(&rays);
    println!("behind the first: {}", told(&next));
    for (ray, next) in next.iter().enumerate() {
        assert_eq!(*next, all.of(ray)[1]);
    }
    Ok(())
}
