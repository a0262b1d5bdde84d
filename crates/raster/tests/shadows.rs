//! Compares shadow volumes with brute-force shadow rays, for well-formed meshes and for many kinds
//! of malformed meshes.

use crate::common::{Numbers, ball, cuboid, floor, view_of};
use intertri::{Hit, Mode, Ray, Triangle};
use intertri_raster::{
    Adjacency, Light, LightError, Verdict, View, Volume, facing, lit, shadow_differences,
    silhouette, triangles,
};
use intertri_scene::Camera;

const THRESHOLD: f64 = 1e-9;
const REACH: f64 = 0.9999;
const SIZE: (u32, u32) = (80, 60);

fn point(position: [f32; 3], reach: f64) -> Light {
    Light::Point { position, reach }
}

fn directional(toward: [f32; 3]) -> Light {
    Light::Directional { toward, reach: 1.0 }
}

/// Computes which pixels are lit, with brute-force shadow rays. The visible triangle does not
/// shadow itself.
fn by_rays(view: &View, hits: &[Hit], soup: &[Triangle], light: Light) -> Vec<bool> {
    let width = view.width() as usize;
    let one = |(i, hit): (usize, &Hit)| {
        if !hit.is_hit() {
            return true;
        }
        let d = view.direction((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        let long = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        let p: [f64; 3] = std::array::from_fn(|k| view.eye()[k] + d[k] * hit.t / long);
        let ray = match light {
            Light::Point { position, reach } => {
                let dir = std::array::from_fn(|k| (p[k] - f64::from(position[k])) as f32);
                Ray::new(position, dir).between(0.0, reach as f32)
            }
            Light::Directional { toward, reach: 1.0 } => Ray::new(p.map(|x| x as f32), toward),
            Light::Directional { toward, reach } => {
                let origin: [f32; 3] =
                    std::array::from_fn(|k| (p[k] + f64::from(toward[k])) as f32);
                let dir = std::array::from_fn(|k| (p[k] - f64::from(origin[k])) as f32);
                Ray::new(origin, dir).between(0.0, reach as f32)
            }
        };
        let blockers = Mode::certified().all(soup, &ray);
        blockers.iter().all(|blocker| blocker.triangle == hit.triangle)
    };
    hits.iter().enumerate().map(one).collect()
}

/// Computes shadows with volumes and with rays, and checks that the rule excuses every difference.
/// Returns the number of dark pixels and the number of pixels that differ.
fn same_as_rays(camera: &Camera, soup: &[Triangle], light: Light) -> (usize, usize) {
    let view = view_of(camera, SIZE.0, SIZE.1);
    let hits = triangles(&view, soup, THRESHOLD);
    let adjacency = Adjacency::new(soup);
    let volume = Volume::new(&adjacency, light).unwrap();
    let counted = lit(&view, &hits, &volume);
    let traced = by_rays(&view, &hits, soup, light);
    let verdicts = shadow_differences(&view, &hits, &volume, &counted, &traced);
    for (i, verdict) in verdicts.iter().enumerate() {
        let at = (i as u32 % SIZE.0, i as u32 / SIZE.0);
        assert_ne!(
            *verdict,
            Verdict::Unexcused,
            "{light:?}, pixel {at:?}: {:?}, counted {}, traced {}",
            hits[i],
            counted[i],
            traced[i]
        );
    }
    let dark = counted.iter().filter(|lit| !**lit).count();
    (dark, verdicts.iter().filter(|v| **v != Verdict::Same).count())
}

/// Returns various lights: near, far, at the eye, behind the eye, below the scene, and directional.
fn lights(camera: &Camera) -> Vec<Light> {
    let mut lights = Vec::new();
    for position in
        [[1.0, 2.5, 1.5], [-30.0, 50.0, 10.0], camera.eye(), [0.5, 2.0, 9.0], [0.2, -3.0, 0.1]]
    {
        lights.extend([point(position, REACH), point(position, 1.0)]);
    }
    for toward in [[0.3, 1.0, 0.2], [-1.0, 0.4, 0.0], [0.0, 1e-3, 1.0], [0.0, 0.0, -5.0]] {
        // Make the vector long enough to reach outside the scene.
        let long = toward.map(|x| 20.0 * x);
        lights.extend([directional(toward), Light::Directional { toward: long, reach: REACH }]);
    }
    lights
}

fn camera() -> Camera {
    Camera::new([1.2, 1.8, 3.5], [0.0, 0.0, 0.0], Camera::UP, 50.0).unwrap()
}

/// Tests one mesh with all lights. At least half of the lights must cast a shadow, and at most
/// `few` pixels in total may be excused.
fn all_lights(camera: &Camera, soup: &[Triangle], few: usize) {
    let (mut with_shadow, mut excused) = (0, 0);
    let lights = lights(camera);
    for &light in &lights {
        let (dark, differ) = same_as_rays(camera, soup, light);
        with_shadow += usize::from(dark > 20);
        println!("{light:?}: {dark} dark, {differ} excused");
        excused += differ;
    }
    assert!(with_shadow * 2 >= lights.len(), "{with_shadow} of {}", lights.len());
    assert!(excused <= few, "{excused} excused");
}

#[test]
fn a_closed_mesh_over_a_floor() {
    let mut soup = floor(-1.0, 3.0);
    soup.extend(ball(&mut Numbers(1), 7, 0.2));
    all_lights(&camera(), &soup, 0);
}

#[test]
fn boxes_that_touch_and_stand_on_the_floor() {
    // The boxes have coplanar faces, shared faces, and edges with four faces.
    let mut soup = floor(-1.0, 3.0);
    soup.extend(cuboid([-1.0, -1.0, -1.0], [0.0, 0.0, 0.0]));
    soup.extend(cuboid([0.0, -1.0, -1.0], [0.5, 0.7, 0.0]));
    soup.extend(cuboid([0.0, -1.0, 0.0], [0.7, -0.5, 0.9]));
    all_lights(&camera(), &soup, 1600);
}

#[test]
fn an_open_mesh() {
    // The soup contains a ball with a third of its triangles removed, and single sheets.
    let mut numbers = Numbers(2);
    let mut soup = ball(&mut numbers, 8, 0.1);
    soup.retain(|_| numbers.next() > -0.3);
    soup.extend(floor(-1.2, 2.5));
    soup.extend(floor(0.9, 0.4));
    all_lights(&camera(), &soup, 0);
}

#[test]
fn many_faces_at_an_edge() {
    // Fins around one axis: nine triangles with a common edge. Every third fin has two duplicates,
    // one for each winding.
    let (top, bottom) = ([0.0, 1.0, 0.0], [0.0, -0.8, 0.0]);
    let mut soup = floor(-1.0, 3.0);
    for i in 0..9 {
        let angle = f64::from(i) * 0.7;
        let tip = [angle.cos() as f32, 0.1 * i as f32 - 0.3, angle.sin() as f32];
        soup.push(Triangle([top, bottom, tip]));
        if i % 3 == 0 {
            soup.push(Triangle([bottom, top, tip]));
            soup.push(Triangle([tip, top, bottom]));
        }
    }
    all_lights(&camera(), &soup, 600);
}

#[test]
fn a_mesh_wound_at_random() {
    let mut numbers = Numbers(3);
    let mut soup = ball(&mut numbers, 7, 0.3);
    for triangle in &mut soup {
        if numbers.next() > 0.0 {
            triangle.0.swap(1, 2);
        }
        triangle.0.rotate_left(numbers.below(3));
    }
    soup.extend(floor(-1.3, 3.0));
    all_lights(&camera(), &soup, 0);
}

#[test]
fn a_mesh_that_runs_through_itself() {
    let mut numbers = Numbers(4);
    let mut soup = numbers.soup(60, 0.8, 0.8);
    soup.extend(cuboid([-0.9, -0.4, -0.5], [0.3, 0.4, 0.5]));
    soup.extend(cuboid([-0.3, -0.7, -0.2], [0.9, 0.2, 0.8]));
    // Degenerate triangles, and triangles with NaN or infinite coordinates, cast no shadow.
    soup.push(Triangle([[0.0; 3], [1.0; 3], [1.0; 3]]));
    soup.push(Triangle([[0.0; 3], [1.0; 3], [2.0; 3]]));
    soup.push(Triangle([[f32::NAN; 3], [1.0; 3], [2.0, 1.0, 0.0]]));
    soup.push(Triangle([[f32::INFINITY, 0.0, 0.0], [1.0; 3], [2.0, 1.0, 0.0]]));
    soup.extend(floor(-1.6, 3.0));
    all_lights(&camera(), &soup, 150);
}

#[test]
fn the_eye_within_a_shadow() {
    // The eye is in a round room, under a table, or under a table in the round room.
    let mut room = ball(&mut Numbers(7), 6, 0.0);
    for triangle in &mut room {
        triangle.0 = triangle.0.map(|p| p.map(|x| x * 6.0));
    }
    let mut under = floor(-1.0, 4.0);
    under.extend(cuboid([-2.0, 0.5, -2.0], [2.0, 0.6, 2.0]));
    under.extend(cuboid([-0.3, -1.0, -0.8], [0.1, -0.4, -0.5]));
    for soup in [&room, &under, &[room.clone(), under.clone()].concat()] {
        let camera = Camera::new([0.3, -0.2, 1.0], [0.0, -0.5, -1.0], Camera::UP, 75.0).unwrap();
        for light in lights(&camera) {
            same_as_rays(&camera, soup, light);
        }
    }
    // Light from outside reaches only the wall on the side that faces the light. Because the wall
    // is a single sheet, it also appears lit from the inside.
    let camera = Camera::new([0.3, -0.2, 1.0], [0.0, -0.5, -1.0], Camera::UP, 75.0).unwrap();
    let outside = [20.0, 30.0, 10.0];
    same_as_rays(&camera, &room, point(outside, REACH));
    let view = view_of(&camera, SIZE.0, SIZE.1);
    let hits = triangles(&view, &room, THRESHOLD);
    let adjacency = Adjacency::new(&room);
    let light = point(outside, 1.0);
    let mask = lit(&view, &hits, &Volume::new(&adjacency, light).unwrap());
    let looks = facing(&adjacency, &light);
    for (hit, lit) in hits.iter().zip(&mask) {
        assert_eq!(*lit, looks[hit.triangle as usize] == 1, "{hit:?}");
    }
    assert!(mask.contains(&true) && mask.contains(&false));
    // A light in the middle of the room reaches the whole room.
    let (dark, _) = same_as_rays(&camera, &room, point([0.0; 3], REACH));
    assert_eq!(dark, 0);
}

#[test]
fn the_light_in_a_mesh_on_a_face_and_at_a_corner() {
    let mut soup = floor(-1.0, 3.0);
    soup.extend(cuboid([-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]));
    let camera = camera();
    for place in
        [[0.1, 0.2, 0.0], [0.5, 0.1, 0.2], [0.5, 0.5, 0.0], [0.5, 0.5, 0.5], [0.0, -1.0, 0.0]]
    {
        for reach in [REACH, 1.0] {
            same_as_rays(&camera, &soup, point(place, reach));
        }
    }
    // A light inside the box lights no part of the floor.
    let (dark, _) = same_as_rays(&camera, &soup, point([0.1, 0.2, 0.0], REACH));
    assert!(dark > 1000, "{dark}");
}

#[test]
fn a_light_along_a_face() {
    // The light is in the plane of the box's top or sides, or in line with its edges.
    let mut soup = floor(-1.0, 3.0);
    soup.extend(cuboid([-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]));
    let camera = camera();
    for toward in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]] {
        same_as_rays(&camera, &soup, directional(toward));
        let long = toward.map(|x| 20.0 * x);
        same_as_rays(&camera, &soup, Light::Directional { toward: long, reach: REACH });
    }
    for place in [[4.0, 0.5, 0.0], [0.5, 4.0, 0.5], [4.0, 0.5, 4.0], [4.0, -1.0, 1.0]] {
        same_as_rays(&camera, &soup, point(place, REACH));
        same_as_rays(&camera, &soup, point(place, 1.0));
    }
}

