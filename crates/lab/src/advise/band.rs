//! Scans a band of an image's rows: tests triangles at each pixel and counts the doubtful pixels.

use std::ops::Range;

use intertri::Hit;

use super::facet::Facet;
use super::footprint::{Footprint, ScanInput};
use super::outcome::Outcome;
use super::pixel::Pixel;
use super::pixel_ray::PixelRay;
use super::scan_result::{SampledPixel, ScanResult};
use super::vector::{Vec3d, vector};
use crate::methods::Intersector;
use crate::methods::moller_trumbore::MollerTrumbore;

/// The pixels of a band of rows.
pub(super) struct Band<'a> {
    input: &'a ScanInput<'a>,
    rows: Range<u32>,
    pixels: Vec<Pixel>,
    shift: Vec<f64>,
}

impl<'a> Band<'a> {
    pub(super) fn new(
        input: &'a ScanInput<'a>,
        rows: Range<u32>,
        seen: &[Hit],
        every: usize,
    ) -> Self {
        let (width, _) = input.camera.size;
        let mut shift = vec![0.0_f64; input.arithmetics.len()];
        let angle = input.camera.pixel();
        let places = rows.clone().flat_map(|y| (0..width).map(move |x| (x, y)));
        let pixels = places.map(|(x, y)| {
            let index = y as usize * width as usize + x as usize;
            let ray = (input.camera.ray)(x, y);
            let dir = vector(ray.dir);
            let pixel_ray =
                PixelRay { dir, length: dir.dot(dir).sqrt(), depth: dir.dot(input.forward) };
            let seen = seen[index].is_hit().then_some(seen[index].triangle);
            let mut far = vec![f64::INFINITY; input.arithmetics.len()];
            if let Some(seen) = seen {
                let facet = input.facet(seen as usize);
                let mut plane_hit = facet.plane_hit(&pixel_ray);
                for (k, &arithmetic) in input.arithmetics.iter().enumerate() {
                    if let Outcome::Hit(_, hi) =
                        facet.outcome(arithmetic, &mut plane_hit, &pixel_ray)
                    {
                        far[k] = hi;
                    }
                    let slant = (pixel_ray.length / pixel_ray.depth).powi(2);
                    let moves = facet.shift(arithmetic, &plane_hit, &pixel_ray) * slant / angle;
                    shift[k] = shift[k].max(moves);
                }
            }
            Pixel {
                ray,
                pixel_ray,
                seen,
                doubtful: 0,
                far,
                sampled: index.is_multiple_of(every),
                closest: (f64::INFINITY, vec![]),
                single: (f32::INFINITY, None),
            }
        });
        Self { input, rows: rows.clone(), pixels: pixels.collect(), shift }
    }

    /// Tests a triangle at the pixels where it may affect the answer.
    pub(super) fn visit(&mut self, index: u32, footprint: &Footprint) {
        let facet = self.input.facet(index as usize);
        let corners =
            self.input.triangles[index as usize].0.map(intertri::simd::Vec3::<f32>::splat);
        let single = MollerTrumbore { epsilon: 0.0 }.triangle::<f32>(corners);
        let (width, _) = self.input.camera.size;
        for y in self.rows.clone() {
            let mut columns =
                if footprint.rows.contains(&y) { footprint.columns.clone() } else { 0..0 };
            if footprint.strip {
                let strip = self.strip(&facet, y);
                columns = if columns.is_empty() {
                    strip
                } else if strip.is_empty() {
                    columns
                } else {
                    columns.start.min(strip.start)..columns.end.max(strip.end)
                };
            }
            let row = (y - self.rows.start) as usize * width as usize;
            for pixel in &mut self.pixels[row + columns.start as usize..row + columns.end as usize]
            {
                pixel.visit(index, &facet, self.input, &single);
            }
        }
    }

    /// Returns the columns of a row in which all edge values may appear to have the same sign in
    /// f32.
    fn strip(&self, facet: &Facet, y: u32) -> Range<u32> {
        // Along a row, the direction is linear in the column, and so are the edge values.
        let camera = self.input.camera;
        let (width, height) = camera.size;
        let (pixel, [right, up, forward]) = (camera.pixel(), camera.axes.map(Vec3d::splat));
        let above = 0.5 * f64::from(height) - 0.5 - f64::from(y);
        let across = -0.5 * f64::from(width) + 0.5;
        let first = forward + up * (above * pixel) + right * (across * pixel);
        let farthest = 1.0 + camera.half_height * (1.0 + f64::from(width) / f64::from(height));
        // Allow for the ray directions, which have been rounded to f32.
        let round = 1e-6 * pixel.min(1.0) + 2.0_f64.powi(-23);
        let mut columns = [f64::INFINITY, f64::NEG_INFINITY];
        for sign in [1.0, -1.0] {
            let (mut low, mut high) = (0.0, f64::from(width));
            for plane in facet.planes {
                let bound = (facet.single_bound() + round * plane.dot(plane).sqrt()) * farthest;
                let (at, slope) = (sign * plane.dot(first), sign * plane.dot(right) * pixel);
                // at + x * slope >= -bound
                let cut = (-bound - at) / slope;
                if slope > 0.0 {
                    low = cut.max(low);
                } else if slope < 0.0 {
                    high = cut.min(high);
                } else if at < -bound {
                    high = -1.0;
                }
            }
            if low <= high {
                columns = [columns[0].min(low), columns[1].max(high)];
            }
        }
        if columns[0] > columns[1] {
            return 0..0;
        }
        let end = f64::from(width);
        (columns[0] - 1.0).clamp(0.0, end) as u32..(columns[1] + 2.0).clamp(0.0, end) as u32
    }

    pub(super) fn finish(self) -> ScanResult {
        let count = |sampled: bool| {
            let of = |k: usize| {
                let pixels = self.pixels.iter().filter(|p| p.sampled || !sampled);
                pixels.filter(|p| p.doubtful & 1 << k != 0).count() as u64
            };
            (0..self.shift.len()).map(of).collect()
        };
        let (doubtful, doubtful_in_sample) = (count(false), count(true));
        let (width, first) = (self.input.camera.size.0 as usize, self.rows.start);
        let sample = self.pixels.into_iter().enumerate().filter(|(_, p)| p.sampled);
        let sample = sample.map(|(i, p)| SampledPixel {
            pixel: ((i % width) as u32, first + (i / width) as u32),
            triangles: p.closest.1,
            single: p.single.1,
        });
        ScanResult { doubtful, doubtful_in_sample, shift: self.shift, sample: sample.collect() }
    }
}
