//! The functions that the fuzzers call. Each makes a query from bytes and panics if two answers differ.
//!
//! Fuzzers (`fuzz/`) find the bytes. The ordinary tests replay the ones that were kept (`fuzz/corpus`,
//! `tests/fixtures`) through the same functions, on stable Rust.

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

/// A function that takes any bytes and panics if an answer is wrong.
pub type Entry = fn(&[u8]);

/// All entries by name.
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
