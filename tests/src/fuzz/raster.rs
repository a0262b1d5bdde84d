//! Compares clipping and the z-buffer with the reference implementation, and shadow volumes with
//! shadow rays.

use std::array::from_fn;
use std::collections::HashMap;

use intertri::{Hit, Mode, Ray, Triangle};
use intertri_raster::{
    ALL_WALLS, Adjacency, Light, NO_FAR_WALL, Point4, Scratch, Verdict, View, Volume, clip_edge,
    clip_facet, differences, facets, lit, outcode, shadow_differences, triangles,
};
use intertri_reference::vector::Vector;
use intertri_reference::{clip_edge as reference, z_buffer};
use intertri_scene::Camera;

use super::input::Input;

/// Checks clipping. An edge must be clipped as in the reference, and the result must not change if
/// its ends are swapped. A clipped facet must not depend on its orientation, must lie inside the
/// clip volume, and must not be empty if any part of its edges is visible.
pub fn clip(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let any_double = input.below(4) == 0;
    let mut corner = || {
        let w = if any_double { input.double() } else { f64::from(input.number()) };
        let [x, y, z] = from_fn(|_| match input.below(8) {
            0 => w,
            1 => -w,
            _ if any_double => input.double(),
            _ => f64::from(input.number()),
        });
        Point4::new(x, y, z, w)
    };
    let corners: Vec<Point4> = (0..5).map(|_| corner()).collect();
    let sides: Vec<[Point4; 2]> = (0..5).map(|i| [corners[i], corners[(i + 1) % 5]]).collect();
    let walls = input.one_of(&[ALL_WALLS, NO_FAR_WALL]);

    let seen = sides.iter().filter(|&&[a, c]| edge(a, c)).count();
    let (mut one, mut other) = (Scratch::default(), Scratch::default());
    let outline = clip_facet(corners.iter().copied(), walls, &mut one);
    let turned = clip_facet(corners.iter().rev().copied(), walls, &mut other);
    assert_eq!(sorted(outline), sorted(turned), "reversed: {corners:?}");

    let in_range = |p: &Point4| p.boundaries().iter().all(|x| x.abs() <= f64::MAX / 4.0);
    let usable = corners.iter().all(in_range);
    assert!(usable || outline.is_empty(), "{corners:?}");
    if usable {
        assert!(
            seen == 0 || !outline.is_empty(),
            "an edge is visible, but the facet is empty: {corners:?}"
        );
        if corners.iter().all(|p| outcode(p.boundaries()) == 0) {
            assert_eq!(outline, corners);
        }
        let room = rounding(&corners);
        for p in outline {
            let inside = |i: usize| walls >> i & 1 == 0 || p.boundaries()[i] >= -room;
            assert!((0..6).all(inside), "{p:?} of {corners:?}");
        }
    }
}

/// Returns a bound on the rounding errors of points computed from `points`.
fn rounding(points: &[Point4]) -> f64 {
    let all = points.iter().flat_map(|p| [p.x, p.y, p.z, p.w]);
    all.fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs())) * 1e-12 + f64::MIN_POSITIVE
}

/// Checks the clipping of one edge. Returns whether the midpoint of the visible part is inside all
/// clip planes by more than the rounding errors.
fn edge(a: Point4, c: Point4) -> bool {
    let there = |p: Point4| reference::Point4::new(p.x, p.y, p.z, p.w);
    let back = |p: reference::Point4| Point4::new(p.x, p.y, p.z, p.w);
    let (mut ra, mut rc) = (there(a), there(c));
    let expected = reference::clip_edge(&mut ra, &mut rc) == 1;
    let expected = expected.then_some((back(ra), back(rc)));
    let found = clip_edge(a, c);
    let swapped = clip_edge(c, a).map(|(c, a)| (a, c));
    assert_eq!(found.map(bits), swapped.map(bits), "{a:?} {c:?}");

    let room = rounding(&[a, c]);
    let apart = |p: Point4, q: Point4| {
        [p.x - q.x, p.y - q.y, p.z - q.z, p.w - q.w]
            .into_iter()
            .fold(0.0, |m: f64, x| m.max(x.abs()))
    };
    match (found, expected) {
        (Some((fa, fc)), Some((ea, ec))) => {
            assert!(apart(fa, ea) <= room && apart(fc, ec) <= room, "{found:?} {expected:?}");
            for (old, new) in [(a, fa), (c, fc)] {
                assert!(outcode(old.boundaries()) != 0 || old == new, "{old:?} {new:?}");
            }
        }
        // If the edge only touches an edge of the clip volume, rounding decides whether it is
        // visible.
        (Some((from, to)), None) | (None, Some((from, to))) => {
            assert!(apart(from, to) <= room, "{a:?} {c:?}: {found:?} {expected:?}");
        }
        (None, None) => {}
    }
    found.is_some_and(|(from, to)| {
        let middle = Point4::new(
            from.x * 0.5 + to.x * 0.5,
            from.y * 0.5 + to.y * 0.5,
            from.z * 0.5 + to.z * 0.5,
            from.w * 0.5 + to.w * 0.5,
        );
        middle.boundaries().iter().all(|&x| x > room)
    })
}

