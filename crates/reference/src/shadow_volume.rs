//! Document C: the silhouette that a light sees, and the shadow volume behind it.
//!
//! ```text
//!     light                       A face turned to the light is "front culled"; the others are
//!       *                         "back culled". Where a front-culled face has a back-culled
//!      . .                        neighbour, their edge is on the silhouette.
//!     .   .
//!    1 --- 2     the edge, in the order of the front-culled face
//!    | \   |
//!    |   \ |     the quad, seen from outside the volume
//!    4 --- 3     the edge again, BIG farther from the light
//! ```
//!
//! # Errors in the document
//! The document sets `index3 = index1 + BIG * lightdir` and `index4 = index2 + BIG * lightdir` and
//! calls the triangles (index2, index1, index3) and (index4, index3, index1) a quad. The two
//! triangles do not form a quad: they overlap in a quarter of the intended quad, leave another
//! quarter uncovered, and wind in opposite directions, so a stencil subtracts one triangle from the
//! other. With the **two new vertices exchanged**, so that `index3` is below `index2` and `index4`
//! is below `index1`, the same index triples form the quad in the drawing. This file exchanges the
//! vertices. The quad then runs along the common edge in the opposite direction to the front-culled
//! face, so lit faces and sides bound one closed, outward-facing volume.
//!
//! # What the document leaves open, and the choices made here
//! - **A missing neighbour** (an open mesh) counts as back culled, so that the volume stays closed.
//! - **The light.** `lightdir` is the direction in which light travels, but the test of a face uses
//!   the direction to the light. For a point light, both differ from vertex to vertex. Here,
//!   `lightdir` has unit length, so BIG is a distance.
//! - **Caps and drawing** are announced in the document but not described, and this file does not
//!   include them.
//!
//! The mesh must be wound consistently and have at most two faces at an edge; the document assumes
//! this, and its adjacency table cannot express anything else.

use alloc::vec::Vec;

use crate::vector::Vector;

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// A light so far away that its rays are parallel. The vector points **to** the light.
    Directional(Vector),
    /// A light at a point.
    Point(Vector),
}

impl Light {
    /// Returns the vector from a point to the light, of any length.
    fn seen_from(self, p: Vector) -> Vector {
        match self {
            Self::Directional(to_light) => to_light,
            Self::Point(place) => place - p,
        }
    }
}

/// The document's `ADJ` of one face `[index1, index2, index3]`: its neighbours across the edges
/// index1-index2, index2-index3 and index3-index1; `None` where the mesh is open.
pub type Adj = [Option<usize>; 3];

/// The sides of a shadow volume, without caps.
#[derive(Clone, Debug, PartialEq)]
pub struct Sides {
    /// The vertices of the mesh, then two new vertices for each edge of the silhouette.
    pub vertx: Vec<Vector>,
    /// Two triangles for each edge, in the order of the silhouette, wound counter-clockwise as seen
    /// from outside if the mesh is.
    pub triangles: Vec<[usize; 3]>,
}

/// Determines which faces are front culled: `dot(normal, direction to the light) >= 0`.
///
/// The normal is `(c2 - c1) ^ (c3 - c1)`, and the direction is taken at c1. Faces that are edge-on
/// to the light or degenerate are front culled; faces with a NaN coordinate are back culled.
///
/// # Panics
/// Panics if a face refers to a missing vertex.
pub fn front_culled(vertx: &[Vector], faces: &[[usize; 3]], light: Light) -> Vec<bool> {
    let front = |&[c1, c2, c3]: &[usize; 3]| {
        let normal = (vertx[c2] - vertx[c1]) ^ (vertx[c3] - vertx[c1]);
        (normal & light.seen_from(vertx[c1])) >= 0.0
    };
    faces.iter().map(front).collect()
}

/// Returns the edges between front-culled faces and their back-culled neighbours, face by face,
/// each in the direction of the front-culled face.
///
/// # Panics
/// Panics if `faces`, `adj`, and `front` differ in length, or if a neighbour is missing.
pub fn silhouette(faces: &[[usize; 3]], adj: &[Adj], front: &[bool]) -> Vec<[usize; 2]> {
    assert!(
        faces.len() == adj.len() && faces.len() == front.len(),
        "`adj` and `front` must have one entry per face"
    );
    let mut edges = Vec::new();
    for face in (0..faces.len()).filter(|&face| front[face]) {
        let [index1, index2, index3] = faces[face];
        let sides = [[index1, index2], [index2, index3], [index3, index1]];
        for (edge, neighbour) in sides.into_iter().zip(adj[face]) {
            let back_culled = neighbour.is_none_or(|neighbour| !front[neighbour]);
            if back_culled {
                edges.push(edge);
            }
        }
    }
    edges
}

/// Extrudes each edge of the silhouette into a quad, from the edge to the distance `big` behind the
/// edge.
///
/// `big` is the document's BIG: a distance that reaches beyond the scene. An edge through the
/// position of the light, or along its direction, yields a degenerate quad.
///
/// # Panics
/// Panics if an edge refers to a missing vertex.
pub fn extrude(vertx: &[Vector], edges: &[[usize; 2]], light: Light, big: f64) -> Sides {
    let mut vertx = Vec::from(vertx);
    let mut triangles = Vec::new();
    for &[index1, index2] in edges {
        let index3 = vertx.len();
        let index4 = index3 + 1;
        for above in [index2, index1] {
            let lightdir = light.seen_from(vertx[above]).unit() * -1.0;
            vertx.push(vertx[above] + lightdir * big);
        }
        triangles.extend([[index2, index1, index3], [index4, index3, index1]]);
    }
    Sides { vertx, triangles }
}
