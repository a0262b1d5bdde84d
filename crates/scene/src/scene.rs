//! Combines a mesh or a set of instances with a camera, a light, and a texture.

use crate::camera::{Camera, CameraError};
use crate::coordinate::Coordinate;
use crate::geometry::SceneGeometry;
use crate::light::Light;
use crate::mesh::{Bounds, Mesh, double};
use crate::texture::Texture;

/// Everything needed to render an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene<S = f32, M = Mesh<S>> {
    /// The triangles: a [`Mesh`], or an [`InstancedMesh`](crate::InstancedMesh).
    pub mesh: M,
    /// The camera.
    pub camera: Camera<S>,
    /// The light.
    pub light: Light<S>,
    /// The texture of the textured parts, or of the whole mesh if it has no parts. The texture
    /// coordinates of the mesh determine the mapping.
    pub texture: Option<Texture>,
}

impl<S: Coordinate> Scene<S> {
    /// Creates a scene with a mesh that is framed by [`Camera::framing`] and lit by
    /// [`Light::over_the_shoulder`], for an image with `aspect` = width / height.
    ///
    /// # Errors
    /// Returns an error under the same conditions as [`Camera::framing`].
    pub fn of(mesh: Mesh<S>, aspect: f64) -> Result<Self, CameraError> {
        let camera = Camera::framing(mesh.points(), aspect)?;
        Ok(Self::seen_by(mesh, camera))
    }

    /// Returns points whose bounds contain all ray origins: the eye and the light or, if the light
    /// has no position, corners of the box in which its shadow rays start.
    pub fn ray_origins(&self) -> Vec<[S; 3]> {
        let bounds = self.mesh.bounds().unwrap_or_else(Bounds::point);
        // Leave a margin, because rounding may move points out of the box.
        let beyond = |corner| bounds.centre() + (double(corner) - bounds.centre()) * 1.01;
        let corners = [bounds.min, bounds.max].map(|corner| beyond(corner).to_array());
        let light = corners.map(|corner| self.light.origin(corner));
        [vec![self.camera.eye()], light.to_vec()].concat()
    }
}

impl<S: Coordinate, M: SceneGeometry<S>> Scene<S, M> {
    /// Creates a scene with a mesh or instances, seen by `camera` and lit by
    /// [`Light::over_the_shoulder`].
    pub fn seen_by(mesh: M, camera: Camera<S>) -> Self {
        let bounds = mesh.bounding_box().unwrap_or_else(Bounds::point);
        let light = Light::over_the_shoulder(&bounds, &camera);
        Self { mesh, camera, light, texture: None }
    }
}
