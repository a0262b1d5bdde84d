//! Engines that use the triangle meshes of the `parry3d` and `parry3d-f64` crates. Each mesh has
//! its own hierarchy.

use std::ops::Range;

use intertri::{Ray, Ray64};

use crate::engine::{Answer, Engine, Question, Singles};

/// Defines the engine for one of the two crates, whose types differ only in the scalar.
macro_rules! parry {
    ($name:ident, $parry:ident, $scalar:ty, $ray:ty) => {
        pub struct $name {
            mesh: $parry::shape::TriMesh,
            /// Each ray with the end of its interval.
            rays: Singles<($parry::query::Ray, $scalar)>,
        }

        impl $name {
            pub fn new(positions: &[[$scalar; 3]], triangles: &[[u32; 3]]) -> Result<Self, String> {
                let points = positions.iter().map(|&p| $parry::math::Vector::from_array(p));
                let mesh = $parry::shape::TriMesh::new(points.collect(), triangles.to_vec());
                Ok(Self { mesh: mesh.map_err(|e| e.to_string())?, rays: Singles::default() })
            }
        }

        impl Engine<$ray> for $name {
            fn load(&mut self, rays: &[$ray], question: Question) {
                let vector = $parry::math::Vector::from_array;
                self.rays.load(rays, question, |r| {
                    let far = r.t_max.min(<$scalar>::MAX);
                    ($parry::query::Ray::new(vector(r.origin), vector(r.dir)), far)
                });
            }

            fn trace(&mut self, part: Range<usize>) {
                let Self { mesh, rays } = self;
                let mesh = &*mesh;
                let cast = |(ray, far): &(_, $scalar)| {
                    $parry::shape::CompositeShapeRef(mesh).cast_local_ray(ray, *far, true)
                };
                // The closest-hit query is also the fastest query for any-hit rays, because no
                // other traversal tests boxes in SIMD lanes.
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
    };
}

parry!(Parry, parry3d, f32, Ray);
parry!(Parry64, parry3d_f64, f64, Ray64);
