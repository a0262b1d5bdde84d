//! Tests document C: silhouettes, closed volumes, and what the document's own indices would draw.

use intertri_reference::Vector;
use intertri_reference::shadow_volume::{Adj, Light, extrude, front_culled, silhouette};
use std::collections::BTreeMap;

/// Returns the cube from -1 to 1, wound counter-clockwise as seen from outside.
fn cube() -> (Vec<Vector>, Vec<[usize; 3]>) {
    let side = |i: usize, bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    let vertx = (0..8).map(|i| Vector::new(side(i, 0), side(i, 1), side(i, 2))).collect();
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    (vertx, faces)
}

/// Returns the document's ADJ for consistently wound faces.
fn adjacency(faces: &[[usize; 3]]) -> Vec<Adj> {
    let owner = |edge: [usize; 2]| {
        faces.iter().position(|&[a, b, c]| [[a, b], [b, c], [c, a]].contains(&edge))
    };
    faces.iter().map(|&[a, b, c]| [owner([b, a]), owner([c, b]), owner([a, c])]).collect()
}

fn at(vertx: &[Vector], triangle: [usize; 3]) -> [Vector; 3] {
    triangle.map(|index| vertx[index])
}

/// Returns the number of silhouette edges, and the closed volume: the sides, the lit faces as the
/// near cap, and their reversed copies at the far end as the far cap.
fn closed(
    vertx: &[Vector],
    faces: &[[usize; 3]],
    light: Light,
    big: f64,
) -> (usize, Vec<[Vector; 3]>) {
    let front = front_culled(vertx, faces, light);
    let edges = silhouette(faces, &adjacency(faces), &front);
    let sides = extrude(vertx, &edges, light, big);
    let mut volume: Vec<_> = sides.triangles.iter().map(|&t| at(&sides.vertx, t)).collect();
    for (face, _) in faces.iter().zip(&front).filter(|(_, front)| **front) {
        let [c1, c2, c3] = at(vertx, *face);
        let far = |p: Vector| {
            let from_light = match light {
                Light::Directional(to_light) => to_light.unit() * -1.0,
                Light::Point(place) => (place - p).unit() * -1.0,
            };
            p + from_light * big
        };
        volume.push([c1, c2, c3]);
        volume.push([far(c3), far(c2), far(c1)]);
    }
    (edges.len(), volume)
}

/// Returns the number of directed edges that do not occur as often as their reverse, which is 0 for
/// a closed surface.
fn open_edges(volume: &[[Vector; 3]]) -> usize {
    let key = |p: Vector| <[f64; 3]>::from(p).map(f64::to_bits);
    let mut count = BTreeMap::new();
    for &[a, b, c] in volume {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *count.entry((key(from), key(to))).or_insert(0) += 1;
            *count.entry((key(to), key(from))).or_insert(0) -= 1;
        }
    }
    count.values().filter(|n| **n != 0).count()
}

/// Computes the enclosed volume by the divergence theorem. It is positive if the surface faces
/// outward.
fn contents(volume: &[[Vector; 3]]) -> f64 {
    volume.iter().map(|&[a, b, c]| (a & (b ^ c)) / 6.0).sum()
}

#[test]
fn a_directional_light_on_a_cube() {
    let (vertx, faces) = cube();
    assert_eq!(faces.len(), 12);
    let lit_from = |x, y, z| Light::Directional(Vector::new(x, y, z));
    // From directly above, the top's two triangles are front culled, and so are the vertical faces,
    // which are edge-on (0 >= 0).
    let front = front_culled(&vertx, &faces, lit_from(0.0, 0.0, 1.0));
    assert_eq!(front.iter().filter(|front| **front).count(), 10);
    // From a general direction, three sides are front culled, and the silhouette has six edges.
    let light = lit_from(0.3, 0.5, 1.0);
    let front = front_culled(&vertx, &faces, light);
    assert_eq!(front.iter().filter(|front| **front).count(), 6);
    assert_eq!(silhouette(&faces, &adjacency(&faces), &front).len(), 6);
}

#[test]
fn edges_keep_the_order_of_the_front_culled_face() {
    let faces = [[0, 1, 2], [2, 1, 3]];
    let adj = [[None, Some(1), None], [Some(0), None, None]];
    assert_eq!(silhouette(&faces, &adj, &[true, false]), [[0, 1], [1, 2], [2, 0]]);
    assert_eq!(silhouette(&faces, &adj, &[false, true]), [[2, 1], [1, 3], [3, 2]]);
    // A missing neighbour counts as back culled; a front-culled neighbour does not.
    assert_eq!(silhouette(&faces, &adj, &[true, true]), [[0, 1], [2, 0], [1, 3], [3, 2]]);
    assert_eq!(silhouette(&faces, &adj, &[false, false]), [[0; 2]; 0]);
}

