//! The commands of the program, one per file, and the options that several commands share.

pub(crate) mod advise;
pub(crate) mod bench;
pub(crate) mod build;
pub(crate) mod chart;
pub(crate) mod crossover;
pub(crate) mod inspect;
mod notes;
mod options;
pub(crate) mod render;
pub(crate) mod stress;
pub(crate) mod trace;
