//! Compares the images that two engines draw: where they differ, and which differences are allowed.
//!
//! - Engines that follow document A must agree on every bit, and so must the exact engines.
//! - Between these two kinds, t may differ in its last bits. If the triangle or the shadow differs,
//!   the lab crate's oracle must confirm `exact`.
//! - The z-buffer and the shadow volumes see the scene along lines that differ by rounding. If
//!   either is involved, a pixel may differ only if an edge, a tie in depth or the surface of a
//!   volume passes within this rounding error of it, by the rule in `docs/raster.md`. Exact shadow
//!   rays extend to the surface, whereas volumes end a ten-thousandth of the distance before it; in
//!   that part, the oracle decides.
//! - The `fixed` engine sees a snapped scene, which may change any pixel.

use intertri::{Hit, Triangle};
use intertri_raster::{Verdict, differences, shadow_differences};
use intertri_scene::{Image, Scene, difference, hit_point};
use rayon::prelude::*;

use crate::engine::frame::Frame;
use crate::engine::oracle;
use crate::engine::raster::Raster;
use crate::error::Result;

/// The colour of differing pixels that are excused.
const EXCUSED: [u8; 3] = [64, 176, 255];
/// The colour of differing pixels that are not excused.
const UNEXCUSED: [u8; 3] = [255, 32, 32];

/// The differences between two frames.
pub(crate) struct Difference {
    /// The verdict on the hit of each pixel.
    pub(crate) hits: Vec<Verdict>,
    /// The verdict on the shadow of each pixel.
    pub(crate) shadows: Vec<Verdict>,
}

impl Difference {
    /// Compares frames of engines of the same kind: each pixel must have the same triangle, the
    /// same bits of t, u and v, and the same shadow.
    pub(crate) fn bits(a: &Frame, b: &Frame) -> Self {
        let verdict = |same| if same { Verdict::Same } else { Verdict::Unexcused };
        let hits = a.hits.iter().zip(&b.hits);
        let shadows = a.lit.iter().zip(&b.lit);
        Self {
            hits: hits.map(|(a, b)| verdict(bits(a) == bits(b))).collect(),
            shadows: shadows.map(|(a, b)| verdict(a == b)).collect(),
        }
    }

    /// Compares an exact frame with one that follows document A. If the triangle or the shadow of a
    /// pixel differs, the oracle must confirm the exact frame.
    pub(crate) fn settled(raster: &Raster<'_>, exact: &Frame, other: &Frame) -> Self {
        let (triangles, scene, (width, height)) = (raster.triangles, raster.scene, raster.size);
        let settle = |right| if right { Verdict::Excused } else { Verdict::Unexcused };
        let pixel = |i: usize| {
            let (x, y) = (i as u32 % width, i as u32 / width);
            (scene.camera.ray(x, y, width, height), &exact.hits[i])
        };
        let hits = (0..exact.hits.len()).into_par_iter().map(|i| {
            let (ray, hit) = pixel(i);
            if hit.triangle == other.hits[i].triangle {
                return Verdict::Same;
            }
            settle(oracle::closest(triangles, &ray).triangle == hit.triangle)
        });
        let shadows = (0..exact.lit.len()).into_par_iter().map(|i| {
            let (_, hit) = pixel(i);
            // A pixel without a hit has no shadow to compare.
            if exact.lit[i] == other.lit[i] || !hit.is_hit() {
                return Verdict::Same;
            }
            let triangle = &triangles[hit.triangle as usize];
            let shadow_ray = scene.light.shadow_ray_of(hit, triangle);
            settle(oracle::any(triangles, &shadow_ray) != exact.lit[i])
        });
        Self { hits: hits.collect(), shadows: shadows.collect() }
    }

    /// Compares two frames, at least one of which was drawn with the z-buffer or the shadow
    /// volumes.
    pub(crate) fn by_rule(raster: &Raster<'_>, a: &Frame, b: &Frame) -> Result<Self> {
        let view = raster.view()?;
        let hits = differences(&view, raster.triangles, &a.hits, &b.hits);
        // If the frames show different triangles, there is no shadow to compare.
        let same = |i: usize| a.hits[i].triangle == b.hits[i].triangle;
        let other: Vec<bool> =
            (0..hits.len()).map(|i| if same(i) { b.lit[i] } else { a.lit[i] }).collect();
        let mut shadows = shadow_differences(&view, &a.hits, &raster.volume()?, &a.lit, &other);

        // Exact rays extend to the surface, whereas volumes omit the last part of the segment.
        let (triangles, scene, size) = (raster.triangles, raster.scene, raster.size);
        shadows.par_iter_mut().zip(&a.hits).enumerate().for_each(|(i, (verdict, hit))| {
            if *verdict == Verdict::Unexcused && left_out(triangles, scene, size, i, hit) {
                *verdict = Verdict::Excused;
            }
        });
        Ok(Self { hits, shadows })
    }

    /// Compares two frames, one of which shows the snapped scene. A pixel may show another
    /// triangle, or be lit differently on the same triangle. Snapping usually changes t, so its
    /// bits are not compared.
    pub(crate) fn snapped(a: &Frame, b: &Frame) -> Self {
        let verdict = |same| if same { Verdict::Same } else { Verdict::Excused };
        let hits: Vec<Verdict> =
            a.hits.iter().zip(&b.hits).map(|(a, b)| verdict(a.triangle == b.triangle)).collect();
        let lit = a.lit.iter().zip(&b.lit).zip(&hits);
        let shadows = lit.map(|((a, b), &hit)| verdict(a == b || hit != Verdict::Same)).collect();
        Self { hits, shadows }
    }

