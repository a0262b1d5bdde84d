//! The report of `inspect`.

use std::fmt;
use std::path::{Path, PathBuf};

use intertri::Scalar;
use intertri_lab::tables::grouped;
use intertri_trace::{DefectiveEdge, DuplicateTriangle, MeshReport};
use serde::{Serialize, Serializer};

use crate::engine::model::ModelNotes;
use crate::engine::scalar_name::ScalarName;

/// The report of `inspect`.
#[derive(Serialize)]
#[serde(bound = "")]
pub(crate) struct InspectReport<S: Scalar> {
    model: PathBuf,
    triangles: usize,
    scalar: ScalarName,
    /// Everything in the model that was omitted, repaired or guessed.
    notes: ModelNotes,
    is_closed: bool,
    open: Edges<S>,
    turned: Edges<S>,
    uneven: Edges<S>,
    doubled: Triangles,
    opposed: Triangles,
}

/// Edges with the same defect.
#[derive(Serialize)]
#[serde(bound = "")]
struct Edges<S: Scalar> {
    count: usize,
    #[serde(serialize_with = "edge_list")]
    edges: Vec<DefectiveEdge<S>>,
}

/// An edge with a defect, in the direction in which its first triangle traverses it.
#[derive(Serialize)]
struct Edge {
    triangle: usize,
    from: [f64; 3],
    to: [f64; 3],
}

/// Triangles with the same defect.
#[derive(Serialize)]
struct Triangles {
    count: usize,
    #[serde(serialize_with = "triangle_list")]
    triangles: Vec<DuplicateTriangle>,
}

/// A triangle that repeats another.
#[derive(Serialize)]
struct Triangle {
    triangle: usize,
    repeats: usize,
}

impl<S: Scalar> InspectReport<S> {
    pub(crate) fn new(
        model: &Path,
        triangles: usize,
        scalar: ScalarName,
        notes: ModelNotes,
        report: MeshReport<S>,
    ) -> Self {
        let edges = |edges: Vec<DefectiveEdge<S>>| Edges { count: edges.len(), edges };
        let repeated =
            |triangles: Vec<DuplicateTriangle>| Triangles { count: triangles.len(), triangles };
        Self {
            model: model.to_owned(),
            triangles,
            scalar,
            notes,
            is_closed: report.is_closed(),
            open: edges(report.open),
            turned: edges(report.turned),
            uneven: edges(report.uneven),
            doubled: repeated(report.doubled),
            opposed: repeated(report.opposed),
        }
    }
}

impl Edge {
    fn new<S: Scalar>(edge: &DefectiveEdge<S>) -> Self {
        let [from, to] = edge.ends.map(|end| end.map(Into::into));
        Self { triangle: edge.triangle, from, to }
    }
}

fn edge_list<S: Scalar, W: Serializer>(
    edges: &[DefectiveEdge<S>],
    to: W,
) -> Result<W::Ok, W::Error> {
    to.collect_seq(edges.iter().map(Edge::new))
}

fn triangle_list<W: Serializer>(triangles: &[DuplicateTriangle], to: W) -> Result<W::Ok, W::Error> {
    let repeats = |&DuplicateTriangle { triangle, of }| Triangle { triangle, repeats: of };
    to.collect_seq(triangles.iter().map(repeats))
}

impl<S: Scalar> fmt::Display for InspectReport<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = grouped(self.triangles as u64);
        let scalar = self.scalar.mention();
        writeln!(f, "{triangles:>12} triangles of {}{scalar}", self.model.display())?;
        for (Edges { count, edges }, what) in [
            (&self.open, "open edges, which belong to only one triangle"),
            (&self.turned, "edges between triangles with opposite orientations"),
            (&self.uneven, "edges of three or more triangles that do not pair up"),
        ] {
            if let Some(Edge { triangle, from, to }) = edges.first().map(Edge::new) {
                let count = grouped(*count as u64);
                writeln!(
                    f,
                    "{count:>12} {what}: the first from {from:?} to {to:?}, in triangle {triangle}"
                )?;
            }
        }
        for (Triangles { count, triangles }, way) in
            [(&self.doubled, "the same way round"), (&self.opposed, "the other way round")]
        {
            if let Some(DuplicateTriangle { triangle, of }) = triangles.first() {
                let count = grouped(*count as u64);
                writeln!(
                    f,
                    "{count:>12} triangles that repeat others {way}: the first is {triangle}, which repeats {of}"
                )?;
            }
        }
        write!(f, "{:>12} the model is {}closed", "", if self.is_closed { "" } else { "not " })
    }
}
