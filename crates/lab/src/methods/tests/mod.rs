//! What the methods are known to do, and where they are known to fail.

mod batches;
mod by_hand;
mod cases;
