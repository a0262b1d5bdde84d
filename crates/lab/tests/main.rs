//! Tests the table of methods through the public interface.
//!
//! The methods are compiled for every level and layout, which takes a minute. Tests that use the
//! table are therefore here, where they link the compiled library, and not among the unit tests,
//! which would compile the table again.

mod accuracy;
mod batches;
mod by_hand;
mod cases;
mod charts;
mod metrics;
mod offsets;
mod onsets;
mod timing;
