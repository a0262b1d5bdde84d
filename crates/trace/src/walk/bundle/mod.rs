//! Bundles of coherent rays: up to 1024 rays that share an origin, an end, or a direction, traced
//! together. In other words, their lines pass through one point, which may be at infinity.
//!
//! Rays are projected onto a frame ([`projection`]), so intersection tests resemble those of a
//! rasterizer. Nodes are culled against the frustum around all rays ([`culling`]), and triangles
//! against windows ([`leaf_tests`]).

mod culling;
mod density;
mod end_plane;
mod frustum;
mod leaf_tests;
mod parts;
mod plane;
mod principal_axis;
mod projection;
mod projection_frame;
mod rays;
mod results;
mod reversed_shadow;
mod traverse;

pub(crate) use projection::{Projection, RAYS};
pub(crate) use rays::{
    BundleRays, Common, endless_direction, half, shares_direction, shares_origin,
};
pub(crate) use results::Results;
pub(crate) use reversed_shadow::CommonEnd;
pub(crate) use traverse::{Bundle, Outcome, Scratch};
