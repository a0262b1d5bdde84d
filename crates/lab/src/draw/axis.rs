//! Logarithmic axes of charts, and labels for their ticks.

/// A logarithmic axis.
#[derive(Clone, Copy, Debug)]
pub struct Log {
    from: f64,
    to: f64,
    places: [f64; 2],
}

impl Log {
    /// Creates an axis that maps values from `from` to `to`, both positive, to positions between
    /// the two `places`.
    pub fn new(from: f64, to: f64, places: [f64; 2]) -> Self {
        Self { from: from.log10(), to: to.log10(), places }
    }

    /// Returns the position of a value on the axis.
    pub fn at(&self, x: f64) -> f64 {
        let share = (x.log10() - self.from) / (self.to - self.from);
        self.places[0] + share * (self.places[1] - self.places[0])
    }

    /// Returns the exponents of the powers of ten on the axis that are multiples of `every`.
    pub fn decades(&self, every: i32) -> Vec<i32> {
        let (lo, hi) = (self.from.min(self.to), self.from.max(self.to));
        let (lo, hi) = ((lo - 1e-9).ceil() as i32, (hi + 1e-9).floor() as i32);
        (lo..=hi).filter(|k| k.rem_euclid(every) == 0).collect()
    }
}

/// Returns a short label for a power of ten.
pub fn power(k: i32) -> String {
    match k {
        -2 => "0.01".into(),
        -1 => "0.1".into(),
        0 => "1".into(),
        1 => "10".into(),
        2 => "100".into(),
        3 => "1,000".into(),
        k => format!("10{}", superscript(k)),
    }
}

/// Formats an integer in superscript digits.
pub(super) fn superscript(k: i32) -> String {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let sign = if k < 0 { "⁻" } else { "" };
    let number = k.unsigned_abs().to_string();
    let raised = number.bytes().map(|b| digits[usize::from(b - b'0')]);
    sign.chars().chain(raised).collect()
}
