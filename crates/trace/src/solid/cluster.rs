//! The loops of a boundary cut into small ones, and a tree of balls around them, so that what is far from a point is bounded
//! as a whole.
//!
//! ```text
//!    ·──▶──·──▶──·            ·──▶──·──▶──·
//!    ▲           ▼            ▲           ▼         ·─────▶─────·
//!    ·           ·     =      ·─────◀─────·    +    ▲           ▼
//!    ▲           ▼                                  ·─────◀─────·
//!    ·──◀──·──◀──·      pieces, each closed by a chord, and the loop of the chords, which is cut again
//! ```
//!
//! Derivation of the bound: `docs/numerics/winding.md`, section 5.

use std::f64::consts::TAU;

use intertri::Scalar;

use crate::util::memory::{NoMemory, room};
use crate::util::stop;

/// Edges of a piece without its chord.
const PIECE: usize = 8;

/// More than the relative roundings of a radius and of an area.
const ROOM: f64 = 1.0 + 1.0e-9;

/// Boundaries of other sizes are added up edge by edge: a size to the fourth power is a number with room on both sides.
const SIZES: [f64; 2] = [1e-60, 1e60];

/// Loops in a ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cluster {
    /// The middle of the ball, and its radius squared.
    pub(super) middle: [f64; 3],
    pub(super) radius: f64,
    /// The area of triangles from the first corner of each loop to its edges, over 4π.
    pub(super) area: f64,
    /// Where the tree goes on after this cluster and those within it.
    pub(super) next: usize,
    /// Where the corners of the loop begin and end, if it is a single one.
    pub(super) corners: Option<[usize; 2]>,
}

/// A boundary as a tree of clusters, each before those within it.
#[derive(Clone, Debug)]
pub(super) struct Clusters {
    pub(super) clusters: Vec<Cluster>,
    pub(super) corners: Vec<[f64; 3]>,
    /// A power of two by which sizes are multiplied, so that the largest is near 1.
    pub(super) scale: f64,
}

impl Clusters {
    pub(super) const NONE: Self = Self { clusters: Vec::new(), corners: Vec::new(), scale: 1.0 };

    /// Those of some loops; each loop has its first corner at its end again. None if their size is extreme:
    /// then no whole turns are certain.
    pub(super) fn of<'a, S: Scalar>(
        loops: impl Iterator<Item = &'a [[S; 3]]> + Clone,
    ) -> Result<Self, NoMemory> {
        let all = Bounds::of(loops.clone().flatten().map(|corner| corner.map(Into::into)));
        if !(SIZES[0]..=SIZES[1]).contains(&all.size()) {
            return Ok(Self::NONE);
        }
        let (corners, mut pieces) = pieces(loops)?;
        let clusters = room(2 * pieces.len())?;
        let (scale, least) = (0.5_f64.powi(all.size().log2() as i32), 4e-15 * all.size());
        let mut tree = Self { clusters, corners, scale };
        tree.add(&mut pieces, least);
        Ok(tree)
    }

    /// Adds the cluster of some pieces, and those within it. Radii are more than a least one.
    fn add(&mut self, pieces: &mut [[usize; 2]], least: f64) {
        stop::heed();
        let corners = |piece: &[usize; 2]| self.corners[piece[0]..piece[1]].iter().copied();
        let bounds = Bounds::of(pieces.iter().flat_map(corners));
        let middle = bounds.middle();
        let far = pieces.iter().flat_map(corners).map(|corner| size(apart(corner, middle)));
        let radius = ROOM * far.fold(0.0, f64::max) + least;
        let area = pieces.iter().map(|piece| fan(corners(piece), least)).sum::<f64>();
        let (at, radius, area) = (self.clusters.len(), radius * radius, ROOM * area / (2.0 * TAU));
        let loop_corners = if let [piece] = *pieces { Some(piece) } else { None };
        self.clusters.push(Cluster { middle, radius, area, next: 0, corners: loop_corners });
        if pieces.len() > 1 {
            // Halves on both sides of the median along the longest side.
            let k = bounds.longest();
            let place = |piece: &[usize; 2]| Bounds::of(corners(piece)).middle()[k];
            let half = pieces.len() / 2;
            pieces.select_nth_unstable_by(half, |a, b| place(a).total_cmp(&place(b)));
            let (some, others) = pieces.split_at_mut(half);
            self.add(some, least);
            self.add(others, least);
        }
        self.clusters[at].next = self.clusters.len();
    }
}

/// Corners of pieces, and where those of each piece begin and end.
type Pieces = (Vec<[f64; 3]>, Vec<[usize; 2]>);

/// Loops cut into pieces.
fn pieces<'a, S: Scalar>(
    loops: impl Iterator<Item = &'a [[S; 3]]> + Clone,
) -> Result<Pieces, NoMemory> {
    // Each level has an eighth of the pieces of the one below, and ten corners a piece.
    let mut corners: Vec<[f64; 3]> = room(loops.clone().map(|all| 2 * all.len() + 8).sum())?;
    let mut pieces = room(loops.clone().map(|all| all.len() / 7 + 8).sum())?;
    let mut chords: Vec<[f64; 3]> = room(loops.clone().map(<[_]>::len).max().unwrap_or(0))?;
    for all in loops {
        chords.clear();
        chords.extend(all.iter().map(|corner| corner.map(Into::<f64>::into)));
        while chords.len() > 2 * PIECE {
            let count = (chords.len() - 1).div_ceil(PIECE);
            for i in 0..count {
                let (from, to) = (i * PIECE, (i * PIECE + PIECE).min(chords.len() - 1));
                // A single edge and its chord cancel.
                if to > from + 1 {
                    let start = corners.len();
                    corners.extend(chords[from..=to].iter().chain([&chords[from]]));
                    pieces.push([start, corners.len()]);
                }
                chords[i] = chords[from];
            }
            chords[count] = chords[0];
            chords.truncate(count + 1);
        }
        pieces.push([corners.len(), corners.len() + chords.len()]);
        corners.extend(&chords);
    }
    Ok((corners, pieces))
}

/// A box around corners.
struct Bounds([[f64; 3]; 2]);

impl Bounds {
    fn of(corners: impl Iterator<Item = [f64; 3]>) -> Self {
        let none = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        Self(corners.fold(none, |[lo, hi], corner| {
            [[0, 1, 2].map(|k| lo[k].min(corner[k])), [0, 1, 2].map(|k| hi[k].max(corner[k]))]
        }))
    }

    fn middle(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| 0.5 * self.0[0][k] + 0.5 * self.0[1][k])
    }

    /// The axis along which it is longest.
    fn longest(&self) -> usize {
        let [x, y, z] = apart(self.0[1], self.0[0]);
        if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        }
    }

    /// Its longest side.
    fn size(&self) -> f64 {
        apart(self.0[1], self.0[0])[self.longest()]
    }
}

/// More than the double area of the triangles from the first corner of a loop to its edges.
fn fan(mut corners: impl Iterator<Item = [f64; 3]>, least: f64) -> f64 {
    let Some(first) = corners.next() else { return 0.0 };
    let (mut from, mut area) = ([0.0; 3], 0.0);
    for corner in corners {
        let to = apart(corner, first);
        let cross = [0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            from[i] * to[j] - from[j] * to[i]
        });
        // The cross product of nearly parallel edges has lost its digits.
        area += size(cross) + least * (size(from) + size(to));
        from = to;
    }
    area
}

fn apart(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn size(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}
