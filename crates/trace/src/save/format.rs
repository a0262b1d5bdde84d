//! The header and the section table of a saved hierarchy. All values are little-endian.
//!
//! ```text
//!   header  0 magic            8 version: u32      12 sections: u32     16 triangles: u64
//!          24 boxed: u64      32 cost: f64         40 size: u64         48 zero            56 checksum: u64
//!   entry   0 kind: u32        4 record: u32        8 place: u64        16 size: u64       24 checksum: u64
//! ```
//!
//! `boxed` is the number of leaves in the main tree; these leaves come first. `cost` is the cost of
//! the tree as it was built, or NaN if the tree was never refitted. `record` is the size of each of
//! the section's records. A section's checksum covers the checksums of its blocks, each of which
//! contains 1024 records. The header's checksum covers the rest of the header and the table, and
//! thereby the whole file.
//!
//! **To add a section**, add a kind here, and the functions that read and write its records next to
//! those for leaves. Readers reject files with an unknown kind unless the kind has the [`OPTIONAL`]
//! bit set. If the layout of nodes or leaves changes, increment [`VERSION`].

use super::checksum::checksum;
use super::error::LoadError;
use crate::tree::LEAF;

/// The first bytes of a saved hierarchy.
///
/// ```
/// use intertri_trace::{Bvh, SAVED_MAGIC};
/// assert!(Bvh::<f32>::new(&[])?.to_bytes().starts_with(&SAVED_MAGIC));
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
pub const SAVED_MAGIC: [u8; 8] = *b"\x89ITRI\r\n\x1a";

/// The format version. Version 1 omitted triangles with zero area.
pub(super) const VERSION: u32 = 2;

/// The size of the header.
pub(super) const HEADER: usize = 64;

/// The size of a table entry.
pub(super) const ENTRY: usize = 32;

/// Sections start at multiples of this offset, so that they are aligned if a file is memory-mapped.
pub(super) const ALIGN: usize = 64;

/// The maximum number of sections in a file.
pub(super) const SECTIONS: u32 = 64;

/// The number of records that share a checksum.
pub(super) const BLOCK: usize = 1024;

/// The maximum size of a record.
const RECORD: usize = 4096;

/// Readers may skip unknown kinds that have this bit set.
pub(super) const OPTIONAL: u32 = 1 << 31;

// The section kinds. The size of each kind's records follows it.

/// The section of nodes.
pub(super) const NODES: u32 = 1;
pub(super) const NODE: usize = 256;
/// The section of leaves in an f32 hierarchy.
pub(super) const LEAVES: u32 = 2;
pub(super) const LEAF_SIZE: usize = 320;
/// The section that lists the indices of omitted triangles.
pub(super) const LEFT_OUT: u32 = 3;
pub(super) const NUMBER: usize = 4;
/// The section of triangle counts and masks, with one record per geometry.
pub(super) const GEOMETRIES: u32 = 4;
pub(super) const GEOMETRY: usize = 8;
/// The section that contains the frame of the f32 copies in an f64 hierarchy.
pub(super) const FRAME: u32 = 5;
pub(super) const FRAME_SIZE: usize = 32;
/// The section of leaves in an f64 hierarchy; it replaces [`LEAVES`].
pub(super) const LEAVES64: u32 = 6;
pub(super) const LEAF64_SIZE: usize = 608;

/// The offset of the header's checksum.
pub(super) const SUM: usize = HEADER - 8;

/// The fields of the header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Header {
    pub triangles: u64,
    pub boxed: u64,
    pub cost: f64,
    pub size: u64,
}

/// An entry of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Entry {
    pub kind: u32,
    pub record: u32,
    pub place: u64,
    pub size: u64,
    pub checksum: u64,
}

impl Entry {
    /// Returns the number of records.
    pub(super) fn count(&self) -> usize {
        (self.size / u64::from(self.record)) as usize
    }
}

/// Serializes the header and the table.
pub(super) fn front(header: &Header, entries: &[Entry]) -> Vec<u8> {
    let numbers = [header.triangles, header.boxed, header.cost.to_bits(), header.size];
    front_of((SAVED_MAGIC, VERSION), numbers, entries)
}

/// Serializes a header that contains the given values, and the table.
pub(super) fn front_of(
    (magic, version): ([u8; 8], u32),
    numbers: [u64; 4],
    entries: &[Entry],
) -> Vec<u8> {
    let mut bytes = Vec::from(magic);
    bytes.extend(version.to_le_bytes());
    bytes.extend((entries.len() as u32).to_le_bytes());
    bytes.extend(numbers.map(u64::to_le_bytes).concat());
    // Reserve space for the checksum, which is written last and does not cover itself.
    bytes.resize(HEADER, 0);
    for entry in entries {
        bytes.extend(entry.kind.to_le_bytes());
        bytes.extend(entry.record.to_le_bytes());
        bytes.extend([entry.place, entry.size, entry.checksum].map(u64::to_le_bytes).concat());
    }
    let sum = sum_of(&bytes);
    bytes[SUM..HEADER].copy_from_slice(&sum.to_le_bytes());
    bytes
}

/// Returns the checksum of the header and the table.
fn sum_of(front: &[u8]) -> u64 {
    checksum(&[&front[..SUM], &front[HEADER..]].concat())
}

