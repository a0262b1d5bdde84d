//! Detects which rays of a batch are the pixels of an image, row by row.
//!
//! The caller does not mark the rows, but at the end of each row the direction jumps back or, if
//! the rays are parallel, the origin does.
//!
//! ```text
//!   ┌──────────────────────►
//!   └──────────────────────►   The jump is back by more than a few pixels.
//!   ...
//! ```
//!
//! Examining two rows and the ends of the others costs almost nothing compared with tracing the
//! rays.

use std::ops::Range;

use super::tiles::{LOWEST, TILE};

/// The smallest width of an image, in pixels.
const SHORTEST: usize = TILE;

/// The largest width that is detected, in pixels.
const LONGEST: usize = 1 << 14;

/// The smallest height of an image, in pixels.
const FEWEST: usize = LOWEST;

/// The direction of each ray is compared with the direction of the ray this many pixels later. The
/// end of a row is where the direction jumps back by at least half of the difference, so rays may
/// be jittered within their pixels.
const STEP: usize = 8;

/// If no rows are found at a ray, the search resumes this many rays later.
const AGAIN: usize = 1 << 16;

/// A run of consecutive rays.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The indices of the rays.
    pub rays: Range<usize>,
    /// The width of the rows, if the rays are the pixels of an image.
    pub width: Option<usize>,
}

/// Splits `count` rays into runs of pixels in rows, and runs of other rays. `line` returns the
/// origin and the direction of a ray.
pub fn runs(count: usize, line: impl Fn(usize) -> [[f64; 3]; 2]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut add = |rays: Range<usize>, width: Option<usize>| match runs.last_mut() {
        Some(last) if last.width == width && width.is_none() => last.rays.end = rays.end,
        _ if rays.is_empty() => (),
        _ => runs.push(Run { rays, width }),
    };
    let mut at = 0;
    while at < count {
        let rows = Rows::new(count - at, |i| line(at + i));
        let Some((first, width)) = rows.find() else {
            // There are no rows at this ray, but an image may begin later.
            let end = count.min(at + AGAIN);
            add(at..end, None);
            at = end;
            continue;
        };
        let count = rows.count(first, width);
        add(at..at + first, None);
        at += first;
        add(at..at + count * width, Some(width));
        at += count * width;
    }
    runs
}

/// Rays among which to look for rows of pixels.
struct Rows<F> {
    count: usize,
    /// A function that returns the origin and the direction of a ray.
    line: F,
    /// Whether the rays share a direction but not an origin.
    parallel: bool,
}

impl<F: Fn(usize) -> [[f64; 3]; 2]> Rows<F> {
    fn new(count: usize, line: F) -> Self {
        let parallel = count > 1 && {
            let ([origin, dir], [origin2, dir2]) = (line(0), line(1));
            bits(dir) == bits(dir2) && bits(origin) != bits(origin2)
        };
        Self { count, line, parallel }
    }

    /// Returns the start of the first row, and the width of the rows.
    fn find(&self) -> Option<(usize, usize)> {
        if self.count < FEWEST * SHORTEST {
            return None;
        }
        let first = self.end_of(0)?;
        let width = self.end_of(first)? - first;
        let begin = if first == width { 0 } else { first };
        let is_picture = width >= SHORTEST && self.count(begin, width) >= FEWEST;
        is_picture.then_some((begin, width))
    }

    /// Returns the end of the row that begins at a ray, if it is found within [`LONGEST`] rays.
    fn end_of(&self, begin: usize) -> Option<usize> {
        let along = self.step(begin, begin + STEP)?;
        let most = self.count.min(begin + LONGEST);
        (begin + 1..most).find(|&i| self.jumps_back(i, along, STEP))
    }

    /// Returns whether the direction (or the origin) jumps back just before a ray, by at least half
    /// of its change over this many pixels.
    fn jumps_back(&self, ray: usize, along: [f64; 3], pixels: usize) -> bool {
        // Compare along the row, in units of its steps, so that jitter within a few pixels is not a
        // jump.
        let half = 0.5 * (pixels as f64 / STEP as f64) * dot(along, along);
        self.step(ray - 1, ray).is_some_and(|step| dot(step, along) < -half)
    }

