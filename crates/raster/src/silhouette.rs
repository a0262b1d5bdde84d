//! Document C: finds the faces that point toward the light, and the silhouette edges of their
//! shadow.
//!
//! The document selects the faces whose normals point toward the light, and the edges between them
//! and the other faces. This selection is correct for a closed mesh with consistent winding. Here,
//! **every** triangle casts a shadow, whatever its winding, just as it blocks a ray: a face that
//! points away from the light is flipped first. The silhouette is then a sum to which each face
//! contributes its three edges. Where two faces run along an edge in opposite directions, they
//! cancel:
//!
//! ```text
//!       / \
//!      / ^ \    Within a lit surface, directions are opposite, and the sum is 0: no silhouette.
//!     <--|-->   Along the document's silhouette, the far face was flipped, so both run the
//!      \ v /    same way, and the sum is 2: one shadow each.
//!       \ /     At an open border, the sum is 1; at three faces, it is -3, -1, 1, or 3.
//! ```
//!
//! For any mesh, this sum is the boundary of the faces after flipping, so the faces and the sides
//! along the silhouette leave no gap.

use robust::{Coord3D, orient3d};

use crate::adjacency::Adjacency;
use crate::vector::{Vector, double};

/// The light that casts the shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// A point light. A triangle's shadow begins at `1 / reach` times its distance from the light.
    Point {
        /// The light's position.
        position: [f32; 3],
        /// The fraction of the segment from the light to a surface within which a blocker casts a
        /// shadow. This is the `t_max` of shadow rays from the light (`t = 0`) to the surface
        /// (`t = 1`), and it must be above 0 and at most 1. Even with 1, a surface does not shadow
        /// itself.
        reach: f64,
    },
    /// A directional light, whose rays are parallel.
    Directional {
        /// The vector to the light, of any nonzero length. Shadow rays have the same length.
        toward: [f32; 3],
        /// The fraction of this vector within which a blocker casts a shadow, measured from the
        /// light's end (`t = 0`) to the surface (`t = 1`), as for a point light. A triangle's
        /// shadow begins behind the triangle, shifted away from the light by `1 - reach` times this
        /// vector.
        reach: f64,
    },
}

/// One edge of a silhouette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outline {
    /// Two indices into [`Adjacency::points`], in the direction of the faces once they point toward
    /// the light (counter-clockwise around each face, as seen from the light).
    pub ends: [u32; 2],
    /// The number of faces that run along the edge in this direction, minus the number that run in
    /// the other direction. It is always positive.
    pub count: u32,
}

/// Returns, for each face, 1 if its normal `(c2 - c1) × (c3 - c1)` points toward the light, -1 if
/// it points away, and 0 if the face casts no shadow because it is edge-on to the light,
/// degenerate, or not finite.
///
/// For a point light, the sign is exact. For a directional light, it is exact for the face's edge
/// vectors after these are rounded to f64.
pub fn facing(adjacency: &Adjacency, light: &Light) -> Vec<i8> {
    let coord = |[x, y, z]: Vector| Coord3D { x, y, z };
    let face = |face: usize| {
        let corners = adjacency.corners(face);
        if !corners.as_flattened().iter().all(|x| x.is_finite()) {
            return 0;
        }
        let [c1, c2, c3] = corners.map(double);
        // The determinant of (c1 - d, c2 - d, c3 - d) is negative where d is on the normal's side.
        let volume = match light {
            Light::Point { position, .. } => {
                orient3d(coord(c1), coord(c2), coord(c3), coord(double(*position)))
            }
            Light::Directional { toward, .. } => {
                let [h4, h5] = [c2, c3].map(|c| coord(crate::vector::sub(c, c1)));
                orient3d(Coord3D { x: 0.0, y: 0.0, z: 0.0 }, h4, h5, coord(double(*toward)))
            }
        };
        i8::from(volume < 0.0) - i8::from(volume > 0.0)
    };
    (0..adjacency.faces().len()).map(face).collect()
}

/// Returns the edges at which the directions of the faces do not cancel once the faces that point
/// away from the light are flipped.
///
/// # Panics
/// Panics if `facing` does not have one entry for each face.
pub fn silhouette(adjacency: &Adjacency, facing: &[i8]) -> Vec<Outline> {
    assert_eq!(facing.len(), adjacency.faces().len(), "`facing` must have one entry per face");
    let edges = adjacency.edges().filter_map(|edge| {
        let along = edge.sides.iter().map(|side| {
            let facing = i32::from(facing[side.face as usize]);
            if side.forward { facing } else { -facing }
        });
        let sum: i32 = along.sum();
        let [a, b] = edge.ends;
        let ends = if sum > 0 { [a, b] } else { [b, a] };
        (sum != 0).then_some(Outline { ends, count: sum.unsigned_abs() })
    });
    edges.collect()
}
