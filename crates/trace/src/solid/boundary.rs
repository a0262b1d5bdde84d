//! The boundary of a mesh: loops formed by the edges that triangles traverse more often in one
//! direction than in the other.
//!
//! ```text
//!   ┌──▶──┬──▶──┐        Each triangle traverses its edges in order. Edges that neighbours traverse in
//!   ▲  ◀──┘  ◀──▼        opposite directions cancel. At each corner, as many of the remaining edges
//!   └──◀──┴──◀──┘        enter as leave, so they form loops.
//! ```

use intertri::{Scalar, TriangleOf};

use super::cluster::Clusters;
use super::edges::{Corner, Edges, of_corner};
use super::seen_corner::Axes;
use crate::util::memory::{NoMemory, filled, room};
use crate::util::stop;

/// The loops of a boundary, concatenated. Each loop ends with a copy of its first corner.
#[derive(Clone, Debug)]
pub(super) struct Boundary<S> {
    corners: Vec<[S; 3]>,
    /// The end of each loop in `corners`.
    ends: Vec<usize>,
    /// The same boundary, divided into small loops.
    pub(super) clusters: Clusters,
    pub(super) axes: Axes,
}

impl<S: Scalar> Boundary<S> {
    /// Returns the empty boundary of a closed mesh.
    pub(super) fn none() -> Self {
        Self { corners: Vec::new(), ends: Vec::new(), clusters: Clusters::NONE, axes: Axes::new() }
    }

    /// Computes the boundary of triangles.
    pub(super) fn of(triangles: &[TriangleOf<S>]) -> Result<Self, NoMemory> {
        let edges = Edges::of(triangles)?;
        let open = || edges.shared().filter(|edge| !edge.is_closed()).map(|edge| edge.excess());
        let mut arcs = room(open().map(|(_, _, times)| times).sum())?;
        for (from, to, times) in open() {
            arcs.extend((0..times).map(|_| (from, to)));
        }
        drop(edges);
        arcs.sort_unstable();
        Self::of_arcs(&arcs)
    }

    /// Builds loops from sorted arcs. Each corner must have equally many incoming and outgoing
    /// arcs.
    fn of_arcs(arcs: &[(Corner<S>, Corner<S>)]) -> Result<Self, NoMemory> {
        // For each corner, the number of outgoing arcs already used, stored at the corner's first
        // arc.
        let mut used = filled(arcs.len(), 0)?;
        let (mut corners, mut ends) = (room(2 * arcs.len())?, room(arcs.len())?);
        let mut first = 0;
        while first < arcs.len() {
            let from = arcs[first].0;
            let count = arcs[first..].partition_point(|arc| arc.0 == from);
            while used[first] < count {
                corners.push(of_corner::<S>(from));
                let mut at = first;
                loop {
                    stop::heed();
                    let to = arcs[at + used[at]].1;
                    used[at] += 1;
                    corners.push(of_corner::<S>(to));
                    if to == from {
                        break;
                    }
                    // Each corner has as many outgoing arcs as incoming ones, so an unused arc is
                    // always available here.
                    at = arcs.partition_point(|arc| arc.0 < to);
                }
                ends.push(corners.len());
            }
            first += count;
        }
        let clusters = Clusters::of(loops(&corners, &ends))?;
        Ok(Self { corners, ends, clusters, axes: Axes::new() })
    }

    /// Returns the number of edges.
    pub(super) fn edges(&self) -> usize {
        self.corners.len() - self.ends.len()
    }

    /// Iterates over the loops, each a slice of its corners.
    pub(super) fn loops(&self) -> impl Iterator<Item = &[[S; 3]]> + Clone {
        loops(&self.corners, &self.ends)
    }
}

/// Splits corners into loops that end at the given positions.
fn loops<'a, S>(
    corners: &'a [[S; 3]],
    ends: &'a [usize],
) -> impl Iterator<Item = &'a [[S; 3]]> + Clone {
    let starts = [0].into_iter().chain(ends.iter().copied());
    starts.zip(ends).map(|(start, &end)| &corners[start..end])
}

#[cfg(test)]
mod tests {
    use intertri::{Triangle, TriangleOf};

    use super::Boundary;

    fn boundary(triangles: &[Triangle]) -> Boundary<f32> {
        Boundary::of(triangles).unwrap()
    }

    #[test]
    fn duplicates_and_lines_may_close_a_mesh() {
        let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, -0.0, 0.0]];
        let edges = |triangles: &[Triangle]| boundary(triangles).edges();
        let flat = [Triangle([a, b, c]), Triangle([c, b, a])];
        assert_eq!((edges(&flat), edges(&flat[..1])), (0, 3));

        // Split an edge in half on one side only. A degenerate triangle closes the gap between the
        // two halves and the whole edge.
        let halves = [Triangle([a, b, c]), Triangle([d, c, b]), Triangle([c, d, a])];
        assert_eq!(edges(&halves), 3);
        assert_eq!(edges(&[&halves[..], &[Triangle([b, a, d])]].concat()), 0);
        assert_eq!(edges(&[&halves[..], &[Triangle([a, b, d])]].concat()), 6);

        // Include one triangle twice, and its reverse once.
        assert_eq!(edges(&[flat[0], flat[0], flat[1]]), 3);
        assert_eq!(edges(&[flat[0], flat[0], flat[1], flat[1]]), 0);
        assert_eq!(edges(&[]), 0);
        // Include a triangle with a corner that is not finite.
        assert_eq!(edges(&[flat[0], TriangleOf([a, b, [f32::NAN; 3]])]), 3);
    }

    /// Checks that the loops traverse each open edge in the direction in which more triangles
    /// traverse it, as many times as the difference.
    #[test]
    fn loops_are_all_that_is_open() {
        let at = |i: usize| [(i * 7 % 5) as f32, (i * 3 % 4) as f32, (i % 3) as f32];
        for count in 0..60 {
            let corner = |i: usize| at(i * i + count);
            let triangle = |i: usize| TriangleOf([corner(i), corner(i + 1), corner(3 * i + 2)]);
            let mesh: Vec<Triangle> = (0..count).map(triangle).collect();
            let mut left: Vec<([[f32; 3]; 2], i32)> = Vec::new();
            let mut add = |[a, b]: [[f32; 3]; 2], times: i32| {
                let (edge, times) = if a < b { ([a, b], times) } else { ([b, a], -times) };
                match left.iter_mut().find(|(other, _)| *other == edge) {
                    Some((_, all)) => *all += times,
                    None => left.push((edge, times)),
                }
            };
            for TriangleOf([a, b, c]) in &mesh {
                for edge in [[*a, *b], [*b, *c], [*c, *a]] {
                    add(edge, 1);
                }
            }
            let boundary = boundary(&mesh);
            for corners in boundary.loops() {
                assert_eq!(corners.first(), corners.last());
                for edge in corners.windows(2) {
                    add([edge[0], edge[1]], -1);
                }
            }
            assert!(left.iter().all(|([a, b], times)| a == b || *times == 0), "{left:?}");
            assert!(boundary.edges() <= 3 * count);
        }
    }
}
