//! Parses numbers on the command line, and formats numbers in answers.
//!
//! This file depends on nothing else in the program, because the fuzzers include it.

use std::fmt;
use std::str::FromStr;

use intertri::Threshold;
use intertri_scene::check_size;

/// Parses three numbers separated by commas, in f32 or f64.
pub(crate) fn point<N: FromStr>(text: &str) -> Result<[N; 3], String> {
    let numbers: Option<Vec<N>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    numbers
        .and_then(|numbers| <[N; 3]>::try_from(numbers).ok())
        .ok_or_else(|| "give three numbers separated by commas, such as 1,2.5,-3".to_owned())
}

/// Parses a size such as 1024x768.
pub(crate) fn size(text: &str) -> Result<(u32, u32), String> {
    let numbers = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let (width, height) = numbers.ok_or("give width and height, such as 1024x768")?;
    check_size(width, height).map_err(|error| error.to_string())?;
    Ok((width, height))
}

/// Parses a threshold.
pub(crate) fn threshold(text: &str) -> Result<Threshold, String> {
    let number = text.parse().map_err(|_| "not a number".to_owned())?;
    Threshold::new(number).map_err(|error| error.to_string())
}

/// Formats the shortest decimal that reads back to the same bits.
pub(crate) struct Decimal(pub(crate) f64);

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if (1e-5..1e16).contains(&size) || size == 0.0 || !size.is_finite() {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_short_and_read_back_to_the_same_bits() {
        for (number, text) in [
            (0.0, "0"),
            (-0.0, "-0"),
            (1.0, "1"),
            (0.1, "0.1"),
            (1e-5, "0.00001"),
            (1.5e-7, "1.5e-7"),
            (5e-324, "5e-324"),
            (f64::MAX, "1.7976931348623157e308"),
            (1.0f64.next_up(), "1.0000000000000002"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(Decimal(number).to_string(), text);
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), number.to_bits());
        }
    }
}
