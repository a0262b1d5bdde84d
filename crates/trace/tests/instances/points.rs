//! Tests ray and point queries of instanced scenes in rare cases: hidden geometries, needles,
//! triangles with zero area, and equal distances.

use std::sync::Arc;

use intertri::{Ray64, Triangle, Triangle64};
use intertri_trace::{Bvh, Containment, InstanceId, Scene};

use crate::scenes::{Mesh, Numbers, ONE, add, cube, matrix, placed, rotation};
use crate::{Pair, compare_points};

/// A geometry's mask hides it from rays, but not from point queries.
#[test]
fn geometries_that_rays_do_not_see_are_solid() {
    let moved = |by: f64| {
        let all = cube(2).into_iter();
        all.map(|t| Triangle64(t.0.map(|c| [c[0] + by, c[1], c[2]]))).collect::<Vec<_>>()
    };
    let (near, far) = (moved(0.0), moved(20.0));
    let mut bvh = Bvh::from_meshes(&[&near, &far]).unwrap();
    bvh.set_mask(0, 0);
    bvh.set_mask(1, 0b10);
    let mut scene = Scene::new();
    scene.add(Arc::new(bvh), matrix(ONE, [1.0, 2.0, -1.0], [0.0; 3])).unwrap();
    let snapshot = scene.commit().unwrap();
    let middle = |mesh: &[Triangle64]| {
        let corners = mesh.iter().flat_map(|t| t.0).collect::<Vec<_>>();
        let sum = corners.iter().fold([0.0; 3], |sum, c| add(sum, *c, 1.0));
        placed(&matrix(ONE, [1.0, 2.0, -1.0], [0.0; 3]), sum.map(|x| x / corners.len() as f64))
    };
    for mask in [u32::MAX, 0b01, 0b10] {
        let snapshot = snapshot.clone().mask(mask);
        for (geometry, mesh) in [(0, &near), (1, &far)] {
            let point = middle(mesh).map(|x| x + 0.01);
            let ray = Ray64::new(point, [0.3, 0.2, 0.1]);
            let sees = geometry == 1 && mask & 0b10 != 0;
            assert_eq!(snapshot.any(&ray), sees, "{geometry} {mask:b}");
            assert_ne!(snapshot.classify(point), Containment::Outside, "{geometry} {mask:b}");
            let closest = snapshot.closest_point(point, f64::INFINITY).unwrap().closest;
            assert_eq!(closest.geometry, geometry, "{mask:b}");
        }
    }
}

/// Needles that are too thin for f32 boxes are stored in leaves outside the main tree. Queries must
/// find them there.
#[test]
fn needles_are_near_points_and_surfaces() {
    let needles = [
        Triangle([[0.0; 3], [1.0, 1e-9, 0.5], [2.0, 3e-9, 1.0]]),
        Triangle([[0.1; 3], [1.1, 0.1, 0.1], [2.1, 0.100_000_01, 0.1]]),
        Triangle([[-3.0, 0.0, 0.0], [-3.0, 1.0, 0.0], [-3.0 + 3e-7, 0.5, 0.0]]),
        Triangle([[5.0, 1e-30, 0.0], [6.0, 0.0, 0.0], [7.0, 0.0, 1e-33]]),
        Triangle([[8.0, 0.0, 0.0], [10.0, 0.0, 0.0], [9.0, 1e-30, 0.0]]),
    ];
    let wall = Triangle([[0.0, 90.0, 0.0], [1.0, 90.0, 0.0], [0.0, 90.0, 1.0]]);
    let shared = Arc::new(Bvh::new(&[&needles[..], &[wall]].concat()).unwrap());
    let exact = |t: &Triangle| Triangle64(t.0.map(|corner| corner.map(f64::from)));
    let geometries = vec![needles.iter().chain([&wall]).map(exact).collect::<Vec<_>>()];
    let mesh = Mesh { shared: shared.into(), geometries, masks: vec![u32::MAX] };
    let mut numbers = Numbers(8);
    for placement in [
        matrix(ONE, [1.0; 3], [0.0; 3]),
        matrix(ONE, [2.0, -1.0, 0.5], [0.1, 0.2, 0.3]),
        matrix(rotation(&mut numbers), [1.0; 3], [3.0, 0.1, 0.0]),
        // These placements flatten the mesh, so rays are tested against boxes in world space.
        matrix(ONE, [1.0, 0.0, 1.0], [0.0; 3]),
        matrix(ONE, [1.0, 1.0, 0.0], [0.0; 3]),
    ] {
        let mut pair = Pair::new();
        let id = pair.add(&mesh, placement);
        let (snapshot, flat) = (pair.scene.commit().unwrap(), pair.flat(u32::MAX));
        if placement[0] == 1.0 && placement[5] == 1.0 {
            // This ray passes through the last needle, between its edges.
            let hit = snapshot.closest(&Ray64::new([9.0, 5e-31, 3.0], [0.0, 0.0, -1.0])).unwrap();
            assert_eq!((hit.hit.triangle, hit.hit.t), (4, 3.0));
        }
        let mut points = Vec::new();
        for (index, needle) in mesh.geometries[0].iter().enumerate() {
            let [a, b, c] = needle.0.map(|corner| placed(&placement, corner));
            for at in [a, b, c, add(a, add(b, a, -1.0), 0.5)] {
                points.extend([at, add(at, numbers.point(), 1e-12), add(at, numbers.point(), 0.1)]);
            }
            let found = snapshot.closest_point(a, f64::INFINITY).unwrap();
            assert_eq!((found.instance, found.closest.distance), (id, 0.0), "{index}");
            assert_eq!(snapshot.classify(b), flat.solid.classify(b), "{index}");
            // Trace one ray toward the needle from above and another from the side.
            let bvh = flat.solid.bvh();
            for ray in [
                Ray64::new(add(b, [0.0, 0.0, 1.0], 3.0), [0.0, 0.0, -1.0]),
                Ray64::new(add(c, [0.1, 7.0, 0.3], 1.0), [-0.1, -7.0, -0.3]),
            ] {
                let expected = bvh.closest(&ray).map(|hit| hit.t);
                assert_eq!(snapshot.closest(&ray).map(|hit| hit.hit.t), expected, "{index}");
            }
        }
        compare_points(&snapshot, &flat, &points, "needles");
    }
}

