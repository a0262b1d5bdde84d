//! Divides the loops of a boundary into small loops and builds a tree of bounding spheres over
//! them, so that the contribution of a distant part can be bounded as a whole.
//!
//! ```text
//!    ·──▶──·──▶──·            ·──▶──·──▶──·
//!    ▲           ▼            ▲           ▼         ·─────▶─────·
//!    ·           ·     =      ·─────◀─────·    +    ▲           ▼
//!    ▲           ▼                                  ·─────◀─────·
//!    ·──◀──·──◀──·      Pieces, each closed by a chord, plus the loop of chords, divided again.
//! ```
//!
//! `docs/numerics/winding.md`, section 5, derives the bound.

use std::f64::consts::TAU;

use intertri::Scalar;

use crate::util::memory::{NoMemory, room};
use crate::util::stop;

/// The number of edges in a piece, not counting its chord.
const PIECE: usize = 8;

/// A factor that covers the relative rounding errors of a radius and an area.
const ROOM: f64 = 1.0 + 1.0e-9;

/// The range of sizes for which clusters are used. Outside this range, edges are summed one by one.
/// Within it, fourth powers of sizes are far from overflow and underflow.
const SIZES: [f64; 2] = [1e-60, 1e60];

/// A bounding sphere around one or more loops.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cluster {
    /// The centre of the sphere.
    pub(super) middle: [f64; 3],
    /// The squared radius of the sphere.
    pub(super) radius: f64,
    /// The total area of the triangles that connect the first corner of each loop to the loop's
    /// edges, divided by 4π.
    pub(super) area: f64,
    /// The index of the next cluster that is not a descendant of this one.
    pub(super) next: usize,
    /// The range of the loop's corners, if the cluster is a single loop.
    pub(super) corners: Option<[usize; 2]>,
}

/// A boundary as a tree of clusters in depth-first order: each cluster precedes its descendants.
#[derive(Clone, Debug)]
pub(super) struct Clusters {
    pub(super) clusters: Vec<Cluster>,
    pub(super) corners: Vec<[f64; 3]>,
    /// A power of two that scales sizes so that the largest size is near 1.
    pub(super) scale: f64,
}

impl Clusters {
    pub(super) const NONE: Self = Self { clusters: Vec::new(), corners: Vec::new(), scale: 1.0 };

    /// Builds the clusters of the given loops, each of which ends with a copy of its first corner.
    /// Returns no clusters if the size is extreme; whole turns are then never certain.
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

    /// Returns a coordinate of the middle of a piece. The function is out of line because the
    /// selection of a median compares in many places.
    #[inline(never)]
    fn middle_of(&self, &[from, to]: &[usize; 2], axis: usize) -> f64 {
        Bounds::of(self.corners[from..to].iter().copied()).middle()[axis]
    }

    /// Adds a cluster for the given pieces, along with its descendants. Radii are increased by
    /// `least` to cover rounding.
    fn add(&mut self, pieces: &mut [[usize; 2]], least: f64) {
        stop::heed();
        let corners = |piece: &[usize; 2]| self.corners[piece[0]..piece[1]].iter().copied();
        let bounds = Bounds::of(pieces.iter().flat_map(corners));
        let middle = bounds.middle();
        let far = pieces.iter().flat_map(corners).map(|corner| size(apart(corner, middle)));
        let radius = ROOM * far.fold(0.0, f64::max) + least;
        let double_area = pieces.iter().map(|piece| fan(corners(piece), least)).sum::<f64>();
        let area = ROOM * double_area / (4.0 * TAU);
        let (at, radius) = (self.clusters.len(), radius * radius);
        let loop_corners = if let [piece] = *pieces { Some(piece) } else { None };
        self.clusters.push(Cluster { middle, radius, area, next: 0, corners: loop_corners });
        if pieces.len() > 1 {
            // Split at the median along the longest side.
            let k = bounds.longest();
            let half = pieces.len() / 2;
            pieces.select_nth_unstable_by(half, |a, b| {
                self.middle_of(a, k).total_cmp(&self.middle_of(b, k))
            });
            let (some, others) = pieces.split_at_mut(half);
            self.add(some, least);
            self.add(others, least);
        }
        self.clusters[at].next = self.clusters.len();
    }
}

/// The corners of all pieces, and the range of each piece.
type Pieces = (Vec<[f64; 3]>, Vec<[usize; 2]>);

/// Cuts loops into pieces.
fn pieces<'a, S: Scalar>(
    loops: impl Iterator<Item = &'a [[S; 3]]> + Clone,
) -> Result<Pieces, NoMemory> {
    // Each level has an eighth as many pieces as the level below, and each piece has ten corners.
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

/// A bounding box of corners.
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

    /// Returns the axis of the longest side.
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

    /// Returns the length of the longest side.
    fn size(&self) -> f64 {
        apart(self.0[1], self.0[0])[self.longest()]
    }
}

