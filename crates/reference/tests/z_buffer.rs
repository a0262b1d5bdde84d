//! Tests document B: the inside test in both orientations, any number of vertices, depth, and
//! degenerate facets.

use intertri_reference::z_buffer::{ZBuffer, inside, turns};
use intertri_reference::{Ray, Scene, Vector};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn v(x: f64, y: f64, z: f64) -> Vector {
    Vector::new(x, y, z)
}

/// Returns a regular outline with `n` vertices, clockwise if y points up.
fn round(n: usize, x: f64, y: f64, radius: f64) -> Vec<Vector> {
    let turn = |k| -std::f64::consts::TAU * f64::from(k) / n as f64;
    (0..n as i32).map(|k| v(x + radius * turn(k).cos(), y + radius * turn(k).sin(), 1.0)).collect()
}

fn reversed(outline: &[Vector]) -> Vec<Vector> {
    outline.iter().rev().copied().collect()
}

fn draw(width: usize, height: usize, facets: &[&[Vector]]) -> ZBuffer {
    let mut buffer = ZBuffer::new(width, height);
    for (facet, outline) in facets.iter().enumerate() {
        buffer.draw(facet, outline);
    }
    buffer
}

#[test]
fn the_rule_is_for_clockwise_outlines_with_y_up() {
    let clockwise = [v(0.0, 0.0, 0.0), v(0.0, 2.0, 0.0), v(2.0, 0.0, 0.0)];
    let centre = v(0.5, 0.5, 0.0);
    assert_eq!(turns(&clockwise, centre).collect::<Vec<_>>(), [-1.0, -2.0, -1.0]);
    assert!(inside(&clockwise, centre));
    assert!(!inside(&reversed(&clockwise), centre));
    for on in
        [v(0.0, 0.0, 0.0), v(0.0, 2.0, 0.0), v(2.0, 0.0, 0.0), v(1.0, 1.0, 0.0), v(0.0, 1.0, 0.0)]
    {
        assert!(inside(&clockwise, on), "{on:?} is on the outline");
    }
    for out in [v(-0.1, 1.0, 0.0), v(1.0, -0.1, 0.0), v(1.1, 1.0, 0.0), v(f64::NAN, 0.5, 0.0)] {
        assert!(!inside(&clockwise, out), "{out:?}");
    }
}

#[test]
fn a_rectangle_covers_its_pixels_whichever_way_it_runs() {
    // A rectangle from x = 1 to 4 and from y = 1.5 to 3.5 covers columns 1 to 3 and rows 1 to 3.
    // Its upper and lower edges run through pixel centres.
    let outline = [v(1.0, 1.5, 7.0), v(4.0, 1.5, 7.0), v(4.0, 3.5, 7.0), v(1.0, 3.5, 7.0)];
    for outline in [outline.to_vec(), reversed(&outline)] {
        let buffer = draw(6, 5, &[&outline]);
        for m in 0..5 {
            for n in 0..6 {
                let covered = (1..=3).contains(&n) && (1..=3).contains(&m);
                assert_eq!(buffer.facet[m * 6 + n], covered.then_some(0), "column {n}, row {m}");
                let depth = if covered { 7.0 } else { f64::INFINITY };
                assert_eq!(buffer.depth[m * 6 + n], depth);
            }
        }
    }
}

#[test]
fn any_number_of_vertices() {
    for n in [3, 4, 5, 7, 12, 1000] {
        let outline = round(n, 20.3, 19.6, 15.2);
        let buffer = draw(40, 40, &[&outline]);
        let covered = buffer.facet.iter().flatten().count() as f64;
        let angle = std::f64::consts::TAU / n as f64;
        let area = 0.5 * n as f64 * 15.2 * 15.2 * angle.sin();
        assert!((covered - area).abs() < 16.0, "{n} vertices: {covered} pixels of {area}");
        assert_eq!(buffer.facet, draw(40, 40, &[&reversed(&outline)]).facet, "{n} vertices");
    }
}

