//! The names of the engines, on the command line and in reports.

use std::fmt;

use clap::ValueEnum;
use serde::Serialize;

/// The engine that finds the hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum EngineName {
    /// SIMD lanes in f32 within a proven error bound, exact arithmetic for the rest; correct for
    /// the coordinates as given; uses a hierarchy
    Exact,
    /// SIMD lanes in f32 within a proven error bound, f64 for the rest; uses a hierarchy
    Certified,
    /// Integers, exact on a grid that the scene is snapped to (--grid), so its answers differ from
    /// the others' because of the snapping; uses a hierarchy
    Fixed,
    /// The scalar f64 reference in a plain loop over all triangles; slow
    Reference,
    /// Rational arithmetic in a plain loop over all triangles, to check exact; very slow
    Oracle,
    /// The z-buffer, an independent check without rays; for pictures only
    Raster,
}

impl EngineName {
    /// The error for tracing rays with the rasterizer.
    pub(crate) const ANSWERS_NO_RAYS: &str = "engine raster draws pictures but traces no rays; choose exact, certified, fixed, reference or oracle";

    /// Returns whether the engine's answers are correct for the coordinates as given.
    pub(crate) fn is_exact(self) -> bool {
        matches!(self, Self::Exact | Self::Oracle)
    }

    /// Returns whether the engine uses document A's threshold.
    pub(crate) fn has_threshold(self) -> bool {
        matches!(self, Self::Certified | Self::Reference | Self::Raster)
    }
}

impl fmt::Display for EngineName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Use the spelling of the command line.
        f.pad(&format!("{self:?}").to_lowercase())
    }
}
