//! The walk: the nearest box first, and no box that is surely farther than something found.

use intertri::internal::exact::{has_area, squares};
use intertri::simd::{Lanes, Mask, Simd, Vec3};

use super::boxes;
use super::found::Candidate;
use crate::across::lanes_of;
use crate::single::{BOTTOM, Kept};
use crate::tree::{LEAF, Tree};

/// A search for the triangle that is closest to a point.
pub(super) struct Search<'a> {
    pub(super) bvh: &'a Tree,
    pub(super) point: [f32; 3],
    /// No square that is larger counts.
    pub(super) most: f64,
    /// The triangles that may be the closest.
    pub(super) candidates: &'a mut Vec<Candidate>,
}

impl Search<'_> {
    /// Walks the tree; first to a leaf that is likely to be near, if one is known. What remains are the candidates.
    #[inline(always)]
    pub(super) fn run<S: Simd>(&mut self, likely: Option<u32>, kept: &mut Kept) {
        let (bvh, point) = (self.bvh, Vec3::<S::F32x8>::splat(self.point));
        self.candidates.clear();
        if let Some(leaf) = likely {
            self.leaf::<S>(leaf as usize);
        }
        for leaf in bvh.boxed..bvh.leaves.len() {
            self.leaf::<S>(leaf);
        }

        let mut far = boxes::far_for(self.most);
        let (mut top, mut stack) = (kept.stack.bottom(0), kept.stack.entries());
        let mut next = if bvh.boxed > 0 { 0 } else { BOTTOM };
        loop {
            if next == BOTTOM {
                next = stack.pop_at_once(&mut top, far);
                if next == BOTTOM {
                    break;
                }
            }
            if next & LEAF != 0 {
                let leaf = (std::mem::replace(&mut next, BOTTOM) ^ LEAF) as usize;
                if likely != Some(leaf as u32) && self.leaf::<S>(leaf) {
                    far = boxes::far_for(self.most);
                }
                continue;
            }
            let node = &bvh.nodes[next as usize];
            let (met, squares) = boxes::squares(node, point, far);
            next = if met.any() {
                stack.push_nearest_first::<S>(&mut top, node, 0, met, squares)
            } else {
                BOTTOM
            };
        }
        let most = self.most;
        self.candidates.retain(|candidate| candidate.least <= most);
    }

    /// Adds the triangles of a leaf that may be the closest. Whether there are any.
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, leaf: usize) -> bool {
        let block = &self.bvh.leaves[leaf].block;
        let point = Vec3::<S::F32x8>::splat(self.point);
        let far = boxes::far_for(self.most);
        let near = boxes::may_be_near(block.corners(), point, far).bits() & block.live();
        if near == 0 {
            return false;
        }
        let [a, b, c] = block.corners();
        let point = Vec3::<S::F64x8>::splat(self.point.map(f64::from));
        let corners = [Vec3::load_f32(a), Vec3::load_f32(b), Vec3::load_f32(c)];
        let found = squares(corners, point);
        let mut near = found.least.le(Lanes::splat(self.most)).bits() & near;
        if near == 0 {
            return false;
        }
        // What may be a line is asked for its area before it can stand in another's way.
        let doubtful = near & !found.has_area.bits();
        if doubtful != 0 {
            let lines = lanes_of(doubtful).filter(|&lane| !has_area(&block.triangle(lane)));
            near &= !lines.fold(0, |lines, lane| lines | 1 << lane);
        }

        let (mut least, mut most) = ([0.0; 8], [0.0; 8]);
        found.least.store(&mut least);
        found.most.store(&mut most);
        for lane in lanes_of(near) {
            self.most = if most[lane] < self.most { most[lane] } else { self.most };
        }
        for lane in lanes_of(near) {
            if least[lane] <= self.most {
                let place = (8 * leaf + lane) as u32;
                self.candidates.push(Candidate { place, least: least[lane] });
            }
        }
        true
    }
}
