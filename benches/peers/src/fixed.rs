//! An engine that traces with the `fixed` mode, through a hierarchy. Triangles and rays are first
//! snapped to a grid, and each crossing is counted once. The answers are therefore exact on the
//! grid, and differ from those of other engines only because of the snapping.

use std::ops::Range;

use intertri::fixed::{self, Bits, Grid};
use intertri::{Hit, Ray};
use intertri_scene::Scene;
use intertri_trace::Bvh;

use crate::engine::{Answer, Engine, Question};

/// The number of rays in a chunk, which are snapped and traced together.
const CHUNK: usize = 1 << 14;

pub struct Fixed {
    bvh: Bvh,
    grid: Grid,
    rays: Vec<Ray>,
    snapped: Vec<fixed::Ray>,
    any: bool,
    hits: Vec<Hit>,
    seen: Vec<bool>,
}

impl Fixed {
    pub fn new(scene: &Scene) -> Result<Self, String> {
        // Leave a margin for rays that start slightly off a surface.
        let room = |p: [f32; 3]| [0.99, 1.01].map(|scale| p.map(|x| x * scale));
        let ends = scene.mesh.bounds().map_or([[0.0; 3]; 2], |bounds| [bounds.min, bounds.max]);
        let looks = [scene.camera.eye(), scene.light.origin([0.0; 3])];
        let points = ends.into_iter().chain(looks).flat_map(room);
        let grid = Grid::around(points, Bits::FINE);
        let grid = grid.map_err(|e| e.to_string())?;
        let triangles: Result<Vec<_>, _> =
            scene.mesh.to_triangles().iter().map(|t| grid.triangle(t)).collect();
        let triangles = triangles.map_err(|e| e.to_string())?;
        let bvh = Bvh::new(&triangles.iter().map(fixed::Triangle::to_f32).collect::<Vec<_>>());
        let bvh = bvh.map_err(|e| e.to_string())?;
        Ok(Self {
            bvh,
            grid,
            rays: vec![],
            snapped: vec![],
            any: false,
            hits: vec![],
            seen: vec![],
        })
    }
}

impl Engine for Fixed {
    fn load(&mut self, rays: &[Ray], question: Question) {
        let nothing = self.grid.ray_of([0; 3], [1, 0, 0]).expect("the ray is on the grid");
        self.rays = rays.to_vec();
        self.snapped = vec![nothing; rays.len()];
        self.any = question.any;
        self.hits = vec![Hit::MISS; rays.len()];
        self.seen = vec![false; rays.len()];
    }

    fn trace(&mut self, part: Range<usize>) {
        // Process one chunk at a time, so that it stays in the cache.
        let Self { bvh, grid, .. } = self;
        let (query, mut lines) = (bvh.query().once(), Vec::with_capacity(CHUNK));
        let (hits, seen) = (&mut self.hits[part.clone()], &mut self.seen[part.clone()]);
        let hits = hits.chunks_mut(CHUNK).zip(seen.chunks_mut(CHUNK));
        let (rays, snapped) = (&self.rays[part.clone()], &mut self.snapped[part]);
        let rays = rays.chunks(CHUNK).zip(snapped.chunks_mut(CHUNK));
        for ((rays, snapped), (hits, seen)) in rays.zip(hits) {
            grid.rays(rays, snapped, |_, why| panic!("the grid contains every origin: {why}"));
            lines.clear();
            lines.extend(snapped.iter().map(|ray| *ray.to_f32()));
            if self.any {
                query.any_batch_into(&lines, seen);
            } else {
                query.closest_batch_into(&lines, hits);
                for (ray, hit) in snapped.iter().zip(hits) {
                    hit.t = ray.t_of_caller(hit.t);
                }
            }
        }
    }

    fn answers(&self) -> Vec<Answer> {
        if self.any {
            self.seen.iter().map(|&hit| if hit { Answer::ANY } else { Answer::MISS }).collect()
        } else {
            let answer = |hit: &Hit| Answer { triangle: hit.triangle, t: hit.t };
            self.hits.iter().map(answer).collect()
        }
    }
}
