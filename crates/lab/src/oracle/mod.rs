//! The exact oracle: where the line of a ray meets a triangle, for f32 or f64 inputs, without rounding.
//!
//! With `A, B, C` the corners relative to the origin and `d` the direction,
//!
//! ```text
//!   U = d · (B × C)                    C                   the line passes every side on the same
//!   V = d · (C × A)                   /  \                 hand: inside. A value of 0: on that
//!   W = d · (A × B)              V=0 /  +  \  U=0          side. Two of them: at the corner
//!   t = A · (B × C) / (U + V + W)   A ------ B             between.
//!                                      W=0
//! ```
//!
//! Only the signs of these values and one quotient are needed. [`answer()`] computes them with adaptive
//! predicates, [`rational`] with another formula in rationals; the two are tested against each other on every
//! family.

mod adaptive;
mod exact;
mod oracle_answer;
pub mod rational;
mod t_error;

pub use adaptive::answer;
pub use exact::{Rational, exact_t, is_finite};
pub use oracle_answer::{LinePosition, OracleAnswer};
pub use t_error::{t_error, t_error_ulps, t_error_ulps_f32};

#[cfg(test)]
mod tests;
