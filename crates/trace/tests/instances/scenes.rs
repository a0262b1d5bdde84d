//! Generates meshes and placements for the tests of instanced scenes. The meshes and placements are
//! the same on every run.

use std::sync::Arc;

use intertri::{Triangle, Triangle64};
use intertri_trace::{Bvh, SceneMesh};

pub(crate) type Matrix = [f64; 12];

/// A pseudo-random number generator (`SplitMix64`). The field is its state, initially the seed.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    pub(crate) fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    /// Returns a pseudo-random number in -1..1.
    pub(crate) fn number(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub(crate) fn point(&mut self) -> [f64; 3] {
        [self.number(), self.number(), self.number()]
    }

    pub(crate) fn one_of<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }
}

pub(crate) fn add(a: [f64; 3], b: [f64; 3], by: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + by * b[k])
}

/// Returns a sphere of `rings` rings. Seen from outside, the corners of each triangle run
/// counter-clockwise.
pub(crate) fn globe(rings: usize) -> Vec<Triangle64> {
    let corner = |ring: usize, i: usize| {
        let (a, b) = (ring as f64 / rings as f64, (i % rings) as f64 / rings as f64);
        let (a, b) = (a * std::f64::consts::PI, b * std::f64::consts::TAU);
        let r = if ring == 0 || ring == rings { 0.0 } else { a.sin() };
        [r * b.cos(), a.cos(), r * b.sin()]
    };
    let squares = (0..rings * rings).map(|i| (i / rings, i % rings));
    let halves = squares.flat_map(|(ring, i)| {
        let [a, b] = [corner(ring, i), corner(ring, i + 1)];
        let [c, d] = [corner(ring + 1, i), corner(ring + 1, i + 1)];
        [Triangle64([a, b, c]), Triangle64([d, c, b])]
    });
    halves.collect()
}

/// Returns an axis-aligned cube with `cells`×`cells` squares on each face.
pub(crate) fn cube(cells: i32) -> Vec<Triangle64> {
    let mut all = Vec::new();
    for side in 0..6 {
        for i in 0..cells * cells {
            let at = |i: i32, j: i32| {
                let [a, b] = [i, j].map(|i| 2.0 * f64::from(i) / f64::from(cells) - 1.0);
                let mut point = [if side % 2 == 0 { -1.0 } else { 1.0 }, a, b];
                point.rotate_right(side as usize / 2);
                point
            };
            let (i, j) = (i % cells, i / cells);
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
            all.extend([Triangle64([a, b, c]), Triangle64([d, c, b])]);
        }
    }
    all
}

/// Returns random triangles of various shapes and sizes. Some have zero area, and some have a NaN
/// coordinate.
pub(crate) fn soup(numbers: &mut Numbers, count: usize) -> Vec<Triangle64> {
    let triangle = |numbers: &mut Numbers| {
        let (a, size) = (numbers.point(), 0.5 * numbers.number().abs().powi(3));
        let [mut b, mut c] = [0, 1].map(|_| add(a, numbers.point(), size));
        match numbers.below(12) {
            0 => c = b,
            1 => c = add(a, [0, 1, 2].map(|k| b[k] - a[k]), 2.0),
            2 => b[numbers.below(3)] = f64::NAN,
            3 => (b, c) = (add(a, b, 1e-9), add(a, c, 1e-9)),
            _ => {}
        }
        Triangle64([a, b, c])
    };
    (0..count).map(|_| triangle(numbers)).collect()
}

/// A mesh that several instances can share, and its triangles in f64, from which the flattened
/// scene is built.
#[derive(Clone)]
pub(crate) struct Mesh {
    pub(crate) shared: SceneMesh,
    pub(crate) geometries: Vec<Vec<Triangle64>>,
    /// The mask of each geometry.
    pub(crate) masks: Vec<u32>,
}

impl Mesh {
    pub(crate) fn in_f64(geometries: Vec<Vec<Triangle64>>) -> Self {
        let slices: Vec<&[Triangle64]> = geometries.iter().map(|mesh| &**mesh).collect();
        let mut bvh = Bvh::from_meshes(&slices).unwrap();
        let masks = masks(geometries.len());
        masks.iter().enumerate().for_each(|(geometry, mask)| bvh.set_mask(geometry, *mask));
        Self { shared: Arc::new(bvh).into(), geometries, masks }
    }

    pub(crate) fn in_f32(geometries: &[Vec<Triangle64>]) -> Self {
        let round = |t: &Triangle64| {
            Triangle::new(
                t.0[0].map(|x| x as f32),
                t.0[1].map(|x| x as f32),
                t.0[2].map(|x| x as f32),
            )
        };
        let rounded: Vec<Vec<Triangle>> =
            geometries.iter().map(|mesh| mesh.iter().map(round).collect()).collect();
        let slices: Vec<&[Triangle]> = rounded.iter().map(|mesh| &**mesh).collect();
        let exact = |t: &Triangle| Triangle64(t.0.map(|corner| corner.map(f64::from)));
        let geometries: Vec<_> =
            rounded.iter().map(|mesh| mesh.iter().map(exact).collect()).collect();
        let masks = vec![u32::MAX; geometries.len()];
        Self { shared: Arc::new(Bvh::from_meshes(&slices).unwrap()).into(), geometries, masks }
    }
}

