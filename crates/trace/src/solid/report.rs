//! Reports defective edges and duplicate triangles of a mesh that should be closed.

use std::fmt;

use intertri::{Scalar, TriangleOf};

use super::edges::{Corner, Edges, corner, is_finite};
use crate::util::memory::{NoMemory, room};
use crate::util::stop;

/// A defective edge of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DefectiveEdge<S> {
    /// The first triangle that contains the edge.
    pub triangle: usize,
    /// The corner of that triangle at which the edge starts. The edge ends at the next corner.
    pub corner: usize,
    /// The start and end of the edge.
    pub ends: [[S; 3]; 2],
}

/// A triangle with the same corners as an earlier triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct DuplicateTriangle {
    /// The index of the duplicate triangle.
    pub triangle: usize,
    /// The index of the earlier triangle.
    pub of: usize,
}

/// The open edges, flipped triangles, and duplicate triangles of a mesh, as found by
/// [`Solid::inspect`](super::Solid::inspect). Edges and triangles are considered equal if the
/// coordinates of their corners are equal. Each list is complete and sorted by triangle.
///
/// ```
/// use intertri_trace::{Solid, intertri::Triangle};
/// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
/// let faces = [[x, y, o], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
/// let report = Solid::inspect(&faces)?;
/// assert!(!report.is_closed() && report.open.is_empty() && report.turned.len() == 3);
/// assert_eq!(
///     report.to_string(),
///     "3 edges lie between triangles with opposite orientations, the first at triangle 0 \
///      from [4.0, 0.0, 0.0] to [0.0, 4.0, 0.0]"
/// );
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MeshReport<S = f32> {
    /// Edges that belong to only one triangle.
    pub open: Vec<DefectiveEdge<S>>,
    /// Edges that two triangles traverse in the same direction, so that one of the two is flipped.
    pub turned: Vec<DefectiveEdge<S>>,
    /// Edges that three or more triangles share and that are traversed more often in one direction
    /// than in the other.
    pub uneven: Vec<DefectiveEdge<S>>,
    /// Triangles that have the same corners as an earlier triangle, in the same orientation.
    pub doubled: Vec<DuplicateTriangle>,
    /// Triangles that have the same corners as an earlier triangle, in the opposite orientation.
    /// Two such triangles cancel.
    pub opposed: Vec<DuplicateTriangle>,
}

impl<S: Scalar> MeshReport<S> {
    /// Inspects triangles. Triangles that are not finite are ignored.
    pub(super) fn of(triangles: &[TriangleOf<S>]) -> Result<Self, NoMemory> {
        let (mut open, mut turned, mut uneven) = (Vec::new(), Vec::new(), Vec::new());
        for edge in Edges::of(triangles)?.shared().filter(|edge| !edge.is_closed()) {
            let list = match edge.counts() {
                [1, 0] | [0, 1] => &mut open,
                [2, 0] | [0, 2] => &mut turned,
                _ => &mut uneven,
            };
            if let Some((triangle, corner, ends)) = edge.first() {
                push(list, DefectiveEdge { triangle, corner, ends })?;
            }
        }
        for list in [&mut open, &mut turned, &mut uneven] {
            list.sort_unstable_by_key(|edge| (edge.triangle, edge.corner));
        }
        let [doubled, opposed] = repeated(triangles)?;
        Ok(Self { open, turned, uneven, doubled, opposed })
    }

    /// Returns whether every edge is traversed equally often in both directions. If so, winding
    /// numbers are integers.
    pub fn is_closed(&self) -> bool {
        self.open.is_empty() && self.turned.is_empty() && self.uneven.is_empty()
    }
}

/// Adds an item to a list, or returns an error if memory runs out.
fn push<T>(list: &mut Vec<T>, item: T) -> Result<(), NoMemory> {
    list.try_reserve(1).map_err(|_| NoMemory)?;
    list.push(item);
    Ok(())
}

/// Finds triangles that duplicate others, in the same and in the opposite orientation.
fn repeated<S: Scalar>(
    triangles: &[TriangleOf<S>],
) -> Result<[Vec<DuplicateTriangle>; 2], NoMemory> {
    // The sorted corners, the triangle's index, and whether sorting took an odd number of swaps.
    type Key<S> = ([Corner<S>; 3], usize, bool);
    let key = |(i, triangle): (usize, &TriangleOf<S>)| -> Key<S> {
        let [mut a, mut b, mut c] = triangle.0.map(corner::<S>);
        let mut is_odd = false;
        // Sort the three corners in two passes and track whether the number of swaps is odd. If two
        // triangles have the same corners but differ in parity, one is a flipped copy of the other.
        for _ in 0..2 {
            if b < a {
                (a, b, is_odd) = (b, a, !is_odd);
            }
            if c < b {
                (b, c, is_odd) = (c, b, !is_odd);
            }
        }
        ([a, b, c], i, is_odd)
    };
    let finite = triangles.iter().enumerate().filter(|(_, triangle)| is_finite(triangle));
    let mut keys = room(triangles.len())?;
    keys.extend(finite.map(key).filter(|([a, b, c], ..)| a != b && b != c));
    keys.sort_unstable_by(|a: &Key<S>, b| {
        stop::heed();
        a.cmp(b)
    });
    let mut found = [Vec::new(), Vec::new()];
    for same in keys.chunk_by(|a, b| a.0 == b.0) {
        let (_, of, is_odd) = same[0];
        for &(_, triangle, other) in &same[1..] {
            let list = &mut found[usize::from(other != is_odd)];
            push(list, DuplicateTriangle { triangle, of })?;
        }
    }
    for list in &mut found {
        list.sort_unstable();
    }
    Ok(found)
}

