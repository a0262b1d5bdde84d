//! The exact point on a triangle that is closest to a given point.
//!
//! ```text
//!            \  corner  /                   The closest point is a corner, lies within an edge, or
//!             \   b    /                    within the face. Exact signs of products decide.
//!              \______/____
//!              /\            edge bc        Its squared distance is a quotient of integers.
//!    edge ab  /  \
//!            / face\
//! ```
//!
//! [`lanes`] bounds squared distances in f64, for eight triangles at once. [`feature`] finds the
//! part of a triangle that contains the closest point, [`order`] decides which of two triangles is
//! closer, and [`attributes`] computes the distance and the position. `docs/numerics/nearest.md`
//! has the bounds and proofs.

mod attributes;
mod closest_point;
mod feature;
mod lanes;
mod offsets;
mod order;
mod rounded;

pub use attributes::closest;
pub use closest_point::Closest;
pub use feature::{Feature, feature, feature_from};
pub use lanes::{Squares, squares};
pub use order::{closer, closer_from};
