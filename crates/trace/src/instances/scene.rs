//! The editable scene: add, remove, move, and hide instances, then commit.

use std::collections::HashMap;
use std::sync::Arc;

use super::committed::{Committed, MeshEntry, NO_MESH, Placed};
use super::error::SceneError;
use super::hit::InstanceId;
use super::mesh::SceneMesh;
use super::snapshot::SceneSnapshot;
use crate::tree::LEAF;

/// A set of mesh instances, each placed by its own matrix. Instances can move between queries.
///
/// A matrix has three rows of four numbers, stored row by row. It places a corner (x, y, z) of the
/// mesh at `((m0 x + m1 y) + m2 z) + m3` along the first axis, and so on, with each operation
/// rounded in f64. Queries return exactly what a `Bvh<f64>` over these corners would return, bit
/// for bit. Any finite matrix is allowed. It may scale, shear, mirror, or even flatten a mesh.
///
/// Changes take effect when you commit the scene. A [`SceneSnapshot`] never changes, so other
/// threads can query it while you edit the scene.
///
/// ```
/// use std::sync::Arc;
/// use intertri_trace::{Bvh, Scene};
/// use intertri_trace::intertri::{Ray64, Triangle};
///
/// let tree = Arc::new(Bvh::new(&[Triangle::new([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0])])?);
/// let at = |z| [1.0, 0.0, 0.0, 0.0, /**/ 0.0, 1.0, 0.0, 0.0, /**/ 0.0, 0.0, 1.0, z];
/// let mut scene = Scene::new();
/// let near = scene.add(tree.clone(), at(5.0))?;
/// let far = scene.add(tree, at(9.0))?;
/// let before = scene.commit()?;
///
/// let ray = Ray64::new([0.0, 0.5, 0.0], [0.0, 0.0, 1.0]);
/// let hit = before.closest(&ray).unwrap();
/// assert_eq!((hit.instance, hit.hit.triangle, hit.hit.t), (near, 0, 5.0));
///
/// scene.place(near, at(20.0))?;
/// let after = scene.commit()?;
/// assert_eq!(after.closest(&ray).unwrap().instance, far);
/// assert_eq!(before.closest(&ray).unwrap().instance, near);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The instances as placed, indexed by instance number. Removed instances have no mesh. The
    /// list is shared with the last snapshot until the scene changes.
    pub(super) placed: Arc<Vec<Placed>>,
    /// The instance numbers available for reuse.
    pub(super) free: Vec<u32>,
    /// The meshes, indexed by mesh number. Meshes without instances are dropped.
    pub(super) meshes: Vec<Option<MeshEntry>>,
    /// The number of instances of each mesh.
    pub(super) uses: Vec<usize>,
    /// Maps a mesh's address to its number.
    pub(super) numbers: HashMap<usize, u32>,
}

impl Scene {
    /// Creates an empty scene.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an instance of a mesh, which is an `Arc<Bvh<f32>>` or `Arc<Bvh<f64>>`.
    ///
    /// # Errors
    /// Returns an error if a matrix entry is NaN or infinite, or if memory runs out.
    pub fn add(
        &mut self,
        mesh: impl Into<SceneMesh>,
        matrix: [f64; 12],
    ) -> Result<InstanceId, SceneError> {
        check(&matrix)?;
        let mesh = self.number_of(mesh.into());
        let placed = Placed { matrix, mesh, mask: u32::MAX };
        let all = Arc::make_mut(&mut self.placed);
        let id = if let Some(id) = self.free.pop() {
            all[id as usize] = placed;
            id
        } else {
            let id = all.len() as u32;
            if id >= LEAF {
                return Err(SceneError::TooManyInstances);
            }
            all.try_reserve(1).map_err(|_| SceneError::OutOfMemory)?;
            all.push(placed);
            id
        };
        self.uses[mesh as usize] += 1;
        Ok(InstanceId(id))
    }

    /// Removes an instance. Its number may be reused for an instance added later.
    ///
    /// # Errors
    /// Returns an error if the instance does not exist.
    pub fn remove(&mut self, id: InstanceId) -> Result<(), SceneError> {
        // Keep the slot, so that other instances keep their numbers.
        let mesh = std::mem::replace(&mut self.instance(id)?.mesh, NO_MESH) as usize;
        self.free.push(id.0);
        self.uses[mesh] -= 1;
        // Drop a mesh along with its last instance.
        if self.uses[mesh] == 0
            && let Some(entry) = self.meshes[mesh].take()
        {
            self.numbers.remove(&entry.mesh.address());
        }
        Ok(())
    }

