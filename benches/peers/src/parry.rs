//! The crate `parry3d`: a triangle mesh with its own hierarchy.

use std::ops::Range;

use intertri::Ray;
use intertri_scene::Mesh;
use parry3d::math::Vector;
use parry3d::shape::{CompositeShapeRef, TriMesh};

use crate::engine::{Answer, Engine, Question, Singles};

pub struct Parry {
    mesh: TriMesh,
    /// With the end of the interval.
    rays: Singles<(parry3d::query::Ray, f32)>,
}

impl Parry {
    pub fn new(mesh: &Mesh) -> Result<Self, String> {
        let points = mesh.positions.iter().map(|&p| Vector::from_array(p)).collect();
        let mesh = TriMesh::new(points, mesh.triangles.clone()).map_err(|e| e.to_string())?;
        Ok(Self { mesh, rays: Singles::default() })
    }
}

impl Engine for Parry {
    fn load(&mut self, rays: &[Ray], question: Question) {
        let vector = Vector::from_array;
        self.rays.load(rays, question, |r| {
            let far = r.t_max.min(f32::MAX);
            (parry3d::query::Ray::new(vector(r.origin), vector(r.dir)), far)
        });
    }

    fn trace(&mut self, part: Range<usize>) {
        let Self { mesh, rays } = self;
        let mesh = &*mesh;
        let cast = |(ray, far): &(_, f32)| CompositeShapeRef(mesh).cast_local_ray(ray, *far, true);
        // For any hit, too, its closest is quickest: only that walk tests boxes in lanes.
        rays.trace(
            part,
            |ray| match cast(ray) {
                Some((triangle, t)) => Answer { triangle, t: t.into() },
                None => Answer::MISS,
            },
            |ray| cast(ray).is_some(),
        );
    }

    fn answers(&self) -> Vec<Answer> {
        self.rays.answers()
    }
}
