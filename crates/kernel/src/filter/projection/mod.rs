//! Projects rays of one apex to points on a plane, and triangles to linear forms on that plane. The
//! apex is an origin, an end, or, for parallel rays, a point at infinity.
//!
//! ```text
//!        up                  A ray along d is the point (x, y) = (d·right, d·up) / d·depth.
//!         │   ╱ depth        U, V, W, and D of document D, divided by d·depth, are linear in x and y.
//!         │ ╱   · (x, y)     So is D / T = 1 / (t d·depth): as in a z-buffer, no division is needed.
//!         o───── right
//! ```
//!
//! Testing a ray thus takes two multiply-adds per edge, and the outline of a triangle can be tested
//! against a whole window of the projection at once. `docs/numerics/projection.md` has the bounds
//! and the proof.

mod frame;
mod nearest;
mod open_pairs;
mod outline;
mod settle;
mod starts;
mod windows;

pub use frame::{Apex, Frame, Parallel, Points};
pub use nearest::{Nearest, OpenPairs};
pub use outline::{Outline, Outlines};
pub use settle::Settle;
pub use starts::{Ranges, Starts};
pub use windows::Windows;
