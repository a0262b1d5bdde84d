//! The faces at each edge: document C's adjacency table, extended to arbitrary meshes.
//!
//! In the document, each face has exactly three neighbours. A real mesh also has edges with one
//! face (where it is open), with two faces of opposite winding, or with three or more. This table
//! is therefore inverted: for each edge, it lists all faces at the edge and the direction in which
//! each face traverses it.
//!
//! ```text
//!        a         Face 0 = (a, b, c) traverses the edge a-b forward.
//!      / | \       Face 1 = (b, a, d) traverses it backward, as a consistent neighbour does.
//!     d  |  c      A third face at a-b would be another entry.
//!      \ | /
//!        b
//! ```

use std::collections::HashMap;

use intertri::Triangle;

/// One face at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Side {
    /// The index of the face among the triangles.
    pub face: u32,
    /// Whether the face's winding traverses the edge from its first end to its second.
    pub forward: bool,
}

/// An edge and the faces that meet at the edge, in ascending order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge<'a> {
    /// Two indices into [`Adjacency::points`], the smaller first.
    pub ends: [u32; 2],
    /// The faces at the edge: one at an open boundary, two in a manifold, or more.
    pub sides: &'a [Side],
}

/// A mesh with welded points, and the faces at each of its edges.
///
/// Points are welded if their coordinates have the same bits, except that 0 and -0 are equal. This
/// reconnects meshes whose files repeat vertices, as at texture seams or in STL.
#[derive(Clone, Debug, Default)]
pub struct Adjacency {
    points: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    ends: Vec<([u32; 2], u32)>,
    sides: Vec<Side>,
}

impl Adjacency {
    /// Welds the corners of triangles and finds their edges. A triangle with two equal corners is
    /// degenerate: it keeps its index but contributes no edges.
    ///
    /// # Panics
    /// Panics if there are 2^30 triangles or more.
    ///
    /// ```
    /// use intertri::Triangle;
    /// use intertri_raster::Adjacency;
    /// let (a, b) = ([0.0; 3], [1.0, 0.0, 0.0]);
    /// let pair = [Triangle([a, b, [0.0, 1.0, 0.0]]), Triangle([b, a, [0.0, -1.0, 0.0]])];
    /// let adjacency = Adjacency::new(&pair);
    /// assert_eq!((adjacency.points().len(), adjacency.edges().count()), (4, 5));
    /// assert_eq!(adjacency.edges().filter(|edge| edge.sides.len() == 2).count(), 1);
    /// ```
    pub fn new(triangles: &[Triangle]) -> Self {
        assert!(triangles.len() < 1 << 30, "there must be fewer than 2^30 triangles");

        // Weld equal points, and number them in the order of their first use.
        let mut points = Vec::new();
        let mut numbers = HashMap::with_capacity(triangles.len());
        let mut number = |p: [f32; 3]| {
            // Adding 0 turns -0 into 0.
            let p = p.map(|x| x + 0.0);
            *numbers.entry(p.map(f32::to_bits)).or_insert_with(|| {
                points.push(p);
                points.len() as u32 - 1
            })
        };
        let faces: Vec<_> = triangles.iter().map(|t| t.0.map(&mut number)).collect();

        // Sort all edges of all faces. Equal edges become adjacent, in the order of their faces.
        let mut uses = Vec::with_capacity(3 * faces.len());
        for (face, &[a, b, c]) in (0..).zip(&faces) {
            if a != b && b != c && c != a {
                for (a, b) in [(a, b), (b, c), (c, a)] {
                    uses.push(([a.min(b), a.max(b)], Side { face, forward: a < b }));
                }
            }
        }
        uses.sort_unstable();
        let mut ends = Vec::new();
        for run in uses.chunk_by(|one, next| one.0 == next.0) {
            let first = ends.last().map_or(0, |&(_, end)| end);
            ends.push((run[0].0, first + run.len() as u32));
        }
        Self { points, faces, ends, sides: uses.into_iter().map(|(_, side)| side).collect() }
    }

    /// Returns the distinct corners, in the order of their first use by a triangle.
    pub fn points(&self) -> &[[f32; 3]] {
        &self.points
    }

    /// Returns the triangles in their original order, as indices into [`Adjacency::points`].
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Returns the three corners of a face.
    ///
    /// # Panics
    /// Panics if the index is out of bounds.
    pub fn corners(&self, face: usize) -> [[f32; 3]; 3] {
        self.faces[face].map(|corner| self.points[corner as usize])
    }

    /// Iterates over the edges, sorted by their ends. Each edge occurs once.
    pub fn edges(&self) -> impl Iterator<Item = Edge<'_>> {
        let firsts = std::iter::once(0).chain(self.ends.iter().map(|&(_, end)| end));
        self.ends.iter().zip(firsts).map(|(&(ends, end), first)| Edge {
            ends,
            sides: &self.sides[first as usize..end as usize],
        })
    }
}
