//! From what is seen and what is lit to colors.

use glam::{DVec3, Vec3};
use intertri::{Hit, Ray};

use crate::image::{Image, ImageError};
use crate::light::hit_point;
use crate::mesh::{Mesh, double};
use crate::scene::Scene;
use crate::texture::place;

/// The share of light that comes from everywhere: this much from below, and this much from above.
const AMBIENT: [f32; 2] = [0.07, 0.20];
/// The backdrop at the top and at the bottom of the picture, linear.
const BACKDROP: [Vec3; 2] = [Vec3::new(0.16, 0.22, 0.32), Vec3::new(0.66, 0.68, 0.68)];

/// Draws `scene` from its visibility buffer and its shadow mask.
///
/// `hits[y * width + x]` is what [`crate::Camera::ray`] of pixel `(x, y)` met, and `lit` of the same
/// index whether that point sees the light (all `true` for a picture without shadows; pixels that
/// met nothing are not asked).
///
/// A surface reflects by Lambert's law: in proportion to the cosine between its normal and the light.
/// The normal is the triangle's own, turned to the eye, so both sides look alike and a mesh looks as
/// faceted as it is. A little ambient light, more from above than from below, keeps shadows readable.
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
        *pixel = srgb(if hits[i].is_hit() {
            surface(scene, &scene.camera.ray(x, y, width, height), &hits[i], lit[i])
        } else {
            BACKDROP[0].lerp(BACKDROP[1], (y as f32 + 0.5) / height as f32)
        });
    }
    Ok(image)
}

/// The linear color of the point where `ray` met a triangle.
fn surface(scene: &Scene, ray: &Ray, hit: &Hit, lit: bool) -> Vec3 {
    let triangle = hit.triangle as usize;
    let normal = facing_normal(&scene.mesh, triangle, ray);
    let toward_light = double(scene.light.position) - DVec3::from(hit_point(ray, hit));

    // The light behind the surface, as the eye sees it, gives nothing: hence the `max`.
    let lambert = normal.dot(toward_light.normalize_or_zero()).max(0.0) as f32;
    let direct = if lit { lambert } else { 0.0 };
    let above = (normal.y as f32).mul_add(0.5, 0.5);
    let ambient = AMBIENT[0] + (AMBIENT[1] - AMBIENT[0]) * above;
    color(scene, triangle, hit) * (ambient + direct)
}

/// What a triangle reflects at a hit: its part's tint times the texture; of a mesh without parts the
/// texture alone, or clay.
fn color(scene: &Scene, triangle: usize, hit: &Hit) -> Vec3 {
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

/// The triangle's unit normal, on the side that the ray comes from. In f64, scaled first, so that
/// neither the smallest nor the largest f32 corners lose it.
fn facing_normal(mesh: &Mesh, triangle: usize, ray: &Ray) -> DVec3 {
    let [a, b, c] = mesh.corners(triangle).map(double);
    let edges = (b - a).normalize_or_zero().cross((c - a).normalize_or_zero());
    let normal = edges.normalize_or_zero();
    if normal.dot(double(ray.dir)) > 0.0 { -normal } else { normal }
}

/// Linear light, cut off at 1, as the eight bits of the sRGB standard (IEC 61966-2-1).
fn srgb(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|x| {
        let x = x.clamp(0.0, 1.0);
        let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (encoded * 255.0 + 0.5) as u8
    })
}

/// Eight bits of sRGB as linear light.
pub(crate) fn linear(encoded: u8) -> f32 {
    let x = f32::from(encoded) / 255.0;
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
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

    const HIT: Hit = Hit { t: 5.0, u: 0.3, v: 0.3, triangle: 0 };

    #[test]
    fn light_above_lights_and_shadow_or_light_below_leaves_the_ambient() {
        let bright = look(&floor(7.0), HIT, true);
        let shadow = look(&floor(7.0), HIT, false);
        let below = look(&floor(-7.0), HIT, true);
        assert!(bright[0] > shadow[0] && shadow[0] > 0, "{bright:?} {shadow:?}");
        assert_eq!(shadow, below);
        let clay = Vec3::from(Mesh::CLAY);
        assert_eq!(bright, srgb(clay * (AMBIENT[1] + 1.0)));
        assert_eq!(shadow, srgb(clay * AMBIENT[1]));
    }

    #[test]
    fn both_sides_of_a_triangle_look_alike() {
        let mut turned = floor(7.0);
        turned.mesh.triangles[0].swap(0, 1);
        assert_eq!(look(&turned, HIT, true), look(&floor(7.0), HIT, true));
    }

    #[test]
    fn a_miss_shows_the_backdrop_whatever_the_mask_says() {
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
        assert_eq!(white, srgb(Vec3::splat(AMBIENT[1])));
        scene.mesh.corner_uvs = Some(vec![[[0.0, 0.5], [2.5, 0.5], [0.0, 0.5]]]);
        let red = srgb(Vec3::new(AMBIENT[1], 0.0, 0.0));
        assert_eq!(look(&scene, HIT, false), red);
        assert_eq!(look(&scene, Hit { u: 0.1, ..HIT }, false), white);
        // A part with a tint, with and without it.
        scene.mesh.parts = vec![Part { first: 0, tint: [0.5; 3], textured: true }];
        assert_eq!(look(&scene, HIT, false), srgb(Vec3::new(AMBIENT[1] * 0.5, 0.0, 0.0)));
        scene.mesh.parts[0].textured = false;
        assert_eq!(look(&scene, HIT, false), srgb(Vec3::splat(AMBIENT[1] * 0.5)));
    }

    #[test]
    fn srgb_meets_the_standard() {
        assert_eq!(srgb(Vec3::new(0.0, 1.0, 7.0)), [0, 255, 255]);
        // Middle gray of 18 % is 118 (0.4613), and the straight part ends at 0.04045.
        assert_eq!(srgb(Vec3::new(0.18, 0.002, f32::NAN)), [118, 7, 0]);
        for encoded in 0..=255 {
            assert_eq!(srgb(Vec3::splat(linear(encoded))), [encoded; 3]);
        }
    }
}
