//! Saves and loads hierarchies and scenes. The bytes are the same on every CPU.
//!
//! ```text
//!   header    magic, version, sizes                   64 bytes
//!   table     kind, offset, checksum of each section  32 bytes per section
//!   sections  nodes; leaves; omitted triangles        each aligned to 64 bytes
//! ```
//!
//! A saved scene ([`scene`]) also starts with a header and a table. Sections for its instances
//! follow, and then its meshes, each as a saved hierarchy.
//!
//! [`format`] documents every field, and `docs/saved.md` specifies the format for other programs.
//! Each section is copied once, from the read buffer to where traversal needs it, and every value
//! is checked along the way ([`records`], [`check`]). A hierarchy that passes these checks returns
//! correct results for the triangles it contains, even if an attacker wrote it.

mod arriving;
mod check;
mod checksum;
mod error;
mod format;
mod in_f64;
mod input;
mod load;
mod records;
mod records64;
mod scene;
mod scene_error;
mod store;
#[cfg(test)]
mod tests;

pub use checksum::checksum;
pub use error::LoadError;
pub use format::SAVED_MAGIC;
pub(crate) use in_f64::{read64, write64};
#[cfg(unix)]
pub(crate) use input::Pieces;
pub(crate) use input::{Input, Slice, Stream};
pub(crate) use load::read;
pub(crate) use records64::EightTriangles;
pub use scene::SAVED_SCENE_MAGIC;
pub(crate) use scene::{InstanceRecord, SavedMesh, SceneFront, SceneReader, write_scene};
pub use scene_error::SceneLoadError;
pub(crate) use store::{Bytes, write};

/// Recomputes all checksums of a saved hierarchy if it is intact enough to locate them. Tests use
/// this function to reach the checks that run after the checksums are verified.
#[doc(hidden)]
pub fn seal(bytes: &mut [u8]) {
    format::seal(bytes);
}

/// Recomputes the checksums of a saved scene in the same way, except the checksums inside its
/// meshes.
#[doc(hidden)]
pub fn seal_scene(bytes: &mut [u8]) {
    scene::seal(bytes);
}
