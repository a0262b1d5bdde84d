//! Turns a visibility buffer and a shadow mask into a shaded image.

use glam::{DVec2, DVec3, Vec3};
use intertri::Hit;
use rayon::prelude::*;

use crate::coordinate::Coordinate;
use crate::geometry::SceneGeometry;
use crate::image::{Image, ImageError};
use crate::mesh::{Mesh, double};
use crate::scene::Scene;
use crate::srgb::Srgb;
use crate::texture::{Texture, ways};

/// The ambient light from below and from above.
const AMBIENT: [f32; 2] = [0.07, 0.20];
/// The linear colours of the background at the top and bottom of the image.
const BACKGROUND: [Vec3; 2] = [Vec3::new(0.16, 0.22, 0.32), Vec3::new(0.66, 0.68, 0.68)];

/// Shades `scene`, given its visibility buffer and its shadow mask.
///
/// `hits[y * width + x]` is the hit of the ray that [`crate::Camera::ray`] returns for pixel
/// `(x, y)`. `lit` at the same index is true if the light reaches the hit point; for a miss, the
/// value is not read. For an image without shadows, pass all `true`.
///
/// The hit's u and v determine its point on the triangle. Surfaces are Lambertian: they reflect
/// light in proportion to the cosine of the angle between the normal and the light. The geometric
/// normal is used, turned toward the camera, so both sides look the same, and meshes are not
/// smoothed. A little ambient light, more from above than from below, keeps shadows readable.
///
/// # Errors
/// Returns an error under the same conditions as [`Image::new`].
///
/// # Panics
/// Panics if a buffer does not have one entry per pixel, or if a hit refers to a missing triangle.
pub fn shade<S: Coordinate, M: SceneGeometry<S>>(
    scene: &Scene<S, M>,
    width: u32,
    height: u32,
    hits: &[Hit],
    lit: &[bool],
) -> Result<Image, ImageError> {
    let mut image = Image::new(width, height)?;
    assert_eq!(hits.len(), image.pixels().len(), "there must be one hit per pixel");
    assert_eq!(lit.len(), image.pixels().len(), "there must be one shadow bit per pixel");

    let srgb = Srgb::get();
    let columns = width as usize;
    let rows = image.pixels_mut().par_chunks_mut(columns).zip(hits.par_chunks(columns));
    rows.zip(lit.par_chunks(columns)).enumerate().for_each(|(y, ((pixels, hits), lit))| {
        let down = (y as f32 + 0.5) / height as f32;
        let background = srgb.encode(BACKGROUND[0].lerp(BACKGROUND[1], down));
        let mut last = None;
        for ((pixel, hit), &lit) in pixels.iter_mut().zip(hits).zip(lit) {
            *pixel = if hit.is_hit() {
                srgb.encode(Face::at(scene, hit, &mut last).radiance(scene, hit, lit))
            } else {
                background
            };
        }
    });
    Ok(image)
}

/// The values that all hits on a triangle share. Neighbouring pixels usually show the same
/// triangle.
struct Face<'a> {
    /// The indices of the triangle and its geometry, as in [`Hit`].
    triangle: [u32; 2],
    /// The first corner.
    corner: DVec3,
    /// The vectors from the first corner to the second and to the third.
    sides: [DVec3; 2],
    /// The unit normal on the side that faces the eye.
    normal: DVec3,
    ambient: f32,
    tint: Vec3,
    /// The texture that covers the triangle, with the texture coordinates of the first corner and
    /// the vectors from there to the other two.
    cover: Option<(&'a Texture, [DVec2; 3])>,
}

