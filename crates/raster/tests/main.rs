//! Tests of the z-buffer and the shadow volumes through their public interface. Pictures and
//! shadows are compared with scalar references and with rays.

mod clip;
mod common;
mod models;
mod shadows;
mod verdicts;
mod wire;
mod z_buffer;
