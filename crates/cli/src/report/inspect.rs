//! The report of `inspect`.

use std::fmt;
use std::path::{Path, PathBuf};

use intertri::Scalar;
use intertri_lab::tables::grouped;
use intertri_trace::{EdgeDefect, MeshReport, TriangleDefect};
use serde::Serialize;

use crate::engine::model::ModelNotes;
use crate::engine::scalar_name::ScalarName;

/// The report of `inspect`.
#[derive(Serialize)]
pub(crate) struct InspectReport {
    model: PathBuf,
    triangles: usize,
    scalar: ScalarName,
    /// Things in the model that were left out, repaired or guessed.
    notes: ModelNotes,
    is_closed: bool,
    open: Edges,
    turned: Edges,
    uneven: Edges,
    doubled: Triangles,
    opposed: Triangles,
}

/// Edges with the same defect.
#[derive(Serialize)]
struct Edges {
    count: usize,
    first: Option<FirstEdge>,
}

/// The first edge with a defect.
#[derive(Serialize)]
struct FirstEdge {
    triangle: usize,
    from: [f64; 3],
    to: [f64; 3],
}

/// Triangles with the same defect.
#[derive(Serialize)]
struct Triangles {
    count: usize,
    first: Option<FirstTriangle>,
}

/// The first triangle that repeats another.
#[derive(Serialize)]
struct FirstTriangle {
    triangle: usize,
    repeats: usize,
}

impl InspectReport {
    pub(crate) fn new<S: Scalar>(
        model: &Path,
        triangles: usize,
        scalar: ScalarName,
        notes: ModelNotes,
        report: MeshReport<S>,
    ) -> Self {
        let edges = |EdgeDefect { count, first }: EdgeDefect<S>| {
            let first = first.map(|(triangle, ends)| {
                let [from, to] = ends.map(|end| end.map(Into::into));
                FirstEdge { triangle, from, to }
            });
            Edges { count, first }
        };
        let repeated = |TriangleDefect { count, first }: TriangleDefect| {
            let first = first.map(|(triangle, repeats)| FirstTriangle { triangle, repeats });
            Triangles { count, first }
        };
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

impl fmt::Display for InspectReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = grouped(self.triangles as u64);
        let scalar = self.scalar.mention();
        writeln!(f, "{triangles:>12} triangles of {}{scalar}", self.model.display())?;
        for (Edges { count, first }, what) in [
            (&self.open, "open edges, which belong to one triangle alone"),
            (&self.turned, "edges between triangles that are turned against each other"),
            (&self.uneven, "edges of three triangles or more, which do not pair up"),
        ] {
            if let Some(FirstEdge { triangle, from, to }) = first {
                let count = grouped(*count as u64);
                writeln!(
                    f,
                    "{count:>12} {what}: the first from {from:?} to {to:?}, in triangle {triangle}"
                )?;
            }
        }
        for (Triangles { count, first }, way) in
            [(&self.doubled, "the same way round"), (&self.opposed, "the other way round")]
        {
            if let Some(FirstTriangle { triangle, repeats }) = first {
                let count = grouped(*count as u64);
                writeln!(
                    f,
                    "{count:>12} triangles that repeat others {way}: the first is {triangle}, which repeats {repeats}"
                )?;
            }
        }
        write!(f, "{:>12} the model is {}closed", "", if self.is_closed { "" } else { "not " })
    }
}
