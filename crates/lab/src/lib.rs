//! Compares the known ray/triangle tests, with inputs designed to break them and an exact oracle
//! that judges their answers.
//!
//! | module | contents |
//! | --- | --- |
//! | [`rng`] | random numbers with the same bits on every CPU |
//! | [`meshes`] | small closed meshes in which neighbouring faces have bitwise equal vertices |
//! | [`families`] | named generators of rays and triangles, ordinary and adversarial |
//! | [`test_batch`], [`layout`] | the input and answers of a method, and their arrangement in lanes |
//! | [`methods`] | the known tests, each written once for any lane type |
//! | [`oracle`] | where a line meets a triangle, without rounding |
//! | [`workloads`] | the inputs: camera rays, secondary rays, rays at edges and vertices, the adversarial mix |
//! | [`timing`] | how long the methods take, side by side |
//! | [`accuracy`] | how often the methods are wrong on a workload |
//! | [`pareto`] | the methods that no other method matches or beats in both speed and accuracy |
//! | [`metrics`] | the methods' results on each family |
//! | [`stress`] | where the methods begin to fail |
//! | [`edge_count`] | checks of the kernel's guarantees on a very large number of rays |
//! | [`advise`] | how many pixels of a frame an arithmetic can get wrong, and how many it does |
//! | `draw`, [`tables`], [`machine`] | charts (feature `draw`), tables, and machine details |
//!
//! Without the `measure` feature, the crate contains only [`rng`], [`meshes`], [`families`], and
//! the generic tests of [`methods`], which compile in seconds on every target.
//!
//! A seed yields the same counts on every run and every CPU; only the times differ.

#[cfg(feature = "measure")]
pub mod accuracy;
#[cfg(feature = "measure")]
pub mod advise;
#[cfg(feature = "measure")]
mod case_answers;
#[cfg(feature = "draw")]
pub mod draw;
#[cfg(feature = "measure")]
pub mod edge_count;
pub mod families;
#[cfg(feature = "measure")]
pub mod layout;
#[cfg(feature = "measure")]
pub mod machine;
pub mod meshes;
pub mod methods;
#[cfg(feature = "measure")]
pub mod metrics;
#[cfg(feature = "measure")]
pub mod oracle;
#[cfg(feature = "measure")]
pub mod pareto;
#[cfg(feature = "measure")]
mod quantile;
pub mod rng;
#[cfg(feature = "measure")]
pub mod stress;
#[cfg(feature = "measure")]
pub mod tables;
#[cfg(feature = "measure")]
pub mod test_batch;
#[cfg(feature = "measure")]
pub mod timing;
#[cfg(feature = "measure")]
pub mod workloads;
