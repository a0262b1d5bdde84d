//! The names of the scalars, on the command line and in reports.

use std::fmt;

use clap::ValueEnum;
use intertri_scene::Coordinate;
use serde::Serialize;

/// The scalar in which a scene is traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ScalarName {
    /// Round every number to f32; the report counts the numbers that changed
    F32,
    /// Keep every number exactly, such as UTM coordinates; only for the exact and oracle engines
    F64,
}

impl ScalarName {
    /// Returns the name of the scalar `S`.
    pub(crate) fn of<S: Coordinate>() -> Self {
        if S::NAME == f32::NAME { Self::F32 } else { Self::F64 }
    }

    /// Returns the text that follows the engine's name in a report. It is empty for f32.
    pub(crate) fn mention(self) -> &'static str {
        match self {
            Self::F32 => "",
            Self::F64 => " in f64",
        }
    }
}

impl fmt::Display for ScalarName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F32 => f32::NAME,
            Self::F64 => f64::NAME,
        })
    }
}