fn bits((a, c): (Point4, Point4)) -> [[u64; 4]; 2] {
    [a, c].map(|p| [p.x, p.y, p.z, p.w].map(f64::to_bits))
}

fn sorted(outline: &[Point4]) -> Vec<[u64; 4]> {
    let mut all: Vec<_> = outline.iter().map(|&p| bits((p, p))[0]).collect();
    all.sort_unstable();
    all
}

/// The width and height, in pixels, of the images that [`z_buffer()`] draws.
const SIDE: u32 = 16;

/// A corner in image coordinates: x and y in quarters of a pixel, and the depth.
type Corner = (i32, i32, f32);

/// Draws triangles whose corners are at multiples of a quarter of a pixel, so that snapping does
/// not move the corners. Each pixel must show the nearest of the triangles that cover its centre
/// according to document B's reference implementation. If three triangles partition a fourth, each
/// pixel of the fourth must be covered by exactly one of the three.
pub fn z_buffer(bytes: &[u8]) {
    let mut input = Input::on_a_grid(bytes);
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    let view = View::new([0.0; 3], axes, 1.0, SIDE, SIDE).unwrap();

    let outlines: Vec<[Corner; 3]> =
        (0..=input.below(4)).map(|_| from_fn(|_| corner(&mut input))).collect();
    nearest_is_drawn(&view, &outlines);

    let [a, b, c] = outlines[0];
    let anywhere = corner(&mut input);
    let inner =
        input.one_of(&[a, (i32::midpoint(a.0, b.0), i32::midpoint(a.1, b.1), 1.0), anywhere]);
    partition_covers_once(&view, [a, b, c], inner);
}

fn corner(input: &mut Input<'_>) -> Corner {
    (input.below(65) as i32, input.below(65) as i32, input.one_of(&[1.0_f32, 2.0, 4.0]))
}

/// Returns the corner as a point in space.
fn unproject((x, y, depth): Corner) -> [f32; 3] {
    [(x - 32) as f32 / 32.0 * depth, (32 - y) as f32 / 32.0 * depth, -depth]
}

/// Returns the corner in raster space, as the z-buffer of document B expects it.
fn project((x, y, depth): Corner) -> Vector {
    Vector::new(f64::from(x) / 4.0, f64::from(y) / 4.0, -1.0 / f64::from(depth))
}

/// Draws each triangle separately with the reference implementation, and checks that each pixel
/// shows one of the nearest triangles that cover it. Pixels whose centre is on an edge are skipped.
fn nearest_is_drawn(view: &View, outlines: &[[Corner; 3]]) {
    let soup: Vec<Triangle> = outlines.iter().map(|o| Triangle(o.map(unproject))).collect();
    let drawn = triangles(view, &soup, 1e-9);
    assert_eq!(
        drawn,
        facets(view, &outlines.iter().map(|o| o.map(unproject)).collect::<Vec<_>>(), 1e-9)
    );

    let alone: Vec<z_buffer::ZBuffer> = outlines.iter().map(drawn_alone).collect();
    for (pixel, hit) in drawn.iter().enumerate() {
        let (x, y) = (pixel as u32 % SIDE, pixel as u32 / SIDE);
        let centre = Vector::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 0.0);
        let on_an_edge =
            |o: &[_; 3]| z_buffer::turns(&o.map(project), centre).any(|turn| turn == 0.0);
        let mut near: Vec<(f64, u32)> = (0..)
            .zip(&alone)
            .filter(|(_, picture)| picture.facet[pixel].is_some())
            .map(|(i, picture)| (picture.depth[pixel], i))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let tie = |&(depth, _): &(f64, u32)| (depth - near[0].0).abs() < 1e-12;
        let may: Vec<u32> = near.iter().filter(|n| tie(n)).map(|n| n.1).collect();
        if near.iter().any(|&(_, i)| on_an_edge(&outlines[i as usize])) {
            continue;
        }
        if may.is_empty() {
            assert!(!hit.is_hit(), "pixel {x} {y}: {hit:?} of {outlines:?}");
        } else {
            assert!(
                may.contains(&hit.triangle),
                "pixel {x} {y}: {hit:?}, {near:?} of {outlines:?}"
            );
        }
    }
}

/// Draws one triangle into an image of its own, using the reference implementation.
fn drawn_alone(outline: &[Corner; 3]) -> z_buffer::ZBuffer {
    let mut picture = z_buffer::ZBuffer::new(SIDE as usize, SIDE as usize);
    picture.draw(0, &outline.map(project));
    picture
}

