//! Generates scenes of instances: a field of bunnies, and a kitchen split into up to five hundred
//! objects.

use std::sync::Arc;

use intertri::{Ray, Triangle64};
use intertri_scene::{Camera, Light, Mesh, hit_point};
use intertri_trace::SceneSnapshot;

use crate::rays::{Kind, Order, cross, direction, dot, primary, sub, unit, widened};
use crate::scenes::{random, scene};

/// The maximum number of objects in the kitchen.
const OBJECTS: usize = 500;

/// The distance between bunnies, in multiples of their size.
const APART: f64 = 1.1;

/// The meshes, and the placement of each instance.
pub struct Forest {
    pub meshes: Vec<Mesh>,
    /// The mesh index and the matrix of each instance.
    pub placed: Vec<(usize, [f64; 12])>,
    /// The index of each instance's first triangle in the flattened scene.
    pub firsts: Arc<[u32]>,
    camera: Camera,
    light: [f32; 3],
}

impl Forest {
    pub fn by_name(name: &str) -> Result<Self, String> {
        let count = name.strip_prefix("bunnies-").and_then(|count| count.parse().ok());
        match (name, count) {
            ("kitchen", _) => Self::kitchen(),
            (_, Some(count)) => Self::bunnies(count, 0),
            _ => Err(format!("{name}: no such scene; use `kitchen` or `bunnies-N`")),
        }
    }

    fn new(
        meshes: Vec<Mesh>,
        placed: Vec<(usize, [f64; 12])>,
        camera: Camera,
        light: [f32; 3],
    ) -> Self {
        let counts = placed.iter().map(|&(mesh, _)| meshes[mesh].triangles.len() as u32);
        let firsts = counts.scan(0, |next, count| {
            let first = *next;
            *next += count;
            Some(first)
        });
        let firsts = firsts.collect();
        Self { meshes, placed, firsts, camera, light }
    }

    /// Places bunnies in a square, each with its own rotation and size.
    pub fn bunnies(count: usize, seed: u64) -> Result<Self, String> {
        let mesh = scene("bunny")?.mesh;
        let bounds = mesh.bounds().ok_or("the bunny is empty")?;
        let middle = [0, 1, 2].map(|k| f64::from(bounds.min[k] + bounds.max[k]) / 2.0);
        let size = (0..3).map(|k| f64::from(bounds.max[k] - bounds.min[k])).fold(0.0, f64::max);
        let (side, apart) = ((count as f64).sqrt().ceil(), APART * size);
        let place = |i: usize| {
            let number = |k| random([i as u64, k, seed]);
            let [x, z] = [i as f64 % side, (i as f64 / side).floor()].map(|x| x * apart);
            turned([3.0 * number(0), 0.3 * number(1)], 0.8 + 0.2 * number(2), middle, [x, 0.0, z])
        };
        let placed = (0..count).map(|i| (0, place(i))).collect();
        let width = (side - 1.0) * apart;
        let at = |x: f64, y: f64, z: f64| [x * width, y * size, z * width].map(|x| x as f32);
        let camera = Camera::new(at(0.5, 6.0, -0.1), at(0.5, 0.0, 0.3), Camera::UP, 50.0);
        let camera = camera.map_err(|e| e.to_string())?;
        Ok(Self::new(vec![mesh], placed, camera, at(0.3, 30.0, 0.2)))
    }

    /// Returns the kitchen, seen from inside. Its parts are grouped into objects, each of which is
    /// stored in its own rotated frame.
    fn kitchen() -> Result<Self, String> {
        let kitchen = scene("kitchen")?;
        let Light::Point { position } = kitchen.light else {
            return Err("the kitchen has no lamp".into());
        };
        let (mut meshes, mut placed) = (Vec::new(), Vec::new());
        for (i, object) in objects(&kitchen.mesh).into_iter().enumerate() {
            let bounds = object.bounds().ok_or("an object is empty")?;
            let middle = [0, 1, 2].map(|k| f64::from(bounds.min[k] + bounds.max[k]) / 2.0);
            let number = |k| random([i as u64, k, 0]);
            let matrix = turned([3.0 * number(0), 0.0], 1.0, [0.0; 3], middle);
            // The inverse rotation, from the room into the object's own frame.
            let own = |p: &[f32; 3]| {
                let q = [0, 1, 2].map(|k| f64::from(p[k]) - middle[k]);
                [0, 1, 2].map(|k| {
                    ((matrix[k] * q[0] + matrix[k + 4] * q[1]) + matrix[k + 8] * q[2]) as f32
                })
            };
            let positions = object.positions.iter().map(own).collect();
            meshes.push(Mesh { positions, ..object });
            placed.push((i, matrix));
        }
        Ok(Self::new(meshes, placed, kitchen.camera, position))
    }

    /// Returns the number of triangles in the flattened scene.
    pub fn triangles(&self) -> usize {
        self.placed.iter().map(|&(mesh, _)| self.meshes[mesh].triangles.len()).sum()
    }

