//! Pairs of every kind in f64.

use crate::cases::{KINDS, case};
use crate::compare::Cases;

const CASES: Cases<f64> = Cases { kinds: KINDS, case };

#[test]
fn every_tier_agrees_with_rationals() {
    CASES.agree(12_000);
}

/// By hand: `cargo test --release -p intertri-tests --test f64 -- --ignored --nocapture`.
#[test]
#[ignore = "takes hours"]
fn a_hundred_million_pairs_agree_with_rationals() {
    CASES.agree_for_hours();
}
