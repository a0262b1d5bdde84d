//! Tests the z-buffer and the shadow volumes through their public interface, comparing images and
//! shadows with scalar reference implementations and with traced rays.

mod clip;
mod common;
mod models;
mod shadows;
mod verdicts;
mod wire;
mod z_buffer;
