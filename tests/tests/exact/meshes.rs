//! The three theorems, on closed meshes: what counts once counts by the closed rule; the signed crossings of
//! every ray are the winding number of its origin; where that is not 0, no ray leaks.

use intertri::internal::exact::{self, Rule, Side, Tier, crossing_from};
use intertri::{Ray, Triangle};
use intertri_lab::meshes::Mesh;
use intertri_lab::rng::Rng;

/// The corners on a grid, so that directions between them are exact.
fn snapped(mesh: Mesh, scale: f64, center: [f64; 3]) -> Vec<Triangle> {
    mesh.map(|p| {
        let on_grid = p.map(|x| (x * 4096.0).round() / 4096.0);
        [0, 1, 2].map(|k| f64::from((on_grid[k] * scale + center[k]) as f32))
    })
    .triangles()
}

/// Two cubes that share an edge, and one that shares a face with the first.
fn stuck() -> Vec<Triangle> {
    let cube = |by: [f64; 3]| Mesh::cube(2).map(|p| [0, 1, 2].map(|k| p[k] + by[k])).triangles();
    [[0.0; 3], [2.0, 2.0, 0.0], [0.0, 0.0, 2.0]].map(cube).concat()
}

/// With triangles that cancel, lie twice, or have no area.
fn soiled(mut mesh: Vec<Triangle>, rng: &mut Rng) -> Vec<Triangle> {
    for _ in 0..mesh.len() / 4 {
        let Triangle([a, b, c]) = rng.pick(&mesh);
        mesh.extend([Triangle([a, b, c]), Triangle([a, c, b])]);
        mesh.extend([Triangle([a, a, b]), Triangle([c, c, c])]);
    }
    mesh
}

/// Meshes whose oriented boundary cancels, and how large they are around which point.
fn meshes() -> Vec<(Vec<Triangle>, f64, [f64; 3])> {
    let (mut rng, o) = (Rng::new(7), [0.0; 3]);
    let sphere = |scale, center| (snapped(Mesh::icosphere(2), scale, center), scale, center);
    let torus = snapped(Mesh::torus(24, 12), 1.0, o);
    let twice = [snapped(Mesh::icosphere(1), 1.0, o), snapped(Mesh::icosphere(1), 1.0, o)].concat();
    let inverted = torus.iter().map(|&Triangle([a, b, c])| Triangle([a, c, b])).collect();
    let mut all = vec![
        sphere(1.0, o),
        sphere(1.0, [148_376.0, 1_234.0, -223_423.0]),
        sphere(1e18, o),
        sphere(1e-18, o),
        sphere(1e-39, o),
        (torus, 1.0, o),
        (inverted, 1.0, o),
        (twice, 1.0, o),
        (stuck(), 2.0, o),
    ];
    let more = [0, 5].map(|i| (soiled(all[i].0.clone(), &mut rng), 1.0, o));
    all.extend(more);
    all
}

/// The winding number of a mesh about a point, by the solid angles of its triangles; of a point on the
/// mesh or too near to tell, none.
fn winding(mesh: &[Triangle], origin: [f32; 3]) -> Option<i32> {
    let mut sum = 0.0;
    for Triangle(corners) in mesh {
        let seen = corners.map(|c| [0, 1, 2].map(|k| f64::from(c[k]) - f64::from(origin[k])));
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let unit = |v: [f64; 3]| v.map(|x| x / dot(v, v).sqrt());
        let [a, b, c] = seen.map(unit);
        let cross =
            [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let den = 1.0 + dot(a, b) + dot(b, c) + dot(c, a);
        sum += 2.0 * dot(a, cross).atan2(den);
    }
    let turns = sum / (4.0 * std::f64::consts::PI);
    ((turns - turns.round()).abs() < 1e-3).then(|| turns.round() as i32)
}

/// Directions from an origin: exactly at corners, at edges, into triangles, along axes and anywhere.
fn directions(mesh: &[Triangle], origin: [f32; 3], rng: &mut Rng) -> Vec<[f32; 3]> {
    let mut all = vec![];
    let to = |p: [f32; 3]| [0, 1, 2].map(|k| p[k] - origin[k]);
    let sum = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|k| a[k] + b[k]);
    for _ in 0..60 {
        let [a, b, c] = rng.pick(mesh).0.map(to);
        all.extend([a, sum(a, b), sum(sum(a, b), c), a.map(|x| -x), sum(a, a.map(|x| x * 0.5))]);
        all.push(rng.direction().map(|x| x as f32));
    }
    for axis in 0..6 {
        let mut dir = [0.0, -0.0, 0.0];
        dir[axis % 3] = if axis < 3 { 1.0 } else { -1e-30 };
        all.push(dir);
    }
    all.retain(|dir| *dir != [0.0; 3]);
    all
}

#[test]
fn signed_crossings_are_the_winding_number() {
    let mut rng = Rng::new(9);
    let mut seen = std::collections::BTreeMap::new();
    for (mesh, scale, center) in meshes() {
        for i in 0..24 {
            // On the grid, near a corner, or anywhere.
            let near = rng.pick(&mesh).0[0].map(f64::from);
            let step = 2.0_f64.powi(-rng.within(5).abs() * i % 12) * scale;
            let origin = [0, 1, 2].map(|k| match i % 3 {
                0 => (center[k] + (rng.signed() * 1024.0).round() / 1024.0 * scale) as f32,
                1 => (near[k] + step * rng.signed()) as f32,
                _ => (center[k] + 1.5 * rng.signed() * scale) as f32,
            });
            let Some(winding) = winding(&mesh, origin) else { continue };
            for dir in directions(&mesh, origin, &mut rng) {
                let ray = Ray::new(origin, dir);
                let (mut crossings, mut hits) = (0, 0);
                for triangle in &mesh {
                    let side = exact::crossing(&ray, triangle);
                    let hit = exact::hit(&ray, triangle);
                    assert!(hit || side.is_none(), "{ray:?} {triangle:?}");
                    crossings += side.map_or(0, Side::sign);
                    hits += u32::from(hit);
                    if i == 0 && side.is_some() {
                        let wide = crossing_from(Tier::Widest, Rule::Once, &ray, triangle);
                        assert_eq!(wide, side, "{ray:?} {triangle:?}");
                    }
                }
                assert_eq!(crossings, winding, "{ray:?} {scale:e} {center:?}");
                assert!(winding == 0 || hits > 0, "{ray:?} leaks");
                *seen.entry(winding).or_insert(0) += 1;
            }
        }
    }
    println!("{seen:?}");
    assert!(
        [-1, 0, 1, 2].iter().all(|number| seen.get(number).is_some_and(|&n| n > 300)),
        "{seen:?}"
    );
}
