//! Intersects rays with the triangles of a leaf, transformed to world space.

use std::marker::PhantomData;

use intertri::internal::RayLanes;
use intertri::internal::exact::{self, decide_with_t};
use intertri::simd::{Lanes, Mask, Simd, Vec3};
use intertri::{LeafSlot, Ray64, Rule, Triangle64};

use super::collect::{Candidate, Collect, NO_BOUNDS};
use super::matrix::{Matrix, placed, placed_triangle};
use super::mesh::SceneMesh;
use super::tree_ray::rounded_up;
use crate::util::lane_ops::lanes_of;
use crate::walk::single::Visit;

/// Broadcasts each entry of a matrix to all lanes.
#[inline(always)]
fn splat<S: Simd>(m: &[f64; 12]) -> [S::F64x8; 12] {
    // Use a loop, because the compiler does not always inline `map`.
    let mut rows = [Lanes::splat(0.0); 12];
    for (to, from) in rows.iter_mut().zip(m) {
        *to = Lanes::splat(*from);
    }
    rows
}

/// An instance's triangles in world space, and the rule that decides which rays hit them.
pub(super) struct PlacedMesh<'a, S> {
    pub(super) mesh: &'a SceneMesh,
    pub(super) matrix: &'a Matrix,
    pub(super) instance: u32,
    pub(super) rule: Rule,
    /// Hits count only if the geometry's mask shares a bit with this mask.
    pub(super) mask: u32,
    pub(super) level: PhantomData<S>,
}

impl<S: Simd> PlacedMesh<'_, S> {
    /// Returns the corners of a leaf's triangles in world space, exactly as the scene defines them.
    #[inline(always)]
    pub(super) fn corners(&self, leaf: usize) -> [Vec3<S::F64x8>; 3] {
        let [a, b, c] = self.mesh.leaf_corners::<S>(leaf);
        let rows = &splat::<S>(self.matrix);
        [placed(rows, a), placed(rows, b), placed(rows, c)]
    }

    /// Tests a ray against the triangles of a leaf, given their corners. `is_tame` means that f64
    /// lanes neither overflow nor underflow. Returns false once no further hit can count.
    #[inline(always)]
    pub(super) fn test(
        &self,
        (leaf, corners): (usize, [Vec3<S::F64x8>; 3]),
        (ray, is_tame): (&Ray64, bool),
        collect: &mut dyn Collect,
    ) -> bool {
        // Run the first tier of the exact test.
        let lanes = RayLanes::<S::F64x8>::of_ray(ray).until(Lanes::splat(collect.far()));
        let (decided, bounds) = decide_with_t(corners, &lanes);
        let sure = if self.rule == Rule::Closed { decided.closed } else { decided.inside };
        let (mut miss, mut sure) = (decided.miss.bits(), sure.bits());
        if !is_tame {
            let plain = self.plain(leaf, ray);
            (miss, sure) = (miss & plain, sure & plain);
        }
        // The remaining lanes are either certain hits or undecided. Both are rare, so process them
        // one lane at a time.
        let left = self.mesh.tree().present(leaf) & !miss;
        if left == 0 {
            return true;
        }
        let mut t = [[0.0; 8]; 2];
        bounds[0].store(&mut t[0]);
        bounds[1].store(&mut t[1]);
        self.settle((leaf, left, sure), &t, ray, collect)
    }

    /// Returns the triangle in a slot, in world space.
    fn triangle(&self, slot: LeafSlot) -> Triangle64 {
        placed_triangle(self.matrix, self.mesh.corners_in(slot))
    }

    /// Returns the lanes of a leaf in which f64 arithmetic neither overflows nor underflows.
    #[cold]
    #[inline(never)]
    fn plain(&self, leaf: usize, ray: &Ray64) -> u32 {
        let slot = |lane: usize| LeafSlot((8 * leaf + lane) as u32);
        let is_plain = |lane: &usize| exact::is_plain(ray, &self.triangle(slot(*lane)));
        (0..8).filter(is_plain).map(|lane| 1 << lane).sum()
    }

    /// Collects the hits in the given lanes of a leaf. Lanes in `sure` are certain hits, and have
    /// bounds on t. Returns false if no further hit can count.
    #[inline(never)]
    fn settle(
        &self,
        (leaf, lanes, sure): (usize, u32, u32),
        [lo, hi]: &[[f64; 8]; 2],
        ray: &Ray64,
        collect: &mut dyn Collect,
    ) -> bool {
        let tree = self.mesh.tree();
        for lane in lanes_of(lanes) {
            let slot = LeafSlot((8 * leaf + lane) as u32);
            let position = tree.index_of(slot);
            let triangle = self.triangle(slot);
            let is_sure = sure >> lane & 1 != 0;
            let is_hit = is_sure || exact::hit(self.rule, ray, &triangle);
            let counts =
                collect.all_geometries() || tree.geometries.mask_of(position) & self.mask != 0;
            if is_hit && counts {
                let instance = self.instance;
                let bounds = if is_sure { [lo[lane], hi[lane]] } else { NO_BOUNDS };
                if !collect.take(Candidate { instance, position: position.0, triangle }, bounds) {
                    return false;
                }
            }
        }
        true
    }
}

/// Tests a ray against the triangles of leaves in world space.
pub(super) struct VisitLeaves<'a, S> {
    pub(super) mesh: PlacedMesh<'a, S>,
    pub(super) ray: &'a Ray64,
    /// Whether f64 lanes can process the ray and the corners without overflow or underflow.
    pub(super) is_tame: bool,
    pub(super) collect: &'a mut (dyn Collect + 'a),
    /// The factor that converts the ray's t to the units of the mesh's tree.
    pub(super) unit: f64,
    pub(super) go_on: bool,
}

impl<S: Simd> Visit for VisitLeaves<'_, S> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        // Most rays that enter an instance reach no leaf, so compute the corners only here.
        let corners = self.mesh.corners(leaf);
        self.go_on = self.mesh.test((leaf, corners), (self.ray, self.is_tame), &mut *self.collect);
        self.go_on.then(|| self.far())
    }
}

impl<S: Simd> VisitLeaves<'_, S> {
    /// Returns the t beyond which hits no longer count, in the units of the mesh's tree.
    #[inline(always)]
    pub(super) fn far(&self) -> f32 {
        rounded_up(self.collect.far(), self.unit)
    }
}
