//! The point of a triangle that is closest to a given one, exactly.
//!
//! ```text
//!            \  corner  /                   the closest point is a corner, lies within an edge, or
//!             \   b    /                    within the face: signs of products tell, exactly
//!              \______/____
//!              /\            edge bc        its squared distance is a quotient of integers
//!    edge ab  /  \
//!            / face\
//! ```
//!
//! [`lanes`] bounds squared distances in f64, eight triangles at once; [`feature`] says where on a triangle the
//! closest point lies; [`order`] which of two triangles is closer; [`attributes`] how far and where. Bounds and
//! proofs: `docs/numerics/nearest.md`.

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
