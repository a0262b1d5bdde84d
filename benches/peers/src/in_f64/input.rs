//! An f64 scene, and the engines that trace it.

use std::sync::Arc;

use intertri::{Mode, Ray, Ray64, RayOf, Triangle64, TriangleOf};
use intertri_scene::Mesh;
use intertri_trace::{Bvh, BvhScalar, MeshTriangle};

use super::own::Own;
use crate::bvh::TwoWay;
use crate::embree::{Api, Build, Embree, Scene};
use crate::engine::{Answer, Engine, Question};
use crate::measure::Named;
use crate::ours::{Batch, Single, Triangles};
use crate::parry::Parry64;

/// A scene in f64.
pub struct Input {
    mesh: Mesh,
    /// The offset from the original position of the mesh.
    by: [f64; 3],
    bvh: Arc<Bvh<f64>>,
    triangles: Vec<Triangle64>,
    embree: Option<Arc<Scene>>,
}

impl Input {
    /// Moves the mesh by an offset, and rounds it to f32 for Embree. If `far` is positive, adds one
    /// triangle about as large as the mesh, `far` times the size of the mesh away along each axis.
    pub fn new(
        mesh: &Mesh,
        by: [f64; 3],
        far: f64,
        api: Option<&Arc<Api>>,
    ) -> Result<Self, String> {
        let at = |p: [f32; 3]| moved(p.map(f64::from), by);
        let corners =
            |&[a, b, c]: &[u32; 3]| TriangleOf([a, b, c].map(|i| at(mesh.positions[i as usize])));
        let mut triangles: Vec<Triangle64> = mesh.triangles.iter().map(corners).collect();
        if let Some(bounds) = mesh.bounds().filter(|_| far > 0.0) {
            let size = (0..3).map(|k| f64::from(bounds.max[k] - bounds.min[k])).fold(0.0, f64::max);
            let corner = |k: usize| {
                let mut p = bounds.max.map(|x| f64::from(x) + far * size);
                p[k] += size;
                p
            };
            triangles.push(TriangleOf([corner(0), corner(1), corner(2)]));
        }
        let bvh = Arc::new(Bvh::<f64>::new(&triangles).map_err(|e| e.to_string())?);
        let embree = api.map(|api| {
            let positions = mesh.positions.iter().map(|&p| at(p).map(|x| x as f32)).collect();
            let rounded = Mesh { positions, ..mesh.clone() };
            let build =
                Build { robust: false, high: false, avx2: false, threads: 0, collect: false };
            Scene::new(api, &rounded, build).map(|scene| {
                scene.commit();
                Arc::new(scene)
            })
        });
        let embree = embree.transpose()?;
        Ok(Self { mesh: mesh.clone(), by, bvh, triangles, embree })
    }

    pub fn triangles(&self) -> &[Triangle64] {
        &self.triangles
    }

    /// Returns a ray moved by the same offset as the scene.
    pub fn ray(&self, ray: &Ray64) -> Ray64 {
        Ray64 { origin: moved(ray.origin, self.by), ..*ray }
    }

    /// Returns the number of triangle tests per ray, and the number that the resolver settles.
    pub fn counts(&self, rays: &[Ray64], question: Question) -> [f64; 2] {
        counts(&self.bvh, rays, question)
    }

    /// Returns the true answers, tracing one ray per call.
    pub fn truth(&self, rays: &[Ray64], question: Question) -> Vec<Answer> {
        let mut single = Single::new(self.bvh.clone(), Mode::exact());
        single.load(rays, question);
        single.trace(0..rays.len());
        Engine::<Ray64>::answers(&single)
    }

    /// Returns our engines for this input. Their names begin with `name`.
    pub fn ours(&self, name: &str, rays: &Arc<[Ray64]>) -> Vec<Named> {
        let (bvh, mode) = (&self.bvh, Mode::exact());
        let engine =
            |form: &str, engine: Box<dyn Engine>| -> Named { (format!("{name}{form}"), engine) };
        vec![
            engine("", Box::new(Own::new(Batch::new(bvh.clone(), mode), rays))),
            engine("-triangles", Box::new(Own::new(Triangles::new(bvh.clone(), mode), rays))),
            engine("-single", Box::new(Own::new(Single::new(bvh.clone(), mode), rays))),
        ]
    }

    /// Returns the other tracers whose names are wanted: f64 tracers, and Embree on the input
    /// rounded to f32.
    pub fn others(
        &self,
        name: &str,
        rays: &Arc<[Ray64]>,
        wanted: &dyn Fn(&str) -> bool,
    ) -> Result<Vec<Named>, String> {
        let [parry, bvh, embree] =
            ["parry", "bvh", "embree"].map(|engine| format!("{engine}-{name}"));
        let mut all: Vec<Named> = Vec::new();
        if wanted(&parry) {
            let positions: Vec<_> =
                self.mesh.positions.iter().map(|&p| moved(p.map(f64::from), self.by)).collect();
            let engine = Parry64::new(&positions, &self.mesh.triangles)?;
            all.push((parry, Box::new(Own::new(engine, rays))));
        }
        if wanted(&bvh) {
            all.push((bvh, Box::new(Own::new(TwoWay::new(&self.triangles), rays))));
        }
        if let Some(scene) = self.embree.as_ref().filter(|_| wanted(&embree)) {
            let rounded: Arc<[Ray]> = rays.iter().map(crate::rays::rounded).collect();
            let engine = Own::new(Embree::<16>::new(scene.clone()), &rounded);
            all.push((embree, Box::new(engine)));
        }
        Ok(all)
    }
}

/// Returns the number of triangle tests per ray, and the number that the resolver settles.
pub fn counts<S: BvhScalar>(bvh: &Bvh<S>, rays: &[RayOf<S>], question: Question) -> [f64; 2] {
    let query = bvh.query();
    let counts = if question.any {
        query.any_batch_into(rays, &mut vec![false; rays.len()])
    } else {
        query.closest_triangle_batch_into(rays, &mut vec![MeshTriangle::MISS; rays.len()])
    };
    [counts.tests, counts.undecided].map(|count| count as f64 / rays.len() as f64)
}

fn moved(p: [f64; 3], by: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| p[k] + by[k])
}