    /// Returns the worse of the two verdicts on each pixel.
    fn pixels(&self) -> impl Iterator<Item = Verdict> {
        let worse = |(&hit, &shadow)| match (hit, shadow) {
            (Verdict::Unexcused, _) | (_, Verdict::Unexcused) => Verdict::Unexcused,
            (Verdict::Excused, _) | (_, Verdict::Excused) => Verdict::Excused,
            (Verdict::Same, Verdict::Same) => Verdict::Same,
        };
        self.hits.iter().zip(&self.shadows).map(worse)
    }

    /// Counts the pixels that differ.
    pub(crate) fn count(&self) -> Count {
        Count::of(self.pixels())
    }

    /// Returns a darkened copy of `image`, with every differing pixel in the colour of its verdict.
    pub(crate) fn picture(&self, image: &Image) -> Image {
        let colour = |verdict| match verdict {
            Verdict::Same => None,
            Verdict::Excused => Some(EXCUSED),
            Verdict::Unexcused => Some(UNEXCUSED),
        };
        difference(image, &self.pixels().map(colour).collect::<Vec<_>>())
    }
}

/// Returns whether all occluders between the light and a pixel's point are in the last part of the
/// segment, which [`Light::REACH`](intertri_scene::Light::REACH) omits.
fn left_out(
    triangles: &[Triangle],
    scene: &Scene,
    (width, height): (u32, u32),
    i: usize,
    hit: &Hit,
) -> bool {
    if !hit.is_hit() {
        return false;
    }
    let ray = scene.camera.ray(i as u32 % width, i as u32 / width, width, height);
    let whole = scene.light.shadow_ray_of(hit, &triangles[hit.triangle as usize]);
    let from_the_light = scene.light.shadow_ray(hit_point(&ray, hit));
    oracle::any(triangles, &whole) && !oracle::any(triangles, &from_the_light)
}

/// Returns all values of a hit as bits, for comparison.
fn bits(hit: &Hit) -> (u32, [u64; 3]) {
    (hit.triangle, [hit.t, hit.u, hit.v].map(f64::to_bits))
}

/// The number of differences, and how many of them are excused.
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
    use crate::engine::engines::Engines;
    use crate::engine::frame::Shadows;
    use crate::engine::name::EngineName;
    use intertri::{Counts, Threshold};

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
        // A pixel with another triangle has no shadow to compare.
        b.hits[1].triangle = 3;
        let differs = Difference::snapped(&a, &b);
        assert_eq!(differs.hits, [Verdict::Same, Verdict::Excused]);
        assert_eq!(differs.shadows, [Verdict::Same; 2]);
    }

    #[test]
    fn only_what_the_oracle_says_settles_a_difference() {
        let (scene, size) = (Scene::built_in(), (16, 12));
        let triangles = scene.mesh.to_triangles();
        let raster = Raster::new(&scene, &triangles, size, Threshold::ZERO);
        let mut engines = Engines::new(&triangles, Threshold::ZERO);
        let mut draw =
            || Frame::draw(&scene, &raster, &mut engines, EngineName::Exact, Shadows::Rays);
        let right = draw().unwrap();
        let none = Count { differ: 0, excused: 0 };
        assert_eq!(Difference::settled(&raster, &right, &right).count(), none);

        let (dark, seen, missed) = (
            right.lit.iter().position(|lit| !lit).unwrap(),
            right.hits.iter().zip(&right.lit).position(|(hit, lit)| hit.is_hit() && *lit).unwrap(),
            right.hits.iter().position(|hit| !hit.is_hit()).unwrap(),
        );
        let changes: [&dyn Fn(&mut Frame); 5] = [
            &|frame| frame.hits[seen].triangle ^= 1,
            &|frame| frame.hits[seen] = Hit::MISS,
            &|frame| frame.hits[missed] = frame.hits[seen],
            &|frame| frame.lit[dark] = true,
            &|frame| frame.lit[seen] = false,
        ];
        for (i, change) in changes.into_iter().enumerate() {
            let mut wrong = draw().unwrap();
            change(&mut wrong);
            let excused = Difference::settled(&raster, &right, &wrong).count();
            assert_eq!(excused, Count { differ: 1, excused: 1 }, "{i}");
            let unexcused = Difference::settled(&raster, &wrong, &right).count();
            assert_eq!(unexcused, Count { differ: 1, excused: 0 }, "{i}");
        }
        // The bits of t are not compared.
        let mut near = draw().unwrap();
        near.hits[seen].t = near.hits[seen].t.next_up();
        assert_eq!(Difference::settled(&raster, &right, &near).count(), none);
    }

    #[test]
    fn a_single_bit_a_triangle_and_a_shadow_count() {
        let same = Difference::bits(&frame(), &frame());
        assert_eq!(same.count(), Count { differ: 0, excused: 0 });

        let changes: [fn(&mut Frame); 4] = [
            |frame| frame.hits[1].t = 2.0f64.next_up(),
            |frame| frame.hits[1].v = f64::from_bits(1),
            |frame| frame.hits[1].triangle = 6,
            |frame| frame.lit[1] = true,
        ];
        for (i, change) in changes.into_iter().enumerate() {
            let mut other = frame();
            change(&mut other);
            let difference = Difference::bits(&frame(), &other);
            let wrong = [Verdict::Same, Verdict::Unexcused];
            assert_eq!((difference.hits == wrong, difference.shadows == wrong), (i < 3, i == 3));
            assert_eq!(difference.count(), Count { differ: 1, excused: 0 });
            let mut image = Image::new(1, 2).unwrap();
            image.pixels_mut().fill([255; 3]);
            assert_eq!(difference.picture(&image).pixels()[1], UNEXCUSED);
        }
    }
}
