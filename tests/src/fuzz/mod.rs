//! The functions that the fuzz targets call. Each builds its input from bytes and panics if two
//! results differ.
//!
//! The fuzzers (`fuzz/`) search for such inputs. The ordinary tests pass the saved ones
//! (`fuzz/seeds`, `tests/fixtures`) to the same functions, on stable Rust.

mod exact;
mod files;
mod input;
mod instances;
mod integers;
mod raster;
mod saved;
mod scenes;
mod text;

pub use exact::exact;
pub use files::models;
pub use instances::instances;
pub use integers::{fans, fixed};
pub use raster::{clip, shadows, z_buffer};
pub use saved::saved;
pub use scenes::{hierarchy, kernel};
pub use text::{numbers, rays};

/// A function that takes any bytes and panics if a result is wrong.
pub type Entry = fn(&[u8]);

/// All entry points with their names.
pub const ENTRIES: &[(&str, Entry)] = &[
    ("kernel", kernel),
    ("hierarchy", hierarchy),
    ("exact", exact),
    ("fixed", fixed),
    ("fans", fans),
    ("clip", clip),
    ("z_buffer", z_buffer),
    ("shadows", shadows),
    ("models", models),
    ("rays", rays),
    ("numbers", numbers),
    ("saved", saved),
    ("instances", instances),
];
