//! Hierarchies over f64 to bytes and back: nodes, where copies are, and leaves of corners in f64.

use std::io::{self, Write};

use intertri::internal::LocalFrame;
use intertri::{Triangle64, TriangleOf};

use super::error::LoadError;
use super::format::{FRAME, FRAME_SIZE, LEAF64_SIZE, LEAVES64};
use super::input::Input;
use super::load::read_parts;
use super::records64::{Leaf64, write_frame, write_leaf64};
use super::store::{Section, write_with};
use crate::across::lanes_of;
use crate::memory::{NoMemory, room};
use crate::threads;
use crate::tree::{Aabb, Tree};

/// Writes all of it.
pub(crate) fn write64(
    tree: &Tree,
    frame: &LocalFrame,
    triangles: &[Triangle64],
    output: &mut dyn Write,
) -> io::Result<()> {
    let (centre, up) = frame.centre_and_exponent();
    let write_frame = |_: usize, to: &mut [u8]| write_frame((centre, up), to);
    let write_leaf = |i: usize, to: &mut [u8]| write_leaf64(&tree.leaves[i], triangles, to);
    let count = tree.leaves.len();
    let sections = vec![
        Section { kind: FRAME, record: FRAME_SIZE, count: 1, write: &write_frame },
        Section { kind: LEAVES64, record: LEAF64_SIZE, count, write: &write_leaf },
    ];
    write_with(tree, sections, output)
}

/// Reads all of it, and nothing that follows: the tree, where its copies are, and the triangles by their numbers, NaN
/// for those that can not be hit.
pub(crate) fn read64(
    input: &mut dyn Input,
) -> Result<(Tree, LocalFrame, Vec<Triangle64>), LoadError> {
    let (header, mut parts) = read_parts(input, "f64")?;
    let (Some((centre, up)), Some(leaves)) = (parts.frame, parts.leaves64.take()) else {
        return LoadError::damaged("it has no frame or no leaves");
    };
    if parts.leaves.is_some() {
        return LoadError::damaged("it has leaves of f32 and of f64");
    }
    let wrong = || LoadError::damaged("its frame makes no sense");
    let Some(frame) = LocalFrame::of(centre, up, [0.0; 3]) else { return wrong() };
    parts.leaves = Some(threads::each(leaves.len(), |i| leaves[i].leaf(&frame))?);
    parts.bounds = threads::each(leaves.len(), |i| leaves[i].bounds(&frame))?;

    // How far from the centre corners are, along each axis.
    let mut around = Aabb::EMPTY;
    parts.bounds.iter().for_each(|leaf| around.join(&leaf.bounds));
    let far = |axis: usize| (-around.lo[axis]).max(around.hi[axis]).max(0.0);
    let Some(frame) = LocalFrame::of(centre, up, [far(0), far(1), far(2)]) else { return wrong() };
    if !frame.reach().is_finite() {
        return wrong();
    }

    let tree = parts.tree(&header)?;
    Ok((tree, frame, by_number(&leaves, header.triangles as usize)?))
}

/// The triangles by their numbers.
fn by_number(leaves: &[Leaf64], count: usize) -> Result<Vec<Triangle64>, NoMemory> {
    let mut triangles = room(count)?;
    triangles.resize(count, TriangleOf([[f64::NAN; 3]; 3]));
    for leaf in leaves {
        for lane in lanes_of(leaf.live) {
            triangles[leaf.indices[lane] as usize] = leaf.triangle(lane);
        }
    }
    Ok(triangles)
}
