//! One traversal in four forms: a ray a call (`single`), streams of rays that have little in common (`stream`), bundles
//! of coherent rays (`bundle`), beams of parallel ones (`beam`).

pub(crate) mod beam;
pub(crate) mod bundle;
mod hit_pairs;
pub(crate) mod one_ray;
mod output;
pub(crate) mod single;
pub(crate) mod stream;

pub(crate) use hit_pairs::{HitPairs, NearestFew};
pub(crate) use output::BatchOutput;
