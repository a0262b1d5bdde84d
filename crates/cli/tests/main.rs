//! The program from outside: the real binary, run in its own folder. All tests are one program, which is
//! linked once.

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
