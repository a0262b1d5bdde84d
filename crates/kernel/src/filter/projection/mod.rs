//! Rays from one origin as points of a projection: what they have in common, taken to its end.
//!
//! ```text
//!        up                     a ray of direction d is the point (x, y) = (d·right, d·up) / d·depth;
//!         │   ╱ depth           U, V, W and D of document D, divided by d·depth, are linear in x and
//!         │ ╱   · (x, y)        y, and D / T = 1 / (t d·depth) is, too: no division, as in a z-buffer
//!         o───── right
//! ```
//!
//! So a triangle costs a ray two multiply-adds an edge, and one outline of a triangle can be held
//! against a whole window of the projection. Bounds and proof: `docs/numerics/projection.md`.

mod frame;
mod nearest;
mod outline;
mod settle;
mod starts;
mod windows;

pub use frame::{Frame, Points};
pub use nearest::Nearest;
pub use outline::{Outline, Outlines};
pub use settle::Settle;
pub use starts::{Ranges, Starts};
pub use windows::Windows;
