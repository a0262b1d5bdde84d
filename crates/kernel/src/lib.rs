//! Ray/triangle intersection in packets. *Trace in f32. Answer in f64. Or exactly.*
//!
//! ```
//! use intertri::{Exact, Mode, Ray, Triangle};
//!
//! let floor = Triangle::new([-9.0, 0.0, -9.0], [9.0, 0.0, -9.0], [0.0, 0.0, 9.0]);
//! let wall = Triangle::new([-9.0, -9.0, 5.0], [9.0, -9.0, 5.0], [0.0, 9.0, 5.0]);
//! let ray = Ray::new([0.0, 1.0, 0.0], [0.0, -0.5, 1.0]);
//!
//! let hit = Exact::default().closest(&[wall, floor], &ray).unwrap();
//! assert_eq!((hit.triangle, hit.t), (1, 2.0));
//! ```
//!
//! The mode [`Exact`] (the one to take) is right on the coordinates as given. [`Certified`] and
//! [`Double`] give the answers of a plain loop over a scalar f64 reference, bit for bit. [`fixed`] is
//! exact on an integer grid. Answers are the same on every CPU: what each mode promises stands at
//! [`Mode`]. The best instructions of the CPU are chosen at run time.
//!
//! Who has a hierarchy of their own tests packets of rays and blocks of triangles: [`LaneQueries`].
//!
//! Triangles that many rays are sent at can be prepared once: [`Blocks`]. For more than some hundred of them take a
//! hierarchy, such as `Bvh` of the crate `intertri-trace`.
//!
//! # Building it fast
//!
//! Build in release mode. In debug builds every operation on lanes is a function call. If your own crate has to stay
//! unoptimized, optimize this one alone, in your workspace's `Cargo.toml`:
//!
//! ```toml
//! [profile.dev.package.intertri]
//! opt-level = 3
//! [profile.dev.package.intertri-trace]   # if you use the hierarchy
//! opt-level = 3
//! ```
//!
//! The queries of [`Mode`], [`Exact`] and [`Blocks`] are compiled here, so these settings apply to them. What you
//! build on [`LaneQueries`] or on the lanes of [`simd`] is compiled with your crate.
//!
//! On x86-64 and 64-bit ARM nothing else is needed. WebAssembly has SIMD only if the build asks for it; without it a
//! query over a slice takes more than twice as long:
//!
//! ```sh
//! RUSTFLAGS="-C target-feature=+simd128" cargo build --release --target wasm32-unknown-unknown
//! ```
//!
//! Without the feature `std` the crate is `no_std`, with `alloc`, and takes the instructions that the
//! build was compiled for.
#![cfg_attr(not(feature = "std"), no_std)]

extern crate alloc;

mod barycentric;
mod crossings;
mod document;
mod exact;
mod filter;
pub mod fixed;
mod hit_attributes;
mod intersect;
mod lanes64;
mod local_frame;
mod packet;
mod query;
mod resolve;
mod scalar;
pub mod simd;
mod threshold;
mod types;

pub use crossings::{Crossing, Crossings};
pub use exact::{spawn_ray, spawn_ray_to};
pub use intersect::{
    ClosestHit, ClosestHits, Counts, LaneQueries, Prepared, PreparedPacket, PreparedRay,
};
pub use packet::{PacketHits, RayPacket, TriangleBlock};
pub use query::{Blocks, Certified, Double, Exact, Mode};
pub use scalar::Scalar;
pub use threshold::{BadThreshold, Threshold};
pub use types::{Hit, Ray, Ray64, RayOf, Triangle, Triangle64, TriangleOf};

/// What the sister crates build on, and what the traits' associated types are. It changes without notice.
#[doc(hidden)]
pub mod internal {
    pub use crate::barycentric::Coefficients;
    pub use crate::document::{SeenPlane, Tri};
    pub use crate::filter::projection::{
        Frame, Nearest, Outline, Outlines, Points, Ranges, Settle, Starts, Windows,
    };
    pub use crate::filter::{
        AlongAxis, Axis, BlockHits, Constants, Evidence, Filter, LaneHits, Precheck, Rays, Room,
        SharedOriginBlock, Triangles,
    };
    pub use crate::hit_attributes::{HitCoefficients, Pairs, SharedOriginHit};
    pub use crate::intersect::{Found, Test};
    pub use crate::lanes64::Lanes64;
    pub use crate::local_frame::LocalFrame;
    pub use crate::packet::{Copy32, RayLanes};
    pub use crate::query::Which;
    pub use crate::resolve::{Originals, Resolver, SharedOrigin};
    pub use crate::scalar::Bits;
    pub use crate::simd::{Pair, prefetch, prefetch_early};

    /// The arithmetic of the mode `exact`.
    pub mod exact {
        pub use crate::exact::{
            Closest, Feature, Squares, closer, closer_from, closest, feature, feature_from, squares,
        };
        pub use crate::exact::{
            Decided, HitCoefficients, Pair64, Rule, Seen, SeenPlane, Side, Tier, attributes,
            attributes_from, crossing, crossing_from, decide, facing, has_area, hit, hits_in,
            hits_of_origin64, hits64, is_on, is_plain, order, order_from, subnormals_are_read, t,
            t_from, t_times, touch,
        };
    }
}
