//! Compares the z-buffer with the reference implementation of document B and with rays, and tests
//! edge cases.

use crate::common;
use crate::common::{Numbers, ball, floor, rays_of, view_of};
use intertri::{Hit, Mode, Triangle};
use intertri_raster::{Verdict, View, differences, facets, triangles};
use intertri_reference::vector::Vector;
use intertri_reference::z_buffer::ZBuffer;
use intertri_scene::Camera;

const THRESHOLD: f64 = 1e-9;

/// Returns a view from the origin along -z with a field of view of 90 degrees.
fn ahead(width: u32, height: u32) -> View {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    View::new([0.0; 3], axes, 1.0, width, height).unwrap()
}

/// Draws an image, traces it by brute force, and checks that the rule excuses every difference.
fn same_as_rays(camera: &Camera, soup: &[Triangle], width: u32, height: u32) -> Vec<Hit> {
    let view = view_of(camera, width, height);
    let drawn = triangles(&view, soup, THRESHOLD);
    let rays = rays_of(camera, width, height);
    let mut traced = vec![Hit::MISS; rays.len()];
    Mode::certified().closest_batch(soup, &rays, &mut traced);
    let verdicts = differences(&view, soup, &drawn, &traced);
    for (i, verdict) in verdicts.iter().enumerate() {
        assert_ne!(*verdict, Verdict::Unexcused, "pixel {i}: {:?}, {:?}", drawn[i], traced[i]);
        if *verdict == Verdict::Same && drawn[i].is_hit() {
            // The more edge-on the triangle is, the more t changes when the ray is rounded to f32.
            let [c1, c2, c3] =
                soup[drawn[i].triangle as usize].0.map(|c| Vector::from(c.map(f64::from)));
            let normal = ((c2 - c1) ^ (c3 - c1)).unit();
            let slope = (normal & Vector::from(rays[i].dir.map(f64::from))).abs();
            assert!((drawn[i].t - traced[i].t).abs() * slope < 2e-7 * traced[i].t, "pixel {i}");
        }
    }
    drawn
}

#[test]
fn facets_of_any_number_of_corners_are_where_the_reference_has_them() {
    // All facets are convex and inside the image. The reference implementation decides coverage by
    // document B's cross products in f64, and depth by -q, which is linear on the screen.
    let (width, height) = (96, 64);
    let view = ahead(width, height);
    let mut numbers = Numbers(11);
    let (mut seen, mut differing) = (0, 0);
    for _ in 0..60 {
        let mut polygons: Vec<Vec<[f32; 3]>> = Vec::new();
        let mut reference = ZBuffer::new(width as usize, height as usize);
        for facet in 0..12 {
            // A regular outline in a tilted plane, flat up to f32 rounding.
            let corners = 3 + numbers.below(9);
            let (z, radius) = (-3.0 - numbers.next(), 0.3 + 0.3 * (numbers.next() + 1.0));
            let (x, y) = (numbers.next() * 1.5, numbers.next());
            let (tilt, lean, flip) = (numbers.next(), numbers.next(), numbers.next().signum());
            let outline: Vec<[f32; 3]> = (0..corners)
                .map(|i| {
                    let angle = flip * std::f64::consts::TAU * i as f64 / corners as f64;
                    let (px, py) = (radius * angle.cos(), radius * angle.sin());
                    [x + px, y + py, z + tilt * px + lean * py].map(|c| c as f32)
                })
                .collect();
            let screen: Vec<Vector> = outline
                .iter()
                .map(|p| {
                    let [px, py, pz] = p.map(f64::from);
                    let half = f64::from(height) * 0.5;
                    let sx = f64::from(width) * 0.5 + px / -pz * half;
                    Vector::new(sx, half - py / -pz * half, 1.0 / pz)
                })
                .collect();
            reference.draw(facet, &screen);
            polygons.push(outline);
        }
        let drawn = facets(&view, &polygons, THRESHOLD);
        for (hit, facet) in drawn.iter().zip(&reference.facet) {
            let ours = hit.is_hit().then_some(hit.triangle as usize);
            seen += usize::from(ours.is_some());
            differing += usize::from(ours != *facet);
        }
    }
    // The reference implementation does not snap corners, so it may decide differently on a centre
    // within 2^-17 of an edge.
    assert!(seen > 50_000 && differing <= 3, "{differing} of {seen}");
}

