//! The type of a family.

use super::scene::{Case, Scene};
use crate::rng::Rng;

/// A named way to make scenes.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// A short name, of small letters and dashes.
    pub name: &'static str,
    /// A description, in one line.
    pub what: &'static str,
    /// The one number that the family depends on, if there is one.
    pub param: Option<Param>,
    pub(super) make: fn(&mut Rng, f64, usize, usize) -> Scene,
}

/// A positive number that a family depends on, to be swept in equal ratios.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Param {
    /// The meaning of the number.
    pub name: &'static str,
    /// One end of its range: the harmless one, where only one end hurts.
    pub from: f64,
    /// The other end.
    pub to: f64,
}

impl Family {
    /// A triangle and a ray, the parameter drawn from its range.
    pub fn case(&self, rng: &mut Rng) -> Case {
        let x = self.draw(rng);
        self.case_at(rng, x)
    }

    /// A triangle and a ray with a given parameter (ignored where the family has none).
    pub fn case_at(&self, rng: &mut Rng, x: f64) -> Case {
        let Scene { triangles, rays, threshold } = self.scene_at(rng, x, 1, 1);
        Case { triangle: triangles[0], ray: rays[0], threshold }
    }

    /// A scene, the parameter drawn from its range.
    pub fn scene(&self, rng: &mut Rng, triangles: usize, rays: usize) -> Scene {
        let x = self.draw(rng);
        self.scene_at(rng, x, triangles, rays)
    }

    /// A scene with a given parameter (ignored where the family has none).
    ///
    /// It has as many rays as asked for (none for 0 triangles) and as many triangles, except that a
    /// closed mesh has the largest number that is possible and not above it, if there is one.
    pub fn scene_at(&self, rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
        (self.make)(rng, x, triangles, rays)
    }

    fn draw(&self, rng: &mut Rng) -> f64 {
        self.param.map_or(1.0, |param| rng.log(param.from, param.to))
    }
}
