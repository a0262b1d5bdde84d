//! The engine `fixed`: one scene on one grid.

use intertri::fixed::{Bits, Fixed, Grid, Ray as Snapped, Triangle as Facet};
use intertri::{Hit, Ray, Triangle};
use intertri_trace::FixedBvh;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Result;
use crate::progress::Progress;

/// Rays a thread snaps and asks at a time.
const CHUNK: usize = 4096;

/// A scene on a grid that holds the origins of its rays, too.
pub(crate) struct OnGrid {
    grid: Grid,
    bvh: FixedBvh,
    /// A ray of which no part counts, in the place of those that have no direction.
    nothing: Snapped,
    /// How far a corner or an origin moved.
    moved: f64,
}

impl OnGrid {
    /// Snaps triangles, and the points from which they will be looked at. A point that is not finite
    /// is where no ray hits anything, as in every engine; it is not on the grid.
    pub(crate) fn new(triangles: &[Triangle], from: &[[f32; 3]], bits: Bits) -> Result<Self> {
        let from = from.iter().copied().filter(|p| p.iter().all(|x| x.is_finite()));
        let points = triangles.iter().flat_map(|t| t.0).chain(from);
        let grid = Grid::around(points.clone(), bits)?;
        let facets = triangles.iter().map(|t| grid.triangle(t));
        let facets = facets.collect::<std::result::Result<Vec<Facet>, _>>()?;
        let mut moved: f64 = 0.0;
        for point in points {
            moved = moved.max(grid.moved(point)?);
        }

        let bar = Progress::new("build", Some(triangles.len() as u64));
        let bvh = FixedBvh::with_progress(&facets, &|done, total| bar.set(done, total))?;
        let nothing = grid.ray_of([0; 3], [1, 0, 0])?.between(0.0, 0.0);
        Ok(Self { grid, bvh, nothing, moved })
    }

    /// The point of the grid next to a point, in the scene. A point that is not on the grid stays.
    pub(crate) fn place(&self, p: [f32; 3]) -> [f32; 3] {
        // What was snapped is an f32 again.
        self.grid.snap(p).map_or(p, |i| self.grid.unsnap(i).map(|x| x as f32))
    }

    /// The closest hit of each ray.
    pub(crate) fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.chunks(rays, hits, |rays, hits| {
            self.bvh.closest_of_each(&Fixed::default(), rays, hits);
        });
    }

    /// Whether each ray hits anything.
    pub(crate) fn any(&self, rays: &[Ray], hits: &mut [bool]) {
        self.chunks(rays, hits, |rays, hits| {
            self.bvh.any_of_each(&Fixed::default(), rays, hits);
        });
    }

    /// Every hit of a ray, in the order of the triangles.
    pub(crate) fn all(&self, ray: &Ray) -> Vec<Hit> {
        let ray = self.grid.ray(ray).unwrap_or(self.nothing);
        self.bvh.all(&Fixed::default(), &ray)
    }

    /// Snaps rays to the grid, which was made around their origins, and asks for their answers, so
    /// many at a time that they stay near.
    fn chunks<T: Send>(
        &self,
        rays: &[Ray],
        answers: &mut [T],
        ask: impl Fn(&[Snapped], &mut [T]) + Sync,
    ) {
        let chunks = rays.par_chunks(CHUNK).zip(answers.par_chunks_mut(CHUNK));
        let buffer = || vec![self.nothing; CHUNK];
        chunks.for_each_init(buffer, |snapped, (rays, answers)| {
            let snapped = &mut snapped[..rays.len()];
            self.grid.rays(rays, snapped, |_, _| self.nothing);
            ask(snapped, answers);
        });
    }

    /// What the grid is like.
    pub(crate) fn report(&self) -> Report {
        let (bits, step) = (self.grid.bits(), self.grid.step());
        // From one end of the grid to the other, a component of a direction is off by less than 2^-q
        // of the longest.
        let across = step * f64::from(2_u32 << bits.b());
        let strays = across / f64::from(1_u32 << bits.q());
        Report { bits: bits.b(), direction_bits: bits.q(), step, moved: self.moved, strays }
    }
}

/// A grid, in units of the scene.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct Report {
    pub(crate) bits: u32,
    pub(crate) direction_bits: u32,
    /// The distance of neighbouring points of the grid.
    pub(crate) step: f64,
    /// How far the corner or origin that moved most did, along an axis.
    pub(crate) moved: f64,
    /// A ray's far end, the whole grid away, is off by less along each axis, for its direction is
    /// snapped too.
    pub(crate) strays: f64,
}

/// A number of bits on a command line.
pub(crate) fn parse_bits(text: &str) -> std::result::Result<Bits, String> {
    let number = text.parse().map_err(|_| "give a whole number from 1 to 20".to_owned())?;
    Bits::of_grid(number).map_err(|error| error.to_string())
}
