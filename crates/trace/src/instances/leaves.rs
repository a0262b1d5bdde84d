//! Tests the triangles of leaves at an instance's position in the world.

use std::marker::PhantomData;

use intertri::internal::RayLanes;
use intertri::internal::exact::{self, decide};
use intertri::simd::{Lanes, Mask, Simd};
use intertri::{LeafSlot, Ray64, Rule, Triangle64};

use super::collect::{Candidate, Collect};
use super::matrix::{Matrix, placed, placed_triangle};
use super::tree_ray::rounded_up;
use crate::bvh::Bvh;
use crate::scalar::BvhScalar;
use crate::tree::Tree;
use crate::util::lane_ops::lanes_of;
use crate::walk::single::Visit;

/// The numbers of a matrix, each in every lane.
#[inline(always)]
fn splat<S: Simd>(m: &[f64; 12]) -> [S::F64x8; 12] {
    // Not `map`, which is not always inlined.
    let mut rows = [Lanes::splat(0.0); 12];
    for (to, from) in rows.iter_mut().zip(m) {
        *to = Lanes::splat(*from);
    }
    rows
}

/// Tests the triangles of leaves at an instance's position in the world.
pub(super) struct VisitLeaves<'a, S, X: BvhScalar, C> {
    pub(super) bvh: &'a Bvh<X>,
    pub(super) matrix: &'a Matrix,
    pub(super) instance: u32,
    pub(super) ray: &'a Ray64,
    pub(super) rule: Rule,
    /// Geometries count whose masks share a bit with this one.
    pub(super) mask: u32,
    /// Whether computing in lanes loses nothing except by rounding.
    pub(super) is_tame: bool,
    pub(super) collect: &'a mut C,
    /// The factor from a t of the ray to one in the units of the mesh's tree.
    pub(super) unit: f64,
    pub(super) go_on: bool,
    pub(super) level: PhantomData<S>,
}

impl<S: Simd, X: BvhScalar, C: Collect> Visit for VisitLeaves<'_, S, X, C> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        let Bvh { tree, originals, .. } = self.bvh;
        // Eight triangles placed in the world by definition, and the first tier of the exact test, in lanes.
        let [a, b, c] = X::leaf_corners::<S>(tree, originals, leaf);
        // Most rays that enter an instance reach no leaf, so lanes are filled only here.
        let (rows, far) = (&splat::<S>(self.matrix), Lanes::splat(self.collect.far()));
        let ray = RayLanes::<S::F64x8>::of_ray(self.ray).until(far);
        let decided = decide([placed(rows, a), placed(rows, b), placed(rows, c)], &ray);
        let sure = if self.rule == Rule::Closed { decided.closed } else { decided.inside };
        let (mut miss, mut sure) = (decided.miss.bits(), sure.bits());
        if !self.is_tame {
            let plain = self.plain(leaf);
            (miss, sure) = (miss & plain, sure & plain);
        }
        // Anything that is not a certain miss is a certain hit or left to integers; both are rare, so they
        // are processed one by one.
        let left = tree.present(leaf) & !miss;
        if left != 0 {
            self.go_on = self.settle(leaf, left, sure);
            if !self.go_on {
                return None;
            }
        }
        Some(self.far())
    }
}

impl<S: Simd, X: BvhScalar, C: Collect> VisitLeaves<'_, S, X, C> {
    /// The t from which on hits no longer count, in the units of the mesh's tree.
    #[inline(always)]
    pub(super) fn far(&self) -> f32 {
        rounded_up(self.collect.far(), self.unit)
    }

    /// The triangle in a slot, in world space.
    fn triangle(&self, slot: LeafSlot) -> Triangle64 {
        let corners = self.bvh.triangle_in(slot).0;
        placed_triangle(self.matrix, corners.map(|corner| corner.map(Into::into)))
    }

    /// The lanes of a leaf in which f64 loses nothing except by rounding.
    #[cold]
    #[inline(never)]
    fn plain(&self, leaf: usize) -> u32 {
        let slot = |lane: usize| LeafSlot((8 * leaf + lane) as u32);
        let is_plain = |lane: &usize| exact::is_plain(self.ray, &self.triangle(slot(*lane)));
        (0..8).filter(is_plain).map(|lane| 1 << lane).sum()
    }

    /// Takes the hits among some lanes of a leaf; those in `sure` are certain. Returns false if no further
    /// hit can count.
    #[inline(never)]
    fn settle(&mut self, leaf: usize, lanes: u32, sure: u32) -> bool {
        let Tree { geometries, .. } = &self.bvh.tree;
        for lane in lanes_of(lanes) {
            let slot = LeafSlot((8 * leaf + lane) as u32);
            let position = self.bvh.tree.index_of(slot);
            let triangle = self.triangle(slot);
            let is_hit = sure >> lane & 1 != 0 || exact::hit(self.rule, self.ray, &triangle);
            let counts = C::ALL_GEOMETRIES || geometries.mask_of(position) & self.mask != 0;
            if is_hit && counts {
                let instance = self.instance;
                let hit = Candidate { instance, position: position.0, triangle };
                if !self.collect.take(hit) {
                    return false;
                }
            }
        }
        true
    }
}
