//! The data of the hierarchy: nodes with eight boxes and leaves with eight triangles.

mod aabb;
mod cost;
mod geometries;
mod hierarchy;
mod hit_bounds;
mod leaf_bounds;
mod margin;
mod node;
mod octant_order;

pub(crate) use aabb::Aabb;
pub use geometries::MeshTriangle;
pub(crate) use geometries::{Geometries, NamesTriangle};
pub(crate) use hierarchy::{Leaf, Tree};
pub(crate) use hit_bounds::{HitBounds, hit_bounds};
pub(crate) use leaf_bounds::{LaneBounds, LeafBounds, boxes_of, lean_of};
pub(crate) use margin::Margin;
pub(crate) use node::{BLOCK, EMPTY, LEAF, MOST_LEAVES, NONE, Node};
pub(crate) use octant_order::{far_to_near, first_slot};