#[test]
fn one_sheet_throws_one_shadow_and_none_on_itself() {
    // A sheet and its shadow on the floor, seen from above. With a point light, the shadow is twice
    // as large as the sheet, which is at half the light's height.
    let mut soup = floor(0.0, 4.0);
    soup.extend(floor(1.0, 0.5));
    let camera = Camera::new([0.0, 6.0, 0.01], [0.0, 0.0, 0.0], [0.0, 0.0, -1.0], 60.0).unwrap();
    let view = view_of(&camera, 100, 100);
    let hits = triangles(&view, &soup, THRESHOLD);
    let adjacency = Adjacency::new(&soup);
    for (light, shadow) in [
        (point([0.0, 2.0, 0.0], 1.0), [-1.0, 1.0]),
        (point([0.0, 2.0, 0.0], REACH), [-1.0, 1.0]),
        (directional([1.0, 1.0, 0.0]), [-1.5, -0.5]),
        (Light::Directional { toward: [9.0, 9.0, 0.0], reach: REACH }, [-1.5, -0.5]),
    ] {
        let volume = Volume::new(&adjacency, light).unwrap();
        let mask = lit(&view, &hits, &volume);
        let mut dark = 0;
        for (i, hit) in hits.iter().enumerate() {
            let d = view.direction((i % 100) as f64 + 0.5, (i / 100) as f64 + 0.5);
            let w = hit.t / d.iter().map(|x| x * x).sum::<f64>().sqrt();
            let x = view.eye()[0] + d[0] * w;
            let z = view.eye()[2] + d[2] * w;
            let deep = if shadow[0] == -1.0 { 1.0 } else { 0.5 };
            let inside = x > shadow[0] && x < shadow[1] && z.abs() < deep;
            let expected = hit.triangle < 2 && inside;
            assert_eq!(!mask[i], expected, "{light:?} at {x}, {z}");
            dark += usize::from(expected);
        }
        assert!(dark > 50);
    }
}

