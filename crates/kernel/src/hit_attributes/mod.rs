//! Computes t, u, and v for rays and triangles that they are known to hit. t has the same bits as
//! in document A; the weights follow document D.

mod pairs;
mod shared_origin;
mod shared_origin_hit;

pub use pairs::Pairs;
pub(crate) use pairs::of_pair;
pub use shared_origin::HitCoefficients;
pub use shared_origin_hit::SharedOriginHit;
