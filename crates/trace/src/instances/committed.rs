//! A committed scene: the data that queries read, and how it is built.

use std::sync::Arc;

use super::matrix::{Inverse, Matrix, sizes, world_box};
use super::mesh::{Extent, SceneMesh};
use super::top::{InstanceBox, Top};
use crate::util::memory::{NoMemory, room};
use crate::util::threads;

/// The mesh number of an instance that was removed.
pub(super) const NO_MESH: u32 = u32::MAX;

/// A bound on the products of matrix entries and coordinates: if each product is 0 or at least this
/// large (2^-140), no sum of them is too small for f64 lanes.
const SMALLEST: f64 = f64::from_bits((1023 - 140) << 52);

/// If the magnitudes of each coordinate's terms sum to at most this (2^299), no coordinate is too
/// large for f64 lanes.
const LARGEST: f64 = f64::from_bits((1023 + 299) << 52);

/// The number of instances to prepare per step.
const PART: usize = 1 << 12;

/// An instance as placed by the user.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) matrix: Matrix,
    /// The number of its mesh, or [`NO_MESH`].
    pub(super) mesh: u32,
    /// Queries consider the instance only if their mask shares a bit with this mask.
    pub(super) mask: u32,
}

/// A mesh of a scene.
#[derive(Clone, Debug)]
pub(super) struct MeshEntry {
    pub(super) mesh: SceneMesh,
    pub(super) extent: Extent,
}

/// A placement prepared for tracing: what a ray needs in order to be transformed to the mesh's
/// frame, in two cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Frame {
    pub(super) inverse: Inverse,
    /// The coordinates of the mesh's tree range over plus and minus this value.
    pub(super) reach: f32,
    /// The number of the mesh, or [`NO_MESH`] if no ray can hit the instance.
    mesh: u32,
    /// The mask of the instance (see [`Placed`]), or 0 if no ray can hit it.
    pub(super) mask: u32,
    /// Whether f64 lanes can compute the world-space corners without overflow or underflow.
    pub(super) is_tame: bool,
}

/// A committed scene, which no longer changes.
#[derive(Debug)]
pub(super) struct Committed {
    pub(super) placed: Arc<Vec<Placed>>,
    pub(super) frames: Vec<Frame>,
    pub(super) meshes: Vec<Option<MeshEntry>>,
    pub(super) top: Top,
    /// A stack size that is large enough for every mesh.
    pub(super) mesh_stack: usize,
}

/// A frame and the box around its instance. The box is `None` if the instance is hidden, removed,
/// or empty.
type FrameAndBox = (Frame, Option<[[f64; 3]; 2]>);

impl Committed {
    pub(super) fn new(
        placed: Arc<Vec<Placed>>,
        meshes: Vec<Option<MeshEntry>>,
    ) -> Result<Self, NoMemory> {
        let (mut frames, mut boxes) = (room(placed.len())?, room(placed.len())?);
        let look = |placed: &Placed| Frame::look(placed, mesh_of(&meshes, placed));
        // Process one part at a time to keep temporary memory small.
        for (part, first) in placed.chunks(PART).zip((0_u32..).step_by(PART)) {
            let mut looked: Vec<FrameAndBox> = room(part.len())?;
            looked.resize(part.len(), (Frame::NONE, None));
            threads::write(&mut looked, 1 << 7, |i| look(&part[i]));
            for ((frame, bounds), instance) in looked.into_iter().zip(first..) {
                frames.push(frame);
                boxes.extend(bounds.map(|bounds| InstanceBox { instance, bounds }));
            }
        }
        let top = Top::over(&boxes)?;
        // All meshes share one stack, so make it as deep as the deepest mesh needs.
        let stacks = meshes.iter().flatten().map(|entry| entry.mesh.tree().stack);
        let mesh_stack = stacks.max().unwrap_or(0);
        Ok(Self { placed, frames, meshes, top, mesh_stack })
    }

    /// Returns the mesh of an instance, or `None` if no ray can hit it, because it is removed, hidden,
    /// or empty.
    #[inline]
    pub(super) fn mesh(&self, instance: usize) -> Option<&MeshEntry> {
        self.meshes.get(self.frames[instance].mesh as usize)?.as_ref()
    }
}

#[inline]
fn mesh_of<'a>(meshes: &'a [Option<MeshEntry>], placed: &Placed) -> Option<&'a MeshEntry> {
    meshes.get(placed.mesh as usize)?.as_ref()
}

impl Frame {
    const NONE: Self =
        Self { inverse: Inverse::NONE, reach: 0.0, mesh: NO_MESH, mask: 0, is_tame: false };

    /// Prepares an instance: returns its frame and the box around it.
    fn look(placed: &Placed, mesh: Option<&MeshEntry>) -> FrameAndBox {
        // An instance that is not in the tree cannot be hit, so return no box for hidden and
        // removed instances.
        let Some(MeshEntry { extent, mesh }) = mesh.filter(|_| placed.mask != 0) else {
            return (Self::NONE, None);
        };
        if extent.is_empty() {
            return (Self::NONE, None);
        }
        let (matrix, sizes) = (&placed.matrix, sizes(&placed.matrix, extent));
        let reach = mesh.tree().reach;
        let frame = Self {
            inverse: Inverse::new(matrix, extent, reach),
            reach,
            mesh: placed.mesh,
            mask: placed.mask,
            is_tame: is_tame(matrix, extent, &sizes),
        };
        (frame, Some(world_box(matrix, extent.bounds, &sizes)))
    }
}

const _: () = assert!(size_of::<Frame>() == 128);

/// Returns whether f64 lanes can compute the corners without overflow or underflow.
fn is_tame(m: &Matrix, extent: &Extent, sizes: &[f64; 3]) -> bool {
    let mut least = f64::INFINITY;
    for (i, x) in m.iter().enumerate() {
        // The last column is added, not multiplied by a coordinate.
        let by = if i % 4 == 3 { 1.0 } else { extent.least };
        // Test the bits without the sign: if the CPU flushes subnormal numbers to zero, a
        // comparison with 0 would treat them as 0.
        if x.to_bits() << 1 != 0 {
            least = least.min(x.abs() * by);
        }
    }
    least >= SMALLEST && sizes.iter().all(|&size| size <= LARGEST)
}
