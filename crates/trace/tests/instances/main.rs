//! Tests that queries of an instanced scene return the same results as the flattened `Bvh<f64>`,
//! bit for bit.
//!
//! `INTERTRI_INSTANCE_RAYS` sets the number of rays to compare; the default is 200,000.

mod points;
mod saved;
mod scenes;

use std::collections::BTreeMap;
use std::sync::Arc;

use intertri::simd::Level;
use intertri::{Hit, Mode, Ray64, Triangle, Triangle64};
use intertri_trace::{
    Bvh, ClosestPoint, Containment, InstanceId, Scene, SceneClosestPoint, SceneError, SceneHit,
    SceneSnapshot, Solid,
};
use scenes::{KINDS, Matrix, Mesh, Numbers, ONE, add, matrix, meshes, placed, placement};

/// A scene, together with the meshes, matrices, and masks from which the flattened scene is built.
struct Pair {
    scene: Scene,
    placed: BTreeMap<InstanceId, (Mesh, Matrix, u32)>,
}

/// A flattened scene. `names` maps each of its geometries to an instance and to the geometry's
/// index in the mesh of that instance.
struct Flat {
    solid: Solid<f64>,
    names: Vec<(InstanceId, u32)>,
    triangles: Vec<Triangle64>,
}

impl Pair {
    fn new() -> Self {
        Self { scene: Scene::new(), placed: BTreeMap::new() }
    }

    fn add(&mut self, mesh: &Mesh, matrix: Matrix) -> InstanceId {
        let id = self.scene.add(mesh.shared.clone(), matrix).unwrap();
        assert!(self.placed.insert(id, (mesh.clone(), matrix, u32::MAX)).is_none());
        id
    }

    fn place(&mut self, id: InstanceId, matrix: Matrix) {
        self.scene.place(id, matrix).unwrap();
        self.placed.get_mut(&id).unwrap().1 = matrix;
    }

    fn set_mask(&mut self, id: InstanceId, mask: u32) {
        self.scene.set_mask(id, mask).unwrap();
        self.placed.get_mut(&id).unwrap().2 = mask;
    }

    fn remove(&mut self, id: InstanceId) {
        self.scene.remove(id).unwrap();
        self.placed.remove(&id).unwrap();
    }

    /// Flattens the part of the scene that is visible to queries with the mask `seen`.
    fn flat(&self, seen: u32) -> Flat {
        let (mut all, mut names, mut masks) = (Vec::new(), Vec::new(), Vec::new());
        for (&id, (mesh, matrix, mask)) in &self.placed {
            for (geometry, triangles) in mesh.geometries.iter().enumerate() {
                let flat = |t: &Triangle64| Triangle64(t.0.map(|corner| placed(matrix, corner)));
                if mask & seen != 0 {
                    all.push(triangles.iter().map(flat).collect::<Vec<_>>());
                    names.push((id, geometry as u32));
                    masks.push(mesh.masks[geometry] & seen);
                }
            }
        }
        let slices: Vec<&[Triangle64]> = all.iter().map(|mesh| &**mesh).collect();
        let mut bvh = Bvh::from_meshes(&slices).unwrap();
        (0..).zip(&masks).for_each(|(geometry, &mask)| bvh.set_mask(geometry, mask));
        let seen = all.iter().zip(&masks).filter(|(_, mask)| **mask != 0);
        let triangles = seen.flat_map(|(triangles, _)| triangles).copied();
        let triangles = triangles.filter(|t| t.0.as_flattened().iter().all(|x| x.is_finite()));
        let triangles = triangles.collect();
        Flat { solid: Solid::assume_closed_bvh(bvh), names, triangles }
    }
}

impl Flat {
    fn named(&self, hit: Hit) -> (InstanceId, [u64; 3], u32, u32) {
        let (instance, geometry) = self.names[hit.geometry as usize];
        (instance, [hit.t, hit.u, hit.v].map(f64::to_bits), geometry, hit.triangle)
    }