    /// Returns the number of consecutive rows that belong to one image.
    fn count(&self, begin: usize, width: usize) -> usize {
        // All rays of an image start at one point or are parallel.
        let shared = |ray: usize| bits((self.line)(ray)[usize::from(self.parallel)]);
        let is_row = |&row: &usize| {
            let first = begin + row * width;
            let Some(along) = self.step(first, first + STEP) else { return false };
            // Only the ends of each row are checked.
            let ends = first + width == self.count || self.jumps_back(first + width, along, width);
            shared(first) == shared(begin) && shared(first + width - 1) == shared(begin) && ends
        };
        (0..(self.count - begin) / width).take_while(is_row).count()
    }

    /// Returns the difference between the directions of two rays or, for parallel rays, between
    /// their origins.
    fn step(&self, from: usize, to: usize) -> Option<[f64; 3]> {
        let pixel = |ray: usize| (self.line)(ray)[usize::from(!self.parallel)];
        (from.max(to) < self.count).then(|| {
            let (from, to) = (pixel(from), pixel(to));
            [0, 1, 2].map(|k| to[k] - from[k])
        })
    }
}

/// Returns the bits of a vector.
fn bits(vector: [f64; 3]) -> [u64; 3] {
    vector.map(f64::to_bits)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use intertri::Ray;

    use super::Run;

    fn runs(rays: &[Ray]) -> Vec<Run> {
        super::runs(rays.len(), |i| [rays[i].origin, rays[i].dir].map(|v| v.map(f64::from)))
    }

    /// Returns the rays of a camera's image, row by row.
    fn rows(camera: f32, width: usize, height: usize) -> Vec<Ray> {
        let at = |i: usize| [(i % width) as f32, (i / width) as f32].map(|k| k / 100.0 - 1.0);
        let ray = |[x, y]: [f32; 2]| Ray::new([camera, 0.0, 0.0], [x, y, 3.0]);
        (0..width * height).map(at).map(ray).collect()
    }

    #[test]
    fn rows_are_seen() {
        let run = |rays, width| Run { rays, width };
        let rows_of = |width| Some(width);
        assert_eq!(runs(&rows(0.0, 40, 9)), [run(0..360, rows_of(40))]);
        assert_eq!(runs(&rows(0.0, 500, 20)), [run(0..10_000, rows_of(500))]);

        // The images of two cameras, with an incomplete row at either end.
        let two = [&rows(0.0, 50, 10)[20..], &rows(1.0, 60, 10)[..585]].concat();
        let seen = [run(0..30, None), run(30..480, rows_of(50)), run(480..1020, rows_of(60))];
        assert_eq!(runs(&two)[..3], seen);
        assert_eq!(runs(&two)[3..], [run(1020..1065, None)]);
    }

    #[test]
    fn rows_of_parallel_rays_are_seen() {
        let parallel = |ray: &Ray| Ray::new(ray.dir, [0.1, -0.2, 1.0]);
        let rays: Vec<Ray> = rows(0.0, 500, 20).iter().map(parallel).collect();
        assert_eq!(runs(&rays), [Run { rays: 0..10_000, width: Some(500) }]);
    }

    #[test]
    fn jittered_rows_are_seen() {
        let mut rays = rows(0.0, 64, 32);
        for (i, ray) in rays.iter_mut().enumerate() {
            let by = |k: usize| (i * k % 101) as f32 / 101.0 - 0.5;
            (ray.dir[0], ray.dir[1]) = (ray.dir[0] + by(37) / 100.0, ray.dir[1] + by(59) / 100.0);
        }
        assert_eq!(runs(&rays), [Run { rays: 0..2048, width: Some(64) }]);
    }

    #[test]
    fn others_are_no_rows() {
        let picture = rows(0.0, 64, 64);
        let bits = |i: usize| (0..6).fold(0, |sum, k| sum | (i >> (2 * k) & 1) << k);
        let tiles: Vec<Ray> = (0..4096).map(|i| picture[64 * bits(i >> 1) + bits(i)]).collect();
        let mixed: Vec<Ray> = (0..4096).map(|i| picture[i * 1021 % 4096]).collect();
        let one_way = vec![picture[77]; 4096];
        for rays in [tiles, mixed, one_way, rows(0.0, 1024, 1), rows(0.0, 20, 100)] {
            assert_eq!(runs(&rays), [Run { rays: 0..rays.len(), width: None }]);
        }
    }
}
