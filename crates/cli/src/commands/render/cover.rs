//! Applies the light and the texture that the user chose.

use std::path::Path;

use intertri_scene::{Coordinate, Scene, SceneGeometry, Texture};

use super::options::Options;
use crate::error::{Error, Result};

/// Sets the scene's light and texture to the ones that the user chose, if any.
pub(super) fn cover<S: Coordinate, M: SceneGeometry<S>>(
    options: &Options,
    scene: &mut Scene<S, M>,
) -> Result<()> {
    options.light.shine_on(scene)?;
    if let Some(path) = &options.texture {
        scene.texture = Some(texture(path)?);
        if !scene.mesh.has_uvs() {
            let model = options.model.as_deref().unwrap_or(Path::new("")).display();
            return Err(Error::at(model, "has no texture coordinates; omit --texture"));
        }
    }
    Ok(())
}

/// Loads an image file, or returns the pattern of the reference documents.
fn texture(path: &Path) -> Result<Texture> {
    if path == Path::new("xor") {
        return Ok(Texture::XOR);
    }
    Ok(Texture::load(path)?)
}
