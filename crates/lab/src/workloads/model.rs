//! The triangle model for the `camera` and `secondary` workloads.

use intertri::{Ray, Triangle, TriangleOf};

use super::vector::{add, cross, distance, length, round, unit};
use crate::meshes::Mesh;
use crate::rng::Rng;
use crate::test_batch::TestBatch;

/// Triangles and their bounding spheres.
#[derive(Clone, Debug)]
pub struct Model {
    triangles: Vec<Triangle>,
    balls: Vec<([f64; 3], f64)>,
    centre: [f64; 3],
    radius: f64,
}

impl Model {
    /// Creates a model from the triangles whose coordinates are less than 1e18 in magnitude.
    /// Returns `None` if there are none, or if all their corners coincide.
    pub fn new(triangles: &[Triangle]) -> Option<Self> {
        let finite = |t: &&Triangle| t.0.as_flattened().iter().all(|x| x.abs() < 1e18);
        let triangles: Vec<_> = triangles.iter().filter(finite).copied().collect();
        let balls: Vec<_> = triangles.iter().map(ball).collect();
        let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in triangles.iter().flat_map(|t| t.0) {
            for k in 0..3 {
                lo[k] = lo[k].min(p[k].into());
                hi[k] = hi[k].max(p[k].into());
            }
        }
        let centre = [0, 1, 2].map(|k| f64::midpoint(lo[k], hi[k]));
        let radius = distance(lo, hi) / 2.0;
        (radius > 0.0 && radius.is_finite()).then_some(Self { triangles, balls, centre, radius })
    }

    /// Creates the built-in model: a sphere and a slanted torus that passes through it. No
    /// coordinate has a special value.
    pub fn built_in() -> Self {
        let place = |[x, y, z]: [f64; 3]| [y + 0.1 * x + 0.37, z - 0.2 * y - 0.21, x + 0.3 * z];
        let mut triangles = Mesh::icosphere(4).map(place).triangles();
        triangles.extend(Mesh::torus(80, 40).map(|p| place(p.map(|x| 1.6 * x))).triangles());
        Self::new(&triangles).unwrap_or_else(|| unreachable!("the built-in model has triangles"))
    }

    /// Returns the number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Always returns false, because there is at least one triangle.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Creates an 8×8 tile of rays from a camera that sees the model at about 1024×1024 pixels,
    /// with the triangles nearest to the tile's middle ray.
    pub(super) fn tile(&self, rng: &mut Rng) -> TestBatch {
        let eye = round(add(self.centre, rng.direction(), 3.0 * self.radius)).map(f64::from);
        let (target, _) = rng.pick(&self.balls);
        let axis = unit(add(target, eye, -1.0));
        let right = unit(cross(axis, rng.direction()));
        let up = cross(axis, right);
        let pixel = 2.0 / 3.0 / 1024.0;
        let rays = (0..64)
            .map(|i| {
                let at = |k: i32| (f64::from(k) - 3.5) * pixel;
                let dir = add(add(axis, right, at(i % 8)), up, at(i / 8));
                Ray::new(round(eye), round(unit(dir)))
            })
            .collect();
        // Returns the distance of a bounding sphere from the line of the middle ray.
        let far = |&(centre, radius): &([f64; 3], f64)| {
            let way = add(centre, eye, -1.0);
            length(cross(way, axis)) - radius
        };
        TestBatch { rays, triangles: self.nearest(far) }
    }

    /// Returns a random triangle and its neighbours, with rays toward them from random points on
    /// the model.
    pub(super) fn leaf(&self, rng: &mut Rng) -> TestBatch {
        let (target, _) = rng.pick(&self.balls);
        let triangles = self.nearest(|&(centre, radius)| distance(centre, target) - radius);
        let rays = (0..64)
            .map(|_| {
                let (start, end) = (rng.pick(&self.triangles), rng.pick(&triangles));
                let (from, to) = (inside(rng, &start), inside(rng, &end));
                let origin = round(from).map(f64::from);
                Ray::new(round(from), round(unit(add(to, origin, -1.0))))
            })
            .collect();
        TestBatch { rays, triangles }
    }

    /// Returns the 32 triangles with the smallest distance `far`, or all triangles if there are
    /// fewer.
    fn nearest(&self, far: impl Fn(&([f64; 3], f64)) -> f64) -> Vec<Triangle> {
        let mut order: Vec<_> = self.balls.iter().map(far).zip(0_usize..).collect();
        let by = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if order.len() > 32 {
            order.select_nth_unstable_by(31, by);
            order.truncate(32);
        }
        order.sort_unstable_by(by);
        order.iter().map(|&(_, k)| self.triangles[k]).collect()
    }
}

/// Returns a random point on a triangle.
fn inside(rng: &mut Rng, &TriangleOf([a, b, c]): &Triangle) -> [f64; 3] {
    let (u, v) = (rng.unit(), rng.unit());
    let (u, v) = if u + v <= 1.0 { (u, v) } else { (1.0 - u, 1.0 - v) };
    let [a, b, c] = [a, b, c].map(|p| p.map(f64::from));
    [0, 1, 2].map(|k| (1.0 - u - v) * a[k] + u * b[k] + v * c[k])
}

/// Returns a bounding sphere of a triangle, centred on the mean of its corners.
fn ball(triangle: &Triangle) -> ([f64; 3], f64) {
    let corners = triangle.0.map(|p| p.map(f64::from));
    let centre = [0, 1, 2].map(|k| corners.iter().map(|p| p[k]).sum::<f64>() / 3.0);
    (centre, corners.iter().fold(0.0, |far: f64, &p| far.max(distance(p, centre))))
}
