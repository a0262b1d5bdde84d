//! The five documents, each by its examples and where it errs.

mod clip_edge;
mod closest;
mod cramer;
mod inter_tri;
mod shadow_volume;
mod vector;
mod z_buffer;