impl<'a> Face<'a> {
    /// Returns the face of a hit. The last face is reused if the hit is on the same triangle.
    fn at<'b, S: Coordinate, M: SceneGeometry<S>>(
        scene: &'a Scene<S, M>,
        hit: &Hit,
        last: &'b mut Option<Self>,
    ) -> &'b Self {
        if last.as_ref().is_none_or(|face| face.triangle != [hit.triangle, hit.geometry]) {
            *last = Some(Self::new(scene, hit));
        }
        last.as_ref().expect("the face has just been stored")
    }

    fn new<S: Coordinate, M: SceneGeometry<S>>(scene: &'a Scene<S, M>, hit: &Hit) -> Self {
        let [a, b, c] = scene.mesh.triangle_of(hit).0.map(double);
        let sides = [b - a, c - a];
        // The sides are normalized first, so that the normal neither underflows nor overflows.
        let [p, q] = sides.map(DVec3::normalize_or_zero);
        let normal = p.cross(q).normalize_or_zero();
        let away = normal.dot(a - double(scene.camera.eye())) > 0.0;
        let normal = if away { -normal } else { normal };
        let above = (normal.y as f32).mul_add(0.5, 0.5);
        let ambient = AMBIENT[0] + (AMBIENT[1] - AMBIENT[0]) * above;
        let (tint, cover) = Self::albedo(scene, hit);
        let triangle = [hit.triangle, hit.geometry];
        Self { triangle, corner: a, sides, normal, ambient, tint, cover }
    }

    /// Returns the components of the albedo that all hits on a triangle share: the part's tint and,
    /// if there is one, the texture. If the mesh has no parts, the tint is white under a texture
    /// and [`Mesh::CLAY`] otherwise.
    fn albedo<S: Coordinate, M: SceneGeometry<S>>(
        scene: &'a Scene<S, M>,
        hit: &Hit,
    ) -> (Vec3, Option<(&'a Texture, [DVec2; 3])>) {
        let Scene { mesh, texture, .. } = scene;
        let part = mesh.part_of(hit);
        let covered = part.is_none_or(|part| part.textured);
        let texture = texture.as_ref().filter(|_| covered).zip(mesh.uvs_of(hit));
        let cover = texture.map(|(texture, uvs)| (texture, ways(uvs)));
        let bare = if cover.is_some() { Vec3::ONE } else { Vec3::from(Mesh::CLAY) };
        (part.map_or(bare, |part| Vec3::from(part.tint)), cover)
    }

    /// Returns the linear radiance that a hit reflects toward the eye.
    #[inline]
    fn radiance<S: Coordinate, M>(&self, scene: &Scene<S, M>, hit: &Hit, lit: bool) -> Vec3 {
        // A light behind the surface, as seen by the camera, contributes nothing, hence the `max`.
        let direct = if lit {
            let point = self.corner + self.sides[0] * hit.u + self.sides[1] * hit.v;
            self.normal.dot(scene.light.direction(point)).max(0.0) as f32
        } else {
            0.0
        };
        let albedo = match self.cover {
            Some((texture, [first, p, q])) => {
                self.tint * texture.color((first + p * hit.u + q * hit.v).to_array())
            }
            None => self.tint,
        };
        albedo * (self.ambient + direct)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::light::Light;
    use crate::mesh::Part;

    /// Returns a floor seen from above, with the light above or below it.
    fn floor(light_height: f32) -> Scene {
        let mesh = Mesh {
            positions: vec![[-9.0, 0.0, -9.0], [9.0, 0.0, -9.0], [0.0, 0.0, 9.0]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let camera = Camera::new([0.0, 5.0, 0.0], [0.0; 3], [0.0, 0.0, -1.0], 40.0).unwrap();
        Scene {
            mesh,
            camera,
            light: Light::Point { position: [0.0, light_height, 0.0] },
            texture: None,
        }
    }

    fn encode(linear: Vec3) -> [u8; 3] {
        Srgb::get().encode(linear)
    }

    fn look(scene: &Scene, hit: Hit, lit: bool) -> [u8; 3] {
        shade(scene, 1, 1, &[hit], &[lit]).unwrap().pixels()[0]
    }

    const HIT: Hit = Hit { t: 5.0, u: 0.25, v: 0.5, triangle: 0, geometry: 0 };

    #[test]
    fn light_above_lights_and_shadow_or_light_below_leaves_the_ambient() {
        let bright = look(&floor(7.0), HIT, true);
        let shadow = look(&floor(7.0), HIT, false);
        let below = look(&floor(-7.0), HIT, true);
        assert!(bright[0] > shadow[0] && shadow[0] > 0, "{bright:?} {shadow:?}");
        assert_eq!(shadow, below);
        let clay = Vec3::from(Mesh::CLAY);
        assert_eq!(bright, encode(clay * (AMBIENT[1] + 1.0)));
        assert_eq!(shadow, encode(clay * AMBIENT[1]));
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
        // Without texture coordinates, the texture has no effect.
        assert_eq!(look(&scene, HIT, false), look(&floor(7.0), HIT, false));
        // First, map the whole triangle to one point of the texture; then, let the point depend on
        // u.
        scene.mesh.corner_uvs = Some(vec![[[0.25, 0.5]; 3]]);
        let white = look(&scene, HIT, false);
        assert_eq!(white, encode(Vec3::splat(AMBIENT[1])));
        scene.mesh.corner_uvs = Some(vec![[[0.0, 0.5], [3.0, 0.5], [0.0, 0.5]]]);
        let red = encode(Vec3::new(AMBIENT[1], 0.0, 0.0));
        assert_eq!(look(&scene, HIT, false), red);
        assert_eq!(look(&scene, Hit { u: 1.0 / 12.0, ..HIT }, false), white);
        // Test a tinted part, with and without the texture.
        scene.mesh.parts = vec![Part { first: 0, tint: [0.5; 3], textured: true }];
        assert_eq!(look(&scene, HIT, false), encode(Vec3::new(AMBIENT[1] * 0.5, 0.0, 0.0)));
        scene.mesh.parts[0].textured = false;
        assert_eq!(look(&scene, HIT, false), encode(Vec3::splat(AMBIENT[1] * 0.5)));
    }
}
