//! The defects of a mesh that should be closed: which edges and triangles have them, and how many.

use std::fmt;

use intertri::{Scalar, TriangleOf};

use super::edges::{Corner, Edges, SharedEdge, corner, is_finite};
use crate::util::memory::{NoMemory, room};
use crate::util::stop;

/// Edges of a mesh that have the same defect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeDefect<S> {
    /// Their number.
    pub count: usize,
    /// The first triangle with such an edge, and the two ends of the edge in that triangle's direction.
    pub first: Option<(usize, [[S; 3]; 2])>,
}

/// Triangles of a mesh that have the same defect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TriangleDefect {
    /// Their number.
    pub count: usize,
    /// The first of them, and the triangle that it duplicates.
    pub first: Option<(usize, usize)>,
}

/// The open edges, and the flipped and duplicate triangles, of a mesh, as found by
/// [`Solid::inspect`](super::Solid::inspect). Edges and triangles are the same if the coordinates of their
/// corners are.
///
/// ```
/// use intertri_trace::{Solid, intertri::Triangle};
/// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
/// let faces = [[x, y, o], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
/// let report = Solid::inspect(&faces)?;
/// assert!(!report.is_closed() && report.open.count == 0 && report.turned.count == 3);
/// assert_eq!(
///     report.to_string(),
///     "3 edges lie between triangles that are turned against each other, the first at triangle 0 \
///      from [0.0, 4.0, 0.0] to [0.0, 0.0, 0.0]"
/// );
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshReport<S = f32> {
    /// Edges of only one triangle.
    pub open: EdgeDefect<S>,
    /// Edges that two triangles traverse in the same direction: one of the two is flipped.
    pub turned: EdgeDefect<S>,
    /// Edges of three triangles or more that are traversed more often in one direction than in the other.
    pub uneven: EdgeDefect<S>,
    /// Triangles with the corners of an earlier one, in the same orientation.
    pub doubled: TriangleDefect,
    /// Triangles with the corners of an earlier one, in the opposite orientation: the two cancel.
    pub opposed: TriangleDefect,
}

impl<S: Scalar> MeshReport<S> {
    /// Inspects triangles; those that are not finite are left out.
    pub(super) fn of(triangles: &[TriangleOf<S>]) -> Result<Self, NoMemory> {
        let none = EdgeDefect { count: 0, first: None };
        let (mut open, mut turned, mut uneven) = (none, none, none);
        for edge in Edges::of(triangles)?.shared().filter(|edge| !edge.is_closed()) {
            match edge.counts() {
                [1, 0] | [0, 1] => open.add(&edge),
                [2, 0] | [0, 2] => turned.add(&edge),
                _ => uneven.add(&edge),
            }
        }
        let [doubled, opposed] = repeated(triangles)?;
        Ok(Self { open, turned, uneven, doubled, opposed })
    }

    /// Whether every edge is traversed equally often in both directions, so that winding numbers are
    /// integers.
    pub fn is_closed(&self) -> bool {
        self.open.count + self.turned.count + self.uneven.count == 0
    }
}

impl<S: Scalar> EdgeDefect<S> {
    fn add(&mut self, edge: &SharedEdge<'_, S>) {
        self.count += 1;
        self.first = [self.first, edge.first()].into_iter().flatten().min_by_key(|first| first.0);
    }
}

impl TriangleDefect {
    fn add(&mut self, triangle: usize, earlier: usize) {
        self.count += 1;
        self.first = self.first.into_iter().chain([(triangle, earlier)]).min();
    }
}

/// Triangles that duplicate others, in the same orientation and in the opposite one.
fn repeated<S: Scalar>(triangles: &[TriangleOf<S>]) -> Result<[TriangleDefect; 2], NoMemory> {
    // The sorted corners, and whether sorting took an odd number of swaps.
    type Key<S> = ([Corner<S>; 3], usize, bool);
    let key = |(i, triangle): (usize, &TriangleOf<S>)| -> Key<S> {
        let [mut a, mut b, mut c] = triangle.0.map(corner::<S>);
        let mut is_odd = false;
        // Sort three corners in two passes and keep the parity of the swaps: the same corners with the other
        // parity are the flipped triangle.
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
    let mut found = [TriangleDefect::default(); 2];
    for same in keys.chunk_by(|a, b| a.0 == b.0) {
        let (_, first, is_odd) = same[0];
        for &(_, triangle, other) in &same[1..] {
            found[usize::from(other != is_odd)].add(triangle, first);
        }
    }
    Ok(found)
}

impl<S: Scalar> fmt::Display for MeshReport<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut between = "";
        let edges = [
            (&self.open, "belongs to one triangle alone", "belong to one triangle alone"),
            (
                &self.turned,
                "lies between triangles that are turned against each other",
                "lie between triangles that are turned against each other",
            ),
            (
                &self.uneven,
                "has three triangles or more, which do not pair up",
                "have three triangles or more, which do not pair up",
            ),
        ];
        for (EdgeDefect { count, first }, one, many) in edges {
            if let Some((triangle, [from, to])) = first {
                let (noun, says) = if *count == 1 { ("edge", one) } else { ("edges", many) };
                let which = if *count == 1 { "" } else { "the first " };
                write!(
                    f,
                    "{between}{count} {noun} {says}, {which}at triangle {triangle} from {from:?} to {to:?}"
                )?;
                between = "; ";
            }
        }
        for (TriangleDefect { count, first }, way) in
            [(&self.doubled, "the same way round"), (&self.opposed, "the other way round")]
        {
            if let Some((triangle, earlier)) = first {
                let noun = if *count == 1 {
                    "triangle repeats another"
                } else {
                    "triangles repeat others"
                };
                let which = if *count == 1 { "" } else { "the first " };
                write!(
                    f,
                    "{between}{count} {noun} {way}, {which}triangle {triangle} that of {earlier}"
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

    use super::MeshReport;

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
        assert_eq!((open.open.count, open.open.first.map(|first| first.0)), (3, Some(0)));
        assert!(
            open.to_string()
                .starts_with("3 edges belong to one triangle alone, the first at triangle 0 from ")
        );

        // A duplicated face: its edges have three triangles, two of them in the same direction.
        let doubled = report(&[&CORNER[..], &[[Y, X, O]]].concat());
        assert_eq!(
            (doubled.uneven.count, doubled.doubled.first, doubled.opposed.count),
            (3, Some((4, 0)), 0)
        );
        assert!(
            doubled
                .to_string()
                .ends_with("; 1 triangle repeats another the same way round, triangle 4 that of 0")
        );

        // A face and its opposite cancel: the mesh is closed, but this is worth reporting.
        let opposed = report(&[&CORNER[..], &[[X, Y, O], [O, Y, X]]].concat());
        assert!(opposed.is_closed());
        assert_eq!((opposed.doubled.first, opposed.opposed.first), (Some((5, 0)), Some((4, 0))));
        assert!(report(&[]).is_closed());
        assert_eq!(report(&[[O, O, X], [O, O, X]]).doubled.count, 0);
    }
}
