//! Measures the properties of a scene as seen by a camera.

use intertri::{Hit, Triangle, TriangleOf};
use serde::Serialize;

use super::camera::PinholeCamera;
use super::vector::{Vec3d, length, vector};

/// The measured properties of a scene. Lengths are in scene units. A value is 0 if it could not be
/// measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Needs {
    /// The number of triangles.
    pub triangles: usize,
    /// The number of triangles that are degenerate or have a coordinate that is not finite.
    pub degenerate: usize,
    /// The diagonal of the scene's bounding box.
    pub extent: f64,
    /// The largest absolute coordinate.
    pub offset: f64,
    /// The length of the shortest side of any nondegenerate triangle.
    pub shortest_edge: f64,
    /// The smallest altitude of any nondegenerate triangle.
    pub smallest_altitude: f64,
    /// The number of pixels.
    pub pixels: u64,
    /// The number of pixels whose ray hits a triangle.
    pub hits: u64,
    /// The distance to the nearest visible surface.
    pub nearest: f64,
    /// The distance to the farthest visible surface.
    pub farthest: f64,
    /// The width of a pixel at the nearest surface.
    pub pixel: f64,
    /// The share of hits where the ray meets the surface at an angle of less than six degrees.
    pub grazing: f64,
    /// The smallest `|nrm · dir|` of any hit. `Threshold` must not exceed it.
    pub smallest_slope: f64,
    /// The smallest t of any hit. `Threshold` must be below it.
    pub smallest_t: f64,
    /// The number of hits that the default `Threshold` loses.
    pub lost: u64,
    /// A `Threshold` that loses no hits, at least a thousand times smaller than the smallest slope
    /// and t: the default if it is that small; otherwise a power of ten, or 0.
    pub threshold: f64,
}

/// Measures a scene. `seen` contains the hits of the pixels, row by row, computed with a threshold
/// of 0; `threshold` is the default threshold.
///
/// # Panics
/// Panics if a hit's triangle index is out of range.
pub fn needs(
    triangles: &[Triangle],
    camera: &PinholeCamera<'_>,
    seen: &[Hit],
    threshold: f64,
) -> Needs {
    let mut needs = Needs {
        triangles: triangles.len(),
        pixels: seen.len() as u64,
        shortest_edge: f64::INFINITY,
        smallest_altitude: f64::INFINITY,
        nearest: f64::INFINITY,
        smallest_slope: f64::INFINITY,
        smallest_t: f64::INFINITY,
        ..Needs::default()
    };

    measure_model(&mut needs, triangles);
    measure_picture(&mut needs, triangles, camera, seen, threshold);
    needs.threshold = threshold_below(needs.smallest_slope.min(needs.smallest_t), threshold);
    for number in [
        &mut needs.shortest_edge,
        &mut needs.smallest_altitude,
        &mut needs.nearest,
        &mut needs.smallest_slope,
        &mut needs.smallest_t,
    ] {
        if number.is_infinite() {
            *number = 0.0;
        }
    }
    needs
}

/// Measures the triangles, visible or not.
fn measure_model(needs: &mut Needs, triangles: &[Triangle]) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for TriangleOf(corners) in triangles {
        let [a, b, c] = corners.map(vector);
        let sides = [b - a, c - b, a - c].map(length);
        let area = length((b - a).cross(c - a));
        if !(area > 0.0 && area.is_finite()) {
            needs.degenerate += 1;
            continue;
        }
        for corner in corners.map(|c| c.map(f64::from)) {
            for axis in 0..3 {
                low[axis] = low[axis].min(corner[axis]);
                high[axis] = high[axis].max(corner[axis]);
                needs.offset = needs.offset.max(corner[axis].abs());
            }
        }
        let [short, long] = [sides.iter().fold(f64::INFINITY, |a, &b| a.min(b)), {
            sides.iter().fold(0.0, |a: f64, &b| a.max(b))
        }];
        needs.shortest_edge = needs.shortest_edge.min(short);
        needs.smallest_altitude = needs.smallest_altitude.min(area / long);
    }
    if low[0] <= high[0] {
        needs.extent = length(Vec3d::splat(high) - Vec3d::splat(low));
    }
}

/// Measures the hits of the pixels.
fn measure_picture(
    needs: &mut Needs,
    triangles: &[Triangle],
    camera: &PinholeCamera<'_>,
    seen: &[Hit],
    threshold: f64,
) {
    let mut grazing = 0;
    for (i, hit) in seen.iter().enumerate().filter(|(_, hit)| hit.is_hit()) {
        let width = camera.size.0 as usize;
        let dir = vector((camera.ray)((i % width) as u32, (i / width) as u32).dir);
        let [a, b, c] = triangles[hit.triangle as usize].0.map(vector);
        let normal = (b - a).cross(c - a);
        let slope = normal.dot(dir).abs() / length(normal);
        let distance = hit.t * length(dir);
        needs.hits += 1;
        needs.nearest = needs.nearest.min(distance);
        needs.farthest = needs.farthest.max(distance);
        needs.smallest_slope = needs.smallest_slope.min(slope);
        needs.smallest_t = needs.smallest_t.min(hit.t);
        needs.lost += u64::from(slope < threshold || hit.t <= threshold);
        grazing += u64::from(slope < 0.1 * length(dir));
    }
    if needs.hits > 0 {
        needs.pixel = needs.nearest * camera.pixel();
        needs.grazing = grazing as f64 / needs.hits as f64;
    }
}

/// Returns the threshold to use if no hit has a slope or a t below `smallest`.
fn threshold_below(smallest: f64, default: f64) -> f64 {
    match smallest / 1000.0 {
        most if most >= default => default,
        most if most < 1e-300 => 0.0,
        most => 10.0_f64.powi(most.log10().floor() as i32),
    }
}
