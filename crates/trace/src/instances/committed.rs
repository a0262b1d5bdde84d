//! A committed scene: what queries read, and what it takes to make it.

use std::sync::Arc;

use super::matrix::{Inverse, Matrix, sizes, world_box};
use super::mesh::{Extent, SceneMesh};
use super::top::{InstanceBox, Top};
use crate::util::memory::{NoMemory, room};
use crate::util::threads;

/// The number of no mesh: of an instance that was removed.
pub(super) const NO_MESH: u32 = u32::MAX;

/// Products of a matrix and coordinates at least this large (2^-140), or 0, add up to no number too small for f64 lanes.
const SMALLEST: f64 = f64::from_bits((1023 - 140) << 52);

/// No sum may be larger: 2^299.
const LARGEST: f64 = f64::from_bits((1023 + 299) << 52);

/// Instances that are looked at in a row.
const PART: usize = 1 << 12;

/// An instance as the user placed it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) matrix: Matrix,
    /// The number of its mesh, or [`NO_MESH`].
    pub(super) mesh: u32,
    pub(super) is_visible: bool,
}

/// A mesh of a scene.
#[derive(Clone, Debug)]
pub(super) struct MeshEntry {
    pub(super) mesh: SceneMesh,
    pub(super) extent: Extent,
}

/// What a placement means for rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) inverse: Inverse,
    /// Whether f64 lanes lose nothing of its corners' numbers but by rounding.
    pub(super) is_tame: bool,
}

/// A scene that no longer changes.
#[derive(Debug)]
pub(super) struct Committed {
    pub(super) placed: Arc<Vec<Placed>>,
    pub(super) frames: Vec<Frame>,
    pub(super) meshes: Vec<Option<MeshEntry>>,
    pub(super) top: Top,
    /// A stack size that suffices for every mesh.
    pub(super) mesh_stack: usize,
}

/// A frame, and a box around its instance; `None` where it counts for nothing.
type Looked = (Frame, Option<[[f64; 3]; 2]>);

impl Committed {
    pub(super) fn new(
        placed: Arc<Vec<Placed>>,
        meshes: Vec<Option<MeshEntry>>,
    ) -> Result<Self, NoMemory> {
        let (mut frames, mut boxes) = (room(placed.len())?, room(placed.len())?);
        let look = |placed: &Placed| Frame::look(placed, mesh_of(&meshes, placed));
        // A part at a time, so that what is on the way stays small.
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
        // One stack serves all meshes in turn, so it is as deep as the deepest needs.
        let stacks = meshes.iter().flatten().map(|entry| entry.mesh.tree().stack);
        let mesh_stack = stacks.max().unwrap_or(0);
        Ok(Self { placed, frames, meshes, top, mesh_stack })
    }

    /// The mesh of an instance; none if the instance was removed.
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
        // Without a box an instance is not in the tree, which is all that hiding and removing take.
        let Some(MeshEntry { extent, .. }) = mesh.filter(|_| placed.is_visible) else {
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

/// Whether f64 lanes lose nothing of the corners' numbers but by rounding.
fn is_tame(m: &Matrix, extent: &Extent, sizes: &[f64; 3]) -> bool {
    let mut least = f64::INFINITY;
    for (i, x) in m.iter().enumerate() {
        // Nothing is multiplied with the last column.
        let by = if i % 4 == 3 { 1.0 } else { extent.least };
        // By its bits, without the sign: a comparison with 0 would take subnormal numbers for 0 where the CPU is set so.
        if x.to_bits() << 1 != 0 {
            least = least.min(x.abs() * by);
        }
    }
    least >= SMALLEST && sizes.iter().all(|&size| size <= LARGEST)
}
