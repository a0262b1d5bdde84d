//! Measures the error of a computed `t`.

use super::exact::Rational;

/// Returns the error of a computed `t` relative to the exact `t`, or `|t|` if the exact `t` is 0.
/// The error is infinite for an infinite `t` and NaN for NaN.
pub fn t_error(t: f64, exact: &Rational) -> f64 {
    let Ok(t) = Rational::try_from(t) else { return t.abs() };
    let off = (t - exact).to_f64().value().abs();
    let size = exact.to_f64().value().abs();
    if size == 0.0 { off } else { off / size }
}

/// Returns the error of a computed `t` in ulps (units in the last place) of the f64 nearest to the
/// exact `t`. The error is infinite for an infinite `t` and NaN for NaN. The exact `t` of f32
/// inputs is always in f64's normal range.
///
/// ```
/// use intertri_lab::oracle::{Rational, t_error_ulps};
/// let third = Rational::from(1) / Rational::from(3);
/// assert!(t_error_ulps(1.0 / 3.0, &third) < 0.5);
/// assert!((t_error_ulps((1.0_f64 / 3.0).next_up(), &third) - 1.0).abs() < 0.5);
/// ```
pub fn t_error_ulps(t: f64, exact: &Rational) -> f64 {
    let near = exact.to_f64().value().abs();
    in_steps(t, exact, near.next_up() - near)
}

/// Returns the error in ulps of the f32 nearest to the exact `t`, or infinity if that f32 is
/// infinite.
pub fn t_error_ulps_f32(t: f32, exact: &Rational) -> f64 {
    let near = (exact.to_f64().value() as f32).abs();
    if near.is_infinite() {
        return if t.is_nan() { f64::NAN } else { f64::INFINITY };
    }
    // The successor of the largest f32 is infinity, so use the step below it.
    let step = if near == f32::MAX { near - near.next_down() } else { near.next_up() - near };
    in_steps(t.into(), exact, step.into())
}

fn in_steps(t: f64, exact: &Rational, step: f64) -> f64 {
    let Ok(t) = Rational::try_from(t) else { return t.abs() };
    (t - exact).to_f64().value().abs() / step
}
