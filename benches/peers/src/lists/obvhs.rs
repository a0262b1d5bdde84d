//! Lists hits with obvhs, using a closure that collects each hit and then reports a miss, so that
//! traversal continues.

use std::ops::Range;

use glam::Vec3A;
use intertri::{Ray, Triangle};
use obvhs::BvhBuildParams;
use obvhs::ray::RayHit;

use super::collected::{Collected, ListedHit, sort};
use crate::engine::{Answer, Engine, Question};
use crate::obvhs::{Layout, Obvhs};

pub struct Every {
    obvhs: Obvhs,
    rays: Collected<obvhs::ray::Ray>,
}

impl Every {
    pub fn new(triangles: &[Triangle], wide: bool) -> Self {
        let obvhs = Obvhs::new(triangles, wide, BvhBuildParams::slow_build());
        Self { obvhs, rays: Collected::default() }
    }
}

impl Engine for Every {
    fn load(&mut self, rays: &[Ray], _: Question) {
        let vector = Vec3A::from_array;
        self.rays.load(rays, |r| {
            obvhs::ray::Ray::new(vector(r.origin), vector(r.dir), r.t_min, r.t_max)
        });
    }

    fn trace(&mut self, part: Range<usize>) {
        let Obvhs { layout, triangles, indices, .. } = &self.obvhs;
        self.rays.trace(part, |rays, lists| {
            for ray in rays {
                let first = lists.hits.len();
                let hits = &mut lists.hits;
                let mut take = |ray: &obvhs::ray::Ray, i: usize| {
                    let t = triangles[i].intersect(ray);
                    if t < ray.tmax {
                        hits.push(ListedHit { t, triangle: indices[i], u: 0.0, v: 0.0 });
                    }
                    f32::INFINITY
                };
                let mut none = RayHit::none();
                match layout {
                    Layout::Two(bvh) => bvh.ray_traverse(*ray, &mut none, &mut take),
                    Layout::Eight(bvh) => bvh.ray_traverse(*ray, &mut none, &mut take),
                };
                sort(&mut lists.hits[first..]);
                lists.ends.push(lists.hits.len());
            }
        });
    }

    fn answers(&self) -> Vec<Answer> {
        self.rays.answers()
    }
}
