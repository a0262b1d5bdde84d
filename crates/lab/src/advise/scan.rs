//! All pixels of a picture, and all triangles that may matter there.
//!
//! Bands of rows, on all threads. A band looks at the triangles whose shape in the picture, widened by
//! the largest error, reaches it; and of these only at the pixels that the shape covers.

#![expect(clippy::neg_cmp_op_on_partial_ord, reason = "what is NaN is in doubt")]

use std::ops::Range;

use intertri::{Hit, Ray, Triangle};
use rayon::prelude::*;

use super::facet::{Facet, Sight, Verdict, moves, vector};
use super::{Arithmetic, V, View};
use crate::subjects::moller_trumbore::MollerTrumbore;
use crate::subjects::{Method, PlainRay};
use crate::truth::{exact_t, truth};

/// Rows a thread takes at a time.
const BAND: u32 = 16;

/// What was found.
#[derive(Clone, Debug)]
pub struct Scan {
    /// For each arithmetic, how many pixels are doubtful.
    pub doubtful: Vec<u64>,
    /// The same on the sample.
    pub doubtful_in_sample: Vec<u64>,
    /// For each arithmetic, how far what is seen moves at most, in pixels.
    pub shift: Vec<f64>,
    /// The sample: every so many pixels, row by row.
    pub sample: Vec<Exact>,
}

/// What a pixel of the sample shows, exactly, and what f32 says.
#[derive(Clone, Debug)]
pub struct Exact {
    /// Its column and row.
    pub pixel: (u32, u32),
    /// The closest triangle, or several where they have the same t, exactly; none for a miss.
    pub triangles: Vec<u32>,
    /// The closest hit of the f32 test.
    pub single: Option<u32>,
}

impl Exact {
    /// Whether an answer is right.
    pub fn allows(&self, triangle: Option<u64>) -> bool {
        match triangle {
            None => self.triangles.is_empty(),
            Some(triangle) => self.triangles.iter().any(|&t| u64::from(t) == triangle),
        }
    }
}

/// Finds the doubtful pixels of a picture, and the exact answers of every `every`-th one.
///
/// `seen` is what the pixels show, row by row, by the reference's arithmetic with a threshold of 0: of
/// several answers that are possible, any will do. There are at most 32 arithmetics.
///
/// # Panics
/// If there are more, if `seen` is not as large as the picture, or if `every` is 0.
pub fn scan(
    triangles: &[Triangle],
    view: &View<'_>,
    seen: &[Hit],
    arithmetics: &[Arithmetic],
    every: usize,
    progress: &(dyn Fn(usize) + Sync),
) -> Scan {
    let (width, height) = view.size;
    assert!(arithmetics.len() <= 32 && seen.len() == width as usize * height as usize);
    let frame = Frame { triangles, view, arithmetics, forward: V::splat(view.axes[2]) };
    let shapes: Vec<Shape> =
        (0..triangles.len()).into_par_iter().map(|i| frame.shape(&frame.facet(i))).collect();

    let bands: Vec<u32> = (0..height).step_by(BAND as usize).collect();
    let done = bands.par_iter().map(|&first| {
        let rows = first..(first + BAND).min(height);
        let mut band = Band::new(&frame, rows.clone(), seen, every);
        for (index, shape) in shapes.iter().enumerate() {
            if shape.strip || shape.rows.start < rows.end && rows.start < shape.rows.end {
                band.look_at(index as u32, shape);
            }
        }
        progress(rows.len());
        band.finish()
    });
    let bands: Vec<Scan> = done.collect();

    let mut all = Scan {
        doubtful: vec![0; arithmetics.len()],
        doubtful_in_sample: vec![0; arithmetics.len()],
        shift: vec![0.0; arithmetics.len()],
        sample: vec![],
    };
    for band in bands {
        for k in 0..arithmetics.len() {
            all.doubtful[k] += band.doubtful[k];
            all.doubtful_in_sample[k] += band.doubtful_in_sample[k];
            all.shift[k] = all.shift[k].max(band.shift[k]);
        }
        all.sample.extend(band.sample);
    }
    all
}

/// What all bands look at.
struct Frame<'a> {
    triangles: &'a [Triangle],
    view: &'a View<'a>,
    arithmetics: &'a [Arithmetic],
    forward: V,
}

/// The pixels where a triangle may matter.
struct Shape {
    columns: Range<u32>,
    rows: Range<u32>,
    /// It is seen so nearly edge-on that f32 can see it beside itself.
    strip: bool,
}

