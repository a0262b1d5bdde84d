//! Saves and loads f64 hierarchies: nodes, the frame of the copies, and leaves with f64 corners.

use std::io::{self, Write};

use intertri::internal::LocalFrame;

use super::error::LoadError;
use super::format::{FRAME, FRAME_SIZE, LEAF64_SIZE, LEAVES64};
use super::input::Input;
use super::load::read_parts;
use super::records64::{EightTriangles, write_frame, write_leaf64};
use super::store::{Section, write_with};
use crate::tree::{Aabb, Tree};

/// Writes the whole hierarchy.
pub(crate) fn write64(
    tree: &Tree,
    frame: &LocalFrame,
    triangles: &[EightTriangles],
    output: &mut dyn Write,
) -> io::Result<()> {
    let write_frame = |_: usize, to: &mut [u8]| write_frame(frame, to);
    let write_leaf = |i: usize, to: &mut [u8]| {
        write_leaf64(&tree.leaves[i], tree.present(i), &triangles[i], to);
    };
    let count = tree.leaves.len();
    let sections = vec![
        Section { kind: FRAME, record: FRAME_SIZE, count: 1, write: &write_frame },
        Section { kind: LEAVES64, record: LEAF64_SIZE, count, write: &write_leaf },
    ];
    write_with(tree, sections, output)
}

/// Reads a whole hierarchy, leaving any bytes after it unread. Returns the tree, the frame of the
/// copies, and the triangles of each leaf.
pub(crate) fn read64(
    input: &mut dyn Input,
) -> Result<(Tree, LocalFrame, Vec<EightTriangles>), LoadError> {
    let (header, mut parts) = read_parts(input, "f64")?;
    let (Some(frame), Some(originals)) = (parts.frame, parts.originals.take()) else {
        return LoadError::damaged("it has no frame or no leaves");
    };

    // Compute the extent of the corners along each axis, relative to the centre.
    let mut around = Aabb::EMPTY;
    parts.bounds.iter().for_each(|leaf| around.join(&leaf.bounds));
    // Compute the reach from the corners instead of trusting the file, because the error bounds of
    // the filter depend on it.
    let far = |axis: usize| (-around.lo[axis]).max(around.hi[axis]).max(0.0);
    let (centre, up) = frame.centre_and_exponent();
    let frame = LocalFrame::of(centre, up, [far(0), far(1), far(2)]);
    let Some(frame) = frame.filter(|frame| frame.reach().is_finite()) else {
        return LoadError::damaged("its frame is invalid");
    };
    Ok((parts.tree(&header)?, frame, originals))
}
