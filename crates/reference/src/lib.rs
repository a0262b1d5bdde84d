//! Implements the project's five documents in scalar f64, with one file per document.
//!
//! The code is written to be compared with the documents, not to be fast. The operations are in the
//! document's order, and nothing is fused, reassociated, or approximated. No code is shared with
//! the kernel, because comparisons would not reveal a bug in shared code. If a document has an
//! error, the file notes and corrects it.
//!
//! | document | file | contents |
//! | --- | --- | --- |
//! | A | [`inter_tri`] | the ray/triangle test that every other method is compared with |
//! |   | [`closest`] | loops over all triangles: the oracle for closest, any, and all hits |
//! | B | [`z_buffer`] | the nearest convex facet at each pixel |
//! | C | [`shadow_volume`] | silhouettes and the sides of shadow volumes |
//! | D | [`cramer`] | triangles prepared for many rays from one origin; texture coordinates |
//! | E | [`clip_edge`](mod@clip_edge) | edges clipped against the canonical view volume |
#![no_std]

extern crate alloc;

pub mod clip_edge;
pub mod closest;
pub mod cramer;
pub mod inter_tri;
pub mod shadow_volume;
pub mod vector;
pub mod z_buffer;

pub use inter_tri::{IndexOutOfRange, Ray, Scene, THRESHOLD, Trian};
pub use vector::Vector;
