//! The four workloads.

use super::closed_mesh::closed_mesh;
use super::model::Model;
use crate::families::{self, FAMILIES};
use crate::layout::Form;
use crate::rng::Rng;
use crate::test_batch::TestBatch;

/// A workload: one kind of batch, with its own panel in the chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workload {
    /// 8×8 tiles of camera rays, and the 32 triangles nearest to the tile's middle ray.
    Camera,
    /// 64 rays from random points on the model to the neighbourhood of one triangle, and the 32
    /// triangles of that neighbourhood, as when diffuse rays reach a leaf of a hierarchy.
    Secondary,
    /// 64 rays from inside a closed convex mesh, each aimed exactly at a vertex or a point on an
    /// edge, and all triangles of the mesh.
    Edges,
    /// The adversarial mix.
    Mix,
}

impl Workload {
    /// All workloads, in the order of the panels.
    pub const ALL: [Self; 4] = [Self::Camera, Self::Secondary, Self::Edges, Self::Mix];

    /// Returns the name: `camera`, `secondary`, `edges`, or `mix`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Secondary => "secondary",
            Self::Edges => "edges",
            Self::Mix => "mix",
        }
    }

    /// Returns the form in which the chart measures the workload: blocks of triangles for the
    /// incoherent secondary rays, and ray packets for the other workloads.
    pub fn form(self) -> Form {
        if self == Self::Secondary { Form::Blocks } else { Form::Packets }
    }

    /// Generates a batch of this kind. [`Workload::Camera`] and [`Workload::Secondary`] use the
    /// model.
    pub fn batch(self, rng: &mut Rng, model: &Model) -> TestBatch {
        match self {
            Self::Camera => model.tile(rng),
            Self::Secondary => model.leaf(rng),
            Self::Edges => closed_mesh(rng, 18, 64),
            Self::Mix => {
                let random = families::find("random").filter(|_| rng.one_in(2));
                let family = random.copied().unwrap_or_else(|| rng.pick(FAMILIES));
                let scene = family.scene(rng, 16, 16);
                TestBatch { rays: scene.rays, triangles: scene.triangles }
            }
        }
    }
}
