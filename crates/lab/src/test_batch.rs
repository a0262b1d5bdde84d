//! A method's input, in which every ray is tested against every triangle, and its answers.

use intertri::{Ray, Triangle};

/// A batch in which every ray is tested against every triangle, as in a leaf of a hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct TestBatch {
    /// The rays.
    pub rays: Vec<Ray>,
    /// The triangles, of which there is at least one.
    pub triangles: Vec<Triangle>,
}

impl TestBatch {
    /// Counts how many triangles each ray hits, testing every pair with `pairs`.
    pub(crate) fn counts(
        &self,
        mut pairs: impl FnMut(&[Triangle], &[Ray], &mut [Answer]),
    ) -> Vec<u32> {
        let mut to = vec![Answer::default(); self.triangles.len()];
        let count = |ray: &Ray| {
            pairs(&self.triangles, &vec![*ray; self.triangles.len()], &mut to);
            to.iter().filter(|answer| answer.hit).count() as u32
        };
        self.rays.iter().map(count).collect()
    }
}

/// A method's answer for a ray and a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Answer {
    /// Whether there is a hit.
    pub hit: bool,
    /// The `t` of the hit; unspecified for a miss.
    pub t: f64,
}

/// The closest hit of a ray in its batch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestHit {
    /// The `t` of the hit, or infinity for a miss.
    pub t: f64,
    /// The index of the triangle in the batch, or `u32::MAX` for a miss.
    pub triangle: u32,
}

impl ClosestHit {
    /// The result of a ray that hits nothing.
    pub const MISS: Self = Self { t: f64::INFINITY, triangle: u32::MAX };
}