impl Frame<'_> {
    fn facet(&self, index: usize) -> Facet {
        Facet::new(&self.triangles[index], self.view.eye, self.forward)
    }

    /// The box around a triangle in the picture, widened by what the worst arithmetic moves.
    fn shape(&self, facet: &Facet) -> Shape {
        let (width, height) = self.view.size;
        let nothing = Shape { columns: 0..0, rows: 0..0, strip: false };
        if !facet.is_finite() {
            return nothing;
        }
        let reach = facet.reach();
        let moves = |&a: &Arithmetic| moves(a, reach);
        let mut moves = self.arithmetics.iter().map(moves).fold(0.0, f64::max);
        if facet.depth.1 + moves < 0.0 {
            return nothing;
        }
        let spill = facet.spill();
        let strip = !(spill < 0.5);
        if !strip {
            moves += 2.0 * spill * facet.side;
        }

        // Too near for a box: everywhere.
        let nearest = facet.depth.0;
        if !(moves < nearest / 4.0) {
            return Shape { columns: 0..width, rows: 0..height, strip };
        }
        let [right, up, _] = self.view.axes.map(V::splat);
        let pixel = self.view.pixel();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in facet.corners {
            let depth = corner.dot(self.forward);
            let at = [corner.dot(right) / depth, -corner.dot(up) / depth];
            for axis in 0..2 {
                let off = moves * (1.0 + at[axis].abs()) / (nearest - moves);
                low[axis] = low[axis].min(at[axis] - off);
                high[axis] = high[axis].max(at[axis] + off);
            }
        }
        let range = |axis: usize, size: u32| {
            let place = |x: f64| x / pixel + 0.5 * f64::from(size) - 0.5;
            let first = (place(low[axis]).floor() - 1.0).clamp(0.0, f64::from(size)) as u32;
            let end = (place(high[axis]).ceil() + 2.0).clamp(0.0, f64::from(size)) as u32;
            first..end.max(first)
        };
        Shape { columns: range(0, width), rows: range(1, height), strip }
    }
}

/// The pixels of some rows.
struct Band<'a> {
    frame: &'a Frame<'a>,
    rows: Range<u32>,
    pixels: Vec<Pixel>,
    shift: Vec<f64>,
}

/// A pixel, and what is known of it so far.
struct Pixel {
    ray: Ray,
    sight: Sight,
    seen: Option<u32>,
    /// A bit for each arithmetic.
    doubtful: u32,
    /// For each arithmetic, the farthest t at which what is seen may be found.
    far: Vec<f64>,
    sampled: bool,
    /// The exact closest hits, and a t that is not less than theirs.
    truth: (f64, Vec<u32>),
    single: (f32, Option<u32>),
}

impl<'a> Band<'a> {
    fn new(frame: &'a Frame<'a>, rows: Range<u32>, seen: &[Hit], every: usize) -> Self {
        let (width, _) = frame.view.size;
        let mut shift = vec![0.0_f64; frame.arithmetics.len()];
        let angle = frame.view.pixel();
        let places = rows.clone().flat_map(|y| (0..width).map(move |x| (x, y)));
        let pixels = places.map(|(x, y)| {
            let index = y as usize * width as usize + x as usize;
            let ray = (frame.view.ray)(x, y);
            let dir = vector(ray.dir);
            let sight = Sight { dir, length: dir.dot(dir).sqrt(), depth: dir.dot(frame.forward) };
            let seen = seen[index].is_hit().then_some(seen[index].triangle as u32);
            let mut far = vec![f64::INFINITY; frame.arithmetics.len()];
            if let Some(seen) = seen {
                let facet = frame.facet(seen as usize);
                let mut meeting = facet.meet(&sight);
                for (k, &arithmetic) in frame.arithmetics.iter().enumerate() {
                    if let Verdict::In(_, hi) = facet.verdict(arithmetic, &mut meeting, &sight) {
                        far[k] = hi;
                    }
                    let slant = (sight.length / sight.depth).powi(2);
                    let moves = facet.shift(arithmetic, &meeting, &sight) * slant / angle;
                    shift[k] = shift[k].max(moves);
                }
            }
            Pixel {
                ray,
                sight,
                seen,
                doubtful: 0,
                far,
                sampled: index.is_multiple_of(every),
                truth: (f64::INFINITY, vec![]),
                single: (f32::INFINITY, None),
            }
        });
        Self { frame, rows: rows.clone(), pixels: pixels.collect(), shift }
    }

    /// A triangle at the pixels where it may matter.
    fn look_at(&mut self, index: u32, shape: &Shape) {
        let facet = self.frame.facet(index as usize);
        let corners = self.frame.triangles[index as usize].0.map(intertri::Vec3::<f32>::splat);
        let single = MollerTrumbore { epsilon: 0.0 }.triangle::<f32>(corners);
        let (width, _) = self.frame.view.size;
        for y in self.rows.clone() {
            let mut columns = if shape.rows.contains(&y) { shape.columns.clone() } else { 0..0 };
            if shape.strip {
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
                pixel.look_at(index, &facet, self.frame, &single);
            }
        }
    }

