//! Everything needed to make an image, apart from ray tracing: meshes and model files, a camera, a
//! light, shading, textures, and image files.
//!
//! Coordinates are f32 by default. [`Mesh`], [`Scene`], [`Camera`], and [`Light`] are generic over
//! the [`Coordinate`] type; a `Scene<f64>`, for example, has rays and triangles in f64.
//!
//! This crate does not determine what a ray hits. A [`Scene`] provides rays ([`Camera::ray`],
//! [`Light::shadow_ray`]) and triangles ([`Mesh::to_triangles`]); a tracer or rasterizer returns a
//! visibility buffer, with one [`intertri::Hit`] per pixel, row by row from the top left, and a
//! shadow mask with one `bool` per pixel. [`shade`] turns both into an [`Image`].
//!
//! ```
//! use intertri::Hit;
//! use intertri_scene::{Scene, hit_point, shade};
//!
//! let scene = Scene::built_in();
//! let (width, height) = (4, 3);
//! let closest = |_ray: &intertri::Ray| Hit::MISS; // a tracer goes here
//! let mut hits = Vec::new();
//! let mut lit = Vec::new();
//! for y in 0..height {
//!     for x in 0..width {
//!         let ray = scene.camera.ray(x, y, width, height);
//!         let hit = closest(&ray);
//!         let shadow_ray = scene.light.shadow_ray(hit_point(&ray, &hit));
//!         lit.push(!closest(&shadow_ray).is_hit());
//!         hits.push(hit);
//!     }
//! }
//! let image = shade(&scene, width, height, &hits, &lit)?;
//! assert_eq!(image.pixels().len(), 12);
//! # Ok::<(), intertri_scene::ImageError>(())
//! ```

mod builtin;
mod camera;
mod coordinate;
mod geometry;
mod image;
mod instances;
mod light;
mod line_end;
mod load;
mod mesh;
mod partial_file;
mod rays;
mod rounding;
mod scene;
mod shade;
mod srgb;
mod texture;

pub use crate::camera::{Camera, CameraError};
pub use crate::coordinate::Coordinate;
pub use crate::geometry::SceneGeometry;
pub use crate::image::{Image, ImageError, MAX_PIXELS, check_output, check_size, difference};
pub use crate::instances::{Instance, InstancedMesh};
pub use crate::light::{Light, hit_point};
pub use crate::load::{
    LoadError, LoadedInstances, LoadedModel, Note, Notes, load, load_instances, load_model, read,
};
pub use crate::mesh::{Bounds, Mesh, Part};
pub use crate::partial_file::PartialFile;
pub use crate::rays::{Rays, RaysFormat};
pub use crate::rounding::Rounding;
pub use crate::scene::Scene;
pub use crate::shade::shade;
pub use crate::texture::{Texture, place};
