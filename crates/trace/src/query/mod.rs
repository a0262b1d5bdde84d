//! What users ask of a hierarchy: of one ray, or of many.

mod batch;
mod crossings;
#[cfg(feature = "fixed")]
mod fixed;
mod one;

#[cfg(feature = "fixed")]
pub use fixed::FixedBvh;

pub(crate) use batch::chunks;

use intertri::{Counts, Hit, Mode, Ray};

use crate::answers::Answers;
use crate::tree::Bvh;

impl Bvh {
    /// The closest hit; of equal t, the lowest index.
    pub fn closest<M: Mode>(&self, mode: &M, ray: &Ray) -> Option<Hit> {
        one::closest(self, mode.test().into(), ray)
    }

    /// Whether anything is hit.
    pub fn any<M: Mode>(&self, mode: &M, ray: &Ray) -> bool {
        one::any(self, mode.test().into(), ray)
    }

    /// Every hit, in order of t; of equal t, of the index.
    pub fn all<M: Mode>(&self, mode: &M, ray: &Ray) -> Vec<Hit> {
        one::all(self, mode.test().into(), ray)
    }

    /// [`Bvh::closest`] of many rays: `hits[i]` becomes the answer of `rays[i]`, [`Hit::MISS`] where there is
    /// none.
    ///
    /// Rays that are neighbours in the slice are best neighbours in space, too. Fastest are rays that
    /// share their origin, 1024 of them in a row in a narrow cone, such as 32 by 32 pixels in Z-order;
    /// whether that is so is found out here, and no answer depends on it.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_batch<M: Mode>(&self, mode: &M, rays: &[Ray], hits: &mut [Hit]) -> Counts {
        batch::answer(self, mode.test().into(), rays, Answers::Hits(hits))
    }

    /// The triangles of [`Bvh::closest_batch`] alone, [`Hit::NO_TRIANGLE`] for a miss: where nobody asks for
    /// t, it need not be computed in f64.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn triangles_batch<M: Mode>(
        &self,
        mode: &M,
        rays: &[Ray],
        triangles: &mut [u32],
    ) -> Counts {
        batch::answer(self, mode.test().into(), rays, Answers::Triangles(triangles))
    }

    /// [`Bvh::any`] of many rays: `any[i]` becomes the answer of `rays[i]`.
    ///
    /// Fastest where neighbours share their origin, or end at one point but for rounding, at t = 1 or at
    /// `t_max`, and do not look beyond it: as shadow rays to a light.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn any_batch<M: Mode>(&self, mode: &M, rays: &[Ray], any: &mut [bool]) -> Counts {
        batch::answer(self, mode.test().into(), rays, Answers::Any(any))
    }
}
