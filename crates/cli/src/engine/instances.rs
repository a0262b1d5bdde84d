//! The `exact` engine for instances, each of which is placed by a matrix and shares the hierarchy
//! of its mesh.

use std::sync::Arc;

use intertri::{Counts, Crossing, Hit, Ray64, Triangle, Triangle64};
use intertri_scene::{InstancedMesh, Mesh};
use intertri_trace::{Bvh, InstanceId, Scene, SceneHit, SceneMesh, SceneSnapshot};

use crate::engine::memory::room;
use crate::engine::tracer::Tracer;
use crate::engine::triangles::triangles;
use crate::error::Result;
use crate::io::progress::Progress;

/// A committed scene with the instances of a model. In its hits, `geometry` is the index of the
/// instance.
pub(crate) struct Instances(SceneSnapshot);

impl Instances {
    /// Builds the hierarchies of all meshes and places the instances.
    pub(crate) fn new(model: &InstancedMesh) -> Result<Self> {
        let bar = Progress::new("build", Some(model.meshes.len() as u64));
        let (mut scene, mut meshes) = (Scene::new(), room(model.meshes.len(), "meshes")?);
        for mesh in &model.meshes {
            meshes.push(shared(mesh)?);
            bar.add(1);
        }
        for instance in &model.instances {
            let mesh = meshes[instance.mesh as usize].clone();
            scene.add(mesh, instance.matrix)?;
        }
        Ok(Self(scene.commit()?))
    }

    /// Converts a hit, storing the instance as its geometry.
    fn hit(SceneHit { hit, instance, .. }: SceneHit) -> Hit {
        let is_hit = hit.is_hit();
        if is_hit { Hit { geometry: InstanceId::index(instance) as u32, ..hit } } else { hit }
    }
}

/// Builds the hierarchy of a mesh. To save memory, the hierarchy is in f32 if f32 can represent all
/// coordinates of the triangles.
fn shared(mesh: &Mesh<f64>) -> Result<SceneMesh> {
    let all = triangles(mesh)?;
    let is_f32 = |Triangle64(corners): &Triangle64| {
        corners.as_flattened().iter().all(|&x| f64::from(x as f32).to_bits() == x.to_bits())
    };
    if !all.iter().all(is_f32) {
        return Ok(Arc::new(Bvh::new(&all)?).into());
    }
    let mut rounded = room(all.len(), "triangles")?;
    rounded.extend(all.iter().map(|t| Triangle(t.0.map(|corner| corner.map(|x| x as f32)))));
    Ok(Arc::new(Bvh::new(&rounded)?).into())
}

impl Tracer for Instances {
    type Scalar = f64;

    fn chunk_size(&self) -> usize {
        4096
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn closest(&self, rays: &[Ray64], hits: &mut [Hit]) -> Counts {
        let found = self.0.closest_batch(rays);
        for (hit, found) in hits.iter_mut().zip(found) {
            *hit = Self::hit(found);
        }
        Counts::default()
    }

    fn any(&self, rays: &[Ray64], hits: &mut [bool]) -> Counts {
        self.0.any_batch_into(rays, hits);
        Counts::default()
    }

    fn all(&self, ray: &Ray64) -> Result<Vec<Hit>> {
        Ok(self.0.all(ray).into_iter().map(Self::hit).collect())
    }

    fn crossings(&self, ray: &Ray64) -> Result<Vec<Crossing>> {
        let crossings = self.0.crossings(ray).into_iter();
        Ok(crossings.map(|hit| Crossing { hit: Self::hit(hit), leaves: hit.leaves }).collect())
    }
}
