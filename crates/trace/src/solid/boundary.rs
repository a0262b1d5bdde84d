//! The boundary of a mesh: the edges that are run along more often one way than the other.

use intertri::internal::Bits;
use intertri::{Scalar, TriangleOf};

use crate::util::memory::{NoMemory, room};
use crate::util::stop;

/// A corner as bits, both zeros alike.
type Corner<S> = [<S as Bits>::Key; 3];

/// An edge from its lower end to its higher one, whether its triangle runs that way, and the triangle.
type Edge<S> = (Corner<S>, Corner<S>, bool, usize);

/// A triangle, and from where to where it runs along an edge.
type OpenEdge<S> = (usize, [[S; 3]; 2]);

/// An edge that the mesh runs along more often one way than the other, and the first triangle that has it;
/// `None` where the mesh is closed.
pub(super) fn open_edge<S: Scalar>(
    triangles: &[TriangleOf<S>],
) -> Result<Option<OpenEdge<S>>, NoMemory> {
    let corner = |c: [S; 3]| c.map(S::key);
    let edges = |(i, t): (usize, &TriangleOf<S>)| {
        let [a, b, c] = t.0.map(corner);
        [(a, b, i), (b, c, i), (c, a, i)]
    };

    // Equal edges together.
    let mut all: Vec<Edge<S>> = room(3 * triangles.len())?;
    let directed = triangles.iter().enumerate().flat_map(edges).filter(|(from, to, _)| from != to);
    all.extend(directed.map(|(from, to, i)| {
        stop::heed();
        if from < to { (from, to, true, i) } else { (to, from, false, i) }
    }));
    all.sort_unstable_by(|a, b| {
        stop::heed();
        a.cmp(b)
    });

    let same = |a: &Edge<S>, b: &Edge<S>| (a.0, a.1) == (b.0, b.1);
    let open = |edge: &&[Edge<S>]| {
        stop::heed();
        2 * edge.iter().filter(|(_, _, up, _)| *up).count() != edge.len()
    };
    let first = |edge: &[Edge<S>]| {
        edge.iter().map(|&(lo, hi, up, i)| (i, if up { [lo, hi] } else { [hi, lo] })).min()
    };
    let found = all.chunk_by(same).filter(open).filter_map(first).min();
    Ok(found.map(|(triangle, edge)| (triangle, edge.map(|corner| corner.map(S::of_key)))))
}

#[cfg(test)]
mod tests {
    use intertri::{Scalar, Triangle, TriangleOf};

    fn open_edge<S: Scalar>(triangles: &[TriangleOf<S>]) -> Option<super::OpenEdge<S>> {
        super::open_edge(triangles).unwrap()
    }

    #[test]
    fn duplicates_and_lines_may_close_a_mesh() {
        let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, -0.0, 0.0]];
        let flat = [Triangle([a, b, c]), Triangle([c, b, a])];
        assert_eq!(open_edge(&flat), None);
        assert_eq!(open_edge(&flat[..1]), Some((0, [a, b])));

        // An edge in two halves meets the whole one by a triangle without area.
        let halves = [Triangle([a, b, c]), Triangle([d, c, b]), Triangle([c, d, a])];
        assert_eq!(open_edge(&halves), Some((0, [a, b])));
        assert_eq!(open_edge(&[&halves[..], &[Triangle([b, a, d])]].concat()), None);
        assert!(open_edge(&[&halves[..], &[Triangle([a, b, d])]].concat()).is_some());

        // Two of one, and one of the other.
        assert!(open_edge(&[flat[0], flat[0], flat[1]]).is_some());
        assert_eq!(open_edge(&[flat[0], flat[0], flat[1], flat[1]]), None);
        assert_eq!(open_edge::<f32>(&[]), None);
    }
}
