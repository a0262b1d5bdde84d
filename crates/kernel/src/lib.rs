//! Ray/triangle intersection in packets. *Trace in f32. Answer in f64. Or exactly.*
#![cfg_attr(not(feature = "std"), no_std)]

mod best;
mod certified;
mod data;
mod double;
pub mod fixed;
pub mod lanes;
mod mode;
mod packet;
mod slices;
mod vec3;
mod verbs;

pub use best::{Best, Bests};
pub use certified::{Certified, Evidence, View};
pub use data::{Hit, Ray, Triangle};
pub use double::Double;
pub use mode::{BadThreshold, Counts, Lane, Threshold, Width};
pub use packet::{Hits, RayPacket, TrianglePack};
pub use vec3::Vec3;
pub use verbs::{Mode, Prepared, PreparedPacket, PreparedRay};
