//! Loads a hierarchy one section at a time. Each batch of records is checksummed, checked, and
//! stored while it is in the cache.

use std::sync::atomic::{AtomicBool, Ordering};

use intertri::internal::LocalFrame;
use intertri::simd::Level;

use super::arriving::ArrivingRecords;
use super::check;
use super::checksum::checksum;
use super::error::LoadError;
use super::format::{
    BLOCK, Entry, FRAME, GEOMETRIES, GEOMETRY, HEADER, Header, LEAF_SIZE, LEAF64_SIZE, LEAVES,
    LEAVES64, LEFT_OUT, NODE, NODES, NUMBER, checksum_of_blocks, parse, table_size, u32_at,
};
use super::input::Input;
use super::records::{ReadLeaves, read_node};
use super::records64::{EightTriangles, ReadLeaves64, read_frame};
use crate::tree::{
    EMPTY, Geometries, Leaf, LeafBounds, MOST_LEAVES, Node, Tree, boxes_of, lean_of,
};
use crate::util::memory::NoMemory;
use crate::util::threads;

/// The number of blocks that each thread reads at a time; small enough for the thread's cache.
const BATCH: usize = 1;

/// The minimum number of records that a thread processes per task.
const LEAST: usize = 128;

/// The contents of the sections that have been read.
#[derive(Default)]
pub(super) struct Parts {
    nodes: Option<Vec<Node>>,
    leaves: Option<Vec<Leaf>>,
    pub(super) bounds: Vec<LeafBounds>,
    /// The frame of the copies, present only in f64 hierarchies.
    pub(super) frame: Option<LocalFrame>,
    /// The original triangles of each leaf, present only in f64 hierarchies.
    pub(super) originals: Option<Vec<EightTriangles>>,
    left_out: Option<Vec<u32>>,
    /// The triangle count and mask of each geometry.
    geometries: Option<Vec<(u32, u32)>>,
}

/// Reads a whole hierarchy, leaving any bytes after it unread.
pub(crate) fn read(input: &mut dyn Input) -> Result<Tree, LoadError> {
    let (header, parts) = read_parts(input, "f32")?;
    parts.tree(&header)
}

/// Reads all sections of a hierarchy with the given scalar type.
pub(super) fn read_parts(
    input: &mut dyn Input,
    scalar: &'static str,
) -> Result<(Header, Parts), LoadError> {
    let mut header = [0; HEADER];
    header.copy_from_slice(input.take(HEADER).map_err(not_saved)?);
    let mut front = header.to_vec();
    front.extend(input.take(table_size(&header)?)?);
    let (header, entries) = parse(&front)?;
    // The table reveals the scalar type, so a caller that expected the other type finds out before
    // any section is read.
    let is_f64 = entries.iter().any(|entry| matches!(entry.kind, FRAME | LEAVES64));
    let found = if is_f64 { "f64" } else { "f32" };
    if found != scalar {
        return Err(LoadError::Scalar { found });
    }

    let mut parts = Parts::default();
    let mut end = front.len() as u64;
    for entry in &entries {
        let gap = input.take((entry.place - end) as usize)?;
        // No checksum covers the padding, so it must be zero.
        if gap.iter().any(|&byte| byte != 0) {
            return LoadError::damaged("there are bytes between its sections");
        }
        parts.read(input, entry, &header)?;
        end = entry.place + entry.size;
    }
    Ok((header, parts))
}

/// Converts a truncation error to [`LoadError::NotSaved`]: a file shorter than a header is probably
/// not a truncated hierarchy but a different kind of file.
fn not_saved(error: LoadError) -> LoadError {
    if matches!(error, LoadError::CutOff) { LoadError::NotSaved } else { error }
}