    fn named_point(&self, found: ClosestPoint) -> SceneClosestPoint {
        let (instance, geometry) = self.names[found.geometry as usize];
        SceneClosestPoint { closest: ClosestPoint { geometry, ..found }, instance }
    }
}

fn bits(hit: &SceneHit) -> (InstanceId, [u64; 3], u32, u32) {
    let SceneHit { hit, instance, .. } = hit;
    (*instance, [hit.t, hit.u, hit.v].map(f64::to_bits), hit.geometry, hit.triangle)
}

/// Returns a random ray near a scene. Some rays are aimed at a corner, an edge, or an interior
/// point of a triangle, some lie along an edge or in a wall, and the rest are arbitrary.
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
        // Rays that are aimed at a point reach it at t = 1. That is the far end of the first
        // interval, which is excluded, and the near end of the second.
        0 => ray.between(0.0, 1.0),
        1 => ray.between(1.0, f64::INFINITY),
        2 => ray.between(numbers.number(), 2.0 * numbers.number()),
        _ => ray,
    }
}

/// Picks a corner, the midpoint of an edge, or an interior point of a triangle (up to rounding),
/// and returns a random point that is exactly there, nearby, or far away.
fn point(numbers: &mut Numbers, triangles: &[Triangle64]) -> [f64; 3] {
    let [Triangle64([a, b, c]), Triangle64([d, ..])] = [0; 2].map(|_| numbers.one_of(triangles));
    let size = (0..3).map(|k| (d[k] - a[k]).abs().max((b[k] - a[k]).abs())).fold(0.0, f64::max);
    let half = [0, 1, 2].map(|k| 0.5 * a[k] + 0.5 * b[k]);
    let inside = [0, 1, 2].map(|k| 0.25 * a[k] + 0.25 * b[k] + 0.5 * c[k]);
    let near = numbers.one_of(&[a, half, inside]);
    add(near, numbers.point(), size * numbers.one_of(&[0.0, 0.0, 1e-9, 0.1, 1.0, 1e3]))
}

/// Compares all queries for random rays and points, and returns the number of rays that hit.
fn check(pair: &mut Pair, numbers: &mut Numbers, rays: usize, what: &str) -> usize {
    let seen = numbers.one_of(&[u32::MAX, u32::MAX, 0b01, 0b10]);
    let (snapshot, flat) = (pair.scene.commit().unwrap().mask(seen), pair.flat(seen));
    if flat.triangles.is_empty() {
        return 0;
    }
    let points: Vec<_> = (0..rays / 10).map(|_| point(numbers, &flat.triangles)).collect();
    compare_points(&snapshot, &flat, &points, what);
    let mut some: Vec<Ray64> = (0..rays / 2).map(|_| ray(numbers, &flat.triangles)).collect();
    while some.len() < rays {
        coherent(numbers, &flat.triangles, &mut some);
    }
    compare(&snapshot, &flat, &some[..rays], what)
}

