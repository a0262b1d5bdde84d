//! The parts of the filter's error bounds that depend on the scene. A scene given in f64 is tested
//! as f32 copies, whose rounding the bounds must cover.
//!
//! ```text
//!   given in f64    copies in f32                             error
//!   c1, o           relative to the scene's centre, rounded   u times their magnitude; shifts A
//!   h4, h5, d       scaled, rounded                           u times each component
//! ```
//!
//! `docs/numerics/f64.md`, section 4, has the derivation.

use super::bound::{self, U};

/// The coefficients of the filter's error bounds that depend on the scene.
/// `docs/numerics/certified.md` explains the names.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Whether blocks contain copies, which have one corner and two edges instead of three corners.
    pub(super) copies: bool,
    /// Whether all hits are on their triangles. The reference, in contrast, may accept a point
    /// outside a triangle whose normal is inaccurate.
    pub(super) exact: bool,
    /// `EDGE`
    pub(super) edge: f32,
    /// `GRAZING`
    pub(super) grazing: f32,
    /// `SLACK DEN`
    pub(super) den: f32,
    /// `SLACK NUM`, and `SLACK` times the part of A's error that does not depend on the length of
    /// A.
    pub(super) num: [f32; 2],
    /// `SHARP` and `SHARP_U`
    pub(super) sharp: [f32; 2],
    /// The noise that is added to the sharp bounds on the edge functions and on T, relative to
    /// `|A|₁`.
    pub(super) sharp_away: [f32; 2],
    /// The part of an edge's bound that is relative to `h |d|₂`: a factor of `|o|₁` and a constant.
    pub(super) off: [f32; 2],
    /// The error of copies of A, apart from a fraction of their length, as a factor of `|o|₁` and a
    /// maximum.
    pub(super) copied: [f32; 2],
    /// A factor and a summand. Any t that exceeds the near end times the factor, plus the summand,
    /// is certainly beyond the near end.
    pub(super) near: [f32; 2],
}

impl Room {
    /// The coefficients for f32 scenes whose results are defined by the reference's operations.
    pub(crate) const NONE: Self = Self {
        copies: false,
        exact: false,
        edge: bound::EDGE,
        grazing: bound::GRAZING,
        den: bound::SLACK * bound::DEN,
        num: [bound::SLACK * bound::NUM, bound::SLACK * bound::NUM * bound::SMALL],
        sharp: [bound::SHARP, bound::SHARP_U],
        sharp_away: [bound::NOISE, 0.0],
        off: [bound::ORIGIN, bound::SMALL],
        copied: [0.0; 2],
        near: [1.0, 0.0],
    };

    /// The coefficients for f32 scenes with exact hits.
    pub(crate) const EXACT: Self = Self { exact: true, ..Self::NONE };

    /// Returns the maximum distance by which a ray may miss the copy of its origin, as seen from
    /// the copies of the triangles. The distance covers the rounding of the origin and the corners,
    /// except for a fraction of the distance between the origin and a corner.
    pub(super) fn passed(&self, origin: [f32; 3]) -> f32 {
        if !self.copies {
            return 0.0;
        }
        let away = origin.iter().fold(0.0, |sum, x| sum + x.abs());
        // This is the limit that `Rays::new` uses, with a margin for a subnormal coordinate.
        (away * self.copied[0]).min(self.copied[1]) + bound::SMALL
    }

    /// Returns the coefficients for copies of f64 scenes. `reach` is an upper bound on the 1-norm
    /// of every corner.
    pub fn of_copies(reach: f32) -> Self {
        // The corner and the origin are both rounded, each by a fraction `COPY` of itself. No
        // corner is farther out than `reach`, which limits the contribution of a far origin
        // (f64.md, section 4).
        let twice = 2.0 * bound::COPY;
        Self {
            copies: true,
            exact: true,
            edge: bound::COPY_EDGE + bound::COPY,
            grazing: bound::COPY_GRAZING,
            den: bound::SLACK * bound::COPY_DEN,
            num: [bound::SLACK * bound::COPY_NUM, bound::SLACK * bound::COPY_NUM * bound::SMALL],
            sharp: [bound::COPY_SHARP, bound::COPY_SHARP_U],
            sharp_away: [bound::COPY; 2],
            off: [bound::ORIGIN, bound::SMALL],
            copied: [twice, twice * reach],
            near: [1.0 + 4.0 * U, bound::TINY],
        }
    }
}