/// A triangle whose corners are collinear in the mesh may have a nonzero area in world space,
/// because the transformed corners are rounded.
#[test]
fn triangles_get_an_area_by_rounding() {
    let mut numbers = Numbers(4);
    let (mut surfaces, mut hits) = (0, 0);
    for _ in 0..200 {
        let turned = matrix(rotation(&mut numbers), [0.7, 1.3, 1.0], numbers.point());
        // The corners are exactly collinear.
        let [from, way] = [0; 2].map(|_| numbers.point().map(|x| (x * 64.0).round()));
        let line = [0.0, 1.0, 3.0].map(|by| add(from, way, by));
        let (flat, wide) = (Triangle64(line), Triangle64(line.map(|c| placed(&turned, c))));
        let far = Triangle64([[900.0; 3], [901.0, 900.0, 900.0], [900.0, 901.0, 900.0]]);
        let mesh = Mesh::in_f64(vec![vec![flat, far]]);
        let mut pair = Pair::new();
        pair.add(&mesh, turned);
        let (snapshot, flattened) = (pair.scene.commit().unwrap(), pair.flat(u32::MAX));
        let [a, b, c] = wide.0;
        for point in [a, b, c] {
            let expected = flattened.solid.classify(point);
            assert_eq!(snapshot.classify(point), expected, "{wide:?}");
            surfaces += usize::from(expected == Containment::Surface);
        }
        // Trace rays through the corners from all sides.
        for _ in 0..20 {
            let dir = numbers.point();
            let to = numbers.one_of(&[a, b, c]);
            let ray = Ray64::new(add(to, dir, -8.0), dir.map(|x| 8.0 * x));
            let expected = flattened.solid.bvh().closest(&ray).map(|hit| hit.t);
            assert_eq!(snapshot.closest(&ray).map(|hit| hit.hit.t), expected, "{wide:?}");
            hits += usize::from(expected.is_some());
        }
    }
    assert!(surfaces > 100, "{surfaces} {hits}");
}

/// No point is on or inside a triangle with zero area, even if the triangle is degenerate only in
/// world space.
#[test]
fn flat_triangles_are_no_surface() {
    let line = [[0.0; 3], [1.0, 1.0, 1.0], [3.0, 3.0, 3.0]];
    let mesh = Mesh::in_f64(vec![vec![
        Triangle64(line),
        Triangle64([[9.0; 3], [9.5, 9.0, 9.0], [9.0, 9.5, 9.0]]),
    ]]);
    // The last placement also flattens the other triangle.
    for placement in [
        matrix(ONE, [1.0; 3], [0.0; 3]),
        matrix(ONE, [-2.0, 4.0, 0.5], [0.25, 0.5, 1.0]),
        matrix(ONE, [1.0, 0.0, 0.0], [0.0; 3]),
    ] {
        let mut pair = Pair::new();
        pair.add(&mesh, placement);
        let (snapshot, flat) = (pair.scene.commit().unwrap(), pair.flat(u32::MAX));
        // These points are in the box around the line; some are on the line, and some are beside
        // it.
        let points = [[0.5; 3], [2.0; 3], [0.5, 2.0, 1.5], [1.0, 0.5, 2.5], [3.0; 3]];
        let points = points.map(|p| placed(&placement, p));
        compare_points(&snapshot, &flat, &points, "a line");
        for point in points {
            assert_eq!(snapshot.classify(point), Containment::Outside, "{placement:?} {point:?}");
        }
    }
}

/// Places a triangle six times, each time with its coordinate axes in a different order. All six
/// instances are equally far from a point whose three coordinates are equal, even though the
/// computed distances may be rounded differently. The first instance must win.
#[test]
fn equal_distances_belong_to_the_lower_instance() {
    let mut numbers = Numbers(5);
    let row = |axis: usize| [0, 1, 2].map(|k| if k == axis { 1.0 } else { 0.0 });
    let orders = [[1, 2, 0], [0, 1, 2], [2, 0, 1], [2, 1, 0], [0, 2, 1], [1, 0, 2]];
    for _ in 0..300 {
        let triangle = Triangle64([numbers.point(), numbers.point(), numbers.point()]);
        let mesh = Arc::new(Bvh::new(&[triangle]).unwrap());
        let mut scene = Scene::new();
        for order in orders {
            scene.add(mesh.clone(), matrix(order.map(row), [1.0; 3], [0.0; 3])).unwrap();
        }
        let snapshot = scene.commit().unwrap();
        for _ in 0..20 {
            let point = [3.0 * numbers.number(); 3];
            let found = snapshot.closest_point(point, f64::INFINITY).unwrap();
            assert_eq!(found.instance, InstanceId::from_index(0), "{triangle:?} {point:?}");
        }
    }
}
