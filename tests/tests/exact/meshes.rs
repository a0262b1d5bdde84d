//! Checks the three theorems of `docs/numerics/exact.md` on closed meshes. Every crossing under the
//! once rule is a hit under the closed rule. The signed crossings of every ray add up to the
//! winding number of the ray's origin. If this winding number is not 0, the ray hits the mesh.

use std::collections::BTreeMap;

use intertri::internal::exact::{self, Side, Tier, crossing_from};
use intertri::{Hit, Mode, Ray, Rule, Triangle, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_tests::oracle;
use intertri_trace::{Containment, Solid};

use super::solids::{Closed, meshes};

/// Returns the winding number of a mesh around a point, computed from the solid angles of its
/// triangles, or `None` if the point is on the mesh or too close to it for a decision.
fn winding(mesh: &[Triangle], origin: [f32; 3]) -> Option<i32> {
    let mut sum = 0.0;
    for TriangleOf(corners) in mesh {
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

/// Generates directions from an origin: exactly toward corners, toward edges and the insides of
/// triangles, along axes, and at random.
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

/// Generates a point on the grid, near a corner, or at an arbitrary position.
fn origin(i: usize, mesh: &Closed, rng: &mut Rng) -> [f32; 3] {
    let Closed { triangles, scale, centre, .. } = mesh;
    let near = rng.pick(triangles).0[0].map(f64::from);
    let step = 2.0_f64.powi(-rng.within(5).abs() * (i % 12) as i32) * scale;
    [0, 1, 2].map(|k| match i % 3 {
        0 => (centre[k] + (rng.signed() * 1024.0).round() / 1024.0 * scale) as f32,
        1 => (near[k] + step * rng.signed()) as f32,
        _ => (centre[k] + 1.5 * rng.signed() * scale) as f32,
    })
}

#[test]
fn signed_crossings_are_the_winding_number() {
    let mut rng = Rng::new(9);
    let mut seen = BTreeMap::new();
    for mesh in meshes(1) {
        let Closed { name, triangles, .. } = &mesh;
        for i in 0..24 {
            let origin = origin(i, &mesh, &mut rng);
            if triangles.iter().any(|triangle| oracle::is_on(origin, triangle)) {
                continue;
            }
            let Some(winding) = winding(triangles, origin) else { continue };
            for dir in directions(triangles, origin, &mut rng) {
                let ray = Ray::new(origin, dir);
                let (mut crossings, mut hits) = (0, 0);
                for triangle in triangles {
                    let side = exact::crossing(&ray, triangle);
                    let hit = exact::hit(Rule::Closed, &ray, triangle);
                    assert!(hit || side.is_none(), "{ray:?} {triangle:?}");
                    crossings += side.map_or(0, Side::sign);
                    hits += u32::from(hit);
                    if i == 0 && side.is_some() {
                        let wide = crossing_from(Tier::Wide, Rule::Once, &ray, triangle);
                        assert_eq!(wide, side, "{ray:?} {triangle:?}");
                    }
                }
                assert_eq!(crossings, winding, "{name} {ray:?}");
                assert!(winding == 0 || hits > 0, "{name} {ray:?} leaks");
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

/// Traces rays through the hierarchy of a mesh. Returns the number of rays for each winding number.
fn through_a_hierarchy(mesh: &Closed, rays: usize, rng: &mut Rng) -> BTreeMap<i32, usize> {
    let Closed { name, triangles, .. } = mesh;
    let solid = Solid::new(triangles).unwrap();
    let (bvh, exact) = (solid.bvh(), Mode::exact());
    let mut query = bvh.query();
    let (mut seen, mut done) = (BTreeMap::new(), 0);
    for i in 0.. {
        if done >= rays {
            break;
        }
        let origin = origin(i, mesh, rng);
        // A point on the surface has no winding number, and rounded solid angles would not reveal
        // that it is on the surface.
        if triangles.iter().any(|triangle| oracle::is_on(origin, triangle)) {
            assert_eq!(solid.classify(origin), Containment::Surface, "{name} {origin:?}");
            continue;
        }
        let Some(winding) = winding(triangles, origin) else { continue };
        let containment =
            if winding == 0 { Containment::Outside } else { Containment::Inside(winding) };
        assert_eq!(solid.classify(origin), containment, "{name} {origin:?}");

        // All rays share an origin, so they form a bundle.
        let dirs = (0..3).flat_map(|_| directions(triangles, origin, rng));
        let rays: Vec<Ray> = dirs.map(|dir| Ray::new(origin, dir)).collect();
        let (counts, lists) = (query.count_crossings_batch(&rays), bvh.crossings_batch(&rays));
        let (any, hits, lists) = (bvh.any_batch(&rays), bvh.closest_batch(&rays), lists.unwrap());
        for (k, ray) in rays.iter().enumerate() {
            assert_eq!(counts[k].signed, i64::from(winding), "{name} {ray:?}");
            assert!(winding == 0 || any[k], "{name} {ray:?} leaks");
            assert_eq!(any[k], hits[k].is_hit(), "{name} {ray:?}");
            // Compare the triangle and every bit of the hit with the plain loop's hit.
            if k % 61 == i % 61 {
                let bits = |hit: Hit| (hit.triangle, [hit.t, hit.u, hit.v].map(f64::to_bits));
                let want = exact.closest(triangles, ray).unwrap_or(Hit::MISS);
                let one = query.closest(ray).unwrap_or(Hit::MISS);
                assert_eq!([bits(hits[k]), bits(one)], [bits(want); 2], "{name} {ray:?}");
                assert_eq!(query.all(ray), exact.all(triangles, ray), "{name} {ray:?}");
                let crossings = exact.crossings(triangles, ray);
                assert_eq!(query.crossings(ray), crossings, "{name} {ray:?}");
                assert_eq!(lists.of(k), crossings, "{name} {ray:?}");
                let next = query.next_crossing(ray);
                assert_eq!(next, crossings.first().copied(), "{name} {ray:?}");
                assert_eq!(counts[k].unsigned, crossings.len() as u64, "{name} {ray:?}");
            }
        }
        done += rays.len();
        *seen.entry(winding).or_insert(0) += rays.len();
    }
    seen
}

fn through_hierarchies(finer: usize, rays: usize) {
    let (mut rng, meshes) = (Rng::new(10), meshes(finer));
    let each = rays.div_ceil(meshes.len());
    let (mut all, mut inside) = (0, 0);
    for mesh in &meshes {
        let seen = through_a_hierarchy(mesh, each, &mut rng);
        println!("{}, {} triangles: {seen:?}", mesh.name, mesh.triangles.len());
        all += seen.values().sum::<usize>();
        inside += seen.iter().filter(|(winding, _)| **winding != 0).map(|(_, n)| n).sum::<usize>();
    }
    println!("{all} rays in {} meshes, {inside} of them from inside", meshes.len());
    assert!(inside > all / 10);
}

#[test]
fn hierarchies_count_the_winding_number() {
    through_hierarchies(1, 200_000);
}

/// Run this test by hand. `INTERTRI_EXACT_RAYS` sets the number of rays.
#[test]
#[ignore = "takes minutes"]
fn ten_million_rays_count_the_winding_number() {
    let rays = std::env::var("INTERTRI_EXACT_RAYS").map_or(10_000_000, |n| n.parse().unwrap());
    through_hierarchies(3, rays);
}
