//! How much wider than their boxes triangles count in a walk.
//!
//! A box is geometry: it holds its triangles, and rounding of the walk itself is a share of the ray's numbers. Only the
//! reference, which rounds, sees hits beside a triangle. `docs/numerics/hierarchy.md`, section 1, bounds how far.

/// How far beside a triangle the reference sees hits, as a share of the largest coordinate of the origin and of the
/// scene, besides what comes from the triangle's shape: 2^-46.
const BESIDE: f32 = 1.0 / (1_u64 << 46) as f32;

/// What a walk must know of a tree besides its boxes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Margin {
    /// No coordinate of a triangle is larger.
    pub(crate) reach: f32,
    /// What boxes are padded by, whatever the ray.
    lean: f32,
    /// The same as a share of the origin's largest coordinate.
    beside: f32,
}

impl Margin {
    /// Of a tree whose coordinates reach to ±`reach`; with `lean`, for hits that may lie that far beside boxes.
    #[inline(always)]
    pub(crate) fn new(reach: f32, lean: Option<f32>) -> Self {
        let (lean, beside) = lean.map_or((0.0, 0.0), |lean| (lean + BESIDE * reach, BESIDE));
        Self { reach, lean, beside }
    }

    /// What boxes are padded by for a ray whose origin's largest coordinate is `away`.
    #[inline(always)]
    pub(crate) fn room(&self, away: f32) -> f32 {
        self.beside * away + self.lean
    }
}
