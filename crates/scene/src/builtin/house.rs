//! The built-in house, at the UTM coordinates that surveyors use: metres from a meridian and the
//! equator.

use glam::{DQuat, DVec3};

use crate::camera::Camera;
use crate::light::Light;
use crate::mesh::{Mesh, Part};
use crate::scene::Scene;

/// The easting, northing, and height of a corner of the house, in metres.
const CORNER: DVec3 = DVec3::new(148_376.213, 528_980.447, 31.02);
/// The rotation of the house relative to the grid, in radians.
const TURN: f64 = 0.43;

const GRASS: [f32; 3] = [0.34, 0.42, 0.22];
const WALL: [f32; 3] = [0.80, 0.74, 0.62];
const ROOF: [f32; 3] = [0.52, 0.22, 0.16];
const STONE: [f32; 3] = [0.50, 0.49, 0.47];
const WOOD: [f32; 3] = [0.62, 0.47, 0.30];

impl Scene<f64> {
    /// Returns a house with a fence at UTM coordinates, about 148 km east and 529 km north of the
    /// origin, with z up. At that distance, adjacent f32 values are 1.6 cm apart eastward and 6.3
    /// cm apart northward. If the coordinates are rounded to f32, walls warp, palings vanish, and
    /// rays that should start on a wall start in front of or behind the wall.
    ///
    /// The scene includes a camera and a light, and every part is closed. Every call returns the
    /// same bits.
    pub fn house() -> Self {
        house()
    }
}

fn house() -> Scene<f64> {
    let mut house = House::default();
    house.part(GRASS);
    house.block([-16.0, -14.0, -0.4], [20.0, 18.0, 0.0]);

    // The front has a door and two windows, and one end wall has a window.
    house.part(WALL);
    let front = [
        (0.0, 1.2, 0.0, 2.8),
        (1.2, 2.6, 0.0, 0.9),
        (1.2, 2.6, 2.1, 2.8),
        (2.6, 3.4, 0.0, 2.8),
        (3.4, 4.5, 2.1, 2.8),
        (4.5, 5.4, 0.0, 2.8),
        (5.4, 6.8, 0.0, 0.9),
        (5.4, 6.8, 2.1, 2.8),
        (6.8, 8.0, 0.0, 2.8),
    ];
    for (left, right, low, high) in front {
        house.block([left, 0.0, low], [right, 0.3, high]);
    }
    let end =
        [(0.3, 2.2, 0.0, 2.8), (2.2, 3.8, 0.0, 0.9), (2.2, 3.8, 2.1, 2.8), (3.8, 5.7, 0.0, 2.8)];
    for (near, far, low, high) in end {
        house.block([0.0, near, low], [0.3, far, high]);
    }
    house.block([7.7, 0.3, 0.0], [8.0, 5.7, 2.8]);
    house.block([0.0, 5.7, 0.0], [8.0, 6.0, 2.8]);
    let gable = [[0.0, 2.8], [6.0, 2.8], [3.0, 4.75]];
    house.beam(&gable, 0.0, 0.3);
    house.beam(&gable, 7.7, 8.0);

    house.part(ROOF);
    house.beam(&[[-0.6, 2.42], [3.0, 4.76], [3.0, 4.98], [-0.6, 2.64]], -0.4, 8.4);
    house.beam(&[[6.6, 2.42], [6.6, 2.64], [3.0, 4.98], [3.0, 4.76]], -0.4, 8.4);

    house.part(STONE);
    house.block([5.9, 3.7, 3.6], [6.6, 4.3, 5.9]);
    for step in 0..3 {
        let (out, high) = (0.32 * f64::from(3 - step), 0.05 * f64::from(step + 1));
        house.block([3.2, -out, 0.0], [4.7, -out + 0.32, high]);
    }

    // Palings (6 cm × 2 cm) and two rails.
    house.part(WOOD);
    for i in 0..56 {
        let left = -5.0 + 0.15 * f64::from(i);
        house.block([left, -3.62, 0.08], [left + 0.06, -3.60, 1.0]);
    }
    for low in [0.3, 0.8] {
        house.block([-5.1, -3.60, low], [3.45, -3.56, low + 0.08]);
    }

    let [eye, target] = [[-6.4, -11.2, 3.0], [3.0, 1.0, 1.75]].map(placed);
    let camera = Camera::new(eye, target, [0.0, 0.0, 1.0], 38.0);
    let sun = turned(DVec3::new(-0.55, -0.75, 0.72)).to_array().map(|x| x as f32);
    let light = house.mesh.bounds().and_then(|bounds| Light::sun(sun, &bounds));
    Scene {
        mesh: house.mesh,
        camera: camera.expect("the camera is made from valid constants"),
        light: light.expect("the direction is a constant other than zero"),
        texture: None,
    }
}

