//! Finds points that are certainly inside a closed mesh.
//!
//! A ray along x from a point inside crosses the surface an odd number of times. The signs of exact
//! areas in the yz plane show which triangles the ray crosses. Each point stays at least a margin
//! away from every triangle. The margin is wide enough for plain f64 to decide which triangles are
//! ahead, and for the points to stay inside when `fixed` snaps them and the mesh to a grid.

use glam::DVec3;
use intertri::{Triangle, TriangleOf};
use rayon::prelude::*;
use robust::{Coord, orient2d};

use crate::scenes::random;

/// The maximum product of the number of points and the number of triangles. If a mesh has many
/// triangles, fewer points are used, and several rays start at each point.
const TESTS: usize = 1 << 31;
/// The margin, as a fraction of the longest side of the bounding box.
const MARGIN: f32 = 1.0 / 1024.0;
/// Origins are multiples of this fraction of the longest side, rounded down to a power of two. This
/// makes more differences exact in f32.
const STEP: f32 = 1.0 / 65536.0;
/// The number of candidate points per round.
const ROUND: usize = 1 << 12;
/// The maximum number of rounds. If they yield too few points, the search fails.
const ROUNDS: usize = 4096;

/// A triangle with its bounding box, which is grown by the margin.
struct Bounded {
    corners: [[f32; 3]; 3],
    lo: [f32; 3],
    hi: [f32; 3],
    margin: f32,
}

impl Bounded {
    fn new(&TriangleOf(corners): &Triangle, margin: f32) -> Self {
        let [a, b, c] = corners;
        let lo = [0, 1, 2].map(|k| a[k].min(b[k]).min(c[k]) - margin);
        let hi = [0, 1, 2].map(|k| a[k].max(b[k]).max(c[k]) + margin);
        Self { corners, lo, hi, margin }
    }

    /// Returns whether a ray along x from `p` crosses the triangle. Returns `None` if `p` is in the
    /// grown box and within the margin of the triangle's plane, or if its projection onto the yz
    /// plane is on the line through an edge.
    fn crosses(&self, p: [f32; 3]) -> Option<bool> {
        let within = |k: usize| self.lo[k] <= p[k] && p[k] <= self.hi[k];
        if !within(1) || !within(2) || p[0] > self.hi[0] {
            return Some(false);
        }
        let height = if within(0) { Some(self.height(p)?) } else { None };

        // In the yz plane, find which side of each edge the point is on.
        let coord = |p: [f32; 3]| Coord { x: p[1], y: p[2] };
        let [a, b, c] = self.corners.map(coord);
        let p = coord(p);
        let areas = [orient2d(a, b, p), orient2d(b, c, p), orient2d(c, a, p)];
        if areas.contains(&0.0) {
            return None;
        }
        let positive = areas[0] > 0.0;
        if areas.iter().any(|&x| (x > 0.0) != positive) {
            return Some(false);
        }
        // The areas have the same sign as the x component of the normal. The triangle is therefore
        // ahead if the height has the opposite sign.
        Some(height.is_none_or(|height| (height < 0.0) == positive))
    }

    /// Returns the signed height of a point above the triangle's plane, or `None` if the point is
    /// within the margin of the plane.
    fn height(&self, p: [f32; 3]) -> Option<f64> {
        let [a, b, c] = self.corners.map(|p| DVec3::from_array(p.map(f64::from)));
        let p = DVec3::from_array(p.map(f64::from));
        let normal = (b - a).cross(c - a).normalize();
        let height = normal.dot(p - a);
        (height.abs() > f64::from(self.margin)).then_some(height)
    }
}

/// Finds `count` points inside the mesh, or fewer if the mesh has many triangles.
pub fn points(triangles: &[Triangle], count: usize) -> Result<Vec<[f32; 3]>, String> {
    let count = count.min(TESTS / triangles.len()).max(1);
    let corners = || triangles.iter().flat_map(|t| t.0);
    let lo = corners().reduce(|a, b| [0, 1, 2].map(|k| a[k].min(b[k]))).unwrap_or_default();
    let hi = corners().reduce(|a, b| [0, 1, 2].map(|k| a[k].max(b[k]))).unwrap_or_default();
    let longest = [0, 1, 2].map(|k| hi[k] - lo[k]).into_iter().fold(0.0, f32::max);
    let bounded: Vec<_> = triangles.iter().map(|t| Bounded::new(t, MARGIN * longest)).collect();
    // Round the step down to a power of two.
    let step = (STEP * longest).log2().floor().exp2();
    let candidate = |i: usize| {
        let p = [0, 1, 2].map(|k: usize| {
            let share = f64::midpoint(random([i as u64, k as u64, 2]), 1.0) as f32;
            ((lo[k] + share * (hi[k] - lo[k])) / step).round() * step
        });
        let odd = bounded.iter().try_fold(false, |odd, t| Some(odd ^ t.crosses(p)?));
        (odd == Some(true)).then_some(p)
    };
    let mut points = Vec::with_capacity(count);
    for round in 0..ROUNDS {
        let round = (round * ROUND..(round + 1) * ROUND).into_par_iter();
        points.par_extend(round.filter_map(candidate));
        if points.len() >= count {
            points.truncate(count);
            return Ok(points);
        }
    }
    Err(format!("found only {} of {count} points inside", points.len()))
}
