//! The built-in scene: a torus knot on a plinth in the turn of a spiral stair.

mod house;
mod shapes;

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use self::shapes::{Ring, Shapes};
use crate::camera::Camera;
use crate::light::Light;
use crate::scene::Scene;
use crate::texture::Texture;

const FLOOR: [f32; 3] = [0.56, 0.53, 0.49];
const PLINTH: [f32; 3] = [0.72, 0.69, 0.64];
const KNOT: [f32; 3] = [0.80, 0.36, 0.16];
const STAIR: [f32; 3] = [0.38, 0.47, 0.52];
const SPHERE: [f32; 3] = [0.20, 0.42, 0.40];
const STONE: [f32; 3] = [0.62, 0.16, 0.24];

impl Scene {
    /// The scene that comes with the program, procedural: a torus knot on a plinth in the turn of a
    /// spiral stair, with a sphere and a cut stone, on a floor.
    ///
    /// It has 10,804 triangles with texture coordinates, its own camera and its own light. Floor and
    /// sphere have the XOR pattern. The same bits on every call.
    pub fn built_in() -> Self {
        built_in()
    }
}

/// One unit is about a meter, y is up.
fn built_in() -> Scene {
    let mut shapes = Shapes::default();

    shapes.part(FLOOR, true);
    shapes.grid([36, 36], [false, false], 9.0, |u, v| {
        DVec3::new((u - 0.5) * 26.0, 0.0, (v - 0.5) * 26.0)
    });

    // Two round steps with a narrow bevel on each.
    shapes.part(PLINTH, false);
    let profile = [
        (1.75, 0.0),
        (1.75, 0.22),
        (1.70, 0.27),
        (1.30, 0.27),
        (1.30, 0.85),
        (1.24, 0.91),
        (0.0, 0.91),
    ];
    let rings = profile.map(|(radius, y)| Ring { radius, y, turn: 0.0 });
    shapes.lathe(72, &rings, |p| p);

    // A (2, 3) torus knot, laid a little aslant so that it stands on its rim.
    shapes.part(KNOT, false);
    let lean = DQuat::from_rotation_x(1.18);
    shapes.grid([180, 16], [true, true], 24.0, |u, v| {
        lean * knot(u, v) + DVec3::new(0.0, 2.042, 0.0)
    });

    // Steps that climb around the plinth, each a wedge of a ring, floating.
    shapes.part(STAIR, false);
    for step in 0..25 {
        let angle = TAU * (0.40 + 0.029 * f64::from(step));
        shapes.wedge(
            [2.5, 3.7],
            0.14 + 0.135 * f64::from(step),
            0.10,
            [angle, angle + TAU * 0.027],
        );
    }

    shapes.part(SPHERE, true);
    shapes.icosphere(3, |p| p * 0.62 + DVec3::new(-2.05, 0.62, 2.35));

    // A cut stone: table, crown, girdle and pavilion, lying on a facet.
    shapes.part(STONE, false);
    let cut = [(0.0, 0.44, 0.0), (0.52, 0.44, 0.0), (0.86, 0.24, 0.5), (1.0, 0.05, 0.0)];
    let under = [(1.0, -0.05, 0.0), (0.55, -0.48, 0.5), (0.0, -0.92, 0.0)];
    let rings = cut.into_iter().chain(under).map(|(radius, y, turn)| Ring { radius, y, turn });
    let tilt = DQuat::from_rotation_y(-0.35) * DQuat::from_rotation_x(0.74);
    shapes.lathe(8, &rings.collect::<Vec<_>>(), |p| tilt * p * 0.62 + DVec3::new(1.75, 0.441, 2.6));

    let camera = Camera::new([4.2, 4.7, 9.4], [0.2, 1.2, 0.1], Camera::UP, 36.0);
    Scene {
        mesh: shapes.mesh,
        camera: camera.expect("its numbers are constants, and a test draws with them"),
        light: Light::Point { position: [-5.5, 10.5, 8.0] },
        texture: Some(Texture::Xor { texels: 8, dark: 0.5 }),
    }
}

/// A point of the tube around a torus knot: `u` along it, `v` around it, both in `0..1`.
fn knot(u: f64, v: f64) -> DVec3 {
    let curve = |u: f64| {
        let angle = TAU * u;
        let radius = 1.0 + 0.42 * (3.0 * angle).cos();
        DVec3::new(
            radius * (2.0 * angle).cos(),
            radius * (2.0 * angle).sin(),
            0.55 * (3.0 * angle).sin(),
        )
    };
    // A frame of the curve: its tangent, the normal away from the middle, and the binormal.
    let (center, step) = (curve(u), 1e-4);
    let tangent = (curve(u + step) - curve(u - step)).normalize();
    let binormal = tangent.cross(center).normalize();
    let normal = binormal.cross(tangent);
    let (sin, cos) = (TAU * v).sin_cos();
    center + (normal * cos + binormal * sin) * 0.235
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_whole_and_of_the_documented_size() {
        let mesh = built_in().mesh;
        assert_eq!(mesh.triangles.len(), 10_804);
        assert_eq!(mesh.corner_uvs.as_ref().map(Vec::len), Some(10_804));
        assert!(mesh.positions.as_flattened().iter().all(|x| x.is_finite()));
        for i in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(i).map(crate::mesh::double);
            assert!((b - a).cross(c - a).length() > 1e-5, "triangle {i} has no area");
        }
    }

    #[test]
    fn nothing_but_the_floor_has_a_border() {
        // Closed shapes: every edge of a part stands once in either direction.
        let mesh = built_in().mesh;
        let first = mesh.parts[1].first as usize;
        let mut edges = std::collections::HashMap::new();
        for t in &mesh.triangles[first..] {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                *edges.entry((a, b)).or_insert(0) += 1;
            }
        }
        let floating =
            edges.iter().filter(|&(&(a, b), &n)| n != 1 || edges.get(&(b, a)) != Some(&1));
        // The plinth stands on the floor and has no underside.
        assert_eq!(floating.count(), 72);
    }

    #[test]
    fn it_is_the_same_every_time() {
        assert_eq!(built_in(), built_in());
    }
}
