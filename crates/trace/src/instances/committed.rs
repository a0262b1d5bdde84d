//! A committed scene: the data that queries read, and how it is built.

use std::sync::Arc;

use super::matrix::{Inverse, Matrix, sizes, world_box};
use super::mesh::{Extent, SceneMesh};
use super::top::{InstanceBox, Top};
use crate::util::memory::{NoMemory, room};
use crate::util::threads;

/// The mesh number of an instance that was removed.
pub(super) const NO_MESH: u32 = u32::MAX;

/// If products of a matrix and coordinates are at least this large (2^-140), or 0, no sum of them is too
/// small for f64 lanes.
const SMALLEST: f64 = f64::from_bits((1023 - 140) << 52);

/// No sum may be larger than this: 2^299.
const LARGEST: f64 = f64::from_bits((1023 + 299) << 52);

/// The number of instances that a thread processes at a time.
const PART: usize = 1 << 12;

/// An instance as placed by the user.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) matrix: Matrix,
    /// The number of its mesh, or [`NO_MESH`].
    pub(super) mesh: u32,
    /// Queries see the instance if their masks share a bit with this one.
    pub(super) mask: u32,
}

/// A mesh of a scene.
#[derive(Clone, Debug)]
pub(super) struct MeshEntry {
    pub(super) mesh: SceneMesh,
    pub(super) extent: Extent,
}

/// A placement, prepared for rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) inverse: Inverse,
    /// Whether computing its corners in f64 lanes loses nothing except by rounding.
    pub(super) is_tame: bool,
}

/// A scene that no longer changes.
#[derive(Debug)]
pub(super) struct Committed {
    pub(super) placed: Arc<Vec<Placed>>,
    pub(super) frames: Vec<Frame>,
    pub(super) meshes: Vec<Option<MeshEntry>>,
    pub(super) top: Top,
    /// A stack size that is sufficient for every mesh.
    pub(super) mesh_stack: usize,
}

/// A frame, and a box around its instance; `None` if the instance is hidden, removed or empty.
type Looked = (Frame, Option<[[f64; 3]; 2]>);

impl Committed {
    pub(super) fn new(
        placed: Arc<Vec<Placed>>,
        meshes: Vec<Option<MeshEntry>>,
    ) -> Result<Self, NoMemory> {
        let (mut frames, mut boxes) = (room(placed.len())?, room(placed.len())?);
        let look = |placed: &Placed| Frame::look(placed, mesh_of(&meshes, placed));
        // One part at a time, so that temporary memory stays small.
        for (part, first) in placed.chunks(PART).zip((0_u32..).step_by(PART)) {
            let mut looked: Vec<Looked> = room(part.len())?;
            looked.resize(part.len(), (Frame::NONE, None));
            threads::write(&mut looked, 1 << 7, |i| look(&part[i]));
            for ((frame, bounds), instance) in looked.into_iter().zip(first..) {
                frames.push(frame);
                boxes.extend(bounds.map(|bounds| InstanceBox { instance, bounds }));
            }
        }
        let top = Top::over(&boxes)?;
        // All meshes share one stack, so it is as deep as the deepest needs.
        let stacks = meshes.iter().flatten().map(|entry| entry.mesh.tree().stack);
        let mesh_stack = stacks.max().unwrap_or(0);
        Ok(Self { placed, frames, meshes, top, mesh_stack })
    }

    /// The mesh of an instance; `None` if the instance was removed.
    #[inline]
    pub(super) fn mesh(&self, instance: usize) -> Option<&MeshEntry> {
        mesh_of(&self.meshes, &self.placed[instance])
    }
}

#[inline]
fn mesh_of<'a>(meshes: &'a [Option<MeshEntry>], placed: &Placed) -> Option<&'a MeshEntry> {
    meshes.get(placed.mesh as usize)?.as_ref()
}

impl Frame {
    const NONE: Self = Self { inverse: Inverse::NONE, is_tame: false };

    /// The frame of an instance and the box around it.
    fn look(placed: &Placed, mesh: Option<&MeshEntry>) -> Looked {
        // An instance without a box is not in the tree, which is all that hiding and removing require.
        let Some(MeshEntry { extent, .. }) = mesh.filter(|_| placed.mask != 0) else {
            return (Self::NONE, None);
        };
        if extent.is_empty() {
            return (Self::NONE, None);
        }
        let (matrix, sizes) = (&placed.matrix, sizes(&placed.matrix, extent));
        let inverse = Inverse::new(matrix, extent);
        let frame = Self { inverse, is_tame: is_tame(matrix, extent, &sizes) };
        (frame, Some(world_box(matrix, extent.bounds, &sizes)))
    }
}

/// Whether computing the corners in f64 lanes loses nothing except by rounding.
fn is_tame(m: &Matrix, extent: &Extent, sizes: &[f64; 3]) -> bool {
    let mut least = f64::INFINITY;
    for (i, x) in m.iter().enumerate() {
        // Nothing is multiplied by the last column.
        let by = if i % 4 == 3 { 1.0 } else { extent.least };
        // Compare the bits without the sign: if the CPU is set to flush subnormal numbers, a comparison with
        // 0 would treat them as 0.
        if x.to_bits() << 1 != 0 {
            least = least.min(x.abs() * by);
        }
    }
    least >= SMALLEST && sizes.iter().all(|&size| size <= LARGEST)
}
