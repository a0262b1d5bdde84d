//! Computes the model view: traces a model with `exact` through a hierarchy, and with the other
//! methods for comparison.

use std::path::Path;

use intertri::{Hit, Ray, RayPacket, Triangle, TriangleOf};
use intertri_scene::{Scene, read};
use intertri_trace::Bvh;

use crate::fan::{CLASSES, Class};
use crate::input::{Numbers, along, single};
use crate::methods::{METHODS, Pairs, Sink};
use crate::tiles::{SIDE, View, ball, by_tile};

/// The maximum number of pixels along a side.
const MAX_SIZE: usize = 2048;

/// A model and its view.
pub struct Model {
    /// The triangles as read from the file.
    original: Vec<Triangle>,
    /// The triangles moved by the offset and rounded to f32.
    triangles: Vec<Triangle>,
    offset: [f64; 3],
    bvh: Bvh,
    middle: [f64; 3],
    radius: f64,
    look: Option<Look>,
}

/// A view, the hit at each pixel, and the triangles of each tile, which are listed on first use.
struct Look {
    view: View,
    hits: Vec<Hit>,
    tiles: Option<Vec<Vec<u32>>>,
}

impl Model {
    /// Reads a model file in OBJ, PLY, STL, glTF, or GLB format, optionally compressed with gzip.
    ///
    /// # Errors
    /// Returns a one-line description of the error if the file is not a valid model.
    pub fn from_file(name: &str, bytes: &[u8]) -> Result<Self, String> {
        let mesh = read(Path::new(name), bytes).map_err(|e| e.to_string())?;
        Self::new(mesh.to_triangles())
    }

