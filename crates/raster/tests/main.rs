//! Both rasterizers through their public interface: pictures and shadows against scalar references and rays.

mod clip;
mod common;
mod models;
mod shadows;
mod verdicts;
mod wire;
mod z_buffer;
