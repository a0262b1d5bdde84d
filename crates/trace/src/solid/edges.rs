//! The edges of a mesh, identified by the coordinates of their ends, and the number of times that
//! triangles traverse each edge in either direction.

use intertri::internal::Bits;
use intertri::{Scalar, TriangleOf};

use crate::util::memory::{NoMemory, room};
use crate::util::stop;

/// A corner as an ordered bit pattern, in which both zeros are equal.
pub(super) type Corner<S> = [<S as Bits>::Key; 3];

/// An edge from its lower to its higher end, whether its triangle traverses it in that direction,
/// and the edge's number: three times the triangle's index plus the corner at which the edge
/// starts.
type DirectedEdge<S> = (Corner<S>, Corner<S>, bool, usize);

/// The edges of all triangles, with equal edges adjacent.
pub(super) struct Edges<S: Scalar>(Vec<DirectedEdge<S>>);

/// An edge, with one entry for each triangle that contains it.
#[derive(Clone, Copy)]
pub(super) struct SharedEdge<'a, S: Scalar>(&'a [DirectedEdge<S>]);

impl<S: Scalar> Edges<S> {
    /// Collects the edges of triangles. Triangles with a non-finite corner are skipped, because no
    /// ray hits them.
    pub(super) fn of(triangles: &[TriangleOf<S>]) -> Result<Self, NoMemory> {
        let edges = |(i, t): (usize, &TriangleOf<S>)| {
            let [a, b, c] = t.0.map(corner::<S>);
            [(a, b, 3 * i), (b, c, 3 * i + 1), (c, a, 3 * i + 2)]
        };
        let mut all = room(3 * triangles.len())?;
        let finite = triangles.iter().enumerate().filter(|(_, triangle)| is_finite(triangle));
        let directed = finite.flat_map(edges).filter(|(from, to, _)| from != to);
        all.extend(directed.map(|(from, to, i)| {
            stop::heed();
            // Put the ends in a fixed order, so that both directions of an edge are sorted next to
            // each other.
            if from < to { (from, to, true, i) } else { (to, from, false, i) }
        }));
        all.sort_unstable_by(|a, b| {
            stop::heed();
            a.cmp(b)
        });
        Ok(Self(all))
    }

    /// Iterates over the distinct edges.
    pub(super) fn shared(&self) -> impl Iterator<Item = SharedEdge<'_, S>> + Clone {
        self.0.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).map(|edge| {
            stop::heed();
            SharedEdge(edge)
        })
    }
}

impl<S: Scalar> SharedEdge<'_, S> {
    /// Returns the number of triangles that traverse the edge from its lower end, and the number
    /// that do so from its higher end.
    pub(super) fn counts(&self) -> [usize; 2] {
        let up = self.0.iter().filter(|(_, _, up, _)| *up).count();
        [up, self.0.len() - up]
    }

    /// Returns whether triangles traverse the edge equally often in both directions.
    pub(super) fn is_closed(&self) -> bool {
        let [up, down] = self.counts();
        up == down
    }

    /// Returns the start and end of the edge in the direction in which more triangles traverse it,
    /// and the difference between the two counts.
    pub(super) fn excess(&self) -> (Corner<S>, Corner<S>, usize) {
        let (&(lo, hi, ..), [up, down]) = (&self.0[0], self.counts());
        let (from, to) = if up > down { (lo, hi) } else { (hi, lo) };
        (from, to, up.abs_diff(down))
    }

    /// Returns the edge as it occurs in the first triangle that contains it: the triangle, the
    /// corner at which the edge starts, and both ends.
    pub(super) fn first(&self) -> Option<(usize, usize, [[S; 3]; 2])> {
        let first = self.0.iter().min_by_key(|(.., number)| *number);
        first.map(|&(lo, hi, up, number)| {
            let ends = if up { [lo, hi] } else { [hi, lo] };
            (number / 3, number % 3, ends.map(of_corner::<S>))
        })
    }

    /// If exactly two triangles share the edge, returns both, and whether each traverses it from
    /// its lower end.
    pub(super) fn pair(&self) -> Option<[(usize, bool); 2]> {
        let triangle = |&(_, _, up, number): &DirectedEdge<S>| (number / 3, up);
        if let [a, b] = self.0 { Some([triangle(a), triangle(b)]) } else { None }
    }
}

/// Returns whether all coordinates of a triangle are finite.
pub(super) fn is_finite<S: Scalar>(triangle: &TriangleOf<S>) -> bool {
    triangle.0.as_flattened().iter().all(|x| x.is_finite())
}

pub(super) fn corner<S: Scalar>(corner: [S; 3]) -> Corner<S> {
    corner.map(S::key)
}

pub(super) fn of_corner<S: Scalar>(corner: Corner<S>) -> [S; 3] {
    corner.map(S::of_key)
}
