//! The names of the scalars, on the command line and in reports.

use clap::ValueEnum;
use serde::Serialize;

/// What coordinates are read and traced in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ScalarName {
    /// Every coordinate is rounded to f32
    #[default]
    F32,
    /// Coordinates are kept in f64, such as UTM's, and answers are exact for these; for engine exact
    F64,
}

impl ScalarName {
    /// What a report adds to the engine: nothing where it is f32.
    pub(crate) fn mention(self) -> &'static str {
        match self {
            Self::F32 => "",
            Self::F64 => " in f64",
        }
    }
}