/// Rotates a direction from the house's axes to the grid's.
fn turned(p: DVec3) -> DVec3 {
    DQuat::from_rotation_z(TURN) * p
}

/// Converts a point from the house's coordinates to UTM coordinates.
fn placed(p: [f64; 3]) -> [f64; 3] {
    (CORNER + turned(DVec3::from(p))).to_array()
}

#[derive(Default)]
struct House {
    mesh: Mesh<f64>,
}

impl House {
    /// Begins a part: the following shapes have this colour.
    fn part(&mut self, tint: [f32; 3]) {
        let first = self.mesh.triangles.len() as u32;
        self.mesh.parts.push(Part { first, tint, textured: false });
    }

    /// Adds a box, given two opposite corners.
    fn block(&mut self, [x, y, z]: [f64; 3], [to_x, to_y, to_z]: [f64; 3]) {
        let outline = [[x, y], [to_x, y], [to_x, to_y], [x, to_y]];
        self.prism(&outline, [z, to_z], |[x, y], z| [x, y, z]);
    }

    /// Adds a convex, counter-clockwise outline in y and z, extruded along x.
    fn beam(&mut self, outline: &[[f64; 2]], x: f64, to_x: f64) {
        self.prism(outline, [x, to_x], |[y, z], x| [x, y, z]);
    }

    /// Adds a prism: the outline at both ends, and the sides between them.
    fn prism(
        &mut self,
        outline: &[[f64; 2]],
        ends: [f64; 2],
        at: impl Fn([f64; 2], f64) -> [f64; 3],
    ) {
        let (first, count) = (self.mesh.positions.len() as u32, outline.len() as u32);
        for end in ends {
            self.mesh.positions.extend(outline.iter().map(|&p| placed(at(p, end))));
        }
        let (low, high) = (|i: u32| first + i % count, |i: u32| first + count + i % count);
        for i in 0..count {
            let side = [[low(i), low(i + 1), high(i + 1)], [low(i), high(i + 1), high(i)]];
            self.mesh.triangles.extend(side);
        }
        for i in 2..count {
            let ends = [[low(0), low(i), low(i - 1)], [high(0), high(i - 1), high(i)]];
            self.mesh.triangles.extend(ends);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use intertri::Rule;
    use intertri::internal::exact;
    use intertri::{Hit, Ray64};

    use super::*;
    use crate::light::hit_point;

    #[test]
    fn every_part_is_closed_and_f32_has_no_digits_for_it() {
        let mesh = house().mesh;
        let mut edges = HashMap::new();
        for &[a, b, c] in &mesh.triangles {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1)));
        // The sum is six times the volume, which is positive if the faces point outward.
        let volume = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| DVec3::from(mesh.positions[i as usize]) - CORNER);
            a.dot(b.cross(c))
        };
        assert!(mesh.triangles.iter().map(volume).sum::<f64>() > 6.0 * 450.0);
        let off = |x: &f64| (x - f64::from(*x as f32)).abs();
        let worst = mesh.positions.as_flattened().iter().map(off).fold(0.0, f64::max);
        assert!(worst > 0.03, "{worst}");
    }

    #[test]
    fn its_camera_sees_it_and_its_sun_lights_it() {
        let scene = house();
        let triangles = scene.mesh.to_triangles();
        let closest = |ray: &Ray64| {
            let hits =
                triangles.iter().enumerate().filter(|(_, t)| exact::hit(Rule::Closed, ray, t));
            let t = |(i, triangle)| {
                let (t, u, v) = exact::attributes(ray, triangle);
                Hit { t, u, v, triangle: i as u32, geometry: 0 }
            };
            hits.map(t).min_by(|a, b| a.t.total_cmp(&b.t))
        };
        let (mut seen, mut lit) = (0, 0);
        for (x, y) in (0..16).flat_map(|x| (0..12).map(move |y| (x, y))) {
            let ray = scene.camera.ray(x, y, 16, 12);
            let Some(hit) = closest(&ray) else { continue };
            seen += 1;
            let triangle = triangles[hit.triangle as usize];
            let next = scene.light.shadow_ray_of(&hit, &triangle);
            let off = DVec3::from(next.origin) - DVec3::from(hit_point(&ray, &hit));
            assert!(off.length() < 1e-8, "{off}");
            lit += u32::from(closest(&next).is_none());
        }
        assert!(seen > 120 && lit > 60, "{seen} {lit}");
    }
}