#[test]
fn volumes_are_closed_and_look_outward() {
    let (vertx, faces) = cube();
    let open = faces[..7].to_vec();
    let single = vec![[0, 3, 6]];
    for light in [
        Light::Directional(Vector::new(0.0, 0.0, 1.0)),
        Light::Directional(Vector::new(0.0, 1.0, 0.0)),
        Light::Directional(Vector::new(-2.0, 0.5, 0.0)),
        Light::Directional(Vector::new(0.3, -0.7, 0.2)),
        Light::Point(Vector::new(0.2, 0.3, 1.5)),
        Light::Point(Vector::new(5.0, 7.0, -9.0)),
    ] {
        for faces in [&faces, &open, &single] {
            let light = match light {
                // With unit length, the far ends computed by this test have the same bits as those
                // of `extrude`.
                Light::Directional(to_light) => Light::Directional(to_light.unit()),
                place @ Light::Point(_) => place,
            };
            let (edges, volume) = closed(&vertx, faces, light, 100.0);
            if volume.is_empty() {
                continue;
            }
            assert!(edges >= 3);
            assert_eq!(open_edges(&volume), 0, "{light:?}, {} faces", faces.len());
            assert!(contents(&volume) >= 0.0, "{light:?}, {} faces", faces.len());
        }
    }
    // The two top faces form a 2×2 square, which is extruded by 100.
    let top: Vec<_> = faces[2..4].to_vec();
    let (edges, volume) =
        closed(&vertx, &top, Light::Directional(Vector::new(0.0, 0.0, 1.0)), 100.0);
    assert_eq!((edges, volume.len()), (4, 12));
    assert!((contents(&volume) - 400.0).abs() < 1e-9);
    // From a light inside the cube, no face is front culled, so there is no volume.
    let inside = Light::Point(Vector::new(0.1, 0.2, 0.3));
    assert!(closed(&vertx, &faces, inside, 100.0).1.is_empty());
}

#[test]
fn the_documents_vertices_would_make_no_quad() {
    // The edge from (0, 0, 0) to (1, 0, 0), with light from above, extruded by 1.
    let vertx = [Vector::default(), Vector::new(1.0, 0.0, 0.0)];
    let light = Light::Directional(Vector::new(0.0, 0.0, 1.0));
    let area = |[a, b, c]: [Vector; 3]| ((b - a) ^ (c - a)).y / 2.0;

    // As in the document, index3 comes from index1 and index4 from index2. The halves wind in
    // opposite directions, and neither contains the point next to the edge from index2 to index4.
    let listed = [vertx[0], vertx[1], Vector::new(0.0, 0.0, -1.0), Vector::new(1.0, 0.0, -1.0)];
    let (first, second) = (at(&listed, [1, 0, 2]), at(&listed, [3, 2, 0]));
    assert_eq!(area(first), -area(second));
    let beside = Vector::new(0.9, 0.0, -0.5);
    let contains = |[a, b, c]: [Vector; 3]| {
        let turns = [[a, b], [b, c], [c, a]].map(|[a, b]| area([a, b, beside]));
        turns.iter().all(|t| *t > 0.0) || turns.iter().all(|t| *t < 0.0)
    };
    assert!(!contains(first) && !contains(second));

    // With the new vertices exchanged, the same triples form the quad.
    let sides = extrude(&vertx, &[[0, 1]], light, 1.0);
    assert_eq!(sides.triangles, [[1, 0, 2], [3, 2, 0]]);
    assert_eq!(sides.vertx[2..], [listed[3], listed[2]]);
    let quad = [at(&sides.vertx, [1, 0, 2]), at(&sides.vertx, [3, 2, 0])];
    assert_eq!(quad.map(area), [-0.5, -0.5]);
    assert!(contains(quad[0]) != contains(quad[1]));
}

#[test]
fn odd_lights() {
    let (vertx, faces) = cube();
    // If the light's direction contains NaN, no face is front culled, so there is nothing to draw.
    let nan = Light::Directional(Vector::new(f64::NAN, 0.0, 0.0));
    assert!(front_culled(&vertx, &faces, nan).iter().all(|front| !front));
    // If the light is at a vertex, that end of the edge stays in place.
    let sides = extrude(&vertx, &[[0, 1]], Light::Point(vertx[0]), 10.0);
    assert_eq!(sides.vertx[9], vertx[0]);
    assert_eq!(sides.vertx[8], Vector::new(11.0, -1.0, -1.0));
    // If there are no edges, there are no sides.
    assert!(extrude(&vertx, &[], nan, 10.0).triangles.is_empty());
}
