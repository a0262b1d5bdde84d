//! Does this ray meet this triangle, and where? *Trace in f32. Answer in f64. Or exactly.*
//!
//! ```
//! use intertri::{Mode, Ray, Triangle};
//!
//! let floor = Triangle::new([-9.0, 0.0, -9.0], [9.0, 0.0, -9.0], [0.0, 0.0, 9.0]);
//! let wall = Triangle::new([-9.0, -9.0, 5.0], [9.0, -9.0, 5.0], [0.0, 9.0, 5.0]);
//! let ray = Ray::new([0.0, 1.0, 0.0], [0.0, -0.5, 1.0]);
//!
//! let hit = Mode::exact().closest(&[wall, floor], &ray).unwrap();
//! assert_eq!((hit.triangle, hit.t), (1, 2.0));
//! ```
//!
//! Rays and triangles are tested in f32 SIMD lanes under a proven error bound. Exact arithmetic
//! settles the few pairs that the bound leaves undecided, near an edge or a vertex. Results are
//! therefore correct at nearly the speed of f32, and they have the same bits on every CPU.
//!
//! # How to choose
//!
//! | you have | use |
//! | --- | --- |
//! | a few hundred triangles, in f32 or f64 | the queries of [`Mode`]: `closest`, `any`, `all`, `crossings` |
//! | the same triangles for many rays | [`Blocks`], which loads them into lanes once |
//! | a mesh | `Bvh` in the `intertri-trace` crate, a hierarchy over millions of triangles |
//! | your own BVH | [`Mode::packet`] and [`Mode::block`], with 4, 8, or 16 rays or triangles side by side; in your own loops, [`Filter`] |
//! | coordinates on an integer grid | [`fixed`] |
//!
//! | mode | agrees exactly with |
//! | --- | --- |
//! | [`Mode::exact`], the default | the true result for the coordinates as given; edges belong to both triangles, so there are no gaps |
//! | [`Mode::once`] | the same, but each edge belongs to only one triangle, so you can count crossings |
//! | [`Mode::certified`] | a plain loop over a scalar f64 reference, bit for bit |
//!
//! To continue a path from a hit without hitting the same surface again, use [`spawn_ray`] and
//! [`spawn_ray_to`].
//!
//! # Features
//!
//! - `std` (default): selects the CPU's best instructions at run time. Without it, the crate is
//!   `no_std` with `alloc`, and it uses the instructions for which it was compiled.
//!
//! `Ray::new(origin, dir)` and `Triangle::new(a, b, c)` accept any type that converts into
//! `[f32; 3]`, such as the vector types of glam and of libraries that support mint. There is no
//! serde feature, because most rays end at infinity, which JSON cannot represent. Rays and
//! triangles have public fields, so you can serialize them in any format.
//!
//! # Limits
//!
//! A triangle with a NaN or infinite coordinate is never hit, and a ray with a NaN or infinite
//! coordinate hits nothing. A slice can have at most 2^32 - 1 triangles.
//!
//! # Building for speed
//!
//! Build in release mode: in debug builds, every SIMD operation is a function call. If your own
//! crate must stay unoptimized, optimize just this crate in your workspace's `Cargo.toml`:
//!
//! ```toml
//! [profile.dev.package.intertri]
//! opt-level = 3
//! [profile.dev.package.intertri-trace]   # if you use the hierarchy
//! opt-level = 3
//! ```
//!
//! The queries of [`Mode`] and [`Blocks`] over slices are compiled in this crate, so these settings
//! apply to them. Code that you build on [`Filter`] or on the lanes of [`simd`] is compiled with
//! your crate.
//!
//! On x86-64 and 64-bit ARM, nothing else is needed. WebAssembly has SIMD only if you enable it for
//! the build; without it, a query over a slice takes more than twice as long:
//!
//! ```sh
//! RUSTFLAGS="-C target-feature=+simd128" cargo build --release --target wasm32-unknown-unknown
//! ```
#![cfg_attr(not(feature = "std"), no_std)]

extern crate alloc;

mod barycentric;
mod crossings;
mod document;
mod exact;
mod filter;
pub mod fixed;
mod hit_attributes;
mod ids;
mod lane_queries;
mod local_frame;
mod packet;
mod query;
mod resolve;
mod scalar;
pub mod simd;
mod threshold;
mod types;

pub use crossings::{Crossing, Crossings};
pub use exact::Rule;
pub use exact::{spawn_ray, spawn_ray_to};
pub use filter::{Counts, Filter, PreparedPacket, PreparedRay, PreparedTriangle};
pub use ids::{LeafSlot, RayId, TriangleId};
pub use lane_queries::{ClosestHit, ClosestHits};
pub use packet::{PacketHits, RayPacket, TriangleBlock};
pub use query::{Blocks, Mode, SliceScalar};
pub use scalar::Scalar;
pub use threshold::{BadThreshold, Threshold};
pub use types::{Hit, Hit32, Ray, Ray64, RayOf, Triangle, Triangle64, TriangleOf};

/// Items that the sister crates build on, and the associated types of traits. They may change
/// without notice.
#[doc(hidden)]
pub mod internal {
    pub use crate::barycentric::Coefficients;
    pub use crate::document::{SeenPlane, Tri};
    pub use crate::filter::projection::{
        Apex, Frame, Nearest, OpenPairs, Outline, Outlines, Parallel, Points, Ranges, Settle,
        Starts, Windows,
    };
    pub use crate::filter::{
        AlongAxis, Axis, BlockHits, Evidence, LaneHits, Rays, Room, Triangles,
    };
    pub use crate::hit_attributes::{HitCoefficients, Pairs, SharedHit};
    pub use crate::lane_queries::NumberedPacket;
    pub use crate::local_frame::LocalFrame;
    pub use crate::packet::{Copy32, RayLanes};
    pub use crate::resolve::{Originals, Resolver, SharedOrigin, sort_hits};
    pub use crate::scalar::Bits;
    pub use crate::simd::{Pair, lanes_of, prefetch, prefetch_early};

    /// The arithmetic of the `exact` mode.
    pub mod exact {
        pub use crate::exact::{
            Closest, Feature, Squares, closer, closer_from, closest, feature, feature_from, squares,
        };
        pub use crate::exact::{
            Decided, DirectionCoefficients, DirectionCoefficients32, EightPairs, HitCoefficients,
            HitCoefficients32, Pair64, PairDecision, Quotients, SeenPlane, Side, Tier, attributes,
            attributes_from, attributes32, crossing, crossing_from, decide, decide_pair,
            decide_with_t, edge_side, facing, has_area, hit, hit32, hits_in, hits_of_origin64,
            hits64, is_on, is_plain, known_order, moment, order, order_by_coordinates, order_from,
            shares_feature, subnormals_are_read, t, t_from, t_times,
        };
    }
}
