//! Families of closed meshes, in which every edge is shared by two triangles and every vertex by
//! several.

use intertri::{Ray, Triangle};
use intertri_reference::THRESHOLD;

use super::aim::{add, around, round, shoot, target, weigh};
use super::scene::Scene;
use crate::meshes::Mesh;
use crate::rng::Rng;

/// The number of grid steps per unit. Even the sum of four vertices minus four origins fits in 24
/// bits.
const GRID: f64 = 262_144.0;

/// Returns the largest icosphere with at most `triangles` faces, or the smallest icosphere if none
/// is small enough.
fn largest_icosphere(triangles: usize) -> Mesh {
    Mesh::icosphere((1..=6).take_while(|&k| 20 << (2 * k) <= triangles).count() as u32)
}

/// Returns the largest torus with at most `triangles` faces and about twice as many quads around as
/// across, or the smallest torus if none is small enough.
fn largest_torus(triangles: usize) -> Mesh {
    let mut across = 3;
    while 4 * (across + 1) * (across + 1) <= triangles {
        across += 1;
    }
    Mesh::torus(triangles / (2 * across), across)
}

/// Returns the largest cube with at most `triangles` faces, or the smallest cube if none is small
/// enough.
fn largest_cube(triangles: usize) -> Mesh {
    let mut n = 1;
    while 48 * (n + 1) * (n + 1) <= triangles {
        n += 1;
    }
    Mesh::cube(n)
}

/// Returns all triangles of a mesh, or only `triangles` consecutive triangles if the mesh has more.
fn part(rng: &mut Rng, mesh: &Mesh, triangles: usize) -> Vec<Triangle> {
    let mut all = mesh.triangles();
    if triangles < all.len() {
        let start = rng.below(all.len());
        all.rotate_left(start);
        all.truncate(triangles);
    }
    all
}

/// Shears, scales, and moves a mesh so that no coordinate is special, permutes its axes, and builds
/// a scene from it. The rays come from inside and outside and pass close to the mesh's edges and
/// vertices.
fn near(rng: &mut Rng, mesh: Mesh, triangles: usize, rays: usize) -> Scene {
    let (centre, size) = (rng.cube(), rng.log(0.1, 10.0));
    let mesh = mesh.map(|[x, y, z]| add(centre, [y + 0.1 * x, z - 0.2 * y, x + 0.3 * z], size));
    let triangles = part(rng, &mesh, triangles);
    let eye = around(rng, centre, size);
    let share = rng.one_in(4);
    let rays = (0..rays)
        .filter(|_| !triangles.is_empty())
        .map(|_| {
            let triangle = rng.pick(&triangles);
            let to = weigh(&triangle, target(rng));
            let inner = rng.cube();
            let origin = match rng.below(2) {
                _ if share => eye,
                0 => round(add(centre, inner, 0.4 * size)),
                _ => around(rng, centre, size),
            };
            shoot(rng, origin, to)
        })
        .collect();
    Scene { triangles, rays, threshold: THRESHOLD }
}

/// Builds a scene from a mesh on a grid and rays from grid points inside and outside that *exactly*
/// meet a vertex, the midpoint or a quarter point of an edge, or a point in a face: origin,
/// direction, and target are free of rounding. `origin` returns a point in grid steps, and `unit`
/// is the size of one step.
fn exact(
    rng: &mut Rng,
    triangles: Vec<Triangle>,
    rays: usize,
    unit: f64,
    mut origin: impl FnMut(&mut Rng) -> [f64; 3],
) -> Scene {
    let rays = (0..rays)
        .filter(|_| !triangles.is_empty())
        .map(|_| {
            let triangle = rng.pick(&triangles);
            let mut weights = rng.pick(&[
                [1.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [1.0, 3.0, 0.0],
                [3.0, 1.0, 0.0],
                [1.0, 1.0, 2.0],
            ]);
            weights.rotate_left(rng.below(3));
            let total = weights.iter().sum::<f64>();
            let origin = origin(rng).map(|x| x * unit);
            let dir = add(weigh(&triangle, weights), origin, -total);
            Ray::new(round(origin), round(dir))
        })
        .collect();
    Scene { triangles, rays, threshold: THRESHOLD }
}

/// Builds an exact scene from a mesh of radius 1 snapped to the grid, with ray origins inside it or
/// up to 8 units away.
fn exact_on_grid(rng: &mut Rng, mesh: Mesh, triangles: usize, rays: usize) -> Scene {
    let mesh = mesh.map(|p| p.map(|x| (x * GRID) as i32 as f64 / GRID));
    let triangles = part(rng, &mesh, triangles);
    exact(rng, triangles, rays, 1.0 / GRID, |rng| {
        let radius = rng.pick(&[0.4, 0.4, 2.0, 8.0]) * GRID;
        [0; 3].map(|_| rng.within(radius as i32) as f64)
    })
}

pub(super) fn icosphere(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    near(rng, largest_icosphere(triangles), triangles, rays)
}

pub(super) fn torus(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    near(rng, largest_torus(triangles), triangles, rays)
}

pub(super) fn icosphere_exact(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    exact_on_grid(rng, largest_icosphere(triangles), triangles, rays)
}

pub(super) fn torus_exact(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    exact_on_grid(rng, largest_torus(triangles), triangles, rays)
}

pub(super) fn cube_exact(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    let mesh = largest_cube(triangles);
    let triangles = part(rng, &mesh, triangles);
    let size = mesh.vertices.iter().fold(0.0, |m: f64, p| m.max(p[0])) as i32;
    let reach = if rng.one_in(2) { size } else { 3 * size };
    exact(rng, triangles, rays, 1.0, |rng| [0; 3].map(|_| rng.within(reach) as f64))
}