/// Adds 64 rays with similar directions, so that they are traced in packets. The rays are parallel,
/// share an origin, or share an end point. Some are aimed at a corner or an edge, and a few have an
/// empty interval or extreme coordinates.
fn coherent(numbers: &mut Numbers, triangles: &[Triangle64], rays: &mut Vec<Ray64>) {
    let first = ray(numbers, triangles);
    let length = first.dir.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let spread = length * numbers.one_of(&[1e-9, 1e-3, 0.02, 0.2]);
    let kind = numbers.below(3);
    // If `flat` is below 3, it is an axis along which every direction has the component +0 or -0.
    let (flat, zero) = (numbers.below(9), numbers.one_of(&[0.0, -0.0]));
    for i in 0..64 {
        let off = if i == 0 { [0.0; 3] } else { numbers.point().map(|x| x * 0.5 * spread) };
        let (from, along) = (add(first.origin, off, 1.0), add(first.dir, off, 1.0));
        let mut one = match kind {
            0 => Ray64::new(from, first.dir),
            1 => Ray64::new(first.origin, along),
            _ => Ray64::new(from, add(first.dir, off, -1.0)),
        };
        (one.t_min, one.t_max) = (first.t_min, first.t_max);
        if flat < 3 {
            one.dir[flat] = zero;
        }
        if numbers.below(4) == 0 {
            let Triangle64([a, b, _]) = numbers.one_of(triangles);
            let half = [0, 1, 2].map(|k| 0.5 * a[k] + 0.5 * b[k]);
            let to = numbers.one_of(&[a, half]);
            one = Ray64 { origin: add(to, one.dir, -1.0), ..one };
        }
        match numbers.below(60) {
            0 => one.t_max = numbers.one_of(&[f64::NAN, one.t_min, -1.0]),
            1 => one.origin = numbers.one_of(&[[f64::NAN; 3], [f64::INFINITY; 3]]),
            2 => one.dir = numbers.one_of(&[[0.0; 3], [f64::NAN; 3]]),
            _ => {}
        }
        // Rays with extreme coordinates are added rarely, because they need integer arithmetic,
        // which takes a thousand times as long.
        match numbers.below(5000) {
            0 => one.origin = [1e300; 3],
            1 => one.dir = one.dir.map(|x| x * numbers.one_of(&[1e-310, 1e-290, 1e290])),
            _ => {}
        }
        rays.push(one);
    }
}

fn compare_points(snapshot: &SceneSnapshot, flat: &Flat, points: &[[f64; 3]], what: &str) {
    let (solid, bvh) = (&flat.solid, flat.solid.bvh());
    for radius in [f64::INFINITY, 0.3] {
        let closest = snapshot.closest_point_batch(points, radius);
        for (found, &point) in closest.iter().zip(points) {
            let expected = bvh.closest_point(point, radius).map(|found| flat.named_point(found));
            let what = format!("{what}: closest within {radius} of {point:?}");
            assert_eq!(found.some(), expected, "{what}");
        }
    }
    for (found, &point) in snapshot.classify_batch(points).into_iter().zip(points) {
        assert_eq!(found, solid.classify(point), "{what}: classification of {point:?}");
    }
}

fn compare(snapshot: &SceneSnapshot, flat: &Flat, rays: &[Ray64], what: &str) -> usize {
    let bvh = flat.solid.bvh();
    let closest = snapshot.closest_batch(rays);
    let any = snapshot.any_batch(rays);
    let all = snapshot.all_batch(rays).unwrap();
    let crossings = snapshot.crossings_batch(rays).unwrap();
    let mut hits = 0;
    for (i, ray) in rays.iter().enumerate() {
        let expected = bvh.closest(ray).map(|hit| flat.named(hit));
        let found = closest[i].is_hit().then(|| bits(&closest[i]));
        assert_eq!(found, expected, "{what}: closest of {ray:?}");
        assert_eq!(any[i], expected.is_some(), "{what}: any of {ray:?}");
        // Batches trace coherent rays in packets, so also trace some rays alone.
        if i % 4 == 0 {
            let alone = snapshot.closest(ray).map(|hit| bits(&hit));
            assert_eq!(alone, found, "{what}: one ray's closest of {ray:?}");
            assert_eq!(snapshot.any(ray), any[i], "{what}: one ray's any of {ray:?}");
        }
        hits += usize::from(any[i]);
        let expected: Vec<_> = bvh.all(ray).into_iter().map(|hit| flat.named(hit)).collect();
        let found: Vec<_> = all.of(i).iter().map(bits).collect();
        assert_eq!(found, expected, "{what}: all of {ray:?}");
        let crossing = |c: intertri::Crossing| (flat.named(c.hit), c.leaves);
        let expected: Vec<_> = bvh.crossings(ray).into_iter().map(crossing).collect();
        let found: Vec<_> = crossings.of(i).iter().map(|hit| (bits(hit), hit.leaves)).collect();
        assert_eq!(found, expected, "{what}: crossings of {ray:?}");
    }
    hits
}