impl Parts {
    /// Reads a section.
    fn read(
        &mut self,
        input: &mut dyn Input,
        entry: &Entry,
        header: &Header,
    ) -> Result<(), LoadError> {
        let triangles = header.triangles as u32;
        // Reject duplicate sections: a second one would overwrite data that was already checked.
        let again = match entry.kind {
            NODES => {
                let nodes = read_nodes(input, entry)?;
                self.nodes.replace(nodes).is_some()
            }
            LEAVES => {
                let (leaves, bounds) = read_leaves(input, entry, triangles)?;
                self.bounds = bounds;
                self.leaves.replace(leaves).is_some()
            }
            LEFT_OUT => {
                let mut numbers = room(input, entry)?;
                in_batches(input, entry, |batch| {
                    let count = batch.len() / NUMBER;
                    let number = |i: usize| u32_at(batch, i * NUMBER);
                    Ok(threads::extend(&mut numbers, count, BLOCK, number)?)
                })?;
                self.left_out.replace(numbers).is_some()
            }
            GEOMETRIES => {
                let mut geometries = room(input, entry)?;
                in_batches(input, entry, |batch| {
                    let count = batch.len() / GEOMETRY;
                    let one =
                        |i: usize| (u32_at(batch, i * GEOMETRY), u32_at(batch, i * GEOMETRY + 4));
                    Ok(threads::extend(&mut geometries, count, BLOCK, one)?)
                })?;
                self.geometries.replace(geometries).is_some()
            }
            FRAME => {
                let mut frame = None;
                in_batches(input, entry, |batch| {
                    frame = Some(read_frame(batch)?);
                    Ok(())
                })?;
                std::mem::replace(&mut self.frame, frame).is_some()
            }
            LEAVES64 => {
                // The copies of the corners are computed while the leaves are read, so the frame
                // must come first.
                let Some(frame) = &self.frame else {
                    return LoadError::damaged("its leaves come before its frame");
                };
                let ((leaves, bounds), originals) = read_leaves64(input, entry, triangles, frame)?;
                self.bounds = bounds;
                self.leaves.replace(leaves).is_some() | self.originals.replace(originals).is_some()
            }
            // Skip an optional section, but verify its checksum.
            _ => {
                in_batches(input, entry, |_| Ok(()))?;
                false
            }
        };
        if again { LoadError::damaged("it has the same section twice") } else { Ok(()) }
    }

    /// Assembles the tree if its parts are consistent.
    pub(super) fn tree(self, header: &Header) -> Result<Tree, LoadError> {
        let (Some(nodes), Some(leaves)) = (self.nodes, self.leaves) else {
            return LoadError::damaged("it has no nodes or no leaves");
        };
        let left_out = self.left_out.unwrap_or_default();
        if leaves.len() > MOST_LEAVES {
            return Err(LoadError::OutOfMemory);
        }
        if header.boxed > leaves.len() as u64 {
            return LoadError::damaged("the header is invalid");
        }
        let boxed = header.boxed as usize;
        // Check the boxes only after the nodes are known to form a tree, because the box check
        // follows child indices.
        let (depth, numbers) = threads::join(
            || check::tree(&nodes, boxed),
            || check::numbers(&leaves, boxed, &left_out, header.triangles as usize),
        );
        let depth = depth?;
        numbers?;
        check::boxes(&nodes, &self.bounds[..boxed])?;

        let geometries = match &self.geometries {
            None => Geometries::one(),
            Some(all) => check::geometries(all, header.triangles)?,
        };
        let cost = header.cost;
        let mut bvh = Tree {
            degenerate: Vec::new(),
            nodes,
            leaves,
            boxed,
            thin_root: EMPTY,
            reach: 0.0,
            lean: lean_of(&self.bounds[..boxed]),
            stack: Tree::stack_for(1 + depth),
            triangles: header.triangles as usize,
            geometries,
            cost_as_built: (cost >= 0.0 && cost.is_finite()).then_some(cost),
        };
        // The second tree is not in the file. It has few leaves, so rebuild it.
        bvh.note_degenerate(&self.bounds)?;
        bvh.add_thin_nodes(&boxes_of(&self.bounds[boxed..])?)?;
        Ok(bvh)
    }
}

fn read_nodes(input: &mut dyn Input, entry: &Entry) -> Result<Vec<Node>, LoadError> {
    let mut nodes = ArrivingRecords::of(input, entry)?;
    in_batches(input, entry, |batch| {
        let count = batch.len() / NODE;
        let size = threads::piece_of(count, LEAST);
        let pieces = batch.chunks(size * NODE).zip(nodes.next(count)?.chunks_mut(size));
        all_sound(pieces, "a node is invalid", |(bytes, nodes)| {
            bytes.chunks_exact(NODE).zip(nodes).all(|(from, to)| read_node(from, to))
        })
    })?;
    Ok(nodes.all())
}

