//! A pixel, and the triangles that may be visible there.

#![expect(clippy::neg_cmp_op_on_partial_ord, reason = "NaN counts as doubtful")]

use intertri::Ray;

use super::facet::Facet;
use super::footprint::ScanInput;
use super::outcome::Outcome;
use super::pixel_ray::PixelRay;
use crate::methods::moller_trumbore::MollerTrumbore;
use crate::methods::{Intersector, PlainRay};
use crate::oracle::{self, exact_t};

/// A pixel, and the results for it so far.
pub(super) struct Pixel {
    pub(super) ray: Ray,
    pub(super) pixel_ray: PixelRay,
    pub(super) seen: Option<u32>,
    /// One bit for each arithmetic, set if the pixel is doubtful in that arithmetic.
    pub(super) doubtful: u32,
    /// For each arithmetic, an upper bound on the t at which the arithmetic may find the visible
    /// triangle.
    pub(super) far: Vec<f64>,
    pub(super) sampled: bool,
    /// An upper bound on the t of the exact closest hits, and the indices of their triangles.
    pub(super) closest: (f64, Vec<u32>),
    pub(super) single: (f32, Option<u32>),
}

impl Pixel {
    pub(super) fn visit(
        &mut self,
        index: u32,
        facet: &Facet,
        input: &ScanInput<'_>,
        single: &<MollerTrumbore as Intersector>::Triangle<f32>,
    ) {
        let mut plane_hit = facet.plane_hit(&self.pixel_ray);
        let mut tied = None;
        let triangle = |index: u32| &input.triangles[index as usize];
        for (k, &arithmetic) in input.arithmetics.iter().enumerate() {
            if self.doubtful & 1 << k != 0 {
                continue;
            }
            let outcome = facet.outcome(arithmetic, &mut plane_hit, &self.pixel_ray);
            let doubt = match outcome {
                Outcome::Miss => self.seen == Some(index),
                Outcome::Hit(lo, _) => self.seen != Some(index) && !(lo > self.far[k]),
                Outcome::Doubtful(lo, _) => !(lo > self.far[k]),
            };
            // If the ray hits two triangles at the same t, either is a correct answer.
            let sure = matches!(outcome, Outcome::Hit(..));
            if doubt
                && !(sure && *tied.get_or_insert_with(|| self.is_tied(index, plane_hit.t, input)))
            {
                self.doubtful |= 1 << k;
            }
        }

        if !self.sampled {
            return;
        }
        // Run the f32 test.
        let ray = PlainRay {
            origin: intertri::simd::Vec3::<f32>::splat(self.ray.origin),
            dir: intertri::simd::Vec3::splat(self.ray.dir),
        };
        let (hit, t) = MollerTrumbore { epsilon: 0.0 }.test::<f32>(single, &ray);
        if hit && t < self.single.0 {
            self.single = (t, Some(index));
        }
        // Run the oracle's exact test.
        if facet.is_outside(&plane_hit, &self.pixel_ray)
            || facet.is_behind(&plane_hit, &self.pixel_ray, self.closest.0)
        {
            return;
        }
        if oracle::answer(triangle(index), &self.ray).is_hit() {
            let order = match self.closest.1.first() {
                None => std::cmp::Ordering::Less,
                Some(&best) => {
                    let t = [index, best].map(|i| exact_t(triangle(i), &self.ray));
                    t[0].cmp(&t[1])
                }
            };
            match order {
                std::cmp::Ordering::Less => {
                    self.closest = (facet.latest(&plane_hit, &self.pixel_ray), vec![index]);
                }
                std::cmp::Ordering::Equal => self.closest.1.push(index),
                std::cmp::Ordering::Greater => {}
            }
        }
    }

    /// Returns whether the ray hits this triangle at exactly the same t as the visible triangle.
    fn is_tied(&self, index: u32, t: f64, input: &ScanInput<'_>) -> bool {
        let Some(seen) = self.seen else { return false };
        let other = input.facet(seen as usize).plane_hit(&self.pixel_ray).t;
        if !((t - other).abs() <= 1e-9 * other.abs()) {
            return false;
        }
        let t = [index, seen].map(|i| exact_t(&input.triangles[i as usize], &self.ray));
        t[0].is_some() && t[0] == t[1]
    }
}
