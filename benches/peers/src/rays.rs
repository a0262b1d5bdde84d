//! Generates the rays of each kind: from a camera, toward a light, diffuse, aimed at edges and
//! vertices, and others.

use intertri::{Mode, Ray, Ray64};
use intertri_scene::{Camera, Scene, hit_point};
use intertri_trace::Bvh;

use crate::engine::Question;
use crate::scenes::random;

/// A kind of ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    /// From the camera; closest hit.
    Primary,
    /// From the points that the camera sees to a point light; any hit.
    Shadow,
    /// The segments of `Shadow` in the opposite direction, from the light; any hit.
    Light,
    /// From the points that the camera sees, cosine-distributed about the normal; closest hit.
    Diffuse,
    /// Like `Diffuse`, but from the points rounded to f32, which lie on the surface or next to it.
    Surface,
    /// From the camera toward the midpoint of an edge of each visible triangle; closest hit.
    Edges,
    /// From the camera toward a corner of each visible triangle; closest hit.
    Vertices,
    /// From an orthographic camera; closest hit.
    Parallel,
    /// From the points that the camera sees toward the sun; any hit.
    Sun,
    /// From the points that the camera sees, sixteen rays per point around the normal, each no
    /// longer than a tenth of the scene's size; any hit.
    Occlusion,
    /// From the moving origin of a scanner on a vehicle; closest hit.
    Lidar,
    /// From outside the scene along z, in planes that may contain walls; closest hit.
    Walls,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::Light => "light",
            Self::Diffuse => "diffuse",
            Self::Surface => "surface",
            Self::Edges => "edges",
            Self::Vertices => "vertices",
            Self::Parallel => "parallel",
            Self::Sun => "sun",
            Self::Occlusion => "occlusion",
            Self::Lidar => "lidar",
            Self::Walls => "walls",
        }
    }

    pub fn question(self) -> Question {
        Question {
            any: matches!(self, Self::Shadow | Self::Light | Self::Sun | Self::Occlusion),
            coherent: !matches!(self, Self::Diffuse | Self::Surface | Self::Occlusion),
        }
    }
}

/// The order of the pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Order {
    /// Nested tiles: each aligned run of 4, 16, 64 and so on pixels forms a square.
    Tiles,
    /// Row by row.
    Rows,
    /// In random order.
    Shuffled,
}

impl Order {
    pub fn name(self) -> &'static str {
        match self {
            Self::Tiles => "tiles",
            Self::Rows => "rows",
            Self::Shuffled => "shuffled",
        }
    }
}

/// Returns all rays of a kind for an image of `size * size` pixels. `size` must be a power of two.
pub fn rays(kind: Kind, scene: &Scene, bvh: &Bvh, size: u32, order: Order) -> Vec<Ray> {
    let mut rays: Vec<Ray> = lines(kind, scene, bvh, size, order).iter().map(rounded).collect();
    if order == Order::Shuffled {
        for i in (1..rays.len()).rev() {
            let share = 0.5 + 0.5 * random([i as u64, 7, 7]);
            rays.swap(i, ((share * (i + 1) as f64) as usize).min(i));
        }
    }
    rays
}

/// Rounds a ray to f32.
pub fn rounded(ray: &Ray64) -> Ray {
    let rounded = |v: [f64; 3]| v.map(|x| x as f32);
    let [t_min, t_max] = [ray.t_min, ray.t_max].map(|t| t as f32);
    Ray::new(rounded(ray.origin), rounded(ray.dir)).between(t_min, t_max)
}

/// Widens a ray to f64.
pub fn widened(ray: &Ray) -> Ray64 {
    let [t_min, t_max] = [ray.t_min, ray.t_max].map(f64::from);
    Ray64::new(ray.origin.map(f64::from), ray.dir.map(f64::from)).between(t_min, t_max)
}

/// Returns the column and row of a pixel.
fn pixel(i: u32, size: u32, order: Order) -> (u32, u32) {
    match order {
        Order::Tiles => (every_other_bit(i), every_other_bit(i >> 1)),
        Order::Rows | Order::Shuffled => (i % size, i / size),
    }
}