#[test]
fn a_thousand_volumes_do_not_wrap_a_counter() {
    // With 65,536 stacked sheets, the count exceeds 16 bits, and a multiple of 2^16 must not look
    // lit.
    let mut soup = floor(-1.0, 3.0);
    for _ in 0..32_768 {
        soup.extend(floor(0.5, 0.4));
        soup.extend(floor(0.6, 0.4));
    }
    let camera = camera();
    let view = view_of(&camera, 40, 30);
    let hits = triangles(&view, &soup, THRESHOLD);
    let adjacency = Adjacency::new(&soup);
    let few = Adjacency::new(&soup[..6]);
    let light = point([0.3, 4.0, 0.2], REACH);
    let many = lit(&view, &hits, &Volume::new(&adjacency, light).unwrap());
    let once = lit(&view, &hits, &Volume::new(&few, light).unwrap());
    assert!(once.contains(&false));
    assert_eq!(many, once);
}

#[test]
fn points_are_welded_and_silhouettes_are_the_documents() {
    // A box in which every triangle has its own corners, some with negative zeros.
    let mut soup = cuboid([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]);
    for triangle in soup.iter_mut().step_by(2) {
        triangle.0 = triangle.0.map(|p| p.map(|x| if x == 0.0 { -0.0 } else { x }));
    }
    let adjacency = Adjacency::new(&soup);
    assert_eq!((adjacency.points().len(), adjacency.edges().count()), (8, 18));
    for edge in adjacency.edges() {
        let [one, other] = edge.sides else { panic!("the mesh must be closed") };
        assert_ne!(one.forward, other.forward, "the mesh must be wound consistently");
    }
    // Seen from an oblique direction, the outline has six edges that form one closed loop. A front
    // face and a back face meet at each edge, so each edge counts 2.
    let looks = facing(&adjacency, &directional([1.0, 2.0, 3.0]));
    assert_eq!(
        (looks.iter().filter(|f| **f == 1).count(), looks.iter().filter(|f| **f == -1).count()),
        (6, 6)
    );
    let outline = silhouette(&adjacency, &looks);
    assert!(outline.len() == 6 && outline.iter().all(|edge| edge.count == 2));
    for edge in &outline {
        assert_eq!(outline.iter().filter(|next| next.ends[0] == edge.ends[1]).count(), 1);
    }
    // The document's own silhouette uses only front faces.
    let fronts: Vec<i8> = looks.iter().map(|f| (*f).max(0)).collect();
    let documents = silhouette(&adjacency, &fronts);
    assert!(documents.iter().all(|edge| edge.count == 1));
    assert!(documents.iter().zip(&outline).all(|(d, o)| d.ends == o.ends));
    // From directly above, the four sides are edge-on and cast no shadow.
    let looks = facing(&adjacency, &directional([0.0, 1.0, 0.0]));
    assert_eq!(looks.iter().filter(|f| **f == 0).count(), 8);
}