/// Leaves, and the hit bounds of their triangles.
type Leaves = (Vec<Leaf>, Vec<LeafBounds>);

fn read_leaves(input: &mut dyn Input, entry: &Entry, triangles: u32) -> Result<Leaves, LoadError> {
    let (mut leaves, mut bounds) =
        (ArrivingRecords::of(input, entry)?, ArrivingRecords::of(input, entry)?);
    let level = Level::best();
    in_batches(input, entry, |batch| {
        let count = batch.len() / LEAF_SIZE;
        let size = threads::piece_of(count, LEAST);
        let pieces = (batch.chunks(size * LEAF_SIZE))
            .zip(leaves.next(count)?.chunks_mut(size))
            .zip(bounds.next(count)?.chunks_mut(size));
        all_sound(pieces, "a leaf is invalid", |((bytes, leaves), bounds)| {
            level.run(ReadLeaves { bytes, triangles, leaves, bounds })
        })
    })?;
    Ok((leaves.all(), bounds.all()))
}

/// Reads f64 leaves and the original triangles.
fn read_leaves64(
    input: &mut dyn Input,
    entry: &Entry,
    triangles: u32,
    frame: &LocalFrame,
) -> Result<(Leaves, Vec<EightTriangles>), LoadError> {
    let (mut leaves, mut bounds) =
        (ArrivingRecords::of(input, entry)?, ArrivingRecords::of(input, entry)?);
    let (mut originals, level) = (ArrivingRecords::of(input, entry)?, Level::best());
    in_batches(input, entry, |batch| {
        let count = batch.len() / LEAF64_SIZE;
        let size = threads::piece_of(count, LEAST);
        let pieces = (batch.chunks(size * LEAF64_SIZE))
            .zip(leaves.next(count)?.chunks_mut(size))
            .zip(bounds.next(count)?.chunks_mut(size))
            .zip(originals.next(count)?.chunks_mut(size));
        all_sound(pieces, "a leaf is invalid", |(((bytes, leaves), bounds), originals)| {
            level.run(ReadLeaves64 { bytes, triangles, frame, leaves, bounds, originals })
        })
    })?;
    Ok(((leaves.all(), bounds.all()), originals.all()))
}

/// Reserves memory for all records of a section if they are certain to follow.
pub(super) fn room<T>(input: &dyn Input, entry: &Entry) -> Result<Vec<T>, NoMemory> {
    let there = input.known() as u64 >= entry.size;
    crate::util::memory::room(if there { entry.count() } else { 0 })
}

/// Passes a section to `each` in batches of blocks, and verifies its checksum.
pub(super) fn in_batches(
    input: &mut dyn Input,
    entry: &Entry,
    mut each: impl FnMut(&[u8]) -> Result<(), LoadError>,
) -> Result<(), LoadError> {
    let block = BLOCK * entry.record as usize;
    let (mut left, mut sums) = (entry.size, Vec::new());
    while left > 0 {
        let size = left.min((BATCH * threads::count() * block) as u64) as usize;
        let batch = input.take(size)?;
        // Each thread checksums its own blocks, which are then still in its cache when `each` reads
        // them.
        let sum = |i: usize| checksum(&batch[i * block..size.min((i + 1) * block)]);
        threads::extend(&mut sums, size.div_ceil(block), 1, sum)?;
        each(batch)?;
        left -= size as u64;
    }
    if checksum_of_blocks(&sums) == entry.checksum {
        Ok(())
    } else {
        LoadError::damaged("the checksum of a section does not match")
    }
}

/// Reads records piece by piece, using all threads. Returns an error if a record is invalid.
fn all_sound<P: Send>(
    pieces: impl Iterator<Item = P>,
    what: &'static str,
    read: impl Fn(P) -> bool + Sync,
) -> Result<(), LoadError> {
    // Pieces return no results, so an invalid piece sets a flag.
    let sound = AtomicBool::new(true);
    threads::pieces(pieces, |_, piece| {
        if !read(piece) {
            sound.store(false, Ordering::Relaxed);
        }
    });
    if sound.into_inner() { Ok(()) } else { LoadError::damaged(what) }
}
