//! What is true of a scene, pair by pair: by the scalar f64 reference, or by integers alone.

use std::cmp::Ordering;

use intertri::internal::exact::{self, Rule, Tier};
use intertri::{Ray, Triangle};
use intertri_reference as reference;

use crate::scene::Scene;

/// The answers of a plain loop over a scene.
pub struct Truth {
    plain: Plain,
    /// By ray and triangle, NaN for a miss.
    pub(crate) t: Vec<Vec<f64>>,
}

/// Who answers for one pair.
enum Plain {
    /// The document's tables.
    Reference(reference::Scene),
    /// Integers, which neither a filter nor f64 precedes.
    Exact(Vec<Triangle>),
}

/// The reference's ray.
pub fn reference_ray(ray: &Ray) -> reference::Ray {
    reference::Ray::new(ray.origin, ray.dir)
}

impl Truth {
    /// Asks the reference about every ray and triangle.
    pub fn of(scene: &Scene) -> Self {
        let tables = reference::Scene::from_triangles(scene.triangles.iter().map(|t| t.0))
            .with_threshold(scene.threshold);
        Self::by(Plain::Reference(tables), scene)
    }

    /// Asks integers.
    pub fn exact(scene: &Scene) -> Self {
        Self::by(Plain::Exact(scene.triangles.clone()), scene)
    }

    fn by(plain: Plain, scene: &Scene) -> Self {
        let t = |ray| {
            let hit = |obj| plain.hit(obj, ray).unwrap_or(f64::NAN);
            (0..scene.triangles.len()).map(hit).collect()
        };
        let t = scene.rays.iter().map(t).collect();
        Self { plain, t }
    }

    /// How many hits there are among all pairs.
    pub fn hits(&self) -> usize {
        self.t.iter().flatten().filter(|t| !t.is_nan()).count()
    }

    /// The number and t of every hit of ray i, in the order of the numbers.
    pub fn all(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        self.t[i].iter().copied().enumerate().filter(|(_, t)| !t.is_nan())
    }

    /// The number and bits of t of every hit of a ray, which is that of number i: in order of t, exact or
    /// not, then of the numbers.
    pub fn all_sorted(&self, i: usize, ray: &Ray) -> Vec<(usize, u64)> {
        let mut all: Vec<_> = self.all(i).collect();
        all.sort_by(|a, b| match &self.plain {
            Plain::Reference(_) => a.1.total_cmp(&b.1),
            Plain::Exact(of) => exact::order_from(Tier::Narrow, ray, &of[a.0], &of[b.0]),
        });
        all.into_iter().map(|(obj, t)| (obj, t.to_bits())).collect()
    }

    /// The closest hit of a ray, by a plain loop.
    pub fn closest(&self, ray: &Ray) -> Option<(usize, f64)> {
        match &self.plain {
            Plain::Reference(scene) => {
                scene.closest(&reference_ray(ray), ray.t_min.into(), ray.t_max.into())
            }
            Plain::Exact(triangles) => {
                let hits = (0..triangles.len()).filter(|&obj| self.plain.hit(obj, ray).is_some());
                let first = hits.reduce(|best, obj| {
                    let (new, old) = (&triangles[obj], &triangles[best]);
                    match exact::order_from(Tier::Narrow, ray, new, old) {
                        Ordering::Less => obj,
                        _ => best,
                    }
                })?;
                Some((first, exact::t_from(Tier::Narrow, ray, &triangles[first])))
            }
        }
    }

    /// The weights of the second and the third corner where a ray meets a triangle.
    pub fn weights(&self, obj: usize, ray: &Ray) -> (f64, f64) {
        match &self.plain {
            Plain::Reference(scene) => scene.barycentric(obj, &reference_ray(ray)),
            Plain::Exact(triangles) => {
                let (_, u, v) = exact::attributes_from(Tier::Narrow, ray, &triangles[obj]);
                (u, v)
            }
        }
    }
}

impl Plain {
    /// t, if the ray hits the triangle within its interval.
    fn hit(&self, obj: usize, ray: &Ray) -> Option<f64> {
        match self {
            Self::Reference(scene) => {
                scene.hit(obj, &reference_ray(ray), ray.t_min.into(), ray.t_max.into())
            }
            Self::Exact(triangles) => {
                let triangle = &triangles[obj];
                exact::crossing_from(Tier::Narrow, Rule::Closed, ray, triangle)
                    .map(|_| exact::t_from(Tier::Narrow, ray, triangle))
            }
        }
    }
}
