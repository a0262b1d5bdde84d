//! Shading: an image from a visibility buffer and a shadow mask.

use glam::{DVec3, Vec3};
use intertri::{Hit, Ray};

use crate::image::{Image, ImageError};
use crate::light::hit_point;
use crate::mesh::{Mesh, double};
use crate::scene::Scene;
use crate::srgb;
use crate::texture::place;

/// The ambient light from below and from above.
const AMBIENT: [f32; 2] = [0.07, 0.20];
/// The background at the top and at the bottom of the image, linear.
const BACKGROUND: [Vec3; 2] = [Vec3::new(0.16, 0.22, 0.32), Vec3::new(0.66, 0.68, 0.68)];

/// Shades `scene` by its visibility buffer and its shadow mask.
///
/// `hits[y * width + x]` is the hit of [`crate::Camera::ray`] of pixel `(x, y)`. `lit` of the same
/// index tells whether the light reaches that point. It is all `true` for an image without shadows,
/// and is not read where the ray missed.
///
/// Surfaces are Lambertian: they reflect in proportion to the cosine between normal and light. The
/// normal is the geometric one, faced toward the camera: both sides look alike, and no mesh is
/// smoothed. A little ambient light, more from above than from below, keeps shadows readable.
///
/// # Errors
/// As [`Image::new`].
///
/// # Panics
/// If a buffer does not have one entry per pixel, or a hit names a triangle that the mesh lacks.
pub fn shade(
    scene: &Scene,
    width: u32,
    height: u32,
    hits: &[Hit],
    lit: &[bool],
) -> Result<Image, ImageError> {
    let mut image = Image::new(width, height)?;
    assert_eq!(hits.len(), image.pixels().len(), "one hit per pixel");
    assert_eq!(lit.len(), image.pixels().len(), "one shadow bit per pixel");

    for (i, pixel) in image.pixels_mut().iter_mut().enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        *pixel = srgb::encode(if hits[i].is_hit() {
            radiance(scene, &scene.camera.ray(x, y, width, height), &hits[i], lit[i])
        } else {
            BACKGROUND[0].lerp(BACKGROUND[1], (y as f32 + 0.5) / height as f32)
        });
    }
    Ok(image)
}

/// The radiance, linear, that the hit of `ray` reflects toward its origin.
fn radiance(scene: &Scene, ray: &Ray, hit: &Hit, lit: bool) -> Vec3 {
    let triangle = hit.triangle as usize;
    let normal = facing_normal(&scene.mesh, triangle, ray);
    let to_light = double(scene.light.position) - DVec3::from(hit_point(ray, hit));

    // A light behind the surface, as the camera sees it, gives nothing: hence the `max`.
    let lambert = normal.dot(to_light.normalize_or_zero()).max(0.0) as f32;
    let direct = if lit { lambert } else { 0.0 };
    let above = (normal.y as f32).mul_add(0.5, 0.5);
    let ambient = AMBIENT[0] + (AMBIENT[1] - AMBIENT[0]) * above;
    albedo(scene, triangle, hit) * (ambient + direct)
}

/// The albedo at a hit: the part's tint times the texture. In a mesh without parts it is the texture
/// alone, or clay.
fn albedo(scene: &Scene, triangle: usize, hit: &Hit) -> Vec3 {
    let Scene { mesh, texture, .. } = scene;
    let part = mesh.part(triangle);
    let covered = part.is_none_or(|part| part.textured);
    let texture = texture.as_ref().filter(|_| covered).zip(mesh.corner_uvs.as_ref());
    let texture = texture.map(|(texture, uvs)| texture.color(place(&uvs[triangle], hit.u, hit.v)));
    match (part, texture) {
        (None, None) => Vec3::from(Mesh::CLAY),
        (None, Some(texture)) => texture,
        (Some(part), texture) => Vec3::from(part.tint) * texture.unwrap_or(Vec3::ONE),
    }
}