/// Returns the size of the table that follows a header. Errors found here take precedence over a
/// checksum mismatch.
pub(super) fn table_size(header: &[u8; HEADER]) -> Result<usize, LoadError> {
    if header[..8] != SAVED_MAGIC {
        return Err(LoadError::NotSaved);
    }
    let (version, sections) = (u32_at(header, 8), u32_at(header, 12));
    // The magic number matches, so this is a saved hierarchy. Report a version mismatch as such.
    if version > VERSION {
        return Err(LoadError::Newer { what: format!("version {version}") });
    }
    if version == 1 {
        return Err(LoadError::Older);
    }
    if version == 0 || sections > SECTIONS {
        return LoadError::damaged("the header is invalid");
    }
    Ok(sections as usize * ENTRY)
}

/// Verifies the checksum of the header and the table.
pub(super) fn check_sum(front: &[u8]) -> Result<(), LoadError> {
    if u64_at(front, SUM) == sum_of(front) {
        Ok(())
    } else {
        LoadError::damaged("the checksum of its header does not match")
    }
}

/// Parses the header and the table, and checks that they are valid.
pub(super) fn parse(front: &[u8]) -> Result<(Header, Vec<Entry>), LoadError> {
    check_sum(front)?;
    let header = Header {
        triangles: u64_at(front, 16),
        boxed: u64_at(front, 24),
        cost: f64::from_bits(u64_at(front, 32)),
        size: u64_at(front, 40),
    };
    let (entries, end) = entries(front, |kind, record, size| {
        Some(match kind {
            NODES => record == NODE as u32,
            LEAVES => record == LEAF_SIZE as u32,
            LEFT_OUT => record == NUMBER as u32,
            GEOMETRIES => record == GEOMETRY as u32,
            FRAME => record == FRAME_SIZE as u32 && size == u64::from(record),
            LEAVES64 => record == LEAF64_SIZE as u32,
            _ => return None,
        })
    })?;
    if end != header.size || header.triangles >= u64::from(LEAF) {
        return LoadError::damaged("the header is invalid");
    }
    Ok((header, entries))
}

/// Parses the table, and returns its entries and the offset at which the last section ends. Given
/// the kind of a section and the sizes of its records and of the section itself, `fits` returns
/// whether these sizes are valid, or `None` if it does not know the kind.
pub(super) fn entries(
    front: &[u8],
    fits: impl Fn(u32, u32, u64) -> Option<bool>,
) -> Result<(Vec<Entry>, u64), LoadError> {
    let entries: Vec<Entry> = front[HEADER..].chunks_exact(ENTRY).map(entry).collect();

    // Sections must be contiguous except for alignment.
    let mut end = front.len() as u64;
    for Entry { kind, record, place, size, .. } in &entries {
        // Check these values before any of them determines an allocation size or is used as an
        // index.
        let sane = (1..=RECORD as u32).contains(record) && size % u64::from(*record) == 0;
        if !sane || *place != end.next_multiple_of(ALIGN as u64) || *size > u64::MAX / 4 {
            return LoadError::damaged("its table of sections is invalid");
        }
        let known = match fits(*kind, *record, *size) {
            Some(fits) => fits,
            // A later version may add optional sections. This version can still read the rest of
            // the file.
            None if kind & OPTIONAL != 0 => true,
            None => return Err(LoadError::Newer { what: format!("a section of kind {kind}") }),
        };
        // Record indices are 31-bit.
        if !known || u64::from(*record) * u64::from(LEAF) < *size {
            return LoadError::damaged("its table of sections is invalid");
        }
        end = place + size;
    }
    Ok((entries, end))
}

fn entry(bytes: &[u8]) -> Entry {
    Entry {
        kind: u32_at(bytes, 0),
        record: u32_at(bytes, 4),
        place: u64_at(bytes, 8),
        size: u64_at(bytes, 16),
        checksum: u64_at(bytes, 24),
    }
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    let mut number = [0; 4];
    number.copy_from_slice(&bytes[at..at + 4]);
    u32::from_le_bytes(number)
}

pub(super) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32
}

/// Returns the checksum of the block checksums.
pub(super) fn checksum_of_blocks(blocks: &[u64]) -> u64 {
    checksum(&blocks.iter().flat_map(|sum| sum.to_le_bytes()).collect::<Vec<u8>>())
}

/// Recomputes the checksums of a saved hierarchy; see [`super::seal`].
pub(super) fn seal(bytes: &mut [u8]) {
    if bytes.len() < HEADER {
        return;
    }
    let table = u32_at(bytes, 12).min(SECTIONS) as usize * ENTRY;
    let Some(front) = bytes.get(..HEADER + table).map(<[u8]>::to_vec) else { return };
    for (i, entry) in front[HEADER..].chunks_exact(ENTRY).map(entry).enumerate() {
        let (Ok(place), Ok(size)) = (usize::try_from(entry.place), usize::try_from(entry.size))
        else {
            return;
        };
        let section = place.checked_add(size).and_then(|end| bytes.get(place..end));
        let (Some(section), 1..=4096) = (section, entry.record) else { return };
        let blocks = section.chunks(BLOCK * entry.record as usize).map(checksum);
        let sum = checksum_of_blocks(&blocks.collect::<Vec<u64>>());
        let at = HEADER + i * ENTRY + 24;
        bytes[at..at + 8].copy_from_slice(&sum.to_le_bytes());
    }
    let sum = sum_of(&bytes[..HEADER + table]);
    bytes[SUM..HEADER].copy_from_slice(&sum.to_le_bytes());
}
