//! What one test of lanes gives, and what becomes of it: the closest hits so far.

mod candidates;
mod closest_hit;
mod closest_hits;
mod pairs;
mod prepared;
mod queries;
mod test;

pub(crate) use candidates::{Candidates, closest_of};
pub use closest_hit::ClosestHit;
pub use closest_hits::ClosestHits;
pub(crate) use pairs::{LanePairs, RayOnRow, RaysOnTriangle};
pub use prepared::{Prepared, PreparedPacket, PreparedRay};
pub use queries::LaneQueries;
pub use test::{Counts, Found, Test};
