//! Scenes of instances must answer as the flattened `Bvh<f64>` does, bit for bit.
//!
//! `INTERTRI_INSTANCE_RAYS` sets how many rays are compared; the default is 200,000.

use std::collections::BTreeMap;
use std::sync::Arc;

use intertri::simd::Level;
use intertri::{Hit, Mode, Ray64, Triangle, Triangle64};
use intertri_trace::{Bvh, InstanceId, Scene, SceneError, SceneHit, SceneMesh, SceneSnapshot};

type Matrix = [f64; 12];

/// Numbers that are the same on every run.
struct Numbers(u64);

impl Numbers {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    /// In -1..1.
    fn number(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn point(&mut self) -> [f64; 3] {
        [self.number(), self.number(), self.number()]
    }

    fn one_of<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }
}

fn add(a: [f64; 3], b: [f64; 3], by: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + by * b[k])
}

/// A sphere made of rings; its corners run counter-clockwise as seen from outside.
fn globe(rings: usize) -> Vec<Triangle64> {
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

/// A cube of small squares with axis-aligned walls.
fn cube(cells: i32) -> Vec<Triangle64> {
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

/// Triangles of any shape and size, some without area or with a NaN.
fn soup(numbers: &mut Numbers, count: usize) -> Vec<Triangle64> {
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

/// A mesh for instances, and its geometries for flattening.
#[derive(Clone)]
struct Mesh {
    shared: SceneMesh,
    geometries: Vec<Vec<Triangle64>>,
}

impl Mesh {
    fn in_f64(geometries: Vec<Vec<Triangle64>>) -> Self {
        let slices: Vec<&[Triangle64]> = geometries.iter().map(|mesh| &**mesh).collect();
        Self { shared: Arc::new(Bvh::from_meshes(&slices).unwrap()).into(), geometries }
    }

    fn in_f32(geometries: &[Vec<Triangle64>]) -> Self {
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
        let geometries = rounded.iter().map(|mesh| mesh.iter().map(exact).collect()).collect();
        Self { shared: Arc::new(Bvh::from_meshes(&slices).unwrap()).into(), geometries }
    }
}

fn meshes(numbers: &mut Numbers) -> Vec<Mesh> {
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
        // Far from its own origin.
        Mesh::in_f64(vec![moved(1e6)]),
        Mesh::in_f32(&[moved(1e3)]),
    ]
}

/// A rotation about some axis.
fn rotation(numbers: &mut Numbers) -> [[f64; 3]; 3] {
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

/// `a · diagonal`, with a translation.
fn matrix(a: [[f64; 3]; 3], diagonal: [f64; 3], at: [f64; 3]) -> Matrix {
    let mut m = [0.0; 12];
    for i in 0..3 {
        for j in 0..3 {
            m[4 * i + j] = a[i][j] * diagonal[j];
        }
        m[4 * i + 3] = at[i];
    }
    m
}

const ONE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The kinds of placements: their size and position.
const KINDS: usize = 14;

fn placement(numbers: &mut Numbers, kind: usize) -> Matrix {
    let near = numbers.point().map(|x| 3.0 * x);
    let turned = rotation(numbers);
    match kind {
        // On a grid, so that walls coincide.
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
        // Tiny and far out: corners are rounded by a noticeable fraction of the mesh.
        5 => matrix(turned, [1e-6; 3], add([1e7, -1e7, 3e6], near, 1e-6)),
        6 => matrix(turned, [1e6; 3], near.map(|x| 1e6 * x)),
        // Condition numbers up to 1e12.
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
        // Beyond the range of the lanes, and with corners that overflow.
        11 => matrix(turned, [1e-150; 3], near.map(|x| 1e-150 * x)),
        12 => matrix(turned, [numbers.one_of(&[1e120, 1e301, 1e308]); 3], near.map(|x| 1e120 * x)),
        _ => {
            let kind = numbers.below(5);
            placement(numbers, kind)
        }
    }
}

/// A placed point, by definition.
fn placed(m: &Matrix, [x, y, z]: [f64; 3]) -> [f64; 3] {
    [0, 4, 8].map(|i| ((m[i] * x + m[i + 1] * y) + m[i + 2] * z) + m[i + 3])
}

/// A scene, and its flattened triangles.
struct Pair {
    scene: Scene,
    placed: BTreeMap<InstanceId, (Mesh, Matrix, bool)>,
}

/// A flattened scene: the instance and index of each geometry.
struct Flat {
    bvh: Bvh<f64>,
    names: Vec<(InstanceId, u32)>,
    triangles: Vec<Triangle64>,
}

impl Pair {
    fn new() -> Self {
        Self { scene: Scene::new(), placed: BTreeMap::new() }
    }

    fn add(&mut self, mesh: &Mesh, matrix: Matrix) -> InstanceId {
        let id = self.scene.add(mesh.shared.clone(), matrix).unwrap();
        assert!(self.placed.insert(id, (mesh.clone(), matrix, true)).is_none());
        id
    }

    fn place(&mut self, id: InstanceId, matrix: Matrix) {
        self.scene.place(id, matrix).unwrap();
        self.placed.get_mut(&id).unwrap().1 = matrix;
    }

    fn show(&mut self, id: InstanceId, is_visible: bool) {
        self.scene.show(id, is_visible).unwrap();
        self.placed.get_mut(&id).unwrap().2 = is_visible;
    }

    fn remove(&mut self, id: InstanceId) {
        self.scene.remove(id).unwrap();
        self.placed.remove(&id).unwrap();
    }

    fn flat(&self) -> Flat {
        let (mut all, mut names) = (Vec::new(), Vec::new());
        for (&id, (mesh, matrix, is_visible)) in &self.placed {
            for (geometry, triangles) in mesh.geometries.iter().enumerate() {
                let flat = |t: &Triangle64| Triangle64(t.0.map(|corner| placed(matrix, corner)));
                if *is_visible {
                    all.push(triangles.iter().map(flat).collect::<Vec<_>>());
                    names.push((id, geometry as u32));
                }
            }
        }
        let slices: Vec<&[Triangle64]> = all.iter().map(|mesh| &**mesh).collect();
        let triangles =
            all.iter().flatten().filter(|t| t.0.as_flattened().iter().all(|x| x.is_finite()));
        Flat {
            bvh: Bvh::from_meshes(&slices).unwrap(),
            names,
            triangles: triangles.copied().collect(),
        }
    }
}

impl Flat {
    fn named(&self, hit: Hit) -> (InstanceId, [u64; 3], u32, u32) {
        let (instance, geometry) = self.names[hit.geometry as usize];
        (instance, [hit.t, hit.u, hit.v].map(f64::to_bits), geometry, hit.triangle)
    }
}

fn bits(hit: &SceneHit) -> (InstanceId, [u64; 3], u32, u32) {
    let SceneHit { hit, instance, .. } = hit;
    (*instance, [hit.t, hit.u, hit.v].map(f64::to_bits), hit.geometry, hit.triangle)
}

/// A ray toward a scene: arbitrary, or toward a corner or an edge, or along an edge or a wall.
fn ray(numbers: &mut Numbers, triangles: &[Triangle64]) -> Ray64 {
    let Triangle64([a, b, c]) = numbers.one_of(triangles);
    let Triangle64([d, ..]) = numbers.one_of(triangles);
    let size = (0..3).map(|k| (d[k] - a[k]).abs().max((b[k] - a[k]).abs())).fold(0.0, f64::max);
    let away = add(d, numbers.point(), size * numbers.one_of(&[0.0, 1e-3, 1.0, 1.0, 30.0]));
    let half = [0, 1, 2].map(|k| 0.5 * a[k] + 0.5 * b[k]);
    let inside = [0, 1, 2].map(|k| 0.3 * a[k] + 0.3 * b[k] + 0.4 * c[k]);
    let to = |from: [f64; 3], at: [f64; 3]| Ray64::new(from, add(at, from, -1.0));
    let ray = match numbers.below(9) {
        0 => to(away, a),
        1 => to(away, half),
        2 | 3 => to(away, inside),
        4 => to(away, d),
        5 => Ray64::new(add(a, add(b, a, -1.0), -2.0), add(b, a, -1.0)),
        6 => {
            let (axis, mut dir) = (numbers.below(3), numbers.point());
            dir[axis] = 0.0;
            let mut from = away;
            from[axis] = a[axis];
            Ray64::new(from, dir)
        }
        7 => {
            let mut dir = [0.0; 3];
            dir[numbers.below(3)] = numbers.one_of(&[1.0, -1.0, 1e-9]);
            Ray64::new(numbers.one_of(&[a, half, inside, away]), dir)
        }
        _ => Ray64::new(away, numbers.point()),
    };
    match numbers.below(6) {
        // Met exactly at the far end, which is open, or at the near end.
        0 => ray.between(0.0, 1.0),
        1 => ray.between(1.0, f64::INFINITY),
        2 => ray.between(numbers.number(), 2.0 * numbers.number()),
        _ => ray,
    }
}

/// Compares every query for several rays. Returns how many hit.
fn check(pair: &mut Pair, numbers: &mut Numbers, rays: usize, what: &str) -> usize {
    let (snapshot, flat) = (pair.scene.commit().unwrap(), pair.flat());
    if flat.triangles.is_empty() {
        return 0;
    }
    let rays: Vec<Ray64> = (0..rays).map(|_| ray(numbers, &flat.triangles)).collect();
    compare(&snapshot, &flat, &rays, what)
}

fn compare(snapshot: &SceneSnapshot, flat: &Flat, rays: &[Ray64], what: &str) -> usize {
    let closest = snapshot.closest_batch(rays);
    let any = snapshot.any_batch(rays);
    let all = snapshot.all_batch(rays).unwrap();
    let crossings = snapshot.crossings_batch(rays).unwrap();
    let mut hits = 0;
    for (i, ray) in rays.iter().enumerate() {
        let expected = flat.bvh.closest(ray).map(|hit| flat.named(hit));
        let found = closest[i].is_hit().then(|| bits(&closest[i]));
        assert_eq!(found, expected, "{what}: closest of {ray:?}");
        assert_eq!(any[i], expected.is_some(), "{what}: any of {ray:?}");
        hits += usize::from(any[i]);
        let expected: Vec<_> = flat.bvh.all(ray).into_iter().map(|hit| flat.named(hit)).collect();
        let found: Vec<_> = all.of(i).iter().map(bits).collect();
        assert_eq!(found, expected, "{what}: all of {ray:?}");
        let crossing = |c: intertri::Crossing| (flat.named(c.hit), c.leaves);
        let expected: Vec<_> = flat.bvh.crossings(ray).into_iter().map(crossing).collect();
        let found: Vec<_> = crossings.of(i).iter().map(|hit| (bits(hit), hit.leaves)).collect();
        assert_eq!(found, expected, "{what}: crossings of {ray:?}");
    }
    hits
}

/// The total number of rays to compare.
fn rays() -> usize {
    let rays = std::env::var("INTERTRI_INSTANCE_RAYS").ok();
    rays.map_or(200_000, |rays| rays.parse().expect("INTERTRI_INSTANCE_RAYS is a number"))
}

/// Scenes with each kind of placement; then some instances move, some are hidden or removed, and others are
/// added.
#[test]
fn answers_are_those_of_the_flattened_scene() {
    let mut numbers = Numbers(1);
    let meshes = meshes(&mut numbers);
    let (mut done, mut hits) = (0, 0);
    for round in 0.. {
        if done >= rays() {
            break;
        }
        let kind = round % KINDS;
        // Extreme numbers are left to integers, which take a thousand times as long.
        let each = if (11..13).contains(&kind) { 20 } else { 2000 };
        let mut pair = Pair::new();
        let count = numbers.one_of(&[1, 2, 9, 40]);
        for _ in 0..count {
            let mesh = numbers.below(meshes.len());
            pair.add(&meshes[mesh], placement(&mut numbers, kind));
        }
        hits += check(&mut pair, &mut numbers, each, &format!("round {round}"));

        let ids: Vec<InstanceId> = pair.placed.keys().copied().collect();
        for id in ids {
            match numbers.below(5) {
                0 => pair.show(id, false),
                1 => pair.remove(id),
                2 | 3 => pair.place(id, placement(&mut numbers, kind)),
                _ => {}
            }
        }
        for _ in 0..numbers.below(4) {
            let mesh = numbers.below(meshes.len());
            pair.add(&meshes[mesh], placement(&mut numbers, kind));
        }
        hits += check(&mut pair, &mut numbers, each, &format!("round {round}, moved"));
        done += 2 * each;
    }
    assert!(hits * 3 > done, "{hits} of {done}");
}

/// At every instruction level, and compared with a plain loop over the triangles.
#[test]
fn answers_do_not_depend_on_the_level() {
    let mut numbers = Numbers(2);
    let meshes = meshes(&mut numbers);
    for kind in [0, 1, 4, 5, 8, 9] {
        let mut pair = Pair::new();
        for mesh in &meshes {
            pair.add(mesh, placement(&mut numbers, kind));
        }
        let (snapshot, flat) = (pair.scene.commit().unwrap(), pair.flat());
        let rays: Vec<Ray64> = (0..200).map(|_| ray(&mut numbers, &flat.triangles)).collect();
        for level in Level::all() {
            compare(&snapshot.clone().at(level), &flat, &rays, level.name());
        }
        for ray in &rays {
            let any = Mode::exact().any(&flat.triangles, ray);
            assert_eq!(snapshot.any(ray), any, "{kind}: {ray:?}");
        }
    }
}

/// A snapshot keeps its state while the scene changes, and of equal hits the lower instance wins.
#[test]
fn a_snapshot_is_one_state() {
    let at = |z: f64| matrix(ONE, [1.0; 3], [0.0, 0.0, z]);
    let wall = Triangle::new([-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    let mesh = Arc::new(Bvh::new(&[wall]).unwrap());
    let ray = Ray64::new([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    let mut scene = Scene::new();
    assert!(scene.commit().unwrap().closest(&ray).is_none() && scene.is_empty());
    let ids = [3.0, 2.0, 2.0].map(|z| scene.add(mesh.clone(), at(z)).unwrap());
    let seen = |snapshot: &SceneSnapshot| {
        let hits = snapshot.all(&ray).into_iter();
        hits.map(|hit| (hit.instance, hit.hit.t)).collect::<Vec<_>>()
    };
    let first = scene.commit().unwrap();
    let expected = [(ids[1], 3.0), (ids[2], 3.0), (ids[0], 4.0)];
    assert_eq!(seen(&first), expected);
    assert_eq!(first.closest(&ray).unwrap().instance, ids[1]);

    scene.place(ids[1], at(9.0)).unwrap();
    scene.show(ids[0], false).unwrap();
    scene.remove(ids[2]).unwrap();
    assert_eq!(seen(&first), expected);
    assert_eq!((seen(&scene.commit().unwrap()), scene.len()), (vec![(ids[1], 10.0)], 2));
    // A mirrored wall flips its face.
    let front = first.closest(&ray).unwrap().leaves;
    scene.place(ids[1], matrix(ONE, [-1.0, 1.0, 1.0], [0.0; 3])).unwrap();
    assert_eq!(scene.commit().unwrap().closest(&ray).unwrap().leaves, !front);
    // The number of the removed instance is free.
    assert_eq!(scene.add(mesh, at(0.0)), Ok(ids[2]));
}

#[test]
fn errors_say_what_to_do() {
    let mesh = Arc::new(Bvh::<f64>::new(&[]).unwrap());
    let mut scene = Scene::new();
    let mut bad = matrix(ONE, [1.0; 3], [0.0; 3]);
    let id = scene.add(mesh.clone(), bad).unwrap();
    assert!(!scene.commit().unwrap().any(&Ray64::new([0.0; 3], [1.0; 3])));
    for (at, x) in [(6, f64::NAN), (11, f64::INFINITY)] {
        (bad[at], bad[11 - at]) = (x, 1.0);
        let error = SceneError::NotFinite { row: at / 4, column: at % 4 };
        assert_eq!(scene.add(mesh.clone(), bad), Err(error));
        assert_eq!(scene.place(id, bad), Err(error));
        let said = error.to_string();
        assert!(said.contains(&format!("row {}, column {}", at / 4, at % 4)), "{said}");
        bad[at] = 0.0;
    }
    let none = InstanceId::from_index(7);
    let errors = [scene.remove(none), scene.show(none, true), scene.place(none, bad)];
    assert_eq!(errors, [Err(SceneError::NoInstance(none)); 3]);
    scene.remove(id).unwrap();
    assert_eq!(scene.remove(id), Err(SceneError::NoInstance(id)));
    assert!(SceneError::NoInstance(id).to_string().contains("no instance 0"));
}
