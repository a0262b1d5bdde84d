//! Compares scenes of instances with a plain loop over the flattened triangles, before and after
//! instances change.

use std::sync::Arc;

use intertri::{Hit, Mode, Ray, Ray64, Triangle, Triangle64};
use intertri_trace::{
    Bvh, ClosestPoint, InstanceId, Scene, SceneClosestPoint, SceneHit, SceneSnapshot, Solid,
};

use super::input::Input;

/// A mesh, an instance of it, and the instance's matrix.
type Instance<'a> = (&'a [Triangle], InstanceId, [f64; 12]);

/// Builds one mesh in f32 and one in f64, places a few instances of them, and checks queries for
/// rays aimed at the placed triangles.
pub fn instances(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let meshes = [input.triangles(20), input.triangles(20)];
    let in_f32 = Arc::new(Bvh::new(&meshes[0]).expect("the mesh is small enough"));
    let in_f64: Vec<Triangle64> = meshes[1].iter().map(|t| widened(*t)).collect();
    let in_f64 = Arc::new(Bvh::new(&in_f64).expect("the mesh is small enough"));

    let (mut scene, mut placed) = (Scene::new(), Vec::new());
    for _ in 0..=input.below(5) {
        let (mesh, matrix) = (input.below(2), matrix(&mut input));
        let id = if mesh == 0 {
            scene.add(in_f32.clone(), matrix)
        } else {
            scene.add(in_f64.clone(), matrix)
        };
        match id {
            Ok(id) => placed.push((&*meshes[mesh], id, matrix)),
            Err(error) => assert!(matrix.iter().any(|x| !x.is_finite()), "{error}"),
        }
    }
    check(&mut input, &scene.commit().expect("the scene is small enough"), &placed);

    for (_, id, was) in &mut placed {
        let matrix = matrix(&mut input);
        if scene.place(*id, matrix).is_ok() {
            *was = matrix;
        }
    }
    if let Some((_, id, _)) = placed.pop() {
        scene.remove(id).expect("the instance exists");
    }
    check(&mut input, &scene.commit().expect("the scene is small enough"), &placed);

    // Hide an instance from the queries below, and save and reload the scene.
    if let Some((_, id, _)) = placed.pop() {
        scene.set_mask(id, 0b10).expect("the instance exists");
    }
    let saved = scene.to_bytes();
    let loaded = Scene::from_bytes(&saved).expect("the file is valid");
    assert!(loaded.to_bytes() == saved);
    check(&mut input, &loaded.commit().expect("the scene is small enough").mask(0b01), &placed);
}

/// Generates a matrix whose elements are numbers of the input's kind or have arbitrary bit
/// patterns. Many of the matrices are plain translations.
fn matrix(input: &mut Input<'_>) -> [f64; 12] {
    let mut matrix = [0.0; 12];
    let kind = input.below(4);
    for (i, x) in matrix.iter_mut().enumerate() {
        let is_plain = kind < 2 && i % 4 != 3;
        *x = match input.below(32) {
            0 => input.double(),
            1 => f64::from(input.number()) / 3.0,
            _ if is_plain => f64::from(u8::from(i % 5 == 0)),
            _ => f64::from(input.number()),
        };
    }
    matrix
}

fn widened(Triangle(corners): Triangle) -> Triangle64 {
    Triangle64(corners.map(|corner| corner.map(f64::from)))
}

/// Transforms a triangle to world space exactly as defined in `docs/numerics/instances.md`.
fn flattened(m: &[f64; 12], triangle: Triangle) -> Triangle64 {
    let at = |[x, y, z]: [f64; 3]| {
        [0, 4, 8].map(|i| ((m[i] * x + m[i + 1] * y) + m[i + 2] * z) + m[i + 3])
    };
    Triangle64(widened(triangle).0.map(at))
}

