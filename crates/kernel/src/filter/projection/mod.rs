//! Rays from one origin as points of a projection plane, and triangles as linear forms on it.
//!
//! ```text
//!        up                     a ray of direction d is the point (x, y) = (d·right, d·up) / d·depth;
//!         │   ╱ depth           U, V, W and D of document D, divided by d·depth, are linear in x and
//!         │ ╱   · (x, y)        y, and D / T = 1 / (t d·depth) is, too: no division, as in a z-buffer
//!         o───── right
//! ```
//!
//! So testing a ray takes two multiply-adds for each edge, and the outline of a triangle can be tested
//! against a whole window of the projection at once. `docs/numerics/projection.md` has the bounds and the
//! proof.

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
