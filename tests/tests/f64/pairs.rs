//! Compares the intersections of f64 rays and triangles with rational arithmetic.

use super::cases::{KINDS, case};
use crate::common::compare::Cases;

const CASES: Cases<f64> = Cases { kinds: KINDS, case };

#[test]
fn every_tier_agrees_with_rationals() {
    CASES.agree(12_000);
}

/// Run this test by hand:
/// `cargo test --release -p intertri-tests f64::pairs -- --ignored --nocapture`.
#[test]
#[ignore = "takes hours"]
fn a_hundred_million_pairs_agree_with_rationals() {
    CASES.agree_for_hours();
}