/// Compares every query with a plain loop, for several rays and points.
fn check(input: &mut Input<'_>, snapshot: &SceneSnapshot, placed: &[Instance<'_>]) {
    let (mut all, mut names) = (Vec::new(), Vec::new());
    for (triangles, id, matrix) in placed {
        all.extend(triangles.iter().map(|&triangle| flattened(matrix, triangle)));
        names.extend((0..triangles.len() as u32).map(|triangle| (*id, triangle)));
    }
    let near = |t: &Triangle64| Triangle(t.0.map(|corner| corner.map(|x| x as f32)));
    let rounded: Vec<Triangle> = all.iter().map(near).collect();
    if rounded.is_empty() {
        return;
    }
    let named = |hit: Hit| {
        let (instance, triangle) = names[hit.triangle as usize];
        (instance, triangle, [hit.t, hit.u, hit.v].map(f64::to_bits))
    };
    let solid = Solid::assume_closed(&all).expect("the mesh is small enough");
    let found = |SceneHit { hit, instance, .. }: SceneHit| {
        (instance, hit.triangle, [hit.t, hit.u, hit.v].map(f64::to_bits))
    };
    let mut many = Vec::new();
    for _ in 0..4 {
        let Ray { origin, t_min, dir, t_max } = input.ray(&rounded);
        let ray = Ray64::new(origin.map(f64::from), dir.map(f64::from));
        let ray = ray.between(t_min.into(), t_max.into());
        let exact = Mode::exact();
        let closest = exact.closest(&all, &ray).map(named);
        assert_eq!(snapshot.closest(&ray).map(found), closest, "{ray:?} {placed:?}");
        assert_eq!(snapshot.any(&ray), closest.is_some(), "{ray:?} {placed:?}");
        // Add neighbouring rays, so that batches can trace them in packets.
        let step = f64::from(input.number()) / 1024.0;
        many.extend((0..20).map(|i| {
            let [x, y, z] = ray.origin;
            Ray64 { origin: [x + f64::from(i % 4) * step, y + f64::from(i / 4) * step, z], ..ray }
        }));
        let expected: Vec<_> = exact.all(&all, &ray).into_iter().map(named).collect();
        let hits: Vec<_> = snapshot.all(&ray).into_iter().map(found).collect();
        assert_eq!(hits, expected, "{ray:?} {placed:?}");
        let crossings = exact.crossings(&all, &ray).into_iter();
        let expected: Vec<_> = crossings.map(|c| (named(c.hit), c.leaves)).collect();
        let crossings = snapshot.crossings(&ray).into_iter();
        let hits: Vec<_> = crossings.map(|hit| (found(hit), hit.leaves)).collect();
        assert_eq!(hits, expected, "{ray:?} {placed:?}");

        // Query the ray's origin, a corner, and a point near the hit.
        let at = closest.map_or(1.0, |(.., [t, _, _])| f64::from_bits(t));
        let hit = [0, 1, 2].map(|k| ray.origin[k] + at * ray.dir[k]);
        for point in [ray.origin, all[0].0[0], hit] {
            assert_eq!(snapshot.classify(point), solid.classify(point), "{point:?} {placed:?}");
            for radius in [f64::INFINITY, 1.0] {
                let expected = solid.bvh().closest_point(point, radius).map(|found| {
                    let (instance, triangle) = names[found.triangle as usize];
                    SceneClosestPoint { closest: ClosestPoint { triangle, ..found }, instance }
                });
                let found = snapshot.closest_point(point, radius);
                assert_eq!(found, expected, "{point:?} {radius} {placed:?}");
            }
        }
    }
    let (hits, any) = (snapshot.closest_batch(&many), snapshot.any_batch(&many));
    for ((ray, hit), any) in many.iter().zip(hits).zip(any) {
        let alone = snapshot.closest(ray);
        assert_eq!(hit.is_hit().then(|| found(hit)), alone.map(found), "{ray:?} {placed:?}");
        assert_eq!(any, alone.is_some(), "{ray:?} {placed:?}");
    }
}