/// Returns a camera's primary rays.
pub fn primary(camera: &Camera, size: u32, order: Order) -> Vec<Ray> {
    let ray = |i| {
        let (x, y) = pixel(i, size, order);
        camera.ray(x, y, size, size)
    };
    (0..size * size).map(ray).collect()
}

/// Returns the rays of [`rays()`] before they are rounded to f32 and shuffled. Unrounded rays aimed
/// at edges and vertices pass closer to their targets.
pub fn lines(kind: Kind, scene: &Scene, bvh: &Bvh, size: u32, order: Order) -> Vec<Ray64> {
    let primary = primary(&scene.camera, size, order);
    match kind {
        Kind::Primary => return primary.iter().map(widened).collect(),
        Kind::Parallel => {
            let parallel = parallel(scene, size);
            return (0..size * size).map(|i| parallel(pixel(i, size, order))).collect();
        }
        Kind::Lidar => return (0..size * size).map(lidar(scene)).collect(),
        Kind::Walls => {
            let walls = walls(scene, size);
            return (0..size * size).map(|i| walls(pixel(i, size, order))).collect();
        }
        _ => (),
    }
    let hits = bvh.query().mode(Mode::certified()).closest_batch(&primary);

    // Start a hundred-thousandth of the scene's size away from the surface, so that a ray does not
    // hit the triangle that it starts on.
    let size_of_scene = length(extent(scene));
    let away = 1e-5 * size_of_scene;
    let seen = primary.iter().zip(&hits).filter(|(_, hit)| hit.is_hit());
    // For occlusion, sixteen consecutive rays start at every sixteenth point.
    let step = if kind == Kind::Occlusion { 16 } else { 1 };
    let seen = seen.step_by(step).flat_map(|seen| std::iter::repeat_n(seen, step));
    seen.enumerate()
        .map(|(i, (ray, hit))| {
            let [c1, c2, c3] = scene.mesh.corners(hit.triangle as usize).map(|p| p.map(f64::from));
            let normal = unit(cross(sub(c2, c1), sub(c3, c1)));
            // Orient the normal toward the camera.
            let normal =
                normal.map(|x| if dot(normal, ray.dir.map(f64::from)) > 0.0 { -x } else { x });
            let point = hit_point(ray, hit);
            let away = if kind == Kind::Surface { 0.0 } else { away };
            let origin = [0, 1, 2].map(|k| (point[k] + away * normal[k]) as f32);
            let corner = [c1, c2, c3][i % 3];
            let at = |p: [f64; 3]| {
                let from = ray.origin.map(f64::from);
                Ray64::new(from, sub(p, from))
            };
            let light = scene.light.origin(point);
            match kind {
                Kind::Edges => {
                    let next = [c2, c3, c1][i % 3];
                    at([0, 1, 2].map(|k| 0.5 * (corner[k] + next[k])))
                }
                Kind::Vertices => at(corner),
                Kind::Sun => {
                    let dir = unit([0.35, 0.8, 0.45]).map(|x| x as f32);
                    widened(&Ray::new(origin, dir))
                }
                Kind::Primary
                | Kind::Diffuse
                | Kind::Surface
                | Kind::Occlusion
                | Kind::Parallel
                | Kind::Lidar
                | Kind::Walls => {
                    let far =
                        if kind == Kind::Occlusion { 0.1 * size_of_scene } else { f64::INFINITY };
                    // Aim at a point on the unit sphere around the tip of the normal.
                    let d = direction(i as u64);
                    let dir = unit([0, 1, 2].map(|k| normal[k] + (1.0 - 1e-9) * d[k]));
                    widened(&Ray::new(origin, dir.map(|x| x as f32)).between(0.0, far as f32))
                }
                Kind::Shadow => {
                    let dir = [0, 1, 2].map(|k| light[k] - origin[k]);
                    widened(&Ray::new(origin, dir).between(0.0, 1.0))
                }
                Kind::Light => {
                    let dir = [0, 1, 2].map(|k| origin[k] - light[k]);
                    widened(&Ray::new(light, dir).between(0.0, 1.0))
                }
            }
        })
        .collect()
}