#[test]
fn random_soups_look_like_their_rays() {
    let mut numbers = Numbers(5);
    let mut covered = 0;
    for (count, size) in [(40, 1.0), (300, 0.2), (20, 8.0), (60, 0.01)] {
        let soup = numbers.soup(count, 1.0, size);
        // One eye is outside the soup. The other is inside, where facets cross the eye's plane and
        // extend behind the eye.
        for eye in [[2.0, 1.5, 3.0], [0.1, 0.05, -0.2]] {
            let camera = Camera::new(eye, [0.0, 0.3, 0.1], Camera::UP, 70.0).unwrap();
            let drawn = same_as_rays(&camera, &soup, 120, 90);
            covered += drawn.iter().filter(|hit| hit.is_hit()).count();
        }
    }
    assert!(covered > 30_000, "{covered}");
}

#[test]
fn from_inside_of_a_closed_surface_every_pixel_is_covered() {
    let mut numbers = Numbers(6);
    for (n, rough) in [(3, 0.0), (8, 0.4), (40, 0.02), (24, 0.9)] {
        let around = ball(&mut numbers, n, rough);
        for _ in 0..4 {
            let eye = numbers.point(0.04);
            let target = numbers.point(1.0);
            let camera = Camera::new(eye, target, Camera::UP, 100.0).unwrap();
            let drawn = triangles(&view_of(&camera, 333, 250), &around, THRESHOLD);
            assert_eq!(drawn.iter().filter(|hit| !hit.is_hit()).count(), 0, "{n} {rough}");
        }
    }
}

#[test]
fn a_floor_reaches_to_the_horizon_and_below_the_feet() {
    // A floor of two triangles that extends a million times farther than the eye's height above the
    // floor.
    let soup = floor(-1.0, 1e6);
    let camera = Camera::new([0.0; 3], [0.3, -0.2, -1.0], Camera::UP, 120.0).unwrap();
    let drawn = same_as_rays(&camera, &soup, 160, 120);
    assert!(drawn[0].triangle == Hit::NO_TRIANGLE && drawn[160 * 119].is_hit());
    // A floor that almost touches the eye.
    let soup = floor(-1e-6, 1.0);
    let drawn = same_as_rays(&camera, &soup, 160, 120);
    assert!(drawn[160 * 119].is_hit());
}

#[test]
fn larger_than_the_picture_and_behind_the_eye() {
    let view = ahead(31, 17);
    let wall = |z: f32| Triangle([[-1e9, -1e9, z], [1e9, -1e9, z], [0.0, 2e9, z]]);
    let hits = triangles(&view, &[wall(2.0), wall(-2.0), wall(0.0)], THRESHOLD);
    assert!(hits.iter().all(|hit| hit.triangle == 1));
    let middle = hits[8 * 31 + 15];
    assert!((middle.t - 2.0).abs() < 1e-12);
}

#[test]
fn slivers_and_facets_without_area() {
    // Needles, caps, and triangles with two or three equal corners must look as they do to rays.
    let mut numbers = Numbers(9);
    let mut soup = Vec::new();
    for i in 0..200 {
        let (a, b) = (numbers.point(1.0), numbers.point(1.0));
        let thin = [1e-2, 1e-4, 1e-7, 0.0][i % 4];
        let c = common::add([0, 1, 2].map(|k| (a[k] + b[k]) * 0.5), numbers.point(thin));
        soup.push(Triangle([a, b, c]));
        soup.push(Triangle([a, b, b]));
        soup.push(Triangle([a, a, a]));
    }
    let camera = Camera::new([0.3, 0.4, 2.5], [0.0; 3], Camera::UP, 50.0).unwrap();
    let drawn = same_as_rays(&camera, &soup, 200, 150);
    assert!(drawn.iter().all(|hit| !hit.is_hit() || hit.triangle % 3 == 0));
    assert!(drawn.iter().filter(|hit| hit.is_hit()).count() > 20);
}