/// Returns an upper bound on twice the total area of the triangles that connect the first corner of
/// a loop to the loop's edges.
fn fan(mut corners: impl Iterator<Item = [f64; 3]>, least: f64) -> f64 {
    let Some(first) = corners.next() else { return 0.0 };
    let (mut from, mut area) = ([0.0; 3], 0.0);
    for corner in corners {
        let to = apart(corner, first);
        let cross = [0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            from[i] * to[j] - from[j] * to[i]
        });
        // The cross product of nearly parallel edges suffers from cancellation, which the second
        // term covers.
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

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::{Cluster, Clusters, apart, size};

    /// Returns a convex planar loop with many edges. Its last corner repeats the first.
    fn circle(count: usize) -> Vec<[f64; 3]> {
        let corner = |i: usize| {
            let angle = (i % count) as f64 / count as f64 * TAU;
            [angle.cos(), angle.sin(), 0.25 * angle.cos()]
        };
        (0..=count).map(corner).collect()
    }

    fn clusters(loops: &[Vec<[f64; 3]>]) -> Clusters {
        Clusters::of(loops.iter().map(Vec::as_slice)).unwrap()
    }

    /// Returns the corners of the loops within a cluster.
    fn loops(tree: &Clusters, at: usize) -> impl Iterator<Item = &[[f64; 3]]> + Clone {
        let within = tree.clusters[at..tree.clusters[at].next].iter();
        within.filter_map(|cluster| cluster.corners).map(|[start, end]| &tree.corners[start..end])
    }

    /// Returns twice the area enclosed by a planar loop.
    fn enclosed(corners: &[[f64; 3]]) -> f64 {
        let mut sum = [0.0; 3];
        for edge in corners.windows(2) {
            let ([ax, ay, az], [bx, by, bz]) = (edge[0], edge[1]);
            let cross = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
            sum = [0, 1, 2].map(|k| sum[k] + cross[k]);
        }
        size(sum)
    }

    /// Checks that the chords cancel, so that the small loops together traverse each edge as often
    /// as the boundary does.
    #[test]
    fn small_loops_are_the_boundary() {
        for count in [3, 8, 16, 17, 18, 129, 130, 1000] {
            let tree = clusters(&[circle(count), circle(5)]);
            let mut edges: Vec<[[f64; 3]; 2]> = Vec::new();
            for edge in loops(&tree, 0).flat_map(|corners| corners.windows(2)) {
                let [from, to] = [edge[0], edge[1]];
                match edges.iter().position(|edge| *edge == [to, from]) {
                    Some(reverse) => drop(edges.swap_remove(reverse)),
                    None => edges.push([from, to]),
                }
            }
            let boundary = [circle(count), circle(5)];
            let boundary = boundary.iter().flat_map(|corners| corners.windows(2));
            let mut boundary: Vec<_> = boundary.map(|edge| [edge[0], edge[1]]).collect();
            let key = |edge: &[[f64; 3]; 2]| {
                edge.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<_>>()
            };
            edges.sort_unstable_by_key(key);
            boundary.sort_unstable_by_key(key);
            assert_eq!(edges, boundary, "{count}");
        }
    }

    /// Checks that each sphere contains its loops, and that the area stored with it is never less
    /// than the area of the loops. For a convex planar loop, the stored area is tight.
    #[test]
    fn balls_and_areas_are_bounds() {
        for count in [3, 17, 200, 1000] {
            let far = circle(9).iter().map(|corner| corner.map(|x| x + 9.0)).collect();
            let tree = clusters(&[circle(count), far]);
            for (at, Cluster { middle, radius, area, .. }) in tree.clusters.iter().enumerate() {
                for corner in loops(&tree, at).flatten() {
                    let away = size(apart(*corner, *middle));
                    assert!(away * away <= *radius, "{count}: {corner:?} is outside of ball {at}");
                }
                let enclosed = loops(&tree, at).map(enclosed).sum::<f64>() / (2.0 * TAU) / 2.0;
                assert!(
                    (enclosed..1.001 * enclosed + 1e-12).contains(area),
                    "{count}: {area} for {enclosed}"
                );
            }
            // Even a degenerate triangle gets a margin for the rounding of its corners.
            let x = 1.0 / count as f64;
            let line = clusters(&[vec![[x; 3], [x + 1.0; 3], [x; 3]]]);
            assert!(line.clusters[0].area > 0.0 && line.clusters[0].radius > 0.75);
        }
    }
}
