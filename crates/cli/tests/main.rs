//! Tests the program from outside, by running the compiled binary in a temporary folder. All tests
//! are in one crate, so that only one test program has to be linked.

mod advise;
mod bench;
mod build;
mod charts;
mod common;
mod errors;
mod exact;
mod files;
mod fixed;
mod formats;
mod inspect;
mod instances;
mod interrupts;
mod light;
mod memory;
mod misread;
mod models;
mod numbers;
mod raster;
mod render;
mod scalar;
mod trace;