    /// Returns a triangle of an instance, in world space.
    fn triangle(&self, instance: usize, triangle: usize) -> Triangle64 {
        let (mesh, m) = &self.placed[instance];
        Triangle64(self.meshes[*mesh].corners(triangle).map(|corner| {
            let [x, y, z] = corner.map(f64::from);
            [0, 4, 8].map(|i| ((m[i] * x + m[i + 1] * y) + m[i + 2] * z) + m[i + 3])
        }))
    }

    /// Returns all triangles in world space.
    pub fn flattened(&self) -> Vec<Triangle64> {
        let instances = (0..self.placed.len()).zip(&self.placed);
        let of = |(i, (mesh, _)): (usize, &(usize, _))| {
            (0..self.meshes[*mesh].triangles.len()).map(move |triangle| self.triangle(i, triangle))
        };
        instances.flat_map(of).collect()
    }

    /// Returns the rays of one kind.
    pub fn rays(
        &self,
        kind: Kind,
        scene: &SceneSnapshot,
        size: u32,
        order: Order,
    ) -> Result<Vec<Ray>, String> {
        let primary = primary(&self.camera, size, order);
        if kind == Kind::Primary {
            return Ok(primary);
        }
        let lines: Vec<_> = primary.iter().map(widened).collect();
        let hits = scene.closest_batch(&lines);
        let mut rays = Vec::new();
        for ((i, ray), hit) in (0..).zip(&primary).zip(hits).filter(|(_, hit)| hit.is_hit()) {
            let Triangle64([a, b, c]) =
                self.triangle(hit.instance.index(), hit.hit.triangle as usize);
            let (ab, ac) = (sub(b, a), sub(c, a));
            let away = 1e-3 * dot(ab, ab).max(dot(ac, ac)).sqrt();
            let normal = unit(cross(ab, ac));
            let is_behind = dot(normal, ray.dir.map(f64::from)) > 0.0;
            let normal = if is_behind { normal.map(|x| -x) } else { normal };
            let point = hit_point(ray, &hit.hit);
            let origin = [0, 1, 2].map(|k| (point[k] + away * normal[k]) as f32);
            rays.push(match kind {
                Kind::Shadow => {
                    let dir = [0, 1, 2].map(|k| self.light[k] - origin[k]);
                    Ray::new(origin, dir).between(0.0, 1.0)
                }
                Kind::Diffuse => {
                    let to = direction(i);
                    let dir = unit([0, 1, 2].map(|k| normal[k] + (1.0 - 1e-9) * to[k]));
                    Ray::new(origin, dir.map(|x| x as f32))
                }
                _ => return Err(format!("{}: use primary, shadow or diffuse", kind.name())),
            });
        }
        Ok(rays)
    }
}

/// Returns a matrix that moves a point to the origin, rotates about y and x, scales, and moves the
/// point to its destination.
fn turned([a, b]: [f64; 2], size: f64, from: [f64; 3], to: [f64; 3]) -> [f64; 12] {
    let ((s, c), (p, q)) = (a.sin_cos(), b.sin_cos());
    let rows = [[c, 0.0, s], [p * s, q, -p * c], [-q * s, p, q * c]];
    let rows = rows.map(|row| row.map(|x| x * size));
    let mut matrix = [0.0; 12];
    for (k, row) in rows.iter().enumerate() {
        matrix[4 * k..4 * k + 3].copy_from_slice(row);
        matrix[4 * k + 3] = to[k] - dot(*row, from);
    }
    matrix
}

/// Groups the connected parts of a mesh, in file order, into objects with roughly equal numbers of
/// triangles.
fn objects(mesh: &Mesh) -> Vec<Mesh> {
    let mut parts: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let root = |parts: &mut Vec<u32>, mut i: u32| {
        while parts[i as usize] != i {
            parts[i as usize] = parts[parts[i as usize] as usize];
            i = parts[i as usize];
        }
        i
    };
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| root(&mut parts, i));
        parts[b as usize] = a;
        let c = root(&mut parts, c);
        parts[c as usize] = root(&mut parts, a);
    }
    let mut of_parts: Vec<(u32, [u32; 3])> =
        mesh.triangles.iter().map(|&triangle| (root(&mut parts, triangle[0]), triangle)).collect();
    of_parts.sort_by_key(|&(part, _)| part);
    let each = mesh.triangles.len().div_ceil(OBJECTS);
    let mut objects: Vec<Mesh> = Vec::new();
    let mut before = None;
    for (part, triangle) in of_parts {
        let is_full = objects.last().is_none_or(|object| object.triangles.len() >= each);
        if is_full && before != Some(part) {
            objects.push(Mesh::default());
        }
        before = Some(part);
        if let Some(Mesh { positions, triangles, .. }) = objects.last_mut() {
            let first = positions.len() as u32;
            positions.extend(triangle.map(|i| mesh.positions[i as usize]));
            triangles.push([first, first + 1, first + 2]);
        }
    }
    objects
}
