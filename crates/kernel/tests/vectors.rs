//! Tests that the kernel accepts glam and mint vectors directly, although it depends on neither
//! crate.

use glam::Vec3;
use intertri::{Mode, Ray, Triangle};

#[test]
fn vectors_of_glam_are_corners_origins_and_directions() {
    let (c1, c2, c3) =
        (Vec3::new(-1.0, -2.0, 4.0), Vec3::new(3.0, -2.0, 4.0), Vec3::new(0.0, 5.0, 4.0));
    let triangle = Triangle::new(c1, c2, c3);
    assert_eq!(triangle.0, [[-1.0, -2.0, 4.0], [3.0, -2.0, 4.0], [0.0, 5.0, 4.0]]);

    let ray = Ray::new(Vec3::new(0.5, 0.25, 0.0), Vec3::Z);
    assert_eq!((ray.origin, ray.dir), ([0.5, 0.25, 0.0], [0.0, 0.0, 1.0]));

    // Hit points convert back to glam vectors.
    let hit = Mode::certified().closest(&[triangle], &ray).unwrap();
    assert_eq!(
        Vec3::from(ray.origin) + Vec3::from(ray.dir) * hit.t as f32,
        Vec3::new(0.5, 0.25, 4.0)
    );
}

#[test]
fn vectors_of_mint_are_corners_origins_and_directions() {
    let point = |x, y, z| mint::Point3 { x, y, z };
    let triangle = Triangle::new(point(0.0, 1.0, 2.0), point(3.0, 4.0, 5.0), point(6.0, 7.0, 9.0));
    assert_eq!(triangle.0, [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0], [6.0, 7.0, 9.0]]);

    let ray = Ray::new(point(0.5, 0.25, 0.0), mint::Vector3 { x: 0.0, y: 0.0, z: 1.0 });
    assert_eq!((ray.origin, ray.dir), ([0.5, 0.25, 0.0], [0.0, 0.0, 1.0]));
}
