//! Known properties of the methods, and known failures.

mod batches;
mod by_hand;
mod cases;
