//! The shares of the filter's bounds that a scene has: none of its own where it is given in f32, room for the
//! rounding of its copies where in f64.
//!
//! ```text
//!   given in f64        copies in f32                        what they are off by
//!   c1, o               about the scene's centre, rounded    u of themselves: a translation of A
//!   h4, h5, d           scaled, rounded                      u of each component
//! ```
//!
//! Derivation: `docs/numerics/f64.md`, section 4.

use super::bound::{self, U};

/// What the filter's bounds are made of, but for what never changes. `docs/numerics/certified.md` has the names.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Whether blocks hold copies: a corner and two edges, not three corners.
    pub(super) copies: bool,
    /// Whether all hits lie on their triangles. The reference sees some beside those whose normals it does not know.
    pub(super) exact: bool,
    /// `EDGE`
    pub(super) edge: f32,
    /// `GRAZING`
    pub(super) grazing: f32,
    /// `SLACK DEN`
    pub(super) den: f32,
    /// `SLACK NUM`, and of what A may be off by in any case.
    pub(super) num: [f32; 2],
    /// `SHARP` and `SHARP_U`
    pub(super) sharp: [f32; 2],
    /// What the sharp bounds of edges and of T have besides, relative to `|A|₁`.
    pub(super) sharp_away: [f32; 2],
    /// The bound of an edge, relative to `h |d|₂`: what it is for each `|o|₁`, and besides.
    pub(super) off: [f32; 2],
    /// What copies of A are off by, besides a share of their length: the first for each `|o|₁`, but not more than the
    /// second.
    pub(super) copied: [f32; 2],
    /// The interval's near end, times the first and more by the second, is surely beyond it.
    pub(super) near: [f32; 2],
}

impl Room {
    /// Of what is given in f32, for the reference: none.
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

    /// Of what is given in f32, for hits that are exact.
    pub(crate) const EXACT: Self = Self { exact: true, ..Self::NONE };

    /// How far from an origin's copy rays may pass, as triangles see it: as far as it is from the origin, and corners
    /// from theirs, but for a share of how far these are away.
    pub(super) fn passed(&self, origin: [f32; 3]) -> f32 {
        if !self.copies {
            return 0.0;
        }
        let away = origin.iter().fold(0.0, |sum, x| sum + x.abs());
        (away * self.copied[0]).min(self.copied[1]) + bound::SMALL
    }

    /// Of copies no corner of which is farther from the origin than `reach`, as a sum of coordinates.
    pub fn of_copies(reach: f32) -> Self {
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
