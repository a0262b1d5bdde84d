//! t, u, and v for pairs that are known to hit: t as in document A, and the weights as in document
//! D.

mod pairs;
mod shared_origin;
mod shared_origin_hit;

pub use pairs::Pairs;
pub(crate) use pairs::of_pair;
pub use shared_origin::HitCoefficients;
pub use shared_origin_hit::SharedOriginHit;