/// Returns a mask for each geometry of a mesh. If the mesh has only one geometry, all queries see
/// it.
pub(crate) fn masks(count: usize) -> Vec<u32> {
    let of = |geometry: usize| if count == 1 { u32::MAX } else { [0b10, 0b11, 0b01][geometry % 3] };
    (0..count).map(of).collect()
}

pub(crate) fn meshes(numbers: &mut Numbers) -> Vec<Mesh> {
    let moved = |by: f64| {
        let all = globe(9).into_iter();
        all.map(|t| Triangle64(t.0.map(|c| [c[0] + by, c[1] * 1e-3, c[2] + by]))).collect()
    };
    vec![
        Mesh::in_f32(&[globe(12)]),
        Mesh::in_f64(vec![globe(14)]),
        Mesh::in_f32(&[cube(4)]),
        Mesh::in_f64(vec![cube(3), Vec::new(), soup(numbers, 40)]),
        Mesh::in_f32(&[soup(numbers, 200)]),
        Mesh::in_f64(vec![soup(numbers, 120)]),
        // These meshes are far from the origin of their own coordinate system.
        Mesh::in_f64(vec![moved(1e6)]),
        Mesh::in_f32(&[moved(1e3)]),
    ]
}

/// Returns a random rotation.
pub(crate) fn rotation(numbers: &mut Numbers) -> [[f64; 3]; 3] {
    let mut q = [numbers.number(), numbers.number(), numbers.number(), numbers.number()];
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q = q.map(|x| x / length);
    let [w, x, y, z] = q;
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Returns the matrix with the linear part `a · diagonal` and the translation `at`.
pub(crate) fn matrix(a: [[f64; 3]; 3], diagonal: [f64; 3], at: [f64; 3]) -> Matrix {
    let mut m = [0.0; 12];
    for i in 0..3 {
        for j in 0..3 {
            m[4 * i + j] = a[i][j] * diagonal[j];
        }
        m[4 * i + 3] = at[i];
    }
    m
}

pub(crate) const ONE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The number of placement kinds that [`placement`] supports. They differ in scale, shape, and
/// position.
pub(crate) const KINDS: usize = 14;

pub(crate) fn placement(numbers: &mut Numbers, kind: usize) -> Matrix {
    let near = numbers.point().map(|x| 3.0 * x);
    let turned = rotation(numbers);
    match kind {
        // Positions are rounded to a grid, so that walls of different instances coincide.
        0 => matrix(ONE, [1.0; 3], near.map(f64::round)),
        1 => matrix(turned, [1.0; 3], near),
        2 => {
            let sides = numbers.point().map(|x| (3.0 * x).exp2());
            matrix(turned, sides, near)
        }
        3 => {
            let signs = [0; 3].map(|_| numbers.one_of(&[-1.0, 1.0, -2.0]));
            matrix(ONE, signs, near.map(f64::round))
        }
        4 => {
            let sheared = [numbers.point(), numbers.point(), numbers.point()];
            matrix(sheared, [2.0; 3], near)
        }
        // The mesh is tiny and far away, so rounding moves its corners by a noticeable fraction of
        // its size.
        5 => matrix(turned, [1e-6; 3], add([1e7, -1e7, 3e6], near, 1e-6)),
        6 => matrix(turned, [1e6; 3], near.map(|x| 1e6 * x)),
        // Matrices with condition numbers up to 1e12.
        7 => {
            let sides = numbers.point().map(|x| 10_f64.powf(6.0 * x));
            let other = rotation(numbers);
            let first = matrix(turned, sides, [0.0; 3]);
            let row =
                |i: usize| [0, 1, 2].map(|j| (0..3).map(|k| first[4 * i + k] * other[k][j]).sum());
            matrix([row(0), row(1), row(2)], [1.0; 3], near.map(|x| 10.0 * x))
        }
        8 => {
            let mut sides = numbers.point();
            sides[numbers.below(3)] = 0.0;
            sides[numbers.below(3)] *= numbers.one_of(&[0.0, 1.0, 1e-30]);
            matrix(if numbers.below(2) == 0 { ONE } else { turned }, sides, near)
        }
        9 => matrix(turned, [1.0; 3], add([1e7, 2e7, -3e7], near, 1.0)),
        10 => matrix(turned, [1e-3, 1e-3, 1e-3], add([1e12, 0.0, 1e12], near, 1e-3)),
        // These coordinates are too extreme for the SIMD lanes to handle; some corners overflow.
        11 => matrix(turned, [1e-150; 3], near.map(|x| 1e-150 * x)),
        12 => matrix(turned, [numbers.one_of(&[1e120, 1e301, 1e308]); 3], near.map(|x| 1e120 * x)),
        _ => {
            let kind = numbers.below(5);
            placement(numbers, kind)
        }
    }
}

/// Returns the position in world space of a point of an instance. The position is defined by this
/// order of operations, each of which is rounded.
pub(crate) fn placed(m: &Matrix, [x, y, z]: [f64; 3]) -> [f64; 3] {
    [0, 4, 8].map(|i| ((m[i] * x + m[i + 1] * y) + m[i + 2] * z) + m[i + 3])
}
