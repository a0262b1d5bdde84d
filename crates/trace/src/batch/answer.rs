//! What a batch may be asked for, one answer a ray.

use intertri::{Crossings, Hit};

use crate::tree::MeshTriangle;
use crate::walk::BatchOutput;

/// The answer to one ray.
pub(crate) trait Answer: Copy + Send + Sync {
    /// The answer for a ray that hits nothing.
    const MISS: Self;

    /// Whether rays of one origin are traced in bundles for it, so that their order matters.
    const IN_BUNDLES: bool;

    /// Where a traversal writes such answers.
    fn output(answers: &mut [Self]) -> BatchOutput<'_>;
}

impl Answer for Hit {
    const MISS: Self = Self::MISS;
    const IN_BUNDLES: bool = true;

    fn output(answers: &mut [Self]) -> BatchOutput<'_> {
        BatchOutput::Hits(answers)
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