/// Returns the size of the scene along each axis.
fn extent(scene: &Scene) -> [f64; 3] {
    let bounds = scene.mesh.bounds();
    bounds.map_or([0.0; 3], |b| [0, 1, 2].map(|k| f64::from(b.max[k] - b.min[k])))
}

/// Returns a function that creates the ray for each pixel of an orthographic camera. Each ray
/// starts in a plane through the camera and points in the viewing direction.
fn parallel(scene: &Scene, size: u32) -> impl Fn((u32, u32)) -> Ray64 {
    let middle = scene.camera.ray(0, 0, 1, 1);
    let ahead = unit(middle.dir.map(f64::from));
    let side = unit(cross(ahead, [0.31, 0.9, 0.3]));
    let up = cross(side, ahead);
    let pixel = 0.7 * length(extent(scene)) / f64::from(size);
    move |(x, y)| {
        let [a, b] = [x, y].map(|k| pixel * (f64::from(k) - 0.5 * f64::from(size)));
        let from =
            [0, 1, 2].map(|k| (f64::from(middle.origin[k]) + a * side[k] - b * up[k]) as f32);
        widened(&Ray::new(from, ahead.map(|x| x as f32)))
    }
}

/// Returns a function that creates each ray of a scanner with 64 beams, one above the other, and
/// 1024 steps per turn. During a turn, the scanner moves by a hundredth of the scene's size.
fn lidar(scene: &Scene) -> impl Fn(u32) -> Ray64 {
    let (start, extent) = (scene.camera.ray(0, 0, 1, 1).origin, extent(scene));
    move |i| {
        let (beam, turns) = (f64::from(i % 64), f64::from(i / 64) / 1024.0);
        let (sin, cos) = (std::f64::consts::TAU * turns).sin_cos();
        let from = [0, 1, 2].map(|k| (f64::from(start[k]) + 0.01 * turns * extent[k]) as f32);
        let dir = [cos, (beam / 64.0 - 0.7) * 0.6, sin];
        widened(&Ray::new(from, dir.map(|x| x as f32)))
    }
}

/// Returns a function that creates a ray along z for each pixel, starting in front of the scene.
/// The pixel's column selects a vertex, and the ray has the same x as the vertex, so it lies within
/// any wall at that x. Each ray has a different height.
fn walls(scene: &Scene, size: u32) -> impl Fn((u32, u32)) -> Ray64 {
    let mut across: Vec<f32> = scene.mesh.positions.iter().map(|p| p[0]).collect();
    across.sort_by(f32::total_cmp);
    across.dedup();
    let (extent, low) = (extent(scene), scene.mesh.bounds().map_or([0.0; 3], |b| b.min));
    move |(x, y)| {
        let [column, row] = [x, y].map(|k| f64::from(k) / f64::from(size));
        let wall = across.get((column * across.len() as f64) as usize).copied().unwrap_or(0.0);
        let up = f64::from(low[1]) + extent[1] * (row + (column + 0.37) / f64::from(size));
        let before = low[2] - extent[2] as f32;
        widened(&Ray::new([wall, up as f32, before], [0.0, 0.0, 1.0]))
    }
}

/// Returns a random direction of length 1: a point in the unit ball, normalized. The same `i`
/// always yields the same direction.
pub fn direction(i: u64) -> [f64; 3] {
    for k in 0.. {
        let p = [0, 1, 2].map(|axis| random([i, k, axis]));
        if (1e-4..=1.0).contains(&dot(p, p)) {
            return unit(p);
        }
    }
    unreachable!("at least one random point is in the ball")
}

/// Packs bits 0, 2, 4, ... into adjacent positions.
fn every_other_bit(i: u32) -> u32 {
    (0..16).fold(0, |sum, k| sum | (i >> (2 * k) & 1) << k)
}

pub fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

pub fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = length(a);
    a.map(|x| x / length)
}
