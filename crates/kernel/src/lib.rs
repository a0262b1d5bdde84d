//! Ray/triangle intersection in packets. *Trace in f32. Answer in f64. Or exactly.*
//!
//! ```
//! use intertri::{Certified, Mode, Ray, Triangle};
//!
//! let floor = Triangle::new([-9.0, 0.0, -9.0], [9.0, 0.0, -9.0], [0.0, 0.0, 9.0]);
//! let wall = Triangle::new([-9.0, -9.0, 5.0], [9.0, -9.0, 5.0], [0.0, 9.0, 5.0]);
//! let ray = Ray::new([0.0, 1.0, 0.0], [0.0, -0.5, 1.0]);
//!
//! let hit = Certified::default().closest(&[wall, floor], &ray);
//! assert_eq!((hit.triangle, hit.t), (1, 2.0));
//! ```
//!
//! The modes [`Certified`] (the one to take) and [`Double`] give the answers of a plain loop over a
//! scalar f64 reference, bit for bit, on every CPU: what each promises stands at [`Mode`]. [`fixed`]
//! is exact on an integer grid. The best instructions of the CPU are chosen at run time.
//!
//! Without the feature `std` the crate is `no_std` and takes the instructions that the build was
//! compiled for.
#![cfg_attr(not(feature = "std"), no_std)]

mod best;
mod blocks;
mod certified;
mod cramer;
mod data;
mod double;
pub mod fixed;
pub mod lanes;
mod mode;
mod packet;
mod pairs;
mod prepared;
mod sight;
mod slices;
mod vec3;
mod verbs;

pub use best::{Best, Bests};
pub use certified::{
    Certified, Evidence, Frame, Judge, Nearest, Outline, Outlines, Points, Ranges, Replay, Starts,
    View, Views, Windows,
};
pub use cramer::Coefficients;
pub use data::{Hit, Ray, Triangle};
pub use double::Double;
pub use mode::{BadThreshold, Counts, Lane, Threshold, Which, Width};
pub use packet::{Hits, RayPacket, TrianglePack};
pub use pairs::Pairs;
pub use prepared::{Prepared, PreparedPacket, PreparedRay};
pub use sight::Sight;
pub use vec3::Vec3;
pub use verbs::Mode;
