//! The laboratory: input families that are built to break a ray/triangle test, and the exact answer
//! to hold it against.
//!
//! | module | what it has |
//! | --- | --- |
//! | [`rng`] | random numbers with the same bits on every CPU |
//! | [`meshes`] | small closed meshes whose neighbours share their vertices bit for bit |
//! | [`families`] | named generators of rays and triangles, ordinary and adversarial |
//! | [`subjects`] | the known tests, each written once for any lanes |
//! | [`truth`] | where a line meets a triangle, without any rounding |
//! | [`workloads`] | what is measured: camera, secondary, edge-and-vertex rays, the mix |
//! | [`timing`] | how long the subjects take, side by side |
//! | [`judge`] | how often they are wrong on a workload |
//! | [`front`] | which methods none beats in both |
//! | [`metrics`] | how they fare on each family |
//! | [`stress`] | where they begin to fail |
//! | [`edge_count`] | the kernel's promises, on very many rays |
//! | [`advise`] | how many pixels of a frame an arithmetic can get wrong, and does |
//! | [`draw`], [`tables`], [`machine`] | pictures, text, and what was measured on |
//!
//! A seed gives the same counts on every run and every CPU; only times differ.

pub mod advise;
mod cases;
pub mod draw;
pub mod edge_count;
pub mod families;
pub mod front;
pub mod judge;
pub mod machine;
pub mod meshes;
pub mod metrics;
pub mod rng;
pub mod stress;
pub mod subjects;
pub mod tables;
pub mod timing;
pub mod truth;
pub mod workloads;