    /// Loads the built-in scene.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    pub fn built_in() -> Result<Self, String> {
        Self::new(Scene::built_in().mesh.to_triangles())
    }

    fn new(original: Vec<Triangle>) -> Result<Self, String> {
        let bvh = Bvh::new(&original).map_err(|e| e.to_string())?;
        let (middle, radius) = ball(&original);
        let triangles = original.clone();
        Ok(Self { original, triangles, offset: [0.0; 3], bvh, middle, radius, look: None })
    }

    /// Returns the number of triangles.
    pub fn len(&self) -> usize {
        self.original.len()
    }

    /// Returns whether there are no triangles.
    pub fn is_empty(&self) -> bool {
        self.original.is_empty()
    }

    /// Sets the view from a list of numbers, in this order: the width and height in pixels, the
    /// width of a pixel at distance 1, the shift of the image's centre (2), the model's offset in
    /// units of its radius (3), the right, up, and forward directions (9), and the distance of the
    /// eye in units of the radius. Returns false if the numbers do not describe a view.
    pub fn look(&mut self, numbers: &[f64]) -> bool {
        self.try_look(numbers).is_some()
    }

    fn try_look(&mut self, numbers: &[f64]) -> Option<()> {
        let mut numbers = Numbers::new(numbers);
        let size = [numbers.count(MAX_SIZE)?, numbers.count(MAX_SIZE)?];
        let (pixel, shift) = (numbers.next()?, [numbers.next()?, numbers.next()?]);
        let offset = numbers.vector()?;
        let axes = [numbers.vector()?, numbers.vector()?, numbers.vector()?];
        let distance = numbers.next()?;
        if pixel <= 0.0 {
            return None;
        }
        let by = offset.map(|x| x * self.radius);
        if offset != self.offset {
            let moved = |p: [f32; 3]| single([0, 1, 2].map(|k| f64::from(p[k]) + by[k]));
            self.triangles = self.original.iter().map(|t| Triangle(t.0.map(moved))).collect();
            self.bvh = Bvh::new(&self.triangles).ok()?;
            self.offset = offset;
        }
        let eye = [0, 1, 2].map(|k| self.middle[k] + by[k] - distance * self.radius * axes[2][k]);
        let view = View { size, eye: single(eye), axes, pixel, shift };
        self.look = Some(Look { view, hits: vec![Hit::MISS; size[0] * size[1]], tiles: None });
        Some(())
    }

    /// Traces rows of the image with `exact`. Returns one byte for each pixel: 0 for a miss, and 1
    /// to 255 for a hit, where a larger value means that the triangle faces the ray more directly.
    pub fn trace(&mut self, rows: std::ops::Range<usize>) -> Vec<u8> {
        let Some(look) = &mut self.look else { return vec![] };
        let [width, height] = look.view.size;
        let rows = rows.start.min(height)..rows.end.min(height);
        let pixels = rows.start * width..rows.end.max(rows.start) * width;
        let rays: Vec<Ray> =
            pixels.clone().map(|i| ray(&look.view, i % width, i / width)).collect();
        let hits = &mut look.hits[pixels];
        self.bvh.query().closest_batch_into(&rays, hits);
        let shade = |(ray, hit): (&Ray, &Hit)| match hit.some() {
            Some(hit) => facing(&self.triangles[hit.triangle as usize], ray),
            None => 0,
        };
        rays.iter().zip(&*hits).map(shade).collect()
    }

    /// Runs a method on rows of tiles, which are eight pixels tall, and compares its hits with
    /// those of [`Model::trace`]. Returns the number of pixels in each class, and the class of each
    /// pixel, row by row.
    ///
    /// # Panics
    /// Panics if the method does not exist.
    pub fn compare(
        &mut self,
        method: usize,
        tile_rows: std::ops::Range<usize>,
    ) -> ([u32; CLASSES], Vec<u8>) {
        let mut counts = [0; CLASSES];
        let Some(look) = &mut self.look else { return (counts, vec![]) };
        let Look { view, hits, tiles } = look;
        let tiles = tiles.get_or_insert_with(|| by_tile(view, &self.triangles));
        let [width, height] = view.size;
        let columns = width.div_ceil(SIDE);
        let rows = tile_rows.start * SIDE..(tile_rows.end * SIDE).min(height);
        let mut classes = vec![0; rows.len() * width];
        for tile_row in tile_rows {
            for column in 0..columns {
                let Some(seen) = tiles.get(tile_row * columns + column) else { break };
                let triangles: Vec<Triangle> =
                    seen.iter().map(|&i| self.triangles[i as usize]).collect();
                let (x, y) = (column * SIDE, tile_row * SIDE);
                let (across, down) = (SIDE.min(width - x), SIDE.min(height - y));
                let row = |j: usize| -> Vec<Ray> {
                    (0..across).map(|i| ray(view, x + i, y + j)).collect()
                };
                let packets: Vec<_> = (0..down).map(|j| RayPacket::new(&row(j))).collect();
                let mut closest = Closest::new(packets.len());
                let pairs = Pairs { packets: &packets, triangles: &triangles, closest: true };
                METHODS[method].run(pairs, &mut closest);
                for j in 0..down {
                    for i in 0..across {
                        let found = closest.triangle[j][i].map(|k| seen[k as usize]);
                        let truth = hits[(y + j) * width + x + i].some().map(|hit| hit.triangle);
                        let class = classify(found, truth);
                        counts[class as usize] += 1;
                        classes[(y + j - rows.start) * width + x + i] = class as u8;
                    }
                }
            }
        }
        (counts, classes)
    }
}

/// Classifies a pixel. Here, `Double` means that the method hits a triangle where `exact` misses.
fn classify(found: Option<u32>, truth: Option<u32>) -> Class {
    match (found, truth) {
        (None, None) => Class::Background,
        _ if found == truth => Class::Right,
        (None, Some(_)) => Class::Leak,
        (Some(_), None) => Class::Double,
        (Some(_), Some(_)) => Class::Wrong,
    }
}

/// Keeps the closest hit of each ray. If two hits have the same t, the first one wins.
struct Closest {
    t: Vec<[f64; 8]>,
    triangle: Vec<[Option<u32>; 8]>,
}

