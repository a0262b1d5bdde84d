//! The `oracle` engine: finds exact answers by testing all triangles one by one. It is slow, and
//! serves only to check the other engines.
//!
//! The lab crate's predicates and rational arithmetic decide whether a ray hits a triangle.
//! Rational arithmetic also orders the hits by t and decides which of them lie within the ray's
//! interval. Only the values of t, u and v, each rounded once, come from the kernel's integers.

use std::cmp::Ordering;

use intertri::internal::exact::{Tier, attributes_from};
use intertri::{Hit, RayOf, Scalar, TriangleOf};
use intertri_lab::oracle::{Rational, answer, exact_t};
use rayon::prelude::*;

/// Finds the closest hit of each ray. If two hits have the same t, the lower triangle index wins.
pub(crate) fn closest_batch<S: Scalar>(
    triangles: &[TriangleOf<S>],
    rays: &[RayOf<S>],
    hits: &mut [Hit],
) {
    rays.par_iter().zip(hits).for_each(|(ray, hit)| *hit = closest(triangles, ray));
}

/// Finds whether each ray hits anything.
pub(crate) fn any_batch<S: Scalar>(
    triangles: &[TriangleOf<S>],
    rays: &[RayOf<S>],
    hits: &mut [bool],
) {
    rays.par_iter().zip(hits).for_each(|(ray, hit)| *hit = any(triangles, ray));
}

/// Returns the closest hit of a ray.
pub(crate) fn closest<S: Scalar>(triangles: &[TriangleOf<S>], ray: &RayOf<S>) -> Hit {
    // `min_by` returns the first of several minima.
    let closest = met(triangles, ray).min_by(|(_, a), (_, b)| a.cmp(b));
    closest.map_or(Hit::MISS, |(index, _)| hit(triangles, ray, index))
}

/// Returns whether a ray hits anything.
pub(crate) fn any<S: Scalar>(triangles: &[TriangleOf<S>], ray: &RayOf<S>) -> bool {
    met(triangles, ray).next().is_some()
}

/// Returns every hit of a ray, ordered by t, then by triangle.
pub(crate) fn all<S: Scalar>(triangles: &[TriangleOf<S>], ray: &RayOf<S>) -> Vec<Hit> {
    let mut all: Vec<_> = met(triangles, ray).collect();
    all.sort_by(|(_, a), (_, b)| a.cmp(b));
    all.into_iter().map(|(index, _)| hit(triangles, ray, index)).collect()
}

/// Returns the triangles that a ray hits under the closed rule, each with its exact t.
fn met<S: Scalar>(
    triangles: &[TriangleOf<S>],
    ray: &RayOf<S>,
) -> impl Iterator<Item = (usize, Rational)> {
    let within = |t: &Rational| {
        compare(t, ray.t_min.into()).is_some_and(Ordering::is_ge)
            && compare(t, ray.t_max.into()).is_some_and(Ordering::is_lt)
    };
    let hits = triangles.iter().enumerate().filter(|(_, triangle)| answer(triangle, ray).is_hit());
    hits.filter_map(move |(index, triangle)| {
        exact_t(triangle, ray).filter(within).map(|t| (index, t))
    })
}

/// Compares t with an end of an interval. Returns `None` if the end is NaN.
fn compare(t: &Rational, end: f64) -> Option<Ordering> {
    match Rational::try_from(end) {
        Ok(end) => Some(t.cmp(&end)),
        // An infinity compares the same way with every finite number.
        Err(_) => 0.0.partial_cmp(&end),
    }
}

/// Returns the hit on a triangle, with its rounded t, u and v.
fn hit<S: Scalar>(triangles: &[TriangleOf<S>], ray: &RayOf<S>, index: usize) -> Hit {
    let (t, u, v) = attributes_from(Tier::Narrow, ray, &triangles[index]);
    Hit { t, u, v, triangle: index as u32, geometry: 0 }
}

#[cfg(test)]
mod tests {
    use intertri::{Mode, Ray};
    use intertri_lab::families::adversarial;
    use intertri_lab::rng::Rng;

    use super::*;

    #[test]
    fn it_answers_as_the_mode_does_over_all_triangles() {
        let mut rng = Rng::new(71);
        let (mode, mut hits) = (Mode::exact(), 0);
        for round in 0..300 {
            let cases: Vec<_> = (0..8).map(|_| adversarial(&mut rng)).collect();
            // Some triangles are duplicates of others, so some hits have equal values of t.
            let triangles: Vec<_> =
                cases.iter().chain(&cases[..3]).map(|case| case.triangle).collect();
            for case in &cases {
                let far = mode.closest(&triangles, &case.ray).map_or(1.0, |hit| hit.t) as f32;
                let ends =
                    [(0.0, f32::INFINITY), (far, f32::INFINITY), (-1.0, far), (0.0, f32::NAN)];
                for (t_min, t_max) in ends {
                    let ray = Ray { t_min, t_max, ..case.ray };
                    let found = all(&triangles, &ray);
                    assert_eq!(found, mode.all(&triangles, &ray), "{round}: {ray:?}");
                    assert_eq!(closest(&triangles, &ray).some(), mode.closest(&triangles, &ray));
                    assert_eq!(any(&triangles, &ray), !found.is_empty());
                    hits += found.len();
                }
            }
        }
        assert!(hits > 1000, "{hits}");
    }
}
