//! The differential tests, compiled into a single program, so that they are linked only once and
//! run in parallel.

mod bound;
mod boxes;
mod bundles;
mod common;
mod corpus;
mod crossings;
mod exact;
mod extremes;
mod f64;
mod fixed;
mod fixtures;
mod golden;
mod hierarchy;
mod indexed;
mod kernel;
mod lookup;
mod media;
mod nearest;
mod parallel;
mod projection;
mod properties;
mod reversed_shadow;
mod select;
mod spawn;
mod threads;
mod visible;
mod winding;
