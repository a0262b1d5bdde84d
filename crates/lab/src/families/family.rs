//! [`Family`], a named generator of scenes.

use super::scene::{Case, Scene};
use crate::rng::Rng;

/// A named generator of scenes.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// A short name in lowercase letters and dashes.
    pub name: &'static str,
    /// A one-line description.
    pub what: &'static str,
    /// The parameter of the family, if it has one.
    pub param: Option<Param>,
    pub(super) make: fn(&mut Rng, f64, usize, usize) -> Scene,
}

/// A positive parameter of a family, swept on a logarithmic scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Param {
    /// The quantity that the parameter measures.
    pub name: &'static str,
    /// One end of the range: the harmless end if only one end is harmful.
    pub from: f64,
    /// The other end of the range.
    pub to: f64,
}

impl Family {
    /// Generates a triangle and a ray, with the parameter drawn from its range.
    pub fn case(&self, rng: &mut Rng) -> Case {
        let x = self.draw(rng);
        self.case_at(rng, x)
    }

    /// Generates a triangle and a ray for a given parameter (ignored if the family has none).
    pub fn case_at(&self, rng: &mut Rng, x: f64) -> Case {
        let Scene { triangles, rays, threshold } = self.scene_at(rng, x, 1, 1);
        Case { triangle: triangles[0], ray: rays[0], threshold }
    }

    /// Generates a scene, with the parameter drawn from its range.
    pub fn scene(&self, rng: &mut Rng, triangles: usize, rays: usize) -> Scene {
        let x = self.draw(rng);
        self.scene_at(rng, x, triangles, rays)
    }

    /// Generates a scene for a given parameter (ignored if the family has none).
    ///
    /// The scene has the requested number of rays, or none if no triangles are requested. It has
    /// the requested number of triangles unless it is a closed mesh. A closed mesh has the largest
    /// number of faces that is possible within the request; if even the smallest mesh has too many,
    /// the scene contains only part of it.
    pub fn scene_at(&self, rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
        (self.make)(rng, x, triangles, rays)
    }

    fn draw(&self, rng: &mut Rng) -> f64 {
        self.param.map_or(1.0, |param| rng.log(param.from, param.to))
    }
}