    /// Moves an instance by replacing its matrix.
    ///
    /// # Errors
    /// Returns an error if the instance does not exist, or if a matrix entry is NaN or infinite.
    pub fn place(&mut self, id: InstanceId, matrix: [f64; 12]) -> Result<(), SceneError> {
        check(&matrix)?;
        self.instance(id)?.matrix = matrix;
        Ok(())
    }

    /// Shows or hides an instance by setting its mask to `u32::MAX` or 0.
    ///
    /// # Errors
    /// Returns an error if the instance does not exist.
    pub fn show(&mut self, id: InstanceId, is_visible: bool) -> Result<(), SceneError> {
        self.set_mask(id, if is_visible { u32::MAX } else { 0 })
    }

    /// Sets the mask of an instance, initially `u32::MAX`. A query considers the instance only if
    /// the query's mask ([`SceneSnapshot::mask`]) shares a bit with the instance's mask.
    ///
    /// # Errors
    /// Returns an error if the instance does not exist.
    pub fn set_mask(&mut self, id: InstanceId, mask: u32) -> Result<(), SceneError> {
        self.instance(id)?.mask = mask;
        Ok(())
    }

    /// Returns the number of instances, including hidden ones.
    pub fn len(&self) -> usize {
        self.placed.len() - self.free.len()
    }

    /// Returns whether the scene has no instances.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns whether the scene contains an instance.
    pub fn contains(&self, id: InstanceId) -> bool {
        self.placed.get(id.index()).is_some_and(|placed| placed.mesh != NO_MESH)
    }

    /// Returns an iterator over all instances, including hidden ones, in ascending order.
    pub fn instances(&self) -> impl Iterator<Item = InstanceId> + '_ {
        let ids = (0..self.placed.len() as u32).map(InstanceId);
        ids.filter(|&id| self.contains(id))
    }

    /// Returns the mesh of an instance, or `None` if the instance does not exist.
    pub fn mesh(&self, id: InstanceId) -> Option<&SceneMesh> {
        let mesh = self.placed.get(id.index())?.mesh;
        self.meshes.get(mesh as usize)?.as_ref().map(|entry| &entry.mesh)
    }

    /// Returns the matrix of an instance, or `None` if the instance does not exist.
    pub fn matrix(&self, id: InstanceId) -> Option<[f64; 12]> {
        self.contains(id).then(|| self.placed[id.index()].matrix)
    }

    /// Returns the mask of an instance, or `None` if the instance does not exist.
    pub fn mask(&self, id: InstanceId) -> Option<u32> {
        self.contains(id).then(|| self.placed[id.index()].mask)
    }

    /// Commits the current scene for queries. This rebuilds the tree of instances, using all
    /// threads.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    pub fn commit(&self) -> Result<SceneSnapshot, SceneError> {
        let committed = Committed::new(self.placed.clone(), self.meshes.clone())?;
        Ok(SceneSnapshot::new(committed))
    }

    /// Returns an instance for editing, or an error if it does not exist.
    fn instance(&mut self, id: InstanceId) -> Result<&mut Placed, SceneError> {
        if self.contains(id) {
            Ok(&mut Arc::make_mut(&mut self.placed)[id.index()])
        } else {
            Err(SceneError::NoInstance(id))
        }
    }

    /// Returns the number of a mesh, assigning one on first use.
    fn number_of(&mut self, mesh: SceneMesh) -> u32 {
        let Self { meshes, uses, numbers, .. } = self;
        *numbers.entry(mesh.address()).or_insert_with(|| {
            let extent = mesh.extent();
            let entry = Some(MeshEntry { mesh, extent });
            if let Some(free) = meshes.iter().position(Option::is_none) {
                meshes[free] = entry;
                free as u32
            } else {
                meshes.push(entry);
                uses.push(0);
                (meshes.len() - 1) as u32
            }
        })
    }
}

/// Returns an error if a matrix entry is not finite.
fn check(matrix: &[f64; 12]) -> Result<(), SceneError> {
    match matrix.iter().position(|x| !x.is_finite()) {
        Some(at) => Err(SceneError::NotFinite { row: at / 4, column: at % 4 }),
        None => Ok(()),
    }
}
