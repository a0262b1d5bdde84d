//! Tests that classifying a batch of points returns the same results as classifying each point
//! alone. The points are inside and outside the mesh, on its surface, and close to the surface.

use intertri::Triangle;
use intertri_trace::{Bvh, Containment, Solid};

/// Returns a sphere of `rings` rings. Seen from outside, the corners of each triangle run
/// counter-clockwise.
fn globe(rings: usize, centre: f32) -> Vec<Triangle> {
    let corner = |ring: usize, i: usize| {
        let (a, b) = (ring as f32 / rings as f32, (i % rings) as f32 / rings as f32);
        let (a, b) = (a * std::f32::consts::PI, b * std::f32::consts::TAU);
        // The poles are single points.
        let r = if ring == 0 || ring == rings { 0.0 } else { a.sin() };
        [centre + r * b.cos(), a.cos(), r * b.sin()]
    };
    let squares = (0..rings * rings).map(|i| (i / rings, i % rings));
    let halves = squares.flat_map(|(ring, i)| {
        let [a, b] = [corner(ring, i), corner(ring, i + 1)];
        let [c, d] = [corner(ring + 1, i), corner(ring + 1, i + 1)];
        [Triangle([a, b, c]), Triangle([d, c, b])]
    });
    halves.collect()
}

#[test]
fn a_batch_tells_what_single_points_are_told() {
    // The mesh consists of two overlapping spheres and a small sphere, turned inside out, within
    // the first one.
    let small = globe(8, 0.0).into_iter().map(|intertri::TriangleOf([a, b, c])| {
        Triangle([a, c, b].map(|corner| corner.map(|x| 0.25 * x)))
    });
    let mesh: Vec<Triangle> =
        globe(16, 0.0).into_iter().chain(globe(20, 1.0)).chain(small).collect();
    let solid = Solid::new(&mesh).unwrap();

    // The points are corners, midpoints of edges, points next to corners, a grid through the whole
    // mesh, and extreme or invalid points.
    let mut points: Vec<[f32; 3]> = mesh.iter().flat_map(|t| t.0).collect();
    points.extend(mesh.iter().map(|t| [0, 1, 2].map(|k| 0.5 * (t.0[0][k] + t.0[1][k]))));
    points.extend(mesh.iter().map(|t| [t.0[0][0].next_up(), t.0[0][1], t.0[0][2].next_down()]));
    let at = |i: usize| (i as f32 - 10.0) / 8.0;
    points.extend((0..9261).map(|i| [at(i % 21) + 0.4, at(i / 21 % 21), at(i / 441)]));
    points.extend([[f32::NAN, 0.0, 0.0], [f32::INFINITY; 3], [f32::MAX; 3], [1e-45, 0.0, 0.0]]);

    let mut containments = vec![Containment::Surface; points.len()];
    let mut contains = vec![false; points.len()];
    solid.classify_batch_into(&points, &mut containments);
    solid.contains_batch_into(&points, &mut contains);
    for ((point, containment), contains) in points.iter().zip(&containments).zip(&contains) {
        assert_eq!(*containment, solid.classify(*point), "{point:?}");
        assert_eq!(*contains, *containment != Containment::Outside, "{point:?}");
    }
    let count =
        |of: Containment| containments.iter().filter(|&&containment| containment == of).count();
    assert!(count(Containment::Surface) >= 3 * mesh.len());
    let counts = [1, 2].map(|times| count(Containment::Inside(times)));
    assert!(counts.iter().all(|&count| count > 100), "{counts:?}");
    // Inside the inverted sphere, its winding number of -1 cancels that of the first sphere.
    assert_eq!(solid.classify([0.1, -0.02, 0.01]), Containment::Inside(1));
    assert_eq!(solid.classify([-0.1, -0.02, 0.01]), Containment::Outside);
    assert_eq!(solid.classify([0.5, 0.01, 0.02]), Containment::Inside(2));
}

/// Masks affect only ray queries, so they cannot remove a mesh from a solid.
#[test]
fn masks_do_not_open_a_solid() {
    let (one, other) = (globe(12, 0.0), globe(12, 5.0));
    let mut bvh = Bvh::from_meshes(&[&one, &other]).unwrap();
    bvh.set_mask(0, 0);
    let solid = Solid::assume_closed_bvh(bvh);
    let at = |i: usize| (i as f32 - 20.0) / 5.0;
    let mut points: Vec<[f32; 3]> =
        (0..1681).map(|i| [at(i % 41), 0.03 * at(i / 41), 0.1]).collect();
    points.extend(one.iter().map(|t| t.0[0]));
    let mut containments = vec![Containment::Outside; points.len()];
    solid.classify_batch_into(&points, &mut containments);
    for (point, containment) in points.iter().zip(&containments) {
        assert_eq!(*containment, solid.classify(*point), "{point:?}");
    }
    assert_eq!(solid.classify([0.0, 0.03, 0.01]), Containment::Inside(1));
    assert_eq!(solid.signed_distance([0.0, 0.0, 0.0]).signum(), -1.0);
    assert!(
        containments.iter().filter(|&&containment| containment == Containment::Inside(1)).count()
            > 100
    );
}