#[test]
fn what_is_not_finite_or_lies_in_one_plane_with_the_eye_is_not_there() {
    let view = ahead(32, 32);
    let (a, b, c) = ([-1.0, -1.0, -2.0], [1.0, -1.0, -2.0], [0.0, 1.0, -2.0]);
    let edge_on = Triangle([[0.0, -1.0, -2.0], [0.0, 1.0, -2.0], [0.0, 0.0, 3.0]]);
    let mut soup = vec![edge_on];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        soup.push(Triangle([a, b, [0.0, bad, -2.0]]));
    }
    assert!(triangles(&view, &soup, THRESHOLD).iter().all(|hit| *hit == Hit::MISS));
    soup.push(Triangle([a, b, c]));
    assert!(
        triangles(&view, &soup, THRESHOLD).iter().all(|hit| !hit.is_hit() || hit.triangle == 4)
    );
    // Use coordinates near the limits of f32.
    let big = [a, b, c].map(|p| p.map(|x: f32| x * 1e38));
    assert!(triangles(&view, &[Triangle(big)], THRESHOLD)[16 * 32 + 16].is_hit());
    let small = [a, b, c].map(|p| p.map(|x: f32| x * 1e-38));
    assert!(!triangles(&view, &[Triangle(small)], THRESHOLD)[16 * 32 + 16].is_hit());
    assert!(triangles(&view, &[Triangle(small)], 0.0)[16 * 32 + 16].is_hit());
    let none: [Triangle; 0] = [];
    assert!(triangles(&view, &none, THRESHOLD).iter().all(|hit| *hit == Hit::MISS));
    assert!(facets(&view, &[vec![a, b], vec![a], vec![]], THRESHOLD).iter().all(|h| !h.is_hit()));
}

#[test]
fn nothing_is_nearer_than_the_threshold() {
    // A plane just below the eye, whose part nearer than t = 0.5 is invisible.
    let slope = Triangle([[-40.0, -0.1, 1.0], [40.0, -0.1, 1.0], [0.0, -0.1, -80.0]]);
    let wall = Triangle([[-90.0, -90.0, -9.0], [90.0, -90.0, -9.0], [0.0, 180.0, -9.0]]);
    let view = ahead(64, 64);
    let hits = triangles(&view, &[slope, wall], 0.5);
    for (i, hit) in hits.iter().enumerate() {
        let d = view.direction((i % 64) as f64 + 0.5, (i / 64) as f64 + 0.5);
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        let t = 0.1 / -d[1] * length;
        let slope = d[1] < 0.0 && t > 0.5 && t < 9.0 * length;
        let expected = u32::from(!slope);
        assert_eq!(hit.triangle, expected, "pixel {i}");
    }
}

#[test]
fn of_equal_depths_the_lowest_facet_is_seen() {
    let view = ahead(16, 16);
    let one = Triangle([[-2.0, -2.0, -2.5], [2.0, -2.0, -1.5], [0.0, 3.0, -2.0]]);
    let behind = Triangle(one.0.map(|[x, y, z]| [x * 1.5, y * 1.5, z * 1.5]));
    let hits = triangles(&view, &[behind, one, one], THRESHOLD);
    assert!(hits.iter().all(|hit| hit.triangle != 2));
    assert!(hits.iter().any(|hit| hit.triangle == 1));
}

