//! Document C: builds the shadow volumes behind the faces, as closed surfaces.
//!
//! ```text
//!           * light          Each face has a volume: everything behind it as seen from the
//!          / \               light, without limit. Its surface consists of
//!         /   \              - the near cap: the face itself, facing the light,
//!        a-----b             - a side along each edge: (b, a, far a, far b), facing outward,
//!       /.......\            - the far cap: the face at infinity, facing away.
//!      /.........\           The sides between neighbours cancel, so only the silhouette has sides.
//!  far a ------- far b
//! ```
//!
//! This is the document's quad with its two new vertices in the correct order
//! (`docs/documents.md`). The document's BIG is infinity here: a far point is a direction, with
//! `w = 0` in homogeneous coordinates, so there is no need for a finite number that is large enough
//! for the scene yet small enough for the arithmetic. For a directional light, all far points
//! coincide, the sides are triangles, and there is no far cap.
//!
//! The number of volumes that contain a point is the number of faces between the point and the
//! light, and also the winding number of the surfaces around the point. This holds for every mesh,
//! whether open, self-intersecting, inconsistently wound, or with many faces at an edge, and it is
//! what a two-sided shadow ray finds. Faces edge-on to the light cast no shadow.

use std::fmt;

use crate::adjacency::Adjacency;
use crate::silhouette::{Light, Outline, facing, silhouette};
use crate::vector::{Vector, add, double, scale, sub};

/// The shadow volumes of a mesh for one light. They do not depend on the view.
#[derive(Clone, Debug)]
pub struct Volume<'a> {
    adjacency: &'a Adjacency,
    light: Light,
    facing: Vec<i8>,
    silhouette: Vec<Outline>,
    /// The position at which the volume begins behind each point.
    near: Vec<Vector>,
    /// The direction in which the volume extends behind each point.
    far: Vec<Vector>,
}

impl<'a> Volume<'a> {
    /// Creates the volumes behind all faces of a mesh.
    ///
    /// # Errors
    /// Returns an error if the light is not finite, has no direction, or has a reach that is not
    /// above 0 and at most 1.
    pub fn new(adjacency: &'a Adjacency, light: Light) -> Result<Self, LightError> {
        let finite = |p: [f32; 3]| p.iter().all(|x| x.is_finite());
        let (Light::Point { position: place, reach } | Light::Directional { toward: place, reach }) =
            light;
        if !finite(place) {
            return Err(LightError::NotFinite);
        }
        if !(reach > 0.0 && reach <= 1.0) {
            return Err(LightError::Reach(reach));
        }
        if matches!(light, Light::Directional { toward, .. } if toward == [0.0; 3]) {
            return Err(LightError::Direction);
        }

        let facing = facing(adjacency, &light);
        let silhouette = silhouette(adjacency, &facing);
        let points = adjacency.points().iter().copied().map(double);
        let (near, far) = match light {
            // If the reach is 1, the near points must have the same bits as the points of the mesh.
            Light::Point { position, reach } => points
                .map(|p| (p, sub(p, double(position))))
                .map(|(p, away)| (add(p, scale(away, (1.0 - reach) / reach)), away))
                .unzip(),
            Light::Directional { toward, reach } => points
                .map(|p| (p, scale(double(toward), -1.0)))
                .map(|(p, away)| (add(p, scale(away, 1.0 - reach)), away))
                .unzip(),
        };
        Ok(Self { adjacency, light, facing, silhouette, near, far })
    }

    /// Returns the mesh.
    pub fn adjacency(&self) -> &'a Adjacency {
        self.adjacency
    }

    /// Returns the light.
    pub fn light(&self) -> Light {
        self.light
    }

    /// Returns the edges from which the sides of the volumes extend.
    pub fn silhouette(&self) -> &[Outline] {
        &self.silhouette
    }

    /// Returns the face's points in counter-clockwise order as seen from the light, or `None` if
    /// the face casts no shadow.
    pub(crate) fn cap(&self, face: usize) -> Option<[u32; 3]> {
        let [a, b, c] = self.adjacency.faces()[face];
        match self.facing[face] {
            0 => None,
            1 => Some([a, b, c]),
            _ => Some([a, c, b]),
        }
    }

    /// Returns the point where the volume begins behind a point of the mesh.
    pub(crate) fn near(&self, point: u32) -> Vector {
        self.near[point as usize]
    }

    /// Returns the direction in which the volume extends behind a point of the mesh.
    pub(crate) fn far(&self, point: u32) -> Vector {
        self.far[point as usize]
    }
}

/// The reason that the shadow volumes cannot be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightError {
    /// A coordinate of the light is NaN or infinite.
    NotFinite,
    /// The direction to the light is zero.
    Direction,
    /// The reach is not above 0 and at most 1.
    Reach(f64),
}

impl fmt::Display for LightError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "light: a coordinate is not finite; give finite numbers"),
            Self::Direction => write!(f, "light: its direction is zero; give any other vector"),
            Self::Reach(reach) => {
                write!(f, "light: a reach of {reach}; give a number above 0 and at most 1")
            }
        }
    }
}

impl std::error::Error for LightError {}
