//! Tests that visible edges, and only visible edges, are drawn over an image.

use crate::common::{cuboid, view_of};
use intertri_raster::{Adjacency, Light, facing, silhouette, triangles, wire};
use intertri_scene::Camera;

#[test]
fn a_box_shows_nine_of_its_edges() {
    let soup = cuboid([-1.0; 3], [1.0; 3]);
    let camera = Camera::new([3.0, 4.0, 5.0], [0.0; 3], Camera::UP, 40.0).unwrap();
    let view = view_of(&camera, 160, 120);
    let hits = triangles(&view, &soup, 1e-9);
    let adjacency = Adjacency::new(&soup);

    // Select all edges except the diagonals of the faces.
    let length = |[a, b]: [u32; 2]| {
        let [a, b] = [a, b].map(|end| adjacency.points()[end as usize]);
        (0..3).map(|k| (a[k] - b[k]).abs()).sum::<f32>()
    };
    let edges: Vec<[u32; 2]> =
        adjacency.edges().map(|edge| edge.ends).filter(|&ends| length(ends) == 2.0).collect();
    assert_eq!(edges.len(), 12);

    let visible =
        |ends: [u32; 2]| wire(&view, &hits, &adjacency, [ends]).iter().filter(|d| **d).count();
    let corner = [-1.0; 3];
    for &ends in &edges {
        let at_back = ends.iter().any(|&end| adjacency.points()[end as usize] == corner);
        let pixels = visible(ends);
        // A hidden edge may still show one pixel at each visible corner where it ends.
        assert!(if at_back { pixels <= 2 } else { pixels >= 20 }, "{ends:?}: {pixels}");
    }

    // The silhouette has six edges, all of them visible.
    let eye = Light::Point { position: camera.eye(), reach: 1.0 };
    let outline = silhouette(&adjacency, &facing(&adjacency, &eye));
    assert_eq!(outline.len(), 6);
    assert!(outline.iter().all(|edge| visible(edge.ends) >= 20));
}

#[test]
fn edges_behind_the_eye_or_beyond_the_picture_are_cut() {
    let soup = [intertri::Triangle([[-9.0, 0.0, 5.0], [9.0, 0.0, -5.0], [0.0, 50.0, 30.0]])];
    let camera = Camera::new([0.0, -0.5, 3.0], [0.0, 0.0, 0.0], Camera::UP, 60.0).unwrap();
    let view = view_of(&camera, 64, 64);
    let adjacency = Adjacency::new(&soup);
    let nothing = vec![intertri::Hit::MISS; 64 * 64];
    let drawn = wire(&view, &nothing, &adjacency, adjacency.edges().map(|edge| edge.ends));
    let pixels = drawn.iter().filter(|d| **d).count();
    assert!((32..300).contains(&pixels), "{pixels}");

    let bad =
        Adjacency::new(&[intertri::Triangle([[f32::NAN; 3], [0.0; 3], [1.0, f32::INFINITY, 0.0]])]);
    let drawn = wire(&view, &nothing, &bad, bad.edges().map(|edge| edge.ends));
    assert!(drawn.iter().all(|d| !d));
}
