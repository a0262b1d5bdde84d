//! Files of every format, good and bad, and pictures.

mod bad_files;
mod formats;
mod gltf;
mod images;
mod models;
