//! Saved hierarchies: to bytes and back, the same bytes on every CPU.
//!
//! ```text
//!   header    magic, version, how much there is      64 bytes
//!   table     kind, place, checksum of each section  32 bytes a section
//!   sections  nodes; leaves; triangles left out      each from a multiple of 64 on
//! ```
//!
//! [`format`] has every field; `docs/saved.md` tells it to those who write programs of their own. A section is
//! copied once, from where it is read to where the walk wants it, and every number is looked at on the way
//! ([`records`], [`check`]): what passes gives the right answers about the triangles that it holds, whoever
//! wrote it.

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
pub(crate) use store::write;

/// Makes all checksums of a saved hierarchy right, where it is so whole that they can be found: for tests of what
/// comes behind them.
#[doc(hidden)]
pub fn seal(bytes: &mut [u8]) {
    format::seal(bytes);
}
