//! The result of a scan: counts, and a sample of pixels with their exact answers.

/// The result of a scan.
#[derive(Clone, Debug)]
pub struct ScanResult {
    /// For each arithmetic, the number of doubtful pixels.
    pub doubtful: Vec<u64>,
    /// For each arithmetic, the number of doubtful pixels in the sample.
    pub doubtful_in_sample: Vec<u64>,
    /// For each arithmetic, a bound on how far the visible surface moves, in pixels.
    pub shift: Vec<f64>,
    /// The sample: pixels at a fixed stride, row by row.
    pub sample: Vec<SampledPixel>,
}

/// The exact answer and the f32 answer at a sampled pixel.
#[derive(Clone, Debug)]
pub struct SampledPixel {
    /// The column and row of the pixel.
    pub pixel: (u32, u32),
    /// The closest triangle, or several if the ray hits them at exactly the same t; empty for a
    /// miss.
    pub triangles: Vec<u32>,
    /// The triangle that is closest according to the f32 test, if any.
    pub single: Option<u32>,
}

impl SampledPixel {
    /// Returns whether an answer is correct: one of the triangles in the exact answer, or `None`
    /// for a miss.
    pub fn allows(&self, triangle: Option<u32>) -> bool {
        match triangle {
            None => self.triangles.is_empty(),
            Some(triangle) => self.triangles.contains(&triangle),
        }
    }
}
