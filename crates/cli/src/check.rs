//! Two engines, one picture: where do they disagree?

use crate::frame::Frame;

/// How two frames differ.
pub(crate) struct Difference {
    /// Pixels with another triangle, or another t by a single bit.
    pub(crate) hits: usize,
    /// Pixels that are lit in one frame only.
    pub(crate) shadows: usize,
    /// One entry a pixel: either.
    pub(crate) pixels: Vec<bool>,
}

impl Difference {
    /// Compares the frames of one scene at one size.
    pub(crate) fn between(a: &Frame, b: &Frame) -> Self {
        let mut difference = Self { hits: 0, shadows: 0, pixels: vec![false; a.hits.len()] };
        for (i, pixel) in difference.pixels.iter_mut().enumerate() {
            let (p, q) = (&a.hits[i], &b.hits[i]);
            let hits = p.triangle != q.triangle || p.t.to_bits() != q.t.to_bits();
            let shadows = a.lit[i] != b.lit[i];
            difference.hits += usize::from(hits);
            difference.shadows += usize::from(shadows);
            *pixel = hits || shadows;
        }
        difference
    }

    /// How many pixels differ at all.
    pub(crate) fn count(&self) -> usize {
        self.pixels.iter().filter(|&&differs| differs).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use intertri::{Counts, Hit};

    fn frame() -> Frame {
        Frame {
            hits: vec![Hit::MISS, Hit { t: 2.0, u: 0.0, v: 0.0, triangle: 7 }],
            lit: vec![true, false],
            shadow_rays: 1,
            counts: Counts::default(),
            trace: 0.0,
            shadow: 0.0,
        }
    }

    #[test]
    fn a_single_bit_of_t_a_triangle_and_a_shadow_count() {
        let same = Difference::between(&frame(), &frame());
        assert_eq!((same.hits, same.shadows, same.count()), (0, 0, 0));

        let changes: [fn(&mut Frame); 3] = [
            |frame| frame.hits[1].t = 2.0f64.next_up(),
            |frame| frame.hits[1].triangle = 6,
            |frame| frame.lit[1] = true,
        ];
        for (i, change) in changes.into_iter().enumerate() {
            let mut other = frame();
            change(&mut other);
            let difference = Difference::between(&frame(), &other);
            let expected = if i == 2 { (0, 1) } else { (1, 0) };
            assert_eq!((difference.hits, difference.shadows), expected);
            assert_eq!(difference.pixels, [false, true]);
        }
    }
}
