//! Computes t, u, and v for rays and triangles that they are known to hit. The values of t match
//! document A bit for bit, and the weights follow document D (`docs/documents.md`).

mod pairs;
mod shared_origin;
mod shared_origin_hit;

pub use pairs::Pairs;
pub(crate) use pairs::of_pair;
pub use shared_origin::HitCoefficients;
pub use shared_origin_hit::SharedOriginHit;
