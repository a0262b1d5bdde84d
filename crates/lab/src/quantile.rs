//! Computes quantiles of a list of numbers.

/// Returns the value below which the given share of the numbers falls, or NaN if the list is empty.
/// Sorts the list in place.
pub(crate) fn quantile(numbers: &mut [f64], share: f64) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let last = numbers.len().saturating_sub(1);
    numbers.get((last as f64 * share).round() as usize).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::quantile;

    #[test]
    fn quantiles() {
        let mut numbers = [3.0, 1.0, 2.0, 5.0, 4.0];
        assert_eq!(quantile(&mut numbers, 0.5), 3.0);
        assert_eq!(quantile(&mut numbers, 1.0), 5.0);
        assert!(quantile(&mut [], 0.5).is_nan());
    }
}
