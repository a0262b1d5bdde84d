//! A path tracer for a closed room with a ball and a lamp:
//! `cargo run --release --example path_tracer [picture.ppm]`.
//!
//! All paths are traced together, bounce by bounce: one batch of rays, then one batch of segments
//! to the lamp.

use std::error::Error;
use std::f32::consts::PI;
use std::{env, fs};

use intertri::{Ray, Triangle};
use intertri_trace::Bvh;

type V = [f32; 3];
const EYE: V = [0.0, 0.0, -0.99];
const SIDE: usize = 192;
const SAMPLES: usize = 16;
const LIGHT: f32 = 9.0;
const LAMP: u32 = 4;
/// The reflectance of each mesh: the white walls, the left wall, the right wall, and the ball.
const COLOURS: [V; 4] = [[0.75; 3], [0.7, 0.2, 0.15], [0.2, 0.55, 0.2], [0.8, 0.8, 0.7]];

fn each(f: impl Fn(usize) -> f32) -> V {
    [f(0), f(1), f(2)]
}
fn dot(a: V, b: V) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn unit(a: V) -> V {
    a.map(|x| x / dot(a, a).sqrt())
}
/// Returns a pseudorandom number in 0..1, the same on every run.
fn random(state: &mut u64) -> f32 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
    (*state >> 40) as f32 / (1 << 24) as f32
}
fn quad([a, b, c, d]: [V; 4]) -> [Triangle; 2] {
    [Triangle::new(a, b, c), Triangle::new(c, d, a)]
}
fn ball() -> Vec<Triangle> {
    let at = |i: usize, j: usize| {
        let (a, b) = ((i % 64) as f32 * PI / 32.0, j as f32 * PI / 32.0);
        let [x, y, z] = [b.sin() * a.cos(), b.cos(), b.sin() * a.sin()];
        [0.4 * x + 0.3, 0.4 * y - 0.6, 0.4 * z + 0.3]
    };
    let squares = (0..64 * 32).map(|k| (k % 64, k / 64));
    squares
        .flat_map(|(i, j)| quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]))
        .collect()
}

/// A ray, its pixel, and the fraction of the light along it that reaches the pixel.
type Path = (Ray, usize, V);

/// Traces paths to their next hits, adds the light that these hits send to the eye, and returns the
/// paths that continue.
fn bounce(room: &Bvh, paths: &[Path], picture: &mut [V], seed: &mut u64) -> Vec<Path> {
    let rays: Vec<Ray> = paths.iter().map(|path| path.0).collect();
    let (mut next, mut segments, mut lit) = (Vec::new(), Vec::new(), Vec::new());
    for (&(ray, pixel, share), hit) in paths.iter().zip(room.closest_batch(&rays)) {
        // The room is closed, so a ray could miss only by slipping through at an edge.
        let normal = room.normal(&hit).expect("every ray hits the closed room");
        if hit.geometry == LAMP {
            // Only the camera sees the lamp directly; at later hits, the segments already account
            // for the lamp's light.
            let seen = if ray.origin == EYE { LIGHT } else { 0.0 };
            picture[pixel] = each(|k| picture[pixel][k] + seen);
            continue;
        }
        let normal = unit(normal.map(|x| x as f32));
        let normal = if dot(normal, ray.dir) > 0.0 { normal.map(|x| -x) } else { normal };
        let share = each(|k| share[k] * COLOURS[hit.geometry as usize][k]);

        // Continue the path: the normal plus a point on the unit sphere is cosine-distributed.
        let (z, a) = (2.0 * random(seed) - 1.0, 2.0 * PI * random(seed));
        let flat = (1.0 - z * z).sqrt();
        let dir = each(|k| normal[k] + [flat * a.cos(), flat * a.sin(), z][k]);
        let ray = room.spawn_ray(&hit, dir);

        // Choose a point on the lamp, which has an area of 0.64.
        let light = [0.8 * random(seed) - 0.4, 0.98, 0.8 * random(seed) - 0.4];
        let to = each(|k| light[k] - ray.origin[k]);
        let cosines = dot(unit(to), normal).max(0.0) * unit(to)[1].max(0.0);
        segments.push([ray.origin, light]);
        lit.push(LIGHT * cosines * 0.64 / (PI * dot(to, to)));
        next.push((ray, pixel, share));
    }
    for ((visible, lit), &(_, pixel, share)) in
        room.visible_batch(&segments).into_iter().zip(lit).zip(&next)
    {
        picture[pixel] = each(|k| picture[pixel][k] + if visible { share[k] * lit } else { 0.0 });
    }
    next
}

fn main() -> Result<(), Box<dyn Error>> {
    let level = |x: f32, y| quad([[-x, y, -x], [x, y, -x], [x, y, x], [-x, y, x]]);
    let wall = |z| quad([[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]]);
    let side = |x| quad([[x, -1.0, -1.0], [x, -1.0, 1.0], [x, 1.0, 1.0], [x, 1.0, -1.0]]);
    let white = [level(1.0, -1.0), level(1.0, 1.0), wall(-1.0), wall(1.0)].concat();
    let room = Bvh::from_meshes(&[&white, &side(-1.0), &side(1.0), &ball(), &level(0.4, 0.98)])?;

    let (mut picture, mut traced, seed) = (vec![[0.0; 3]; SIDE * SIDE], 0, &mut 1);
    for _ in 0..SAMPLES {
        let mut at = |i: usize| 2.0 * ((i as f32 + random(seed)) / SIDE as f32 - 0.5);
        let mut dir = |i: usize| [at(i % SIDE), -at(i / SIDE), 1.0];
        let pixels = 0..SIDE * SIDE;
        let mut paths: Vec<Path> = pixels.map(|i| (Ray::new(EYE, dir(i)), i, [1.0; 3])).collect();
        for _ in 0..5 {
            traced += paths.len();
            paths = bounce(&room, &paths, &mut picture, seed);
        }
    }
    let mean = picture.iter().flatten().sum::<f32>() / (3 * SAMPLES * picture.len()) as f32;
    println!("{} triangles, {traced} rays, none lost, mean radiance {mean:.3}", room.len());
    if let Some(path) = env::args().nth(1) {
        let byte = |&x: &f32| (255.0 * (x / SAMPLES as f32).min(1.0).powf(1.0 / 2.2)) as u8;
        let mut bytes = format!("P6 {SIDE} {SIDE} 255\n").into_bytes();
        bytes.extend(picture.iter().flatten().map(byte));
        fs::write(path, bytes)?;
    }
    Ok(())
}
