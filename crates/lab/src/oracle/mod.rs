//! The exact oracle, which determines without rounding where the line of a ray meets a triangle.
//! The inputs are f32 or f64.
//!
//! Let `A, B, C` be the corners relative to the origin and `d` the direction. Then
//!
//! ```text
//!   U = d · (B × C)                    C                   All of U, V, W have the same sign: the
//!   V = d · (C × A)                   /  \                 line passes inside. One is 0: through
//!   W = d · (A × B)              V=0 /  +  \  U=0          that side. Two are 0: through the
//!   t = A · (B × C) / (U + V + W)   A ------ B             corner that they share.
//!                                      W=0
//! ```
//!
//! Only the signs of these values and one quotient are needed. [`answer()`] computes them with
//! adaptive predicates, and [`rational`] with another formula in rational arithmetic. The two
//! implementations are tested against each other on every family.

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
