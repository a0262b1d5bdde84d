//! An engine that uses Embree's instances: each mesh has its own scene, and matrices place these
//! scenes in a common scene.

use std::ops::Range;
use std::sync::Arc;

use intertri::Ray;
use intertri_scene::Mesh;

use super::{Api, Build, Embree, MEDIUM, Ptr, RayHit, Scene};
use crate::engine::{Answer, Engine, Question};

/// `RTC_GEOMETRY_TYPE_INSTANCE`.
const INSTANCE: i32 = 121;
/// `RTC_FORMAT_FLOAT3X4_ROW_MAJOR`.
const ROWS_OF_FOUR: i32 = 0x9134;

impl Scene {
    /// Returns a scene of instances, each given by a mesh index and a matrix.
    pub fn of_instances(
        api: &Arc<Api>,
        meshes: &[Mesh],
        placed: &[(usize, [f64; 12])],
        build: Build,
    ) -> Result<Self, String> {
        let whole = Self::empty(api, build)?;
        // SAFETY: the calls are in the order that Embree's manual prescribes. Each geometry keeps
        // its instanced scene alive.
        unsafe {
            let scenes: Vec<Ptr> = meshes.iter().map(|mesh| whole.part(mesh)).collect();
            for &(mesh, matrix) in placed {
                let geometry = (api.new_geometry)(whole.device, INSTANCE);
                (api.instanced_scene)(geometry, scenes[mesh]);
                let rounded = matrix.map(|x| x as f32);
                (api.transform)(geometry, 0, ROWS_OF_FOUR, rounded.as_ptr());
                (api.commit_geometry)(geometry);
                (api.attach_geometry)(whole.scene, geometry);
                (api.release_geometry)(geometry);
            }
            scenes.into_iter().for_each(|scene| (api.release_scene)(scene));
        }
        whole.commit();
        whole.checked("the instances")
    }

    /// Returns a committed scene that contains one mesh, on the same device.
    unsafe fn part(&self, mesh: &Mesh) -> Ptr {
        let Self { api, device, version, .. } = self;
        // SAFETY: the calls are in the order that Embree's manual prescribes. The device outlives
        // the scene, which is not dropped here.
        unsafe {
            let scene = (api.new_scene)(*device);
            (api.scene_quality)(scene, MEDIUM);
            let part = Self { api: api.clone(), device: *device, scene, version: *version };
            part.add(mesh, false);
            part.commit();
            std::mem::forget(part);
            scene
        }
    }

    /// Moves all instances, and commits the scene.
    pub fn place(&self, matrices: &[[f64; 12]]) {
        for (number, matrix) in (0..).zip(matrices) {
            // SAFETY: the geometry is an instance, and nothing queries the scene meanwhile.
            unsafe {
                let geometry = (self.api.get_geometry)(self.scene, number);
                let rounded = matrix.map(|x| x as f32);
                (self.api.transform)(geometry, 0, ROWS_OF_FOUR, rounded.as_ptr());
                (self.api.commit_geometry)(geometry);
            }
        }
        self.commit();
    }
}

/// A scene of instances, queried with N rays per call: 1, 8 or 16.
pub struct Instances<const N: usize> {
    embree: Embree<N>,
    instances: Vec<[u32; N]>,
    /// The index of each instance's first triangle.
    firsts: Arc<[u32]>,
}

impl<const N: usize> Instances<N> {
    pub fn new(scene: Arc<Scene>, firsts: Arc<[u32]>) -> Self {
        Self { embree: Embree::new(scene), instances: vec![], firsts }
    }
}

impl<const N: usize> Engine for Instances<N> {
    fn load(&mut self, rays: &[Ray], question: Question) {
        self.embree.load(rays, question);
        self.instances = vec![[0; N]; self.embree.groups.len()];
    }

    fn trace(&mut self, part: Range<usize>) {
        let keep = |instances: &mut _, hit: &RayHit<N>| *instances = hit.instance[0];
        self.embree.trace_keeping(part, &mut self.instances, keep);
    }

    fn answers(&self) -> Vec<Answer> {
        let mut answers = self.embree.answers();
        if !self.embree.question.any {
            for (answer, instance) in answers.iter_mut().zip(self.instances.as_flattened()) {
                if answer.is_hit() {
                    answer.triangle += self.firsts[*instance as usize];
                }
            }
        }
        answers
    }
}
