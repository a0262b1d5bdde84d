//! Phrases that several reports share.

use std::fmt;
use std::path::Path;

use crate::engine::fixed::GridReport;

/// Returns the path to the model, or a name for the built-in scene.
pub(crate) fn model(path: Option<&Path>) -> String {
    path.map_or("the built-in scene".to_owned(), |path| path.display().to_string())
}

/// Formats the rate at which rays were traced.
pub(crate) fn rate(rays: u64, seconds: f64) -> String {
    if seconds > 0.0 {
        format!("{:.2} million a second", rays as f64 / seconds * 1e-6)
    } else {
        "no time taken".to_owned()
    }
}

/// Formats a number with three significant digits.
pub(crate) fn significant(number: f64) -> String {
    let place = if number > 0.0 { number.log10().floor() } else { 0.0 };
    let decimals = (2.0 - place).clamp(0.0, 12.0) as usize;
    format!("{number:.decimals$}")
}

/// Writes a line that describes the grid, if there is one.
pub(crate) fn write_grid(f: &mut fmt::Formatter<'_>, grid: Option<GridReport>) -> fmt::Result {
    let Some(GridReport { bits, direction_bits, step, moved, strays }) = grid else {
        return Ok(());
    };
    writeln!(
        f,
        "{bits:>12} grid bits, {direction_bits} direction bits: a step is {step:.1e}, points \
         moved by up to {moved:.1e}, rays deviate by less than {strays:.1e}"
    )
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn small_numbers_have_digits_and_large_ones_no_more_than_that() {
        let numbers = [0.000_123_4, 0.0567, 1.0, 7.654, 58.01, 123.4, 98_765.4, 0.0];
        let texts = ["0.000123", "0.0567", "1.00", "7.65", "58.0", "123", "98765", "0.00"];
        assert_eq!(numbers.map(significant), texts);
    }
}
