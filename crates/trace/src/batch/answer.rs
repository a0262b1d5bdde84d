//! The types of answers that a batch query can return, one answer per ray.

use intertri::{Crossings, Hit, Hit32};

use crate::tree::MeshTriangle;
use crate::walk::BatchOutput;

/// The answer for one ray.
pub trait Answer: Copy + Send + Sync {
    /// The answer for a ray that hits nothing.
    const MISS: Self;

    /// Whether rays with a common apex are traced in bundles for this answer, so that the order
    /// of the rays affects the speed.
    const IN_BUNDLES: bool;

    /// Whether the answer is whether a ray hits anything.
    const ANY: bool = false;

    /// Wraps a slice of answers for a traversal to write to.
    fn output(answers: &mut [Self]) -> BatchOutput<'_>;
}

/// The hits that [`Query::closest_batch_into`](crate::Query::closest_batch_into) writes: [`Hit`],
/// with t, u, and v in f64, or [`Hit32`], with t, u, and v in f32. The trait is sealed.
pub trait HitRecord: Answer {}

impl HitRecord for Hit {}
impl HitRecord for Hit32 {}

impl Answer for Hit {
    const MISS: Self = Self::MISS;
    const IN_BUNDLES: bool = true;

    fn output(answers: &mut [Self]) -> BatchOutput<'_> {
        BatchOutput::Hits(answers)
    }
}

impl Answer for Hit32 {
    const MISS: Self = Self::MISS;
    const IN_BUNDLES: bool = true;

    fn output(answers: &mut [Self]) -> BatchOutput<'_> {
        BatchOutput::Hits32(answers)
    }
}

impl Answer for MeshTriangle {
    const MISS: Self = Self::MISS;
    const IN_BUNDLES: bool = true;

    fn output(answers: &mut [Self]) -> BatchOutput<'_> {
        BatchOutput::Triangles(answers)
    }
}

impl Answer for bool {
    const MISS: Self = false;
    const IN_BUNDLES: bool = true;
    const ANY: bool = true;

    fn output(answers: &mut [Self]) -> BatchOutput<'_> {
        BatchOutput::Any(answers)
    }
}

impl Answer for Crossings {
    const MISS: Self = Self { signed: 0, unsigned: 0 };
    const IN_BUNDLES: bool = false;

    fn output(answers: &mut [Self]) -> BatchOutput<'_> {
        BatchOutput::Crossings(answers)
    }
}