#[test]
fn impossible_lights_are_errors() {
    let soup = floor(0.0, 1.0);
    let adjacency = Adjacency::new(&soup);
    let error = |light| Volume::new(&adjacency, light).err();
    assert_eq!(error(point([0.0, f32::NAN, 0.0], 1.0)), Some(LightError::NotFinite));
    assert_eq!(error(point([0.0, f32::INFINITY, 0.0], 1.0)), Some(LightError::NotFinite));
    for reach in [0.0, -1.0, 1.5] {
        assert_eq!(error(point([0.0; 3], reach)), Some(LightError::Reach(reach)));
    }
    assert!(error(point([0.0; 3], f64::NAN)).is_some());
    assert_eq!(error(directional([0.0; 3])), Some(LightError::Direction));
}

#[test]
fn a_wrong_mask_is_not_excused() {
    let mut soup = floor(-1.0, 3.0);
    soup.extend(ball(&mut Numbers(1), 7, 0.2));
    let camera = camera();
    let view = view_of(&camera, SIZE.0, SIZE.1);
    let hits = triangles(&view, &soup, THRESHOLD);
    let adjacency = Adjacency::new(&soup);
    let volume = Volume::new(&adjacency, point([1.0, 2.5, 1.5], REACH)).unwrap();
    let good = lit(&view, &hits, &volume);
    let count = |bad: &[bool]| {
        let verdicts = shadow_differences(&view, &hits, &volume, &good, bad);
        verdicts.iter().filter(|v| **v == Verdict::Unexcused).count()
    };
    let mut shifted = good.clone();
    shifted.rotate_right(1);
    assert!(count(&shifted) > 40);
    let dark = good.iter().filter(|lit| !**lit).count();
    assert!(dark > 100 && count(&vec![true; good.len()]) + 5 > dark, "{dark}");
}