impl Closest {
    fn new(packets: usize) -> Self {
        Self { t: vec![[f64::INFINITY; 8]; packets], triangle: vec![[None; 8]; packets] }
    }
}

impl Sink for Closest {
    #[inline]
    fn hits(&mut self, packet: usize, bits: u32, triangle: usize, t: &[f64; 8]) {
        for lane in (0..8).filter(|lane| bits >> lane & 1 != 0) {
            if t[lane] < self.t[packet][lane] {
                self.t[packet][lane] = t[lane];
                self.triangle[packet][lane] = Some(triangle as u32);
            }
        }
    }
}

/// Returns the ray through a pixel's centre.
fn ray(view: &View, column: usize, row: usize) -> Ray {
    let [x, y] = view.at(column, row);
    let [right, up, forward] = view.axes;
    Ray::new(view.eye, single(along(forward, [right, up], x, y)))
}

/// Returns how directly a triangle faces a ray, from 1 (edge-on) to 255 (perpendicular).
fn facing(TriangleOf(corners): &Triangle, ray: &Ray) -> u8 {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let edge = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] - a[k]);
    let ([ux, uy, uz], [vx, vy, vz]) = (edge(b), edge(c));
    let n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    let d = ray.dir.map(f64::from);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cosine = dot(n, d).abs() / (dot(n, n) * dot(d, d)).sqrt();
    (1.0 + 254.0 * cosine) as u8
}

#[cfg(test)]
mod tests {
    use super::Model;
    use crate::methods::METHODS;

    /// The per-tile triangle lists lose no hit: with them, `exact` finds the same hits as with the
    /// hierarchy, at several zoom levels, near the origin and far from it. Other methods find
    /// different hits, which shows that this test can detect an error.
    #[test]
    fn tiles_show_what_the_hierarchy_shows() {
        let mut model = Model::built_in().unwrap();
        let mut wrong = [0; METHODS.len()];
        for away in [0.0, 1e4] {
            for pixel in [2e-2, 3e-3, 2e-6] {
                for forward in [[0.6, 0.0, 0.8], [0.0, -0.6, 0.8], [0.48, -0.64, 0.6]] {
                    let [x, y, z]: [f64; 3] = forward;
                    let across = (x * x + z * z).sqrt();
                    let right = [z / across, 0.0, -x / across];
                    let up = [-x * y / across, across, -z * y / across];
                    let mut numbers = vec![72.0, 40.0, pixel, 1e-2, 0.0, away, away, away];
                    numbers.extend([right, up, forward].concat());
                    numbers.push(4.0);
                    assert!(model.look(&numbers));
                    let seen = model.trace(0..40);
                    assert!(seen.iter().any(|&shade| shade > 0));
                    for (method, wrong) in wrong.iter_mut().enumerate() {
                        let (counts, classes) = model.compare(method, 0..5);
                        assert_eq!(counts.iter().sum::<u32>(), 72 * 40);
                        assert_eq!(classes.len(), 72 * 40);
                        *wrong += counts[2..].iter().sum::<u32>();
                    }
                }
            }
        }
        assert_eq!(wrong[METHODS.len() - 1], 0);
        assert!(wrong[0] > 0, "{wrong:?}");
    }

    #[test]
    fn what_is_no_view_is_refused() {
        let mut model = Model::built_in().unwrap();
        let good = [
            8.0, 8.0, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0,
            4.0,
        ];
        assert!(model.look(&good));
        for (i, bad) in [(0, 0.0), (0, 1e9), (1, 2.5), (2, 0.0), (2, f64::NAN), (17, f64::INFINITY)]
        {
            let mut numbers = good;
            numbers[i] = bad;
            assert!(!model.look(&numbers), "{i} {bad}");
        }
        assert!(!model.look(&good[..17]));
        assert!(Model::from_file("a.obj", b"f 1 2 3\n").is_err());
    }
}