/// Returns the total number of rays to compare.
fn rays() -> usize {
    let rays = std::env::var("INTERTRI_INSTANCE_RAYS").ok();
    rays.map_or(200_000, |rays| rays.parse().expect("INTERTRI_INSTANCE_RAYS must be a number"))
}

/// Compares scenes with every kind of placement. Each scene is compared again after some instances
/// have been moved, hidden, or removed and others have been added.
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
        // Extreme placements need integer arithmetic, which takes a thousand times as long.
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
                0 => pair.set_mask(id, numbers.one_of(&[0, 0b01, 0b10])),
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
    assert!(hits * 3 > done, "only {hits} of {done} rays hit");
}

/// Tests that results are the same at every SIMD level and agree with a plain loop over the
/// triangles.
#[test]
fn answers_do_not_depend_on_the_level() {
    let mut numbers = Numbers(2);
    let meshes = meshes(&mut numbers);
    for kind in [0, 1, 4, 5, 8, 9] {
        let mut pair = Pair::new();
        for mesh in &meshes {
            pair.add(mesh, placement(&mut numbers, kind));
        }
        let (snapshot, flat) = (pair.scene.commit().unwrap(), pair.flat(u32::MAX));
        let mut rays: Vec<Ray64> = (0..200).map(|_| ray(&mut numbers, &flat.triangles)).collect();
        while rays.len() < 1000 {
            coherent(&mut numbers, &flat.triangles, &mut rays);
        }
        for level in Level::all() {
            compare(&snapshot.clone().at(level), &flat, &rays, level.name());
        }
        for ray in &rays {
            let any = Mode::exact().any(&flat.triangles, ray);
            assert_eq!(snapshot.any(ray), any, "{kind}: {ray:?}");
        }
    }
}

/// Triangles with zero area can be closest to a point, but no ray hits them, and they enclose
/// nothing.
#[test]
fn triangles_without_an_area_are_near_points_alone() {
    let segment = Triangle64([[3.0, 0.0, 0.0], [3.0, 2.0, 0.0], [3.0, 1.0, 0.0]]);
    let corner = Triangle64([[0.0, 4.0, 0.0]; 3]);
    let far = [Triangle64([[9.0; 3], [11.0, 9.0, 9.0], [9.0, 11.0, 9.0]])];
    let mesh = Mesh::in_f64(vec![[&[segment, corner], &far[..]].concat()]);
    let mut pair = Pair::new();
    pair.add(&mesh, matrix(ONE, [1.0; 3], [0.0; 3]));
    pair.add(&mesh, matrix(ONE, [-1.0, 2.0, 1.0], [1.0; 3]));
    let points = [[3.0, 0.5, 0.0], [0.0, 4.0, 0.0], [3.0, 0.5, 1.0], [-2.0, 2.0, 1.0], [9.5; 3]];
    let (snapshot, flat) = (pair.scene.commit().unwrap(), pair.flat(u32::MAX));
    compare_points(&snapshot, &flat, &points, "no area");
    assert_eq!(snapshot.closest_point(points[0], 0.0).unwrap().closest.triangle, 0);
    assert_eq!(snapshot.classify(points[0]), Containment::Outside);
}

/// A snapshot keeps its state while the scene changes. If two hits have the same t, the hit on the
/// instance with the lower number wins.
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
    // Mirroring the wall swaps its front and back faces.
    let front = first.closest(&ray).unwrap().leaves;
    scene.place(ids[1], matrix(ONE, [-1.0, 1.0, 1.0], [0.0; 3])).unwrap();
    assert_eq!(scene.commit().unwrap().closest(&ray).unwrap().leaves, !front);
    // The removed instance's number is reused.
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