    /// The columns of a row in which all edge values may seem to have one sign in f32.
    fn strip(&self, facet: &Facet, y: u32) -> Range<u32> {
        // In a row the direction is linear in the column, and so are the edge values.
        let view = self.frame.view;
        let (width, height) = view.size;
        let (pixel, [right, up, forward]) = (view.pixel(), view.axes.map(V::splat));
        let above = 0.5 * f64::from(height) - 0.5 - f64::from(y);
        let across = -0.5 * f64::from(width) + 0.5;
        let first = forward + up * (above * pixel) + right * (across * pixel);
        let farthest = 1.0 + view.half_height * (1.0 + f64::from(width) / f64::from(height));
        // The directions of the rays are rounded to f32.
        let round = 1e-6 * pixel.min(1.0) + 2.0_f64.powi(-23);
        let mut columns = [f64::INFINITY, f64::NEG_INFINITY];
        for sign in [1.0, -1.0] {
            let (mut low, mut high) = (0.0, f64::from(width));
            for plane in facet.planes() {
                let bound = (facet.single() + round * plane.dot(plane).sqrt()) * farthest;
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

    fn finish(self) -> Scan {
        let count = |sampled: bool| {
            let of = |k: usize| {
                let pixels = self.pixels.iter().filter(|p| p.sampled || !sampled);
                pixels.filter(|p| p.doubtful & 1 << k != 0).count() as u64
            };
            (0..self.shift.len()).map(of).collect()
        };
        let (doubtful, doubtful_in_sample) = (count(false), count(true));
        let (width, first) = (self.frame.view.size.0 as usize, self.rows.start);
        let sample = self.pixels.into_iter().enumerate().filter(|(_, p)| p.sampled);
        let sample = sample.map(|(i, p)| Exact {
            pixel: ((i % width) as u32, first + (i / width) as u32),
            triangles: p.truth.1,
            single: p.single.1,
        });
        Scan { doubtful, doubtful_in_sample, shift: self.shift, sample: sample.collect() }
    }
}

impl Pixel {
    fn look_at(
        &mut self,
        index: u32,
        facet: &Facet,
        frame: &Frame<'_>,
        single: &<MollerTrumbore as Method>::Triangle<f32>,
    ) {
        let mut meeting = facet.meet(&self.sight);
        let mut tied = None;
        let triangle = |index: u32| &frame.triangles[index as usize];
        for (k, &arithmetic) in frame.arithmetics.iter().enumerate() {
            if self.doubtful & 1 << k != 0 {
                continue;
            }
            let verdict = facet.verdict(arithmetic, &mut meeting, &self.sight);
            let doubt = match verdict {
                Verdict::Out => self.seen == Some(index),
                Verdict::In(lo, _) => self.seen != Some(index) && !(lo > self.far[k]),
                Verdict::Doubt(lo, _) => !(lo > self.far[k]),
            };
            // Where two have the same t, either is right.
            let sure = matches!(verdict, Verdict::In(..));
            if doubt
                && !(sure && *tied.get_or_insert_with(|| self.is_tied(index, meeting.t, frame)))
            {
                self.doubtful |= 1 << k;
            }
        }

        if !self.sampled {
            return;
        }
        // What f32 says.
        let ray = PlainRay {
            origin: intertri::Vec3::<f32>::splat(self.ray.origin),
            dir: intertri::Vec3::splat(self.ray.dir),
        };
        let (hit, t) = MollerTrumbore { epsilon: 0.0 }.test::<f32>(single, &ray);
        if hit && t < self.single.0 {
            self.single = (t, Some(index));
        }
        // What is true.
        if facet.is_outside(&meeting, &self.sight)
            || facet.is_behind(&meeting, &self.sight, self.truth.0)
        {
            return;
        }
        if truth(triangle(index), &self.ray).is_hit() {
            let order = match self.truth.1.first() {
                None => std::cmp::Ordering::Less,
                Some(&best) => {
                    let t = [index, best].map(|i| exact_t(triangle(i), &self.ray));
                    t[0].cmp(&t[1])
                }
            };
            match order {
                std::cmp::Ordering::Less => {
                    self.truth = (facet.latest(&meeting, &self.sight), vec![index]);
                }
                std::cmp::Ordering::Equal => self.truth.1.push(index),
                std::cmp::Ordering::Greater => {}
            }
        }
    }

    /// Whether a triangle has the t of what is seen, exactly.
    fn is_tied(&self, index: u32, t: f64, frame: &Frame<'_>) -> bool {
        let Some(seen) = self.seen else { return false };
        let other = frame.facet(seen as usize).meet(&self.sight).t;
        if !((t - other).abs() <= 1e-9 * other.abs()) {
            return false;
        }
        let t = [index, seen].map(|i| exact_t(&frame.triangles[i as usize], &self.ray));
        t[0].is_some() && t[0] == t[1]
    }
}
