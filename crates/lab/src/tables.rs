//! Formats numbers as text and rows as CSV.

use serde::Serialize;

/// Formats rows as CSV with a header.
///
/// # Errors
/// Returns an error if a row cannot be written as text fields.
pub fn csv<T: Serialize>(rows: &[T]) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    let bytes = writer.into_inner().map_err(csv::IntoInnerError::into_error)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Formats a number with its digits in groups of three.
///
/// ```
/// use intertri_lab::tables::grouped;
/// assert_eq!([0, 999, 123_456, 1_234_567].map(grouped), ["0", "999", "123,456", "1,234,567"]);
/// ```
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Formats the number of errors found in some trials. If none were found, adds the highest error
/// rate that is consistent with that at 95 % confidence.
///
/// ```
/// use intertri_lab::tables::count;
/// assert_eq!(count(3, 1000), "3 of 1,000");
/// assert_eq!(count(0, 1000), "0 of 1,000 (< 3e-3 at 95 %)");
/// assert_eq!(count(0, 0), "0 of 0");
/// ```
pub fn count(errors: u64, trials: u64) -> String {
    let text = format!("{} of {}", grouped(errors), grouped(trials));
    if errors == 0 && trials > 0 {
        format!("{text} (< {:.0e} at 95 %)", 3.0 / trials as f64)
    } else {
        text
    }
}
