//! Reading a hierarchy: a section at a time, each batch of it summed up and put in its place while it is in the
//! cache.

use bytemuck::Zeroable;
use intertri::simd::Level;

use super::check;
use super::checksum::checksum;
use super::error::LoadError;
use super::format::{
    BLOCK, Entry, FRAME, GEOMETRIES, GEOMETRY, HEADER, Header, LEAF_SIZE, LEAF64_SIZE, LEAVES,
    LEAVES64, LEFT_OUT, NODE, NODES, NUMBER, checksum_of_blocks, parse, table_size, u32_at,
};
use super::input::Input;
use super::records::{ReadLeaf, read_node};
use super::records64::{Frame, Leaf64, read_frame, read_leaf64};
use crate::memory::NoMemory;
use crate::threads;
use crate::tree::{Geometries, LaneBounds, Leaf, LeafBounds, Node, Tree};

/// Blocks read at a time for each thread, which are small enough for its cache.
const BATCH: usize = 4;

/// Records that a thread takes at a time, at least.
const LEAST: usize = 128;

/// What the sections have.
#[derive(Default)]
pub(super) struct Parts {
    nodes: Option<Vec<Node>>,
    pub(super) leaves: Option<Vec<Leaf>>,
    pub(super) bounds: Vec<LeafBounds>,
    /// Of f64: where copies are, and the leaves of which they are made.
    pub(super) frame: Option<Frame>,
    pub(super) leaves64: Option<Vec<Leaf64>>,
    left_out: Option<Vec<u32>>,
    /// Of each geometry how many triangles it has, and its mask.
    geometries: Option<Vec<(u32, u32)>>,
}

/// Reads all of it, and nothing that follows.
pub(crate) fn read(input: &mut dyn Input) -> Result<Tree, LoadError> {
    let (header, parts) = read_parts(input, "f32")?;
    parts.tree(&header)
}

/// Reads all sections of a hierarchy over some scalar.
pub(super) fn read_parts(
    input: &mut dyn Input,
    scalar: &'static str,
) -> Result<(Header, Parts), LoadError> {
    let mut header = [0; HEADER];
    header.copy_from_slice(input.take(HEADER).map_err(not_saved)?);
    let mut front = header.to_vec();
    front.extend(input.take(table_size(&header)?)?);
    let (header, entries) = parse(&front)?;
    let is_f64 = entries.iter().any(|entry| matches!(entry.kind, FRAME | LEAVES64));
    let found = if is_f64 { "f64" } else { "f32" };
    if found != scalar {
        return Err(LoadError::Scalar { found });
    }

    let mut parts = Parts::default();
    let mut end = front.len() as u64;
    for entry in &entries {
        let gap = input.take((entry.place - end) as usize)?;
        if gap.iter().any(|&byte| byte != 0) {
            return LoadError::damaged("there is something between its sections");
        }
        parts.read(input, entry, &header)?;
        end = entry.place + entry.size;
    }
    Ok((header, parts))
}

/// What is too short for a header is hardly one that was cut off.
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
        let again = match entry.kind {
            NODES => {
                let mut nodes = room(input, entry)?;
                in_batches(input, entry, |batch| {
                    let node = |i: usize| read_node(&batch[i * NODE..][..NODE]);
                    append(&mut nodes, batch.len() / NODE, node, "a node makes no sense")
                })?;
                self.nodes.replace(nodes).is_some()
            }
            LEAVES => {
                let (mut leaves, mut bounds) = (room(input, entry)?, room(input, entry)?);
                let level = Level::best();
                in_batches(input, entry, |batch| {
                    let leaf = |i: usize| {
                        let bytes = &batch[i * LEAF_SIZE..][..LEAF_SIZE];
                        level.run(ReadLeaf { bytes, triangles })
                    };
                    let (done, count) = (leaves.len(), batch.len() / LEAF_SIZE);
                    append(&mut leaves, count, leaf, "a leaf makes no sense")?;
                    let new = &leaves[done..];
                    let around = |i: usize| level.run(LaneBounds::of(&new[i].block));
                    Ok(threads::extend(&mut bounds, count, LEAST, around)?)
                })?;
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
                let mut leaves = room(input, entry)?;
                in_batches(input, entry, |batch| {
                    let leaf =
                        |i: usize| read_leaf64(&batch[i * LEAF64_SIZE..][..LEAF64_SIZE], triangles);
                    let count = batch.len() / LEAF64_SIZE;
                    append(&mut leaves, count, leaf, "a leaf makes no sense")
                })?;
                self.leaves64.replace(leaves).is_some()
            }
            // Nobody needs it; its checksum is right or not.
            _ => {
                in_batches(input, entry, |_| Ok(()))?;
                false
            }
        };
        if again { LoadError::damaged("it has a section twice") } else { Ok(()) }
    }

    /// The tree, if all belongs together.
    pub(super) fn tree(self, header: &Header) -> Result<Tree, LoadError> {
        let (Some(nodes), Some(leaves)) = (self.nodes, self.leaves) else {
            return LoadError::damaged("it has no nodes or no leaves");
        };
        let left_out = self.left_out.unwrap_or_default();
        if header.boxed > leaves.len() as u64 {
            return LoadError::damaged("the header makes no sense");
        }
        let boxed = header.boxed as usize;
        // Boxes are looked at where the tree leads to, so after that.
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
            nodes,
            leaves,
            boxed,
            reach: 0.0,
            stack: Tree::stack_for(depth),
            triangles: header.triangles as usize,
            geometries,
            cost_as_built: (cost >= 0.0 && cost.is_finite()).then_some(cost),
        };
        bvh.reach = bvh.find_reach();
        Ok(bvh)
    }
}

/// Room for all records of a section, if they are surely there.
fn room<T>(input: &dyn Input, entry: &Entry) -> Result<Vec<T>, NoMemory> {
    let there = input.known() as u64 >= entry.size;
    crate::memory::room(if there { entry.count() } else { 0 })
}

/// Hands on a section in batches of blocks, and compares its checksum.
fn in_batches(
    input: &mut dyn Input,
    entry: &Entry,
    mut each: impl FnMut(&[u8]) -> Result<(), LoadError>,
) -> Result<(), LoadError> {
    let block = BLOCK * entry.record as usize;
    let (mut left, mut sums) = (entry.size, Vec::new());
    while left > 0 {
        let size = left.min((BATCH * threads::count() * block) as u64) as usize;
        let batch = input.take(size)?;
        let sum = |i: usize| checksum(&batch[i * block..size.min((i + 1) * block)]);
        threads::extend(&mut sums, size.div_ceil(block), 1, sum)?;
        each(batch)?;
        left -= size as u64;
    }
    if checksum_of_blocks(&sums) == entry.checksum {
        Ok(())
    } else {
        LoadError::damaged("the checksum of a section differs")
    }
}

/// Appends records, or says that one of them makes no sense.
fn append<T: Zeroable + Clone + Send>(
    all: &mut Vec<T>,
    count: usize,
    of: impl Fn(usize) -> Option<T> + Sync,
    what: &'static str,
) -> Result<(), LoadError> {
    use std::sync::atomic::{AtomicBool, Ordering};
    let bad = AtomicBool::new(false);
    let of = |i: usize| {
        of(i).unwrap_or_else(|| {
            bad.store(true, Ordering::Relaxed);
            T::zeroed()
        })
    };
    threads::extend(all, count, LEAST, of)?;
    if bad.into_inner() { LoadError::damaged(what) } else { Ok(()) }
}
