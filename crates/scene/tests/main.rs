//! Tests loading valid and invalid model files of every format, and reading and writing images.

mod bad_files;
mod formats;
mod gltf;
mod gltf_instances;
mod gltf_scenes;
mod images;
mod models;
mod polygons;
