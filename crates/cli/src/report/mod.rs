//! Reports as text and JSON, comparisons of frames, and output folders for charts.

pub(crate) mod advise;
pub(crate) mod bench;
pub(crate) mod build;
pub(crate) mod charts;
pub(crate) mod check;
pub(crate) mod inspect;
mod phrases;
pub(crate) mod print;
pub(crate) mod render;
pub(crate) mod rounding;
pub(crate) mod trace;