/// The geometric normal, of unit length, on the side that the ray comes from. In f64, with the edges
/// normalized first, so that it neither underflows nor overflows.
fn facing_normal(mesh: &Mesh, triangle: usize, ray: &Ray) -> DVec3 {
    let [a, b, c] = mesh.corners(triangle).map(double);
    let edges = (b - a).normalize_or_zero().cross((c - a).normalize_or_zero());
    let normal = edges.normalize_or_zero();
    if normal.dot(double(ray.dir)) > 0.0 { -normal } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::light::Light;
    use crate::mesh::Part;
    use crate::texture::Texture;

    /// A floor seen from above, the light above it or below it.
    fn floor(light_height: f32) -> Scene {
        let mesh = Mesh {
            positions: vec![[-9.0, 0.0, -9.0], [9.0, 0.0, -9.0], [0.0, 0.0, 9.0]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let camera = Camera::new([0.0, 5.0, 0.0], [0.0; 3], [0.0, 0.0, -1.0], 40.0).unwrap();
        Scene { mesh, camera, light: Light { position: [0.0, light_height, 0.0] }, texture: None }
    }

    fn look(scene: &Scene, hit: Hit, lit: bool) -> [u8; 3] {
        shade(scene, 1, 1, &[hit], &[lit]).unwrap().pixels()[0]
    }

    const HIT: Hit = Hit { t: 5.0, u: 0.3, v: 0.3, triangle: 0, geometry: 0 };

    #[test]
    fn light_above_lights_and_shadow_or_light_below_leaves_the_ambient() {
        let bright = look(&floor(7.0), HIT, true);
        let shadow = look(&floor(7.0), HIT, false);
        let below = look(&floor(-7.0), HIT, true);
        assert!(bright[0] > shadow[0] && shadow[0] > 0, "{bright:?} {shadow:?}");
        assert_eq!(shadow, below);
        let clay = Vec3::from(Mesh::CLAY);
        assert_eq!(bright, srgb::encode(clay * (AMBIENT[1] + 1.0)));
        assert_eq!(shadow, srgb::encode(clay * AMBIENT[1]));
    }

    #[test]
    fn both_sides_of_a_triangle_look_alike() {
        let mut turned = floor(7.0);
        turned.mesh.triangles[0].swap(0, 1);
        assert_eq!(look(&turned, HIT, true), look(&floor(7.0), HIT, true));
    }

    #[test]
    fn a_miss_shows_the_background_whatever_the_mask_says() {
        assert_eq!(look(&floor(7.0), Hit::MISS, true), look(&floor(7.0), Hit::MISS, false));
        let scene = floor(7.0);
        let two = shade(&scene, 1, 2, &[Hit::MISS; 2], &[true; 2]).unwrap();
        assert_ne!(two.pixels()[0], two.pixels()[1]);
    }

    #[test]
    fn a_texture_covers_what_it_should_at_the_place_of_the_hit() {
        let mut image = Image::new(2, 1).unwrap();
        image.pixels_mut().copy_from_slice(&[[255; 3], [255, 0, 0]]);
        let mut scene = floor(7.0);
        scene.texture = Some(Texture::Image(image));
        // No texture coordinates.
        assert_eq!(look(&scene, HIT, false), look(&floor(7.0), HIT, false));
        // The whole triangle has one place, then u leads to the other.
        scene.mesh.corner_uvs = Some(vec![[[0.25, 0.5]; 3]]);
        let white = look(&scene, HIT, false);
        assert_eq!(white, srgb::encode(Vec3::splat(AMBIENT[1])));
        scene.mesh.corner_uvs = Some(vec![[[0.0, 0.5], [2.5, 0.5], [0.0, 0.5]]]);
        let red = srgb::encode(Vec3::new(AMBIENT[1], 0.0, 0.0));
        assert_eq!(look(&scene, HIT, false), red);
        assert_eq!(look(&scene, Hit { u: 0.1, ..HIT }, false), white);
        // A part with a tint, with and without it.
        scene.mesh.parts = vec![Part { first: 0, tint: [0.5; 3], textured: true }];
        assert_eq!(look(&scene, HIT, false), srgb::encode(Vec3::new(AMBIENT[1] * 0.5, 0.0, 0.0)));
        scene.mesh.parts[0].textured = false;
        assert_eq!(look(&scene, HIT, false), srgb::encode(Vec3::splat(AMBIENT[1] * 0.5)));
    }
}
