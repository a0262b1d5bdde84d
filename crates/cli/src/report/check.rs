//! Two engines, one picture: where do they disagree, and may they?
//!
//! - Engines that trace must agree in every bit.
//! - The z-buffer and the shadow volumes see the scene along lines that are a rounding apart. Where one
//!   of them takes part, a pixel may differ only where an edge, a tie of depths or the surface of a
//!   volume passes within that rounding: the rule of `docs/raster.md`, decided for each pixel.
//! - The engine `fixed` sees a scene that was snapped to its grid, and any pixel may differ by that.

use intertri_raster::{Verdict, differences, shadow_differences};
use intertri_scene::{Image, difference};

use crate::engine::frame::Frame;
use crate::engine::raster::Raster;
use crate::error::Result;

/// The colours of pixels that differ: may, and may not.
const EXCUSED: [u8; 3] = [64, 176, 255];
const UNEXCUSED: [u8; 3] = [255, 32, 32];

/// How two frames differ.
pub(crate) struct Difference {
    /// Of what each pixel shows.
    pub(crate) hits: Vec<Verdict>,
    /// Of whether that is lit.
    pub(crate) shadows: Vec<Verdict>,
}

impl Difference {
    /// Compares frames of tracing engines: each must have the other's triangle, bits of t, and shadow.
    pub(crate) fn bits(a: &Frame, b: &Frame) -> Self {
        let verdict = |same| if same { Verdict::Same } else { Verdict::Unexcused };
        let hits = a.hits.iter().zip(&b.hits);
        let shadows = a.lit.iter().zip(&b.lit);
        Self {
            hits: hits
                .map(|(a, b)| verdict(a.triangle == b.triangle && a.t.to_bits() == b.t.to_bits()))
                .collect(),
            shadows: shadows.map(|(a, b)| verdict(a == b)).collect(),
        }
    }

    /// Compares frames of which the z-buffer or the shadow volumes made one.
    pub(crate) fn by_rule(raster: &Raster<'_>, a: &Frame, b: &Frame) -> Result<Self> {
        let view = raster.view()?;
        let hits = differences(&view, raster.triangles, &a.hits, &b.hits);
        // Where the two see different triangles, there is no shadow to compare.
        let same = |i: usize| a.hits[i].triangle == b.hits[i].triangle;
        let other: Vec<bool> =
            (0..hits.len()).map(|i| if same(i) { b.lit[i] } else { a.lit[i] }).collect();
        let shadows = shadow_differences(&view, &a.hits, &raster.volume()?, &a.lit, &other);
        Ok(Self { hits, shadows })
    }

    /// Compares frames of which one is of the snapped scene: a pixel may show another triangle, or be
    /// lit differently where the triangle is the same. The bits of t differ anyway and are not compared.
    pub(crate) fn snapped(a: &Frame, b: &Frame) -> Self {
        let verdict = |same| if same { Verdict::Same } else { Verdict::Excused };
        let hits: Vec<Verdict> =
            a.hits.iter().zip(&b.hits).map(|(a, b)| verdict(a.triangle == b.triangle)).collect();
        let lit = a.lit.iter().zip(&b.lit).zip(&hits);
        let shadows = lit.map(|((a, b), &hit)| verdict(a == b || hit != Verdict::Same)).collect();
        Self { hits, shadows }
    }

    /// Each pixel's worse verdict.
    fn pixels(&self) -> impl Iterator<Item = Verdict> {
        let worse = |(&hit, &shadow)| match (hit, shadow) {
            (Verdict::Unexcused, _) | (_, Verdict::Unexcused) => Verdict::Unexcused,
            (Verdict::Excused, _) | (_, Verdict::Excused) => Verdict::Excused,
            (Verdict::Same, Verdict::Same) => Verdict::Same,
        };
        self.hits.iter().zip(&self.shadows).map(worse)
    }

    /// How many pixels differ at all.
    pub(crate) fn count(&self) -> Count {
        Count::of(self.pixels())
    }

    /// `image` darkened, and every pixel that differs in the colour of its verdict.
    pub(crate) fn picture(&self, image: &Image) -> Image {
        let colour = |verdict| match verdict {
            Verdict::Same => None,
            Verdict::Excused => Some(EXCUSED),
            Verdict::Unexcused => Some(UNEXCUSED),
        };
        difference(image, &self.pixels().map(colour).collect::<Vec<_>>())
    }
}

/// How many differences there are, and how many of them are excused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Count {
    pub(crate) differ: usize,
    pub(crate) excused: usize,
}

impl Count {
    pub(crate) fn of(verdicts: impl IntoIterator<Item = Verdict>) -> Self {
        let mut count = Self { differ: 0, excused: 0 };
        for verdict in verdicts {
            count.differ += usize::from(verdict != Verdict::Same);
            count.excused += usize::from(verdict == Verdict::Excused);
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use intertri::{Counts, Hit};

    fn frame() -> Frame {
        Frame {
            hits: vec![Hit::MISS, Hit { t: 2.0, u: 0.0, v: 0.0, triangle: 7, geometry: 0 }],
            lit: vec![true, false],
            shadow_rays: 1,
            counts: Counts::default(),
            trace_seconds: 0.0,
            shadow_seconds: 0.0,
        }
    }

    #[test]
    fn on_a_grid_another_triangle_or_shadow_counts_and_may_be() {
        let (a, mut b) = (frame(), frame());
        b.hits[1].t = 2.5;
        assert_eq!(Difference::snapped(&a, &b).count(), Count { differ: 0, excused: 0 });
        b.lit[1] = true;
        let differs = Difference::snapped(&a, &b);
        assert_eq!(differs.shadows, [Verdict::Same, Verdict::Excused]);
        assert_eq!(differs.count(), Count { differ: 1, excused: 1 });
        // Another triangle has another shadow.
        b.hits[1].triangle = 3;
        let differs = Difference::snapped(&a, &b);
        assert_eq!(differs.hits, [Verdict::Same, Verdict::Excused]);
        assert_eq!(differs.shadows, [Verdict::Same; 2]);
    }

    #[test]
    fn a_single_bit_of_t_a_triangle_and_a_shadow_count() {
        let same = Difference::bits(&frame(), &frame());
        assert_eq!(same.count(), Count { differ: 0, excused: 0 });

        let changes: [fn(&mut Frame); 3] = [
            |frame| frame.hits[1].t = 2.0f64.next_up(),
            |frame| frame.hits[1].triangle = 6,
            |frame| frame.lit[1] = true,
        ];
        for (i, change) in changes.into_iter().enumerate() {
            let mut other = frame();
            change(&mut other);
            let difference = Difference::bits(&frame(), &other);
            let wrong = [Verdict::Same, Verdict::Unexcused];
            assert_eq!((difference.hits == wrong, difference.shadows == wrong), (i < 2, i == 2));
            assert_eq!(difference.count(), Count { differ: 1, excused: 0 });
            let mut image = Image::new(1, 2).unwrap();
            image.pixels_mut().fill([255; 3]);
            assert_eq!(difference.picture(&image).pixels()[1], UNEXCUSED);
        }
    }
}
