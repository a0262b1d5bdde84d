//! A bounding volume hierarchy whose answers equal a plain loop's, bit for bit.
//!
//! One walk in four forms: a ray a call (`single`), streams of rays that have little in common
//! (`stream`), bundles of coherent rays (`bundle`), beams of parallel ones (`beam`). `query` chooses.

mod across;
mod answers;
mod beam;
mod build;
mod bundle;
mod bvh;
mod given;
mod memory;
mod morton;
mod nearest;
mod pairs;
mod place;
mod prefetch;
mod query;
mod refit;
mod save;
mod select;
mod single;
mod solid;
mod stop;
mod stream;
#[cfg(test)]
mod test_numbers;
mod threads;
mod tree;

pub use intertri;

pub use build::BuildError;
pub use bvh::Bvh;
pub use given::{Given, ModeFor};
pub use memory::OutOfMemory;
pub use nearest::ClosestPoint;
pub use place::Place;
#[cfg(feature = "fixed")]
pub use query::FixedBvh;
pub use query::{HitLists, Intersector, Only};
pub use refit::{Refit, RefitError};
pub use save::{LoadError, SAVED_MAGIC};
pub use select::{Faces, Select};
pub use solid::{Solid, SolidError};

/// What the tests and the Python package build on. It changes without notice.
#[doc(hidden)]
pub mod internal {
    pub use crate::save::{checksum, seal};
    pub use crate::stop::{StopToken, Stopped};
    pub use crate::threads::on_this_thread;
}
