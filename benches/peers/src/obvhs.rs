//! An engine that uses the `obvhs` crate, with a binary or a compressed eight-wide hierarchy.

use std::ops::Range;
use std::time::Duration;

use glam::Vec3A;
use intertri::{Ray, Triangle};
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::RayHit;
use obvhs::rt_triangle::RtTriangle;

use crate::engine::{Answer, Engine, Question, Singles};

pub enum Layout {
    Two(Bvh2),
    Eight(CwBvh),
}

pub struct Obvhs {
    pub layout: Layout,
    /// The triangles, in the order in which they appear in the leaves.
    pub triangles: Vec<RtTriangle>,
    pub indices: Vec<u32>,
    rays: Singles<obvhs::ray::Ray>,
}

impl Obvhs {
    pub fn new(triangles: &[Triangle], wide: bool, params: BvhBuildParams) -> Self {
        let corner = Vec3A::from_array;
        let all: Vec<_> = (triangles.iter())
            .map(|t| obvhs::triangle::Triangle {
                v0: corner(t.0[0]),
                v1: corner(t.0[1]),
                v2: corner(t.0[2]),
            })
            .collect();
        let time = &mut Duration::default();
        let (layout, indices) = if wide {
            let bvh = build_cwbvh_from_tris(&all, params, time);
            let indices = bvh.primitive_indices.clone();
            (Layout::Eight(bvh), indices)
        } else {
            let bvh = build_bvh2_from_tris(&all, params, time);
            let indices = bvh.primitive_indices.clone();
            (Layout::Two(bvh), indices)
        };
        let triangles = indices.iter().map(|&i| RtTriangle::from(&all[i as usize])).collect();
        Self { layout, triangles, indices, rays: Singles::default() }
    }
}

impl Engine for Obvhs {
    fn load(&mut self, rays: &[Ray], question: Question) {
        let vector = Vec3A::from_array;
        self.rays.load(rays, question, |r| {
            obvhs::ray::Ray::new(vector(r.origin), vector(r.dir), r.t_min, r.t_max)
        });
    }

    fn trace(&mut self, part: Range<usize>) {
        let Self { layout, triangles, indices, rays } = self;
        let answer = |hit: &RayHit| match indices.get(hit.primitive_id as usize) {
            Some(&triangle) => Answer { triangle, t: hit.t.into() },
            None => Answer::MISS,
        };
        macro_rules! through {
            ($bvh:ident) => {
                rays.trace(
                    part,
                    |ray| {
                        let mut hit = RayHit::none();
                        $bvh.ray_traverse(*ray, &mut hit, |ray, i| triangles[i].intersect(ray));
                        answer(&hit)
                    },
                    |ray| !$bvh.ray_traverse_miss(*ray, |ray, i| triangles[i].intersect(ray)),
                )
            };
        }
        match layout {
            Layout::Two(bvh) => through!(bvh),
            Layout::Eight(bvh) => through!(bvh),
        }
    }

    fn answers(&self) -> Vec<Answer> {
        self.rays.answers()
    }
}
