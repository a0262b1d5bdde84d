//! Tests the methods' known properties and known failures.

mod batches;
mod by_hand;
mod cases;
