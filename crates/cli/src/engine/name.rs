//! The names of the engines, on the command line and in reports.

use std::fmt;

use clap::ValueEnum;
use serde::Serialize;

/// The engine that finds the hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum EngineName {
    /// f32 lanes under a proven bound, exact arithmetic where it cannot decide: right on the coordinates
    /// as given; a hierarchy
    Exact,
    /// f32 lanes under a proven bound, f64 where it cannot decide; a hierarchy
    Certified,
    /// Integers: exact on a grid that the scene is snapped to (--grid), and so another scene's
    /// answers by a rounding; a hierarchy
    Fixed,
    /// The scalar f64 reference in a plain loop over all triangles: slow
    Reference,
    /// Rationals in a plain loop over all triangles, which exact must equal: very slow
    Oracle,
    /// The z-buffer: no rays, and so another witness; for pictures alone
    Raster,
}

impl EngineName {
    /// The error for tracing rays by the rasterizer.
    pub(crate) const ANSWERS_NO_RAYS: &str = "engine raster draws pictures and answers no rays; choose exact, certified, fixed, reference or oracle";

    /// Whether it answers for the real numbers that the coordinates are.
    pub(crate) fn is_exact(self) -> bool {
        matches!(self, Self::Exact | Self::Oracle)
    }

    /// Whether it has the threshold of document A.
    pub(crate) fn has_threshold(self) -> bool {
        matches!(self, Self::Certified | Self::Reference | Self::Raster)
    }
}

impl fmt::Display for EngineName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // As the command line spells it.
        f.pad(&format!("{self:?}").to_lowercase())
    }
}
