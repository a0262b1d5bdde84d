//! Five forms of traversal: single rays (`single`), streams of incoherent rays (`stream`), packets
//! of coherent rays (`packet`), bundles of rays of one apex (`bundle`), and beams of
//! parallel rays (`beam`).

pub(crate) mod beam;
pub(crate) mod bundle;
mod hit_pairs;
pub(crate) mod one_ray;
mod output;
pub(crate) mod packet;
pub(crate) mod single;
pub(crate) mod stream;

pub(crate) use hit_pairs::{HitPairs, NearestFew};
pub(crate) use output::{BatchOutput, HitFormat};
