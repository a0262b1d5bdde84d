//! Tests the z-buffer and the shadow volumes through their public interface. Images and shadows
//! are compared with scalar references and with rays.

mod clip;
mod common;
mod models;
mod shadows;
mod verdicts;
mod wire;
mod z_buffer;
