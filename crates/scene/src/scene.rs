//! A mesh with a camera, a light and a texture.

use crate::camera::{Camera, CameraError};
use crate::light::Light;
use crate::mesh::Mesh;
use crate::texture::Texture;

/// All that an image is rendered from.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The triangles.
    pub mesh: Mesh,
    /// The camera.
    pub camera: Camera,
    /// The light.
    pub light: Light,
    /// What covers the textured parts of the mesh, or all of a mesh without parts, by its texture
    /// coordinates.
    pub texture: Option<Texture>,
}

impl Scene {
    /// A mesh framed by [`Camera::framing`] and lit by [`Light::over_the_shoulder`], for an image of
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
}
