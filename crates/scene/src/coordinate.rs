//! Defines the scalar type of a scene's coordinates: f32 or f64.

use std::str::FromStr;

use intertri::Scalar;

/// The scalar in which the coordinates of meshes, cameras, lights, and rays are read and stored:
/// f32 (the default) or f64. Do not implement this trait for other types.
///
/// ```no_run
/// use std::path::Path;
/// use intertri_scene::{LoadError, Mesh, load_model};
/// /// Reads a survey in UTM coordinates, without rounding to f32.
/// fn survey(path: &Path) -> Result<Mesh<f64>, LoadError> {
///     load_model(path).map(|model| model.mesh)
/// }
/// ```
pub trait Coordinate: Scalar + FromStr {
    /// The name of the scalar, used in messages.
    const NAME: &'static str;
}

impl Coordinate for f32 {
    const NAME: &'static str = "f32";
}

impl Coordinate for f64 {
    const NAME: &'static str = "f64";
}
