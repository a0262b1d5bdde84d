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

pub mod families;
pub mod meshes;
pub mod rng;
pub mod subjects;
pub mod truth;
