//! What is measured and judged: bundles of rays with the triangles that they are tested against.

use intertri::{Ray, Triangle};

use crate::families::{self, FAMILIES};
use crate::meshes::Mesh;
use crate::rng::Rng;
use crate::subjects::{Bundle, Form};

/// A kind of bundle, one panel of the chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workload {
    /// Tiles of 8 by 8 rays of a camera, and the 32 triangles nearest to the tile's middle ray.
    Camera,
    /// 64 rays from anywhere on the model to the neighbourhood of one triangle, and the 32 triangles
    /// of that neighbourhood: what a leaf sees of diffuse rays.
    Secondary,
    /// 64 rays from within a closed convex mesh, each exactly at a vertex or a point of an edge, and
    /// all its triangles.
    Edges,
    /// The adversarial mix.
    Mix,
}

impl Workload {
    /// All of them, in the order of the panels.
    pub const ALL: [Self; 4] = [Self::Camera, Self::Secondary, Self::Edges, Self::Mix];

    /// `camera`, `secondary`, `edges` or `mix`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Secondary => "secondary",
            Self::Edges => "edges",
            Self::Mix => "mix",
        }
    }

    /// The form in which it is measured for the chart: rays that run together share a triangle, a
    /// ray on its own takes a pack of triangles.
    pub fn form(self) -> Form {
        if self == Self::Secondary { Form::Packs } else { Form::Packets }
    }

    /// A bundle of this kind. The model is that of [`Workload::Camera`] and [`Workload::Secondary`].
    pub fn bundle(self, rng: &mut Rng, model: &Model) -> Bundle {
        match self {
            Self::Camera => model.tile(rng),
            Self::Secondary => model.leaf(rng),
            Self::Edges => closed(rng, 18, 64),
            Self::Mix => {
                let random = families::find("random").filter(|_| rng.one_in(2));
                let family = random.copied().unwrap_or_else(|| rng.pick(FAMILIES));
                let scene = family.scene(rng, 16, 16);
                Bundle { rays: scene.rays, triangles: scene.triangles }
            }
        }
    }
}

/// Triangles with the balls around them.
#[derive(Clone, Debug)]
pub struct Model {
    triangles: Vec<Triangle>,
    balls: Vec<([f64; 3], f64)>,
    center: [f64; 3],
    radius: f64,
}

impl Model {
    /// The triangles that are finite; `None` if there are none.
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
        let center = [0, 1, 2].map(|k| f64::midpoint(lo[k], hi[k]));
        let radius = distance(lo, hi) / 2.0;
        (radius > 0.0 && radius.is_finite()).then_some(Self { triangles, balls, center, radius })
    }

    /// The built-in model: a sphere and a torus that leans through it, with no coordinate special.
    pub fn built_in() -> Self {
        let place = |[x, y, z]: [f64; 3]| [y + 0.1 * x + 0.37, z - 0.2 * y - 0.21, x + 0.3 * z];
        let mut triangles = Mesh::icosphere(4).map(place).triangles();
        triangles.extend(Mesh::torus(80, 40).map(|p| place(p.map(|x| 1.6 * x))).triangles());
        Self::new(&triangles).unwrap_or_else(|| unreachable!("the built-in model has triangles"))
    }

    /// How many triangles there are.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Never: there is a triangle.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// A tile of a camera that sees the model in about 1024 by 1024 pixels.
    fn tile(&self, rng: &mut Rng) -> Bundle {
        let eye = round(add(self.center, rng.direction(), 3.0 * self.radius)).map(f64::from);
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
        // Distance of a ball from the middle ray's line.
        let far = |&(center, radius): &([f64; 3], f64)| {
            let way = add(center, eye, -1.0);
            length(cross(way, axis)) - radius
        };
        Bundle { rays, triangles: self.nearest(far) }
    }

    /// The neighbourhood of a triangle, and rays that arrive there from anywhere.
    fn leaf(&self, rng: &mut Rng) -> Bundle {
        let (target, _) = rng.pick(&self.balls);
        let triangles = self.nearest(|&(center, radius)| distance(center, target) - radius);
        let rays = (0..64)
            .map(|_| {
                let (start, end) = (rng.pick(&self.triangles), rng.pick(&triangles));
                let (from, to) = (inside(rng, &start), inside(rng, &end));
                let origin = round(from).map(f64::from);
                Ray::new(round(from), round(unit(add(to, origin, -1.0))))
            })
            .collect();
        Bundle { rays, triangles }
    }

    /// The 32 triangles for which a distance is least, or as many as there are.
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

/// A convex mesh on a grid of `2^-bits`, and rays from its inside, each exactly at a vertex or at
/// a quarter point of an edge: origin, direction and target are free of rounding for up to 18 bits,
/// and survive the grid of the mode `fixed` for up to 15. A ray leaves such a mesh in one point.
pub fn closed(rng: &mut Rng, bits: u32, rays: usize) -> Bundle {
    let steps = f64::from(1_u32 << bits);
    let stretch = [0; 3].map(|_| 0.5 + 0.49 * rng.unit());
    let mesh = if rng.one_in(4) { Mesh::cube(1) } else { Mesh::icosphere(1) };
    let mesh = mesh.map(|p| [0, 1, 2].map(|k| (p[k] * stretch[k] * steps) as i32 as f64));
    let rays = (0..rays)
        .map(|_| {
            let reach = (0.25 * steps) as i32;
            let origin = [0; 3].map(|_| f64::from(rng.within(reach)));
            let face = rng.pick(&mesh.faces);
            let corner = rng.below(3);
            let [a, b] = [face[corner], face[(corner + 1) % 3]].map(|v| mesh.vertices[v]);
            // Weights of the ends of an edge in quarters.
            let weight = rng.pick(&[0.0, 0.0, 0.0, 1.0, 2.0, 3.0]);
            let dir = [0, 1, 2].map(|k| (4.0 - weight) * a[k] + weight * b[k] - 4.0 * origin[k]);
            Ray::new(round(origin.map(|x| x / steps)), round(dir.map(|x| x / steps)))
        })
        .collect();
    let triangles = mesh.map(|p| p.map(|x| x / steps)).triangles();
    Bundle { rays, triangles }
}

/// A random point of a triangle.
fn inside(rng: &mut Rng, &Triangle([a, b, c]): &Triangle) -> [f64; 3] {
    let (u, v) = (rng.unit(), rng.unit());
    let (u, v) = if u + v <= 1.0 { (u, v) } else { (1.0 - u, 1.0 - v) };
    let [a, b, c] = [a, b, c].map(|p| p.map(f64::from));
    [0, 1, 2].map(|k| (1.0 - u - v) * a[k] + u * b[k] + v * c[k])
}

/// A ball around a triangle: about the middle of its corners.
fn ball(triangle: &Triangle) -> ([f64; 3], f64) {
    let corners = triangle.0.map(|p| p.map(f64::from));
    let center = [0, 1, 2].map(|k| corners.iter().map(|p| p[k]).sum::<f64>() / 3.0);
    (center, corners.iter().fold(0.0, |far: f64, &p| far.max(distance(p, center))))
}

fn add(a: [f64; 3], b: [f64; 3], scale: f64) -> [f64; 3] {
    [a[0] + b[0] * scale, a[1] + b[1] * scale, a[2] + b[2] * scale]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    length(add(a, b, -1.0))
}

/// Length 1 in the same direction; what has none stays as it is.
fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = length(a);
    if length > 0.0 { a.map(|x| x / length) } else { a }
}

fn round(a: [f64; 3]) -> [f32; 3] {
    a.map(|x| x as f32)
}
