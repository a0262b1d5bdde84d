//! Tests the implementations of the five documents, including the documents' examples and errors.

mod clip_edge;
mod closest;
mod cramer;
mod inter_tri;
mod shadow_volume;
mod vector;
mod z_buffer;
