//! Reads the numbers that the page sends.

/// Reads f64 numbers in order.
#[derive(Clone, Debug)]
pub(crate) struct Numbers<'a>(std::slice::Iter<'a, f64>);

impl<'a> Numbers<'a> {
    pub(crate) fn new(numbers: &'a [f64]) -> Self {
        Self(numbers.iter())
    }

    /// The next number; `None` at the end, or if it is not finite.
    pub(crate) fn next(&mut self) -> Option<f64> {
        self.0.next().copied().filter(|x| x.is_finite())
    }

    pub(crate) fn vector(&mut self) -> Option<[f64; 3]> {
        Some([self.next()?, self.next()?, self.next()?])
    }

    /// An integer from 1 to `limit`.
    pub(crate) fn count(&mut self, limit: usize) -> Option<usize> {
        let x = self.next()?;
        (x.fract() == 0.0 && x >= 1.0 && x <= limit as f64).then_some(x as usize)
    }
}

/// `a + x u + y v`, component by component.
pub(crate) fn along(a: [f64; 3], [u, v]: [[f64; 3]; 2], x: f64, y: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + x * u[k] + y * v[k])
}

/// Rounded to f32.
pub(crate) fn single(p: [f64; 3]) -> [f32; 3] {
    p.map(|x| x as f32)
}

/// As f64.
pub(crate) fn double(p: [f32; 3]) -> [f64; 3] {
    p.map(f64::from)
}
