//! Tests ray packets and triangle blocks with the filter, and keeps track of the closest hits.

mod closest_hit;
mod closest_hits;
mod lane_pairs;
mod open_lanes;
mod queries;

pub use closest_hit::ClosestHit;
pub use closest_hits::ClosestHits;
pub(crate) use lane_pairs::{LanePairs, RayOnRow};
pub use queries::NumberedPacket;
