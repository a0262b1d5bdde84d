//! Generates rays from points inside a mesh toward its vertices and the midpoints of its edges.

use intertri::Ray;
use intertri_raster::Adjacency;
use rayon::prelude::*;

use crate::scenes::random;

/// The target of the rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    Vertices,
    /// The midpoints of the edges.
    Edges,
}

impl Target {
    pub fn name(self) -> &'static str {
        match self {
            Self::Vertices => "vertices",
            Self::Edges => "edges",
        }
    }
}

/// An origin, and two points whose midpoint is the target: either the same vertex twice, or the two
/// ends of an edge.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    pub origin: [f32; 3],
    pub ends: [[f32; 3]; 2],
}

impl Aim {
    /// Returns the ray as a typical caller computes it: the target is rounded to f32, and so is its
    /// difference from the origin.
    pub fn ray(&self) -> Ray {
        let [a, b] = self.ends;
        Ray::new(self.origin, [0, 1, 2].map(|k| f32::midpoint(a[k], b[k]) - self.origin[k]))
    }

    /// Returns whether the direction is exact, that is, whether nothing was rounded.
    pub fn is_exact(&self) -> bool {
        let [a, b] = self.ends.map(|p| p.map(f64::from));
        let dir = self.ray().dir.map(f64::from);
        (0..3).all(|k| dir[k] == f64::midpoint(a[k], b[k]) - f64::from(self.origin[k]))
    }
}

/// Returns random rays, each from one of the points in `inside` toward a target. Calls with the
/// same arguments return the same rays.
pub fn aims(target: Target, adjacency: &Adjacency, inside: &[[f32; 3]], rays: usize) -> Vec<Aim> {
    let points = adjacency.points();
    let ends: Vec<[u32; 2]> = match target {
        Target::Vertices => (0..points.len() as u32).map(|i| [i, i]).collect(),
        Target::Edges => adjacency.edges().map(|edge| edge.ends).collect(),
    };
    let aim = |i: usize| {
        let share = f64::midpoint(random([i as u64, target as u64, 1]), 1.0);
        let nth = (share * ends.len() as f64) as usize;
        let ends = ends[nth.min(ends.len() - 1)].map(|end| points[end as usize]);
        Aim { origin: inside[i % inside.len()], ends }
    };
    (0..rays).into_par_iter().map(aim).collect()
}
