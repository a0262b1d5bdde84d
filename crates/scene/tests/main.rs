//! Tests of model files in every format, valid and invalid, and of images.

mod bad_files;
mod formats;
mod gltf;
mod gltf_scenes;
mod images;
mod models;
mod polygons;