#[test]
fn a_facet_of_a_thousand_corners_and_its_weights() {
    let view = ahead(200, 200);
    let outline: Vec<[f32; 3]> = (0..1000)
        .map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / 1000.0;
            [angle.cos() as f32, angle.sin() as f32, -2.0]
        })
        .collect();
    let hits = facets(&view, &[&outline[..]], THRESHOLD);
    // A circle with a radius of 50 pixels.
    let covered = hits.iter().filter(|hit| hit.is_hit()).count() as f64;
    assert!((covered - std::f64::consts::PI * 2500.0).abs() < 40.0, "{covered}");
    for (i, hit) in hits.iter().enumerate().filter(|(_, hit)| hit.is_hit()) {
        // Moving from the first corner by u and v must lead to a point on the line of sight.
        let d = view.direction((i % 200) as f64 + 0.5, (i / 200) as f64 + 0.5);
        let [c1, c2, c3] = [0, 1, 2].map(|k| outline[k].map(f64::from));
        for k in 0..2 {
            let there = c1[k] + hit.u * (c2[k] - c1[k]) + hit.v * (c3[k] - c1[k]);
            assert!((there - d[k] * 2.0).abs() < 1e-9, "{there} {}", d[k]);
        }
    }
}

#[test]
fn a_concave_facet_is_drawn_as_it_is() {
    // A comb with three teeth, whole and clipped by the image's left and right walls.
    let comb: [[f32; 2]; 12] = [
        [-3.01, -1.01],
        [3.01, -1.01],
        [3.01, 1.01],
        [2.01, 1.01],
        [2.01, 0.01],
        [0.53, 0.01],
        [0.53, 1.01],
        [-0.53, 1.01],
        [-0.53, 0.01],
        [-2.01, 0.01],
        [-2.01, 1.01],
        [-3.01, 1.01],
    ];
    for flip in [false, true] {
        let mut outline: Vec<[f32; 3]> = comb.iter().map(|&[x, y]| [x, y, -2.0]).collect();
        if flip {
            outline.reverse();
        }
        for (width, height) in [(90, 60), (40, 80)] {
            let view = ahead(width, height);
            let hits = facets(&view, &[&outline[..]], THRESHOLD);
            for (i, hit) in hits.iter().enumerate() {
                let (px, py) = (i as u32 % width, i as u32 / width);
                let d = view.direction(f64::from(px) + 0.5, f64::from(py) + 0.5);
                let (x, y) = (d[0] * 2.0, d[1] * 2.0);
                let tooth = x.abs() < 0.53 || x.abs() > 2.01;
                let inside = x.abs() < 3.01 && y > -1.01 && y < if tooth { 1.01 } else { 0.01 };
                assert_eq!(hit.is_hit(), inside, "{x} {y}");
            }
        }
    }
}

#[test]
fn a_wrong_picture_is_not_excused() {
    let mut numbers = Numbers(21);
    let soup = numbers.soup(30, 1.0, 0.7);
    let camera = Camera::new([0.0, 0.5, 3.0], [0.0; 3], Camera::UP, 45.0).unwrap();
    let view = view_of(&camera, 100, 100);
    let good = triangles(&view, &soup, THRESHOLD);
    let count = |bad: &[Hit]| {
        let verdicts = differences(&view, &soup, &good, bad);
        verdicts.iter().filter(|v| **v == Verdict::Unexcused).count()
    };
    assert_eq!(count(&good), 0);
    // An image shifted by one pixel, and an image without the triangle in its centre.
    let mut shifted = good.clone();
    shifted.rotate_right(1);
    assert!(count(&shifted) > 50);
    let front = good[50 * 100 + 50].triangle;
    let without: Vec<Hit> =
        good.iter().map(|h| if h.triangle == front { Hit::MISS } else { *h }).collect();
    let gone = good.iter().filter(|h| h.triangle == front).count();
    assert!(gone > 0 && count(&without) == gone);
    // An image with the correct triangles at an incorrect depth.
    let farther: Vec<Hit> = good.iter().map(|h| Hit { t: h.t * (1.0 + 2e-4), ..*h }).collect();
    let seen = good.iter().filter(|h| h.is_hit()).count();
    assert!(count(&farther) > seen * 9 / 10, "{} of {seen}", count(&farther));
}
