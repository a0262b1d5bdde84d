//! The engines that trace rays, the rasterizer, and the frames that they draw.

pub(crate) mod batch;
pub(crate) mod engine64;
pub(crate) mod engines;
pub(crate) mod fixed;
pub(crate) mod frame;
pub(crate) mod instances;
pub(crate) mod memory;
pub(crate) mod model;
pub(crate) mod name;
pub(crate) mod oracle;
pub(crate) mod pixels;
pub(crate) mod raster;
pub(crate) mod ray_engine;
mod reference;
pub(crate) mod scalar_name;
pub(crate) mod tracer;
pub(crate) mod triangles;
