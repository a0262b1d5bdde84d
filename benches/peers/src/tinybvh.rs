//! An engine that uses tinybvh's `BVH8_CPU`, the fastest layout for single-ray calls, through the
//! `tinybvh-rs` crate.
//!
//! The layout requires AVX2. The C++ code is compiled for the CPU of the build machine, and the
//! crate offers this layout only to programs that are themselves compiled for AVX2. The crate has
//! no any-hit query for this layout, so shadow rays search for the closest hit within their
//! interval.

use std::ops::Range;

use intertri::{Ray, Triangle};
use tinybvh_rs::{Intersector, bvh, bvh8_cpu, mbvh};

use crate::engine::{Answer, Engine, Question, Singles};

#[cfg(not(target_feature = "avx2"))]
compile_error!("tinybvh needs AVX2: build with RUSTFLAGS=\"-C target-cpu=native\"");

pub struct TinyBvh {
    tree: Tree,
    rays: Singles<Padded>,
}

/// A ray as the C++ code expects it: 128 bytes, aligned to 64. The crate's type is half as large,
/// and the crate's `Ray::new` writes beyond the end of a ray, so this program builds rays itself.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Padded {
    ray: tinybvh_rs::Ray,
    rest: [u64; 8],
}

impl Padded {
    fn new(ray: &Ray) -> Self {
        // Invert the direction as tinybvh's constructor does, but without normalizing it.
        let inverse = |x: f32| if x.abs() > 1e-12 { 1.0 / x } else { tinybvh_rs::INFINITE };
        let hit = tinybvh_rs::Intersection {
            t: tinybvh_rs::INFINITE.min(ray.t_max),
            ..Default::default()
        };
        let (origin, dir) = (ray.origin, ray.dir);
        // Set all bits of the mask, so that no instance is masked out.
        let (padding_0, padding_1, padding_2) = (0xffff, 0, 0);
        let r_d = dir.map(inverse);
        let ray = tinybvh_rs::Ray { origin, padding_0, dir, padding_1, r_d, padding_2, hit };
        Self { ray, rest: [0; 8] }
    }
}

/// The hierarchy, which owns a copy of the triangles.
struct Tree(bvh8_cpu::BVH);

// SAFETY: the tree never changes once built; `intersect` reads it and writes only to the ray.
unsafe impl Send for Tree {}
// SAFETY: as for `Send`.
unsafe impl Sync for Tree {}

impl Tree {
    /// Finds the closest hit. tinybvh shortens the ray to that hit.
    fn closest(&self, mut own: Padded) -> Answer {
        let end = own.ray.hit.t;
        self.0.intersect(&mut own.ray);
        let hit = own.ray.hit;
        if hit.t < end { Answer { triangle: hit.prim, t: hit.t.into() } } else { Answer::MISS }
    }
}

impl TinyBvh {
    /// Builds the tree with spatial splits, as tinybvh's high-quality build does.
    pub fn new(triangles: &[Triangle]) -> Result<Self, String> {
        let corner = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let corners: Vec<[f32; 4]> =
            triangles.iter().flat_map(|triangle| triangle.0.map(corner)).collect();
        let text = |error: tinybvh_rs::Error| error.to_string();
        let mut two_way = bvh::BVH::new_hq(corners.as_slice().into()).map_err(text)?;
        two_way.split_leaves(4);
        let eight_way = mbvh::BVH::new(&two_way);
        let tree = Tree(bvh8_cpu::BVH::new(&eight_way).map_err(text)?);
        Ok(Self { tree, rays: Singles::default() })
    }
}

impl Engine for TinyBvh {
    fn load(&mut self, rays: &[Ray], question: Question) {
        self.rays.load(rays, question, Padded::new);
    }

    fn trace(&mut self, part: Range<usize>) {
        let Self { tree, rays } = self;
        rays.trace(part, |ray| tree.closest(*ray), |ray| tree.closest(*ray).is_hit());
    }

    fn answers(&self) -> Vec<Answer> {
        self.rays.answers()
    }
}
