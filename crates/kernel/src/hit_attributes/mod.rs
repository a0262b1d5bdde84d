//! Computes t, u, and v for rays and triangles that they are known to hit. The values of t match
//! document A bit for bit, and the weights follow document D (`docs/documents.md`).

mod pairs;
mod shared_hit;
mod shared_origin;

pub use pairs::Pairs;
pub(crate) use pairs::of_pair;
pub use shared_hit::SharedHit;
pub use shared_origin::HitCoefficients;
