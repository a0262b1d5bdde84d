//! A mesh with somebody to look at it and something to see it by.

use crate::builtin;
use crate::camera::{Camera, CameraError};
use crate::light::Light;
use crate::mesh::Mesh;
use crate::texture::Texture;

/// All that a picture is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The triangles.
    pub mesh: Mesh,
    /// Who looks.
    pub camera: Camera,
    /// What lights it.
    pub light: Light,
    /// What covers the textured parts of the mesh, or all of a mesh without parts, by its texture
    /// coordinates.
    pub texture: Option<Texture>,
}

impl Scene {
    /// A mesh framed by [`Camera::framing`] and lit by [`Light::over_the_shoulder`], for a picture of
    /// `aspect` = width / height.
    ///
    /// # Errors
    /// As [`Camera::framing`].
    pub fn of(mesh: Mesh, aspect: f64) -> Result<Self, CameraError> {
        let camera = Camera::framing(mesh.points(), aspect)?;
        Ok(Self::seen_by(mesh, camera))
    }

    /// A mesh as `camera` sees it, lit by [`Light::over_the_shoulder`].
    pub fn seen_by(mesh: Mesh, camera: Camera) -> Self {
        let light = Light::over_the_shoulder(&mesh.bounds_or_point(), &camera);
        Self { mesh, camera, light, texture: None }
    }

    /// The scene that comes with the program, made by code: a torus knot on a plinth in the turn of a
    /// spiral stair, with a sphere and a cut stone, on a floor; 10,804 triangles with texture
    /// coordinates, its own camera and its own light; floor and sphere have the XOR pattern. The same bits on every call.
    pub fn built_in() -> Self {
        builtin::scene()
    }
}
