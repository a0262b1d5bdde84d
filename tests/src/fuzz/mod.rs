//! The entry points of the fuzz targets. Each builds its input from bytes and panics if a result is
//! wrong.
//!
//! The fuzzers (`fuzz/`) search for bytes that make an entry point panic. The ordinary tests, which
//! run on stable Rust, pass saved inputs (`fuzz/seeds`, `tests/fixtures`) to the same functions.

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

/// A function that accepts arbitrary bytes and panics if a result is wrong.
pub type Entry = fn(&[u8]);

/// All entry points, with their names.
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
