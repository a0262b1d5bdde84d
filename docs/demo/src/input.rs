//! Reads and converts the input numbers that the page sends.

/// Reads f64 numbers one at a time, in order.
#[derive(Clone, Debug)]
pub(crate) struct Numbers<'a>(std::slice::Iter<'a, f64>);

impl<'a> Numbers<'a> {
    pub(crate) fn new(numbers: &'a [f64]) -> Self {
        Self(numbers.iter())
    }

    /// Returns the next number, or `None` at the end or if the number is not finite.
    pub(crate) fn next(&mut self) -> Option<f64> {
        self.0.next().copied().filter(|x| x.is_finite())
    }

    pub(crate) fn vector(&mut self) -> Option<[f64; 3]> {
        Some([self.next()?, self.next()?, self.next()?])
    }

    /// Returns the next number if it is an integer from 1 to `limit`.
    pub(crate) fn count(&mut self, limit: usize) -> Option<usize> {
        let x = self.next()?;
        (x.fract() == 0.0 && x >= 1.0 && x <= limit as f64).then_some(x as usize)
    }
}

/// Computes `a + x u + y v`.
pub(crate) fn along(a: [f64; 3], [u, v]: [[f64; 3]; 2], x: f64, y: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + x * u[k] + y * v[k])
}

/// Rounds a point to f32.
pub(crate) fn single(p: [f64; 3]) -> [f32; 3] {
    p.map(|x| x as f32)
}

/// Converts a point to f64.
pub(crate) fn double(p: [f32; 3]) -> [f64; 3] {
    p.map(f64::from)
}