#[test]
fn nearest_wins_and_the_first_of_equals_stays() {
    let at = |z| [v(0.0, 0.0, z), v(9.0, 0.0, z), v(0.0, 9.0, z)];
    assert_eq!(draw(1, 1, &[&at(3.0), &at(1.0), &at(2.0)]).facet, [Some(1)]);
    assert_eq!(draw(1, 1, &[&at(3.0), &at(3.0)]).facet, [Some(0)]);
    assert_eq!(draw(1, 1, &[&at(3.0), &at(-3.0)]).depth, [-3.0]);
}

#[test]
fn crossing_facets_split_the_picture_where_they_cross() {
    // One facet rises from 0 to 10 over 10 columns, and the other falls. They cross at x = 5.
    let rising = [v(0.0, 0.0, 0.0), v(10.0, 0.0, 10.0), v(10.0, 1.0, 10.0), v(0.0, 1.0, 0.0)];
    let falling = rising.map(|p| v(p.x, p.y, 10.0 - p.z));
    let buffer = draw(10, 1, &[&rising, &falling]);
    for n in 0..10 {
        assert_eq!(buffer.facet[n], Some(usize::from(n >= 5)), "column {n}");
        assert_eq!(buffer.depth[n], (n as f64 + 0.5).min(9.5 - n as f64));
    }
}

#[test]
fn without_area_or_not_finite_draws_nothing() {
    let (a, b, c) = (v(0.0, 0.0, 1.0), v(4.0, 4.0, 1.0), v(0.0, 4.0, 1.0));
    let line = [a, v(2.0, 2.0, 1.0), b];
    // Under the document's rule alone, a facet collapsed to a line would own every point on that
    // line, and one collapsed to a point would own every pixel.
    assert!(inside(&line, v(9.5, 9.5, 0.0)) && inside(&[a; 3], v(3.0, 1.0, 0.0)));
    let nothing = ZBuffer::new(5, 5);
    let edge_on = [a, b, v(2.0, 2.0, 3.0)];
    for outline in [&line[..], &edge_on, &[a; 3], &[a, b, b], &[a, b], &[a], &[]] {
        assert_eq!(draw(5, 5, &[outline]), nothing, "{outline:?}");
    }
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for p in [v(bad, 0.0, 1.0), v(0.0, bad, 1.0), v(0.0, 0.0, bad)] {
            assert_eq!(draw(5, 5, &[&[p, b, c]]), nothing, "{p:?}");
            assert_eq!(draw(5, 5, &[&[b, c, v(0.0, 2.0, 1.0), p]]), nothing, "{p:?}");
        }
    }
    // A repeated vertex changes nothing.
    assert_eq!(draw(5, 5, &[&[a, a, b, c]]), draw(5, 5, &[&[a, b, c]]));
}

proptest! {
    // Test the same cases on every run.
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    /// Documents A and B agree for rays along z through the pixel centres.
    #[test]
    fn agrees_with_inter_tri(c in prop::collection::vec(prop::array::uniform3(0.0f32..12.0), 3..=24)) {
        let triangles: Vec<[[f32; 3]; 3]> = c.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        let mut buffer = ZBuffer::new(12, 12);
        for (facet, triangle) in triangles.iter().enumerate() {
            buffer.draw(facet, &triangle.map(Vector::from));
        }
        let scene = Scene::from_triangles(triangles.iter().copied());
        for m in 0..12 {
            for n in 0..12 {
                let p = v(n as f64 + 0.5, m as f64 + 0.5, -1.0);
                // If a centre is on an outline or a facet is nearly edge-on, rounding may decide
                // the result.
                let close = triangles.iter().any(|triangle| {
                    turns(&triangle.map(Vector::from), p).any(|c| c.abs() < 1e-6)
                });
                if close {
                    continue;
                }
                let hit = scene.closest(&Ray { org: p, dir: v(0.0, 0.0, 1.0) }, 0.0, f64::INFINITY);
                let pixel = m * 12 + n;
                prop_assert_eq!(buffer.facet[pixel], hit.map(|(facet, _)| facet));
                if let Some((_, t)) = hit {
                    prop_assert!((buffer.depth[pixel] - (t - 1.0)).abs() < 1e-5);
                }
            }
        }
    }
}
