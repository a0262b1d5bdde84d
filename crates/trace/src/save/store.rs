//! Writes hierarchies in the saved format.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use super::checksum::checksum;
use super::format::{
    ALIGN, BLOCK, ENTRY, Entry, GEOMETRIES, GEOMETRY, HEADER, Header, LEAF_SIZE, LEAVES, LEFT_OUT,
    NODE, NODES, NUMBER, checksum_of_blocks, front,
};
use super::records::{write_leaf, write_node};
use crate::tree::Tree;
use crate::util::memory::{NoMemory, room, zeros};
use crate::util::stop;
use crate::util::threads;

/// A byte buffer that returns an error if it cannot grow because memory runs out.
pub(crate) struct Bytes(pub(crate) Vec<u8>);

impl Write for Bytes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.try_reserve(bytes.len()).map_err(|_| io::ErrorKind::OutOfMemory)?;
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The cost stored for a tree that was never refitted: a NaN with the same bits on every platform.
const NO_COST: f64 = f64::from_bits(0x7ff8 << 48);

/// A section to write: the number and size of its records, and a function that writes a record.
pub(super) struct Section<'a> {
    pub(super) kind: u32,
    pub(super) record: usize,
    pub(super) count: usize,
    pub(super) write: &'a (dyn Fn(usize, &mut [u8]) + Sync),
}

impl Section<'_> {
    /// Serializes a block of the section.
    fn block(&self, block: usize) -> Result<Box<[u8]>, NoMemory> {
        // Sections are never kept in memory as a whole, so each block is generated twice: once for
        // its checksum and once for the output.
        let records = block * BLOCK..self.count.min((block + 1) * BLOCK);
        let mut bytes = zeros(records.len() * self.record)?;
        for (i, to) in records.zip(bytes.chunks_exact_mut(self.record)) {
            (self.write)(i, to);
        }
        Ok(bytes)
    }

    /// Returns the checksums of the section's blocks.
    fn sums(&self) -> Result<Vec<u64>, NoMemory> {
        let (mut sums, is_full) = (Vec::new(), AtomicBool::new(false));
        let sum = |block| {
            self.block(block).map_or_else(
                |NoMemory| {
                    is_full.store(true, Ordering::Relaxed);
                    0
                },
                |bytes| checksum(&bytes),
            )
        };
        threads::extend(&mut sums, self.count.div_ceil(BLOCK), 1, sum)?;
        if is_full.into_inner() { Err(NoMemory) } else { Ok(sums) }
    }
}

/// Writes the whole hierarchy.
pub(crate) fn write(bvh: &Tree, output: &mut dyn Write) -> io::Result<()> {
    let leaf = |i: usize, to: &mut [u8]| write_leaf(&bvh.leaves[i], to);
    let count = bvh.leaves.len();
    let leaves = Section { kind: LEAVES, record: LEAF_SIZE, count, write: &leaf };
    write_with(bvh, vec![leaves], output)
}

/// Writes the whole hierarchy, given the sections that hold its leaves.
pub(super) fn write_with(
    bvh: &Tree,
    leaves: Vec<Section<'_>>,
    output: &mut dyn Write,
) -> io::Result<()> {
    let left_out = bvh.left_out().map_err(no_memory)?;
    let node = |i: usize, to: &mut [u8]| write_node(&bvh.nodes[i], to);
    let number = |i: usize, to: &mut [u8]| to.copy_from_slice(&left_out[i].to_le_bytes());
    let mut geometries = room(bvh.geometries.count()).map_err(no_memory)?;
    geometries.extend(bvh.geometries.counts_and_masks(bvh.triangles));
    let geometry = |i: usize, to: &mut [u8]| {
        let (count, mask) = geometries[i];
        to[..4].copy_from_slice(&count.to_le_bytes());
        to[4..].copy_from_slice(&mask.to_le_bytes());
    };
    let mut sections =
        vec![Section { kind: NODES, record: NODE, count: bvh.main_nodes().len(), write: &node }];
    sections.extend(leaves);
    let count = left_out.len();
    sections.push(Section { kind: LEFT_OUT, record: NUMBER, count, write: &number });
    if !bvh.geometries.is_plain() {
        let count = geometries.len();
        sections.push(Section { kind: GEOMETRIES, record: GEOMETRY, count, write: &geometry });
    }

    let (entries, end) = entries_of(&sections).map_err(no_memory)?;
    let header = Header {
        triangles: bvh.triangles as u64,
        boxed: bvh.boxed as u64,
        cost: bvh.cost_as_built.unwrap_or(NO_COST),
        size: end as u64,
    };
    write_sections(front(&header, &entries), &sections, &entries, output)
}

/// Returns the table entries of all sections, and the offset at which the last section ends.
pub(super) fn entries_of(sections: &[Section<'_>]) -> Result<(Vec<Entry>, usize), NoMemory> {
    // The table comes first and the output cannot seek, so all checksums must be known before
    // writing starts.
    let mut end = HEADER + sections.len() * ENTRY;
    let mut entries = Vec::new();
    for section in sections {
        let place = end.next_multiple_of(ALIGN);
        let size = section.count * section.record;
        let sums = section.sums()?;
        entries.push(Entry {
            kind: section.kind,
            record: section.record as u32,
            place: place as u64,
            size: size as u64,
            checksum: checksum_of_blocks(&sums),
        });
        end = place + size;
    }
    Ok((entries, end))
}

/// Writes the header and the table, given as `front`, and then the sections.
pub(super) fn write_sections(
    front: Vec<u8>,
    sections: &[Section<'_>],
    entries: &[Entry],
    output: &mut dyn Write,
) -> io::Result<()> {
    let mut written = front;
    output.write_all(&written)?;
    let mut end = written.len();
    for (section, entry) in sections.iter().zip(entries) {
        let place = entry.place as usize;
        written.clear();
        written.resize(place - end, 0);
        output.write_all(&written)?;
        for block in 0..section.count.div_ceil(BLOCK) {
            stop::check();
            output.write_all(&section.block(block).map_err(no_memory)?)?;
        }
        end = place + entry.size as usize;
    }
    Ok(())
}

pub(super) fn no_memory(_: NoMemory) -> io::Error {
    io::ErrorKind::OutOfMemory.into()
}
