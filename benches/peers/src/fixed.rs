//! The mode `fixed`, through its hierarchy: triangles and rays are snapped to a grid first, so that
//! its answers are exact on the grid and differ from the others' by the snapping.

use std::ops::Range;

use intertri::fixed::{self, Bits, Grid};
use intertri::{Hit, Ray};
use intertri_scene::Scene;
use intertri_trace::FixedBvh;

use crate::engine::{Answer, Engine, Question};

/// Rays that are snapped and asked at a time.
const CHUNK: usize = 1 << 14;

pub struct Fixed {
    bvh: FixedBvh,
    grid: Grid,
    mode: fixed::Fixed,
    rays: Vec<Ray>,
    snapped: Vec<fixed::Ray>,
    any: bool,
    hits: Vec<Hit>,
    seen: Vec<bool>,
}

impl Fixed {
    pub fn new(scene: &Scene) -> Result<Self, String> {
        // With room for rays that start a little off a surface.
        let room = |p: [f32; 3]| [0.99, 1.01].map(|scale| p.map(|x| x * scale));
        let ends = scene.mesh.bounds().map_or([[0.0; 3]; 2], |bounds| [bounds.min, bounds.max]);
        let looks = [scene.camera.eye(), scene.light.origin([0.0; 3])];
        let points = ends.into_iter().chain(looks).flat_map(room);
        let grid = Grid::around(points, Bits::FINE);
        let grid = grid.map_err(|e| e.to_string())?;
        let triangles: Result<Vec<_>, _> =
            scene.mesh.to_triangles().iter().map(|t| grid.triangle(t)).collect();
        let bvh = FixedBvh::new(&triangles.map_err(|e| e.to_string())?);
        let bvh = bvh.map_err(|e| e.to_string())?;
        let mode = fixed::Fixed::default();
        Ok(Self {
            bvh,
            grid,
            mode,
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
        let nothing = self.grid.ray_of([0; 3], [1, 0, 0]).expect("a ray of integers");
        self.rays = rays.to_vec();
        self.snapped = vec![nothing; rays.len()];
        self.any = question.any;
        self.hits = vec![Hit::MISS; rays.len()];
        self.seen = vec![false; rays.len()];
    }

    fn trace(&mut self, part: Range<usize>) {
        // So many at a time that they stay near.
        let Self { bvh, grid, mode, .. } = self;
        let (hits, seen) = (&mut self.hits[part.clone()], &mut self.seen[part.clone()]);
        let hits = hits.chunks_mut(CHUNK).zip(seen.chunks_mut(CHUNK));
        let (rays, snapped) = (&self.rays[part.clone()], &mut self.snapped[part]);
        let rays = rays.chunks(CHUNK).zip(snapped.chunks_mut(CHUNK));
        for ((rays, snapped), (hits, seen)) in rays.zip(hits) {
            grid.rays(rays, snapped, |_, why| panic!("the grid has room for every origin: {why}"));
            if self.any {
                bvh.any_batch(mode, snapped, seen);
            } else {
                bvh.closest_batch(mode, snapped, hits);
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
