//! Code shared by the tests: views and their rays, random numbers, and shapes.

use intertri::{Ray, Triangle};
use intertri_raster::View;
use intertri_scene::Camera;

/// Returns a view with a camera's position and direction.
pub(crate) fn view_of(camera: &Camera, width: u32, height: u32) -> View {
    View::new(camera.eye(), camera.axes(), camera.half_height(), width, height).unwrap()
}

/// Returns the camera's rays, row by row.
pub(crate) fn rays_of(camera: &Camera, width: u32, height: u32) -> Vec<Ray> {
    let row = |y| (0..width).map(move |x| camera.ray(x, y, width, height));
    (0..height).flat_map(row).collect()
}

/// Pseudorandom numbers that are the same on every run.
pub(crate) struct Numbers(pub u64);

impl Numbers {
    /// Returns a number in -1..1.
    pub(crate) fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Returns an integer below a limit.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        ((self.next() + 1.0) * 0.5 * limit as f64) as usize
    }

    /// Returns a point whose coordinates are between `-size` and `size`.
    pub(crate) fn point(&mut self, size: f64) -> [f32; 3] {
        [(); 3].map(|()| (self.next() * size) as f32)
    }

    /// Returns triangles of about the given size at random positions in a cube.
    pub(crate) fn soup(&mut self, count: usize, cube: f64, size: f64) -> Vec<Triangle> {
        let triangle = |_| {
            let place = self.point(cube);
            Triangle([(); 3].map(|()| add(place, self.point(size))))
        };
        (0..count).map(triangle).collect()
    }
}

pub(crate) fn add(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Returns a closed surface around the origin, with outward winding: a sphere of `n` × `2 n` cells
/// whose points are moved inward or outward by up to `rough` times its radius.
pub(crate) fn ball(numbers: &mut Numbers, n: usize, rough: f64) -> Vec<Triangle> {
    let pi = std::f64::consts::PI;
    let mut ring = |i: usize| -> Vec<[f32; 3]> {
        let polar = pi * i as f64 / n as f64;
        let mut points: Vec<[f32; 3]> = (0..2 * n)
            .map(|j| {
                let angle = pi * j as f64 / n as f64;
                let radius = 1.0 + rough * numbers.next();
                let (s, c) = (polar.sin() * radius, polar.cos() * radius);
                [s * angle.cos(), c, s * angle.sin()].map(|x| x as f32)
            })
            .collect();
        if i == 0 || i == n {
            let pole = points[0];
            points.fill([0.0, pole[1], 0.0]);
        }
        points
    };
    let rings: Vec<_> = (0..=n).map(&mut ring).collect();
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..2 * n {
            let k = (j + 1) % (2 * n);
            let (a, b, c, d) = (rings[i][j], rings[i][k], rings[i + 1][k], rings[i + 1][j]);
            triangles.extend([Triangle([a, b, c]), Triangle([a, c, d])]);
        }
    }
    triangles.retain(|t| t.0[0] != t.0[1] && t.0[1] != t.0[2] && t.0[2] != t.0[0]);
    triangles
}

/// Returns a box between two opposite corners, made of 12 triangles.
pub(crate) fn cuboid(min: [f32; 3], max: [f32; 3]) -> Vec<Triangle> {
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { max[axis] } else { min[axis] };
        [pick(0), pick(1), pick(2)]
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let quad = |q: [usize; 4]| {
        let [a, b, c, d] = q.map(corner);
        [Triangle([a, b, c]), Triangle([a, c, d])]
    };
    quads.into_iter().flat_map(quad).collect()
}

/// Returns a horizontal square of two triangles at height `y`, from `-size` to `size`.
pub(crate) fn floor(y: f32, size: f32) -> Vec<Triangle> {
    let p = |x: f32, z: f32| [x * size, y, z * size];
    let (a, b, c, d) = (p(-1.0, -1.0), p(-1.0, 1.0), p(1.0, 1.0), p(1.0, -1.0));
    vec![Triangle([a, b, c]), Triangle([a, c, d])]
}
