//! Files of every format, good and bad, and pictures.

mod bad_files;
mod formats;
mod gltf;
mod gltf_instances;
mod gltf_scenes;
mod images;
mod models;
mod polygons;
