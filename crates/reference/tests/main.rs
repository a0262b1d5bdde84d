//! Tests the five documents, including their examples and their errors.

mod clip_edge;
mod closest;
mod cramer;
mod inter_tri;
mod shadow_volume;
mod vector;
mod z_buffer;
