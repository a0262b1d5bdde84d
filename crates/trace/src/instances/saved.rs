//! Saves and loads scenes.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use std::sync::Arc;

use super::committed::{MeshEntry, NO_MESH, Placed};
use super::mesh::SceneMesh;
use super::scene::Scene;
use crate::bvh::Bvh;
use crate::save::{
    Bytes, Input, InstanceRecord, SavedMesh, SceneFront, SceneLoadError, SceneReader, Slice,
    Stream, write_scene,
};
use crate::util::memory::{NoMemory, room};

impl SavedMesh for SceneMesh {
    fn is_f64(&self) -> bool {
        matches!(self, Self::F64(_))
    }

    fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::F32(mesh) => mesh.write_to(output),
            Self::F64(mesh) => mesh.write_to(output),
        }
    }
}

/// Saving and loading. A loaded scene has the same instances, with the same numbers, placements,
/// and masks, and the same meshes, with their geometries and masks. Instances that shared a mesh
/// still share it. Once committed, the scene therefore returns the same results.
impl Scene {
    /// Serializes the scene for [`Scene::from_bytes`]. The bytes are the same on every CPU and with
    /// any number of threads.
    ///
    /// Each mesh is stored once, as by [`Bvh::to_bytes`]. Each instance takes another 104 bytes.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use intertri_trace::{Bvh, Scene};
    /// use intertri_trace::intertri::{Ray64, Triangle};
    /// let tree = Arc::new(Bvh::new(&[Triangle::new([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0])])?);
    /// let at = |z| [1.0, 0.0, 0.0, 0.0, /**/ 0.0, 1.0, 0.0, 0.0, /**/ 0.0, 0.0, 1.0, z];
    /// let mut scene = Scene::new();
    /// scene.add(tree.clone(), at(9.0))?;
    /// let near = scene.add(tree, at(5.0))?;
    ///
    /// let saved = scene.to_bytes();
    /// let loaded = Scene::from_bytes(&saved)?;
    /// let ray = Ray64::new([0.0, 0.5, 0.0], [0.0, 0.0, 1.0]);
    /// assert_eq!(loaded.commit()?.closest(&ray).unwrap().instance, near);
    /// assert!(Scene::from_bytes(&saved[..99]).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Panics if memory runs out; [`Scene::write_to`] returns an error instead.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.try_to_bytes().expect("not enough memory to save the scene")
    }

    /// Like [`Scene::to_bytes`], but returns an error if memory runs out.
    #[doc(hidden)]
    pub fn try_to_bytes(&self) -> io::Result<Vec<u8>> {
        let mut bytes = Bytes(Vec::new());
        self.write_to(&mut bytes)?;
        Ok(bytes.0)
    }

    /// Writes the bytes of [`Scene::to_bytes`] piece by piece.
    ///
    /// # Errors
    /// Returns an error if writing fails or memory runs out.
    pub fn write_to(&self, mut output: impl Write) -> io::Result<()> {
        let no_memory = |NoMemory| io::Error::from(io::ErrorKind::OutOfMemory);
        // Renumber the meshes to close the gaps that dropped meshes left.
        let mut numbers = room(self.meshes.len()).map_err(no_memory)?;
        let mut meshes: Vec<&dyn SavedMesh> = room(self.meshes.len()).map_err(no_memory)?;
        for entry in &self.meshes {
            numbers.push(meshes.len() as u32);
            meshes.extend(entry.iter().map(|entry| &entry.mesh as &dyn SavedMesh));
        }
        let instance = |i: usize| {
            let Placed { matrix, mesh, mask } = self.placed[i];
            if mesh == NO_MESH {
                return InstanceRecord { matrix: [0.0; 12], mesh: None, mask: 0 };
            }
            InstanceRecord { matrix, mesh: Some(numbers[mesh as usize]), mask }
        };
        write_scene((self.placed.len(), &instance), &self.free, &meshes, &mut output)
    }

    /// Loads a saved scene.
    ///
    /// Any input yields either an error or a sound scene, as with [`Bvh::from_bytes`]. An attacker
    /// can change the scene's contents, but cannot make a query miss a triangle that the scene
    /// contains.
    ///
    /// # Errors
    /// Returns an error if the bytes are not a saved scene; are damaged, truncated, or followed by
    /// more bytes; were written by a later version; or need more memory than is available.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SceneLoadError> {
        let mut input = Slice::new(bytes);
        let scene = Self::read(&mut input)?;
        input.end()?;
        Ok(scene)
    }

    /// Like [`Scene::from_bytes`], but reads from a stream. Bytes after the scene are not read.
    /// Memory use grows with the bytes that arrive, whatever the header claims. The function
    /// already reads in large pieces, so a buffered reader does not help.
    ///
    /// # Errors
    /// Returns the same errors as [`Scene::from_bytes`], and an error if the stream cannot be read.
    pub fn read_from(input: impl Read) -> Result<Self, SceneLoadError> {
        Self::read(&mut Stream::new(input, 0))
    }

    /// Like [`Scene::from_bytes`], but reads from a file.
    ///
    /// # Errors
    /// Returns the same errors as [`Scene::from_bytes`], and an error if the file cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneLoadError> {
        let file = File::open(path)?;
        let metadata = file.metadata()?;
        #[cfg(unix)]
        if metadata.is_file() {
            let mut input = crate::save::Pieces::new(file, metadata.len());
            let scene = Self::read(&mut input)?;
            input.end()?;
            return Ok(scene);
        }
        let size = usize::try_from(metadata.len()).unwrap_or(usize::MAX);
        let mut input = Stream::new(file, size);
        let scene = Self::read(&mut input)?;
        input.end()?;
        Ok(scene)
    }

    fn read(input: &mut dyn Input) -> Result<Self, SceneLoadError> {
        let (mut reader, front) = SceneReader::new(input)?;
        let SceneFront { instances, free, meshes: scalars } = front;
        let (mut meshes, mut numbers) = (Vec::new(), HashMap::new());
        for (index, is_f64) in scalars.into_iter().enumerate() {
            let mesh: SceneMesh = if is_f64 {
                Arc::new(reader.mesh(index, Bvh::<f64>::read)?).into()
            } else {
                Arc::new(reader.mesh(index, Bvh::<f32>::read)?).into()
            };
            numbers.insert(mesh.address(), index as u32);
            let extent = mesh.extent();
            meshes.push(Some(MeshEntry { mesh, extent }));
        }
        reader.end()?;

        let (mut placed, mut uses) = (room(instances.len())?, vec![0; meshes.len()]);
        for InstanceRecord { matrix, mesh, mask } in instances {
            if let Some(mesh) = mesh {
                uses[mesh as usize] += 1;
            }
            placed.push(Placed { matrix, mesh: mesh.unwrap_or(NO_MESH), mask });
        }
        Ok(Self { placed: Arc::new(placed), free, meshes, uses, numbers })
    }
}
