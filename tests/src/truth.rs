//! Computes the expected results for a scene, pair by pair, using either the scalar f64 reference
//! or only integer arithmetic.

use intertri::internal::exact::{self, Tier};
use intertri::{Ray, Rule, Triangle};
use intertri_reference as reference;

use crate::scene::Scene;

/// The expected results for all rays and triangles of a scene, computed by a plain loop.
pub(crate) struct Truth {
    plain: Plain,
    /// The value of t for each ray and triangle, or NaN for a miss.
    pub(crate) t: Vec<Vec<f64>>,
    /// The results for each ray, computed once and compared with the results of every query.
    pub(crate) answers: Vec<Answers>,
}

/// The expected results for one ray and all triangles of a scene.
pub(crate) struct Answers {
    /// The triangle and t of the closest hit.
    pub(crate) closest: Option<(usize, f64)>,
    /// The weights of the second and third corners at the closest hit.
    pub(crate) weights: Option<(f64, f64)>,
    /// Every hit, as the triangle's index and the bits of t, sorted by t (by exact t in the exact
    /// modes) and then by index.
    pub(crate) all: Vec<(usize, u64)>,
}

/// The method that computes the expected result for a ray and a triangle.
enum Plain {
    /// The scalar f64 reference implementation of document A.
    Reference(reference::Scene),
    /// Integer arithmetic under the given rule, without a filter or any f64 arithmetic.
    Exact(Rule, Vec<Triangle>),
}

/// Converts a ray to the reference's type.
pub fn reference_ray(ray: &Ray) -> reference::Ray {
    reference::Ray::new(ray.origin, ray.dir)
}

impl Truth {
    /// Computes the expected results with the reference, for every ray and triangle.
    pub(crate) fn of(scene: &Scene) -> Self {
        let tables = reference::Scene::from_triangles(scene.triangles.iter().map(|t| t.0))
            .with_threshold(scene.threshold);
        Self::by(Plain::Reference(tables), scene)
    }

    /// Computes the expected results with integers, under the closed rule.
    pub(crate) fn exact(scene: &Scene) -> Self {
        Self::by(Plain::Exact(Rule::Closed, scene.triangles.clone()), scene)
    }

    /// Computes the expected results with integers, under the once rule, which assigns each point
    /// on a shared edge or corner to one triangle.
    pub(crate) fn once(scene: &Scene) -> Self {
        Self::by(Plain::Exact(Rule::Once, scene.triangles.clone()), scene)
    }

    fn by(plain: Plain, scene: &Scene) -> Self {
        let t = |ray| {
            let hit = |obj| plain.hit(obj, ray).unwrap_or(f64::NAN);
            (0..scene.triangles.len()).map(hit).collect()
        };
        let t: Vec<Vec<f64>> = scene.rays.iter().map(t).collect();
        let answers = scene.rays.iter().zip(&t).map(|(ray, t)| plain.answers(ray, t)).collect();
        Self { plain, t, answers }
    }

    /// Returns the number of pairs that hit.
    pub(crate) fn hits(&self) -> usize {
        self.t.iter().flatten().filter(|t| !t.is_nan()).count()
    }

    /// Returns the closest hit of a ray, found by a plain loop.
    pub(crate) fn closest(&self, ray: &Ray) -> Option<(usize, f64)> {
        self.plain.closest(ray, |obj| self.plain.hit(obj, ray).is_some())
    }
}

impl Plain {
    /// Returns t if the ray hits the triangle within the ray's interval.
    fn hit(&self, obj: usize, ray: &Ray) -> Option<f64> {
        match self {
            Self::Reference(scene) => {
                scene.hit(obj, &reference_ray(ray), ray.t_min.into(), ray.t_max.into())
            }
            Self::Exact(rule, triangles) => {
                let triangle = &triangles[obj];
                exact::crossing_from(Tier::Narrow, *rule, ray, triangle)
                    .map(|_| exact::t_from(Tier::Narrow, ray, triangle))
            }
        }
    }

    /// Returns all results for a ray, given its t for every triangle.
    fn answers(&self, ray: &Ray, t: &[f64]) -> Answers {
        let closest = self.closest(ray, |obj| !t[obj].is_nan());
        let weights = closest.map(|(obj, _)| self.weights(obj, ray));
        Answers { closest, weights, all: self.all(ray, t) }
    }

    /// Returns the closest hit. If several hits have the same t, the lowest index wins.
    fn closest(&self, ray: &Ray, is_hit: impl Fn(usize) -> bool) -> Option<(usize, f64)> {
        match self {
            Self::Reference(scene) => {
                scene.closest(&reference_ray(ray), ray.t_min.into(), ray.t_max.into())
            }
            Self::Exact(_, of) => {
                let order = |new, old| exact::order_from(Tier::Narrow, ray, &of[new], &of[old]);
                let nearer = |best, new| if order(new, best).is_lt() { new } else { best };
                let first = (0..of.len()).filter(|&obj| is_hit(obj)).reduce(nearer)?;
                Some((first, exact::t_from(Tier::Narrow, ray, &of[first])))
            }
        }
    }

    /// Returns every hit, sorted by t.
    fn all(&self, ray: &Ray, t: &[f64]) -> Vec<(usize, u64)> {
        let mut all: Vec<_> = (0..t.len()).filter(|&obj| !t[obj].is_nan()).collect();
        all.sort_by(|&a, &b| match self {
            Self::Reference(_) => t[a].total_cmp(&t[b]),
            // Correct rounding keeps the order, so only equal t need the exact numbers.
            Self::Exact(_, of) => t[a]
                .total_cmp(&t[b])
                .then_with(|| exact::order_from(Tier::Narrow, ray, &of[a], &of[b])),
        });
        all.into_iter().map(|obj| (obj, t[obj].to_bits())).collect()
    }

    /// Returns the weights of the second and third corners at the point where a ray meets a
    /// triangle.
    fn weights(&self, obj: usize, ray: &Ray) -> (f64, f64) {
        match self {
            Self::Reference(scene) => scene.barycentric(obj, &reference_ray(ray)),
            Self::Exact(_, triangles) => {
                let (_, u, v) = exact::attributes_from(Tier::Narrow, ray, &triangles[obj]);
                (u, v)
            }
        }
    }
}