impl<S: Scalar> fmt::Display for MeshReport<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut between = "";
        let edges = [
            (&self.open, "belongs to only one triangle", "belong to only one triangle"),
            (
                &self.turned,
                "lies between triangles with opposite orientations",
                "lie between triangles with opposite orientations",
            ),
            (
                &self.uneven,
                "has three triangles or more, which do not pair up",
                "have three triangles or more, which do not pair up",
            ),
        ];
        for (edges, one, many) in edges {
            if let Some(DefectiveEdge { triangle, ends: [from, to], .. }) = edges.first() {
                let count = edges.len();
                let (noun, says) = if count == 1 { ("edge", one) } else { ("edges", many) };
                let which = if count == 1 { "" } else { "the first " };
                write!(
                    f,
                    "{between}{count} {noun} {says}, {which}at triangle {triangle} from {from:?} to {to:?}"
                )?;
                between = "; ";
            }
        }
        for (duplicates, way) in
            [(&self.doubled, "the same way round"), (&self.opposed, "the other way round")]
        {
            if let Some(DuplicateTriangle { triangle, of }) = duplicates.first() {
                let count = duplicates.len();
                let noun =
                    if count == 1 { "triangle repeats another" } else { "triangles repeat others" };
                let which = if count == 1 { "" } else { "the first is " };
                write!(
                    f,
                    "{between}{count} {noun} {way}: {which}triangle {triangle}, which repeats {of}"
                )?;
                between = "; ";
            }
        }
        if between.is_empty() { f.write_str("closed") } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use intertri::{Triangle, TriangleOf};

    use super::{DefectiveEdge, DuplicateTriangle, MeshReport};

    const O: [f32; 3] = [0.0; 3];
    const X: [f32; 3] = [1.0, 0.0, 0.0];
    const Y: [f32; 3] = [0.0, 1.0, 0.0];
    const Z: [f32; 3] = [0.0, 0.0, 1.0];
    const CORNER: [[[f32; 3]; 3]; 4] = [[O, Y, X], [O, X, Z], [O, Z, Y], [X, Y, Z]];

    fn report(triangles: &[[[f32; 3]; 3]]) -> MeshReport {
        let triangles: Vec<Triangle> =
            triangles.iter().map(|corners| TriangleOf(*corners)).collect();
        MeshReport::of(&triangles).unwrap()
    }

    #[test]
    fn defects_are_counted_and_named() {
        let whole = report(&CORNER);
        assert!(whole.is_closed() && whole.to_string() == "closed");
        let open = report(&CORNER[1..]);
        assert_eq!((open.open.len(), open.open[0].triangle), (3, 0));
        assert!(
            open.to_string()
                .starts_with("3 edges belong to only one triangle, the first at triangle 0 from ")
        );

        // If a face is duplicated, its edges belong to three triangles, two of which traverse them
        // in the same direction.
        let doubled = report(&[&CORNER[..], &[[Y, X, O]]].concat());
        assert_eq!(
            (doubled.uneven.len(), doubled.doubled.as_slice(), doubled.opposed.len()),
            (3, [DuplicateTriangle { triangle: 4, of: 0 }].as_slice(), 0)
        );
        assert!(doubled.to_string().ends_with(
            "; 1 triangle repeats another the same way round: triangle 4, which repeats 0"
        ));

        // Each edge has its direction in the first triangle that contains it, and edges are sorted
        // by triangle.
        let edges = |list: &[DefectiveEdge<f32>]| {
            list.iter().map(|edge| (edge.triangle, edge.corner, edge.ends)).collect::<Vec<_>>()
        };
        assert_eq!(edges(&open.open), [(0, 0, [O, X]), (1, 2, [Y, O]), (2, 0, [X, Y])]);
        let turned = report(&[CORNER[0], [X, O, Z], CORNER[2], CORNER[3]]);
        assert_eq!(edges(&turned.turned), [(0, 2, [X, O]), (1, 1, [O, Z]), (1, 2, [Z, X])]);
        assert_eq!(edges(&doubled.uneven), [(0, 0, [O, Y]), (0, 1, [Y, X]), (0, 2, [X, O])]);

        // A face and its flipped copy cancel. The mesh is therefore closed, but the pair is worth
        // reporting.
        let opposed = report(&[&CORNER[..], &[[X, Y, O], [O, Y, X]]].concat());
        assert!(opposed.is_closed());
        let of = |list: &[DuplicateTriangle]| {
            list.iter().map(|t| (t.triangle, t.of)).collect::<Vec<_>>()
        };
        assert_eq!((of(&opposed.doubled), of(&opposed.opposed)), (vec![(5, 0)], vec![(4, 0)]));
        assert!(report(&[]).is_closed());
        assert_eq!(report(&[[O, O, X], [O, O, X]]).doubled.len(), 0);
    }
}