/// Checks that the three triangles around an inner point cover each pixel of the outer triangle
/// exactly once.
fn partition_covers_once(view: &View, [a, b, c]: [Corner; 3], inner: Corner) {
    let turn = |a: Corner, b: Corner| (b.0 - a.0) * (inner.1 - a.1) - (b.1 - a.1) * (inner.0 - a.0);
    let turns = [turn(a, b), turn(b, c), turn(c, a)];
    let inside = turns.iter().all(|&t| t >= 0) || turns.iter().all(|&t| t <= 0);
    if !inside {
        return;
    }
    let covered = |o: [Corner; 3]| -> Vec<bool> {
        let flat = Triangle(o.map(|(x, y, _)| unproject((x, y, 1.0))));
        triangles(view, &[flat], 1e-9).iter().map(Hit::is_hit).collect()
    };
    let whole = covered([a, b, c]);
    let parts = [covered([a, b, inner]), covered([b, c, inner]), covered([c, a, inner])];
    for (pixel, &whole) in whole.iter().enumerate() {
        let count = parts.iter().filter(|part| part[pixel]).count();
        assert_eq!(count, usize::from(whole), "pixel {pixel} of {a:?} {b:?} {c:?} at {inner:?}");
    }
}

/// Compares images drawn by the z-buffer with ray-traced images, and shadow volumes with shadow
/// rays. The results may differ only where `docs/raster.md` proves that they can. The silhouettes
/// must close the shadow volumes exactly.
pub fn shadows(bytes: &[u8]) {
    const SIZE: (u32, u32) = (20, 15);
    let mut input = Input::new(bytes);
    let soup = input.triangles(10);
    let light = match input.below(3) {
        0 => Light::Directional { toward: input.point(), reach: 1.0 },
        1 => Light::Point { position: input.point(), reach: 1.0 },
        _ => Light::Point { position: input.point(), reach: 0.9999 },
    };
    let adjacency = Adjacency::new(&soup);
    let Ok(volume) = Volume::new(&adjacency, light) else { return };

    // If the oriented faces traverse an edge more often in one direction than in the other, the
    // silhouette must contain the difference.
    let mut open = HashMap::new();
    let facing = intertri_raster::facing(&adjacency, &light);
    for (&[a, b, c], facing) in adjacency.faces().iter().zip(facing) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *open.entry((from, to)).or_insert(0) += i64::from(facing);
            *open.entry((to, from)).or_insert(0) -= i64::from(facing);
        }
    }
    for edge in volume.silhouette() {
        let [from, to] = edge.ends;
        *open.entry((from, to)).or_insert(0) -= i64::from(edge.count);
        *open.entry((to, from)).or_insert(0) += i64::from(edge.count);
    }
    assert!(open.values().all(|&count| count == 0), "{light:?} {soup:?}");

    // Rasterize and ray trace with the same camera.
    let (eye, target) = (input.point(), input.point());
    let Ok(camera) = Camera::new(eye, target, Camera::UP, 70.0) else { return };
    let Ok(view) = View::new(camera.eye(), camera.axes(), camera.half_height(), SIZE.0, SIZE.1)
    else {
        return;
    };
    let drawn = triangles(&view, &soup, 1e-9);
    let rays: Vec<Ray> = (0..SIZE.1)
        .flat_map(|y| (0..SIZE.0).map(move |x| (x, y)))
        .map(|(x, y)| camera.ray(x, y, SIZE.0, SIZE.1))
        .collect();
    let mut traced = vec![Hit::MISS; rays.len()];
    Mode::certified().closest_batch(&soup, &rays, &mut traced);
    for (i, verdict) in differences(&view, &soup, &drawn, &traced).into_iter().enumerate() {
        let what = || format!("pixel {i}: {:?} {:?}\n{camera:?} {soup:?}", drawn[i], traced[i]);
        assert_ne!(verdict, Verdict::Unexcused, "{}", what());
    }
    let counted = lit(&view, &drawn, &volume);
    let by_rays: Vec<bool> =
        (0..).zip(&drawn).map(|(i, hit)| sees(&view, i, hit, &soup, light)).collect();
    let verdicts = shadow_differences(&view, &drawn, &volume, &counted, &by_rays);
    for (i, verdict) in verdicts.into_iter().enumerate() {
        let what =
            || format!("pixel {i}: {} {}\n{light:?} {camera:?} {soup:?}", counted[i], by_rays[i]);
        assert_ne!(verdict, Verdict::Unexcused, "shadow of {}", what());
    }
}

/// Returns whether light reaches the point that a pixel shows. The triangle that contains the point
/// does not shadow it.
fn sees(view: &View, pixel: u32, hit: &Hit, soup: &[Triangle], light: Light) -> bool {
    if !hit.is_hit() {
        return true;
    }
    let (x, y) = (pixel % view.width(), pixel / view.width());
    let d = view.direction(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let long = d.iter().map(|x| x * x).sum::<f64>().sqrt();
    let p: [f64; 3] = from_fn(|k| view.eye()[k] + d[k] * hit.t / long);
    let ray = match light {
        Light::Point { position, reach } => {
            let dir: [f32; 3] = from_fn(|k| (p[k] - f64::from(position[k])) as f32);
            Ray::new(position, dir).between(0.0, reach as f32)
        }
        Light::Directional { toward, .. } => Ray::new(p.map(|x| x as f32), toward),
    };
    let blockers = Mode::certified().all(soup, &ray);
    blockers.iter().all(|blocker| blocker.triangle == hit.triangle)
}
