//! The f64 backend: traversal uses f32 copies, and the resolver uses the originals.

use std::cell::RefCell;
use std::cmp::Ordering;
use std::io::{self, Write};
use std::ops::Range;
use std::slice::from_ref;

use bytemuck::Zeroable;
use intertri::internal::exact::{self, EightPairs, HitCoefficients, PairDecision, SeenPlane, Side};
use intertri::internal::{LocalFrame, Originals, Room, prefetch};
use intertri::simd::{Level, Simd, Vec3, WithSimd};
use intertri::{
    Filter, Hit, Hit32, LeafSlot, Mode, Ray, Ray64, RayId, Rule, Triangle64, TriangleBlock,
};

use super::mesh64::Mesh64;
use super::{Backend, Progress};
use crate::build::{BuildError, Triangles};
use crate::nearest::{ClosestPoint, closest_points};
use crate::refit::{Refit, RefitError};
use crate::save::{EightTriangles, Input, LoadError, read64, write64};
use crate::tree::{Aabb, BLOCK, HitBounds, LeafBounds, NONE, Tree};
use crate::util::crowd::crowd;
use crate::util::lane_ops::lanes_of;
use crate::util::memory::{NoMemory, OutOfMemory, copied, zeros};
use crate::util::threads;

/// The original triangles, in the leaf order of their copies, and the frame of the copies.
#[derive(Clone, Debug)]
pub struct Originals64 {
    frame: LocalFrame,
    leaves: Vec<EightTriangles>,
}

impl Originals64 {
    /// Returns the triangle in a leaf slot.
    #[inline]
    fn triangle(&self, slot: LeafSlot) -> &Triangle64 {
        &self.leaves.as_flattened()[slot.0 as usize]
    }
}

/// Stores the original triangles of each leaf.
fn keep(
    tree: &Tree,
    triangles: &[Triangle64],
    kept: &mut Vec<EightTriangles>,
) -> Result<(), NoMemory> {
    // Pages of freshly zeroed memory are untouched, so the threads below are the first to touch
    // them.
    kept.truncate(tree.leaves.len());
    if kept.is_empty() {
        *kept = zeros(tree.leaves.len())?.into_vec();
    }
    kept.try_reserve(tree.leaves.len() - kept.len())?;
    kept.resize(tree.leaves.len(), Zeroable::zeroed());
    // The contents of lanes without a triangle do not matter.
    let some = |i: u32| triangles.get(i as usize).copied().unwrap_or(Zeroable::zeroed());
    threads::write(kept, 1 << 7, |i| tree.leaves[i].indices.map(some));
    Ok(())
}

impl Backend for f64 {
    type Originals = Originals64;
    const PIECE: usize = 1 << 12;

    fn build(
        triangles: &[Triangle64],
        progress: Progress<'_>,
    ) -> Result<(Tree, Originals64), BuildError> {
        let copies = Copies::new(triangles);
        let (tree, frame) = (Tree::over(&copies, progress)?, copies.frame);
        let mut leaves = Vec::new();
        keep(&tree, triangles, &mut leaves)
            .map_err(|NoMemory| BuildError::OutOfMemory { count: triangles.len() })?;
        Ok((tree, Originals64 { frame, leaves }))
    }

    fn try_clone(originals: &Originals64) -> Result<Originals64, OutOfMemory> {
        let Originals64 { frame, leaves } = originals;
        Ok(Originals64 { frame: *frame, leaves: copied(leaves)? })
    }

    #[inline]
    fn with_ray<A>(
        tree: &Tree,
        originals: &Originals64,
        mode: Mode,
        ray: &Ray64,
        trace: impl FnOnce(&Filter<'_>, &Ray) -> A,
    ) -> A {
        // A single ray needs no buffer, because its copy fits on the stack.
        let copied = CopiedRays::new(tree, originals, mode, (from_ref(ray), 0..1));
        trace(&copied.filter(), &originals.frame.ray(ray))
    }

    fn with_rays<A>(
        tree: &Tree,
        originals: &Originals64,
        mode: Mode,
        rays: (&[Ray64], Range<usize>),
        trace: impl FnOnce(Filter<'_>, &[Ray]) -> A,
    ) -> A {
        // The thread reuses the memory for the copies between calls.
        let copied = CopiedRays::new(tree, originals, mode, rays);
        let mut copies = COPIES.take();
        originals.frame.rays(copied.level, copied.rays, &mut copies);
        let answer = trace(copied.filter(), &copies);
        COPIES.set(copies);
        answer
    }

    #[inline]
    fn triangle(_: &Tree, originals: &Originals64, slot: LeafSlot) -> Triangle64 {
        *originals.triangle(slot)
    }

    #[inline(always)]
    fn leaf_corners<L: Simd>(
        _: &Tree,
        originals: &Originals64,
        leaf: usize,
    ) -> [Vec3<L::F64x8>; 3] {
        let mut corners = [[[0.0; 8]; 3]; 3];
        for (lane, triangle) in originals.leaves[leaf].iter().enumerate() {
            for (rows, corner) in corners.iter_mut().zip(&triangle.0) {
                for (row, x) in rows.iter_mut().zip(corner) {
                    row[lane] = *x;
                }
            }
        }
        let [a, b, c] = &corners;
        [Vec3::load(a), Vec3::load(b), Vec3::load(c)]
    }

    fn frame(originals: &Originals64) -> ([f64; 3], f64) {
        let frame = &originals.frame;
        (frame.centre_and_exponent().0, frame.scale())
    }

    fn point(originals: &Originals64, point: [f64; 3]) -> [f32; 3] {
        originals.frame.point(point)
    }

    fn closest_points(
        tree: &Tree,
        originals: &Originals64,
        points: &[[f64; 3]],
        radius: f64,
        closest: &mut [ClosestPoint],
    ) {
        let Originals64 { frame, leaves } = originals;
        closest_points(Mesh64 { tree, frame, leaves }, points, radius, closest);
    }

    fn refit(
        tree: &mut Tree,
        originals: &mut Originals64,
        triangles: &[Triangle64],
    ) -> Result<Refit, RefitError> {
        // The copies use the frame that a new build would choose, which fits the moved triangles.
        let copies = Copies::new(triangles);
        let (refit, frame) = (tree.refit(&copies)?, copies.frame);
        originals.frame = frame;
        // The tree has been refitted, but the originals have not been replaced. Clear the tree,
        // because an empty tree is correct, but an inconsistent one is not.
        if let Err(NoMemory) = keep(tree, triangles, &mut originals.leaves) {
            tree.clear();
            return Err(RefitError::OutOfMemory);
        }
        Ok(refit)
    }

    fn write(tree: &Tree, originals: &Originals64, output: &mut dyn Write) -> io::Result<()> {
        write64(tree, &originals.frame, &originals.leaves, output)
    }

    fn read(input: &mut dyn Input) -> Result<(Tree, Originals64), LoadError> {
        let (tree, frame, leaves) = read64(input)?;
        Ok((tree, Originals64 { frame, leaves }))
    }
}

/// Returns the frame around all finite triangles.
fn frame_around(triangles: &[Triangle64]) -> LocalFrame {
    let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for triangle in triangles {
        let corners = triangle.0.as_flattened();
        // Zero times NaN or infinity is NaN, and a sum that includes NaN is NaN.
        if corners.iter().map(|x| x * 0.0).sum::<f64>() == 0.0 {
            for (i, &x) in corners.iter().enumerate() {
                (lo[i % 3], hi[i % 3]) = (lo[i % 3].min(x), hi[i % 3].max(x));
            }
        }
    }
    LocalFrame::around([lo, hi], crowd(triangles.iter().map(|triangle| triangle.0[0])))
}

/// The triangles of a mesh, to be copied to f32.
struct Copies<'a> {
    frame: LocalFrame,
    triangles: &'a [Triangle64],
    level: Level,
}

impl<'a> Copies<'a> {
    /// Prepares copies relative to the centre of the triangles.
    fn new(triangles: &'a [Triangle64]) -> Self {
        Self { frame: frame_around(triangles), triangles, level: Level::best() }
    }
}

impl Triangles for Copies<'_> {
    fn count(&self) -> usize {
        self.triangles.len()
    }

    fn hit_bounds(&self, i: usize) -> HitBounds {
        let triangle = &self.triangles[i];
        let Some(bounds) = self.frame.bounds(triangle) else { return HitBounds::Nowhere };
        let [lo, hi] = bounds.map(|[x, y, z]| [x, y, z, 0.0]);
        // The frame rounds the bounds outward to the next f32, so no margin is needed.
        let bounds = Aabb { lo, hi };
        // A triangle whose f64 normal rounds to zero may still have a tiny nonzero area, which
        // integer arithmetic detects.
        if triangle.normal() == [0.0; 3] && !exact::has_area(triangle) {
            return HitBounds::Degenerate(bounds);
        }
        HitBounds::Box { bounds, lean: 0.0 }
    }

    fn block(&self, indices: &[u32; BLOCK]) -> TriangleBlock<8> {
        let count = indices.iter().take_while(|&&i| i != NONE).count();
        let all = ((1_u64 << count) - 1) as u32;
        self.copied(indices, all, all)
    }

    fn moved(&self, indices: &[u32; BLOCK]) -> (TriangleBlock<8>, LeafBounds) {
        let mut leaf = LeafBounds::NONE;
        for (lane, &i) in indices.iter().enumerate().take_while(|(_, i)| **i != NONE) {
            let (bounds, lanes) = match self.hit_bounds(i as usize) {
                HitBounds::Nowhere | HitBounds::Thin(_) => continue,
                HitBounds::Box { bounds, .. } => (bounds, &mut leaf.boxed),
                HitBounds::Degenerate(bounds) => (bounds, &mut leaf.degenerate),
            };
            leaf.bounds.join(&bounds);
            *lanes |= 1 << lane;
        }
        (self.copied(indices, leaf.present(), leaf.boxed), leaf)
    }
}

impl Copies<'_> {
    /// Copies the triangles in the lanes of `present`. Of these, only the triangles in the lanes of
    /// `live` can be hit. All other lanes repeat the first present triangle.
    fn copied(&self, indices: &[u32; BLOCK], present: u32, live: u32) -> TriangleBlock<8> {
        let Some(first) = lanes_of(present).next() else { return TriangleBlock::of_copies(&[]) };
        let mut corners = [[[0.0; BLOCK]; 3]; 3];
        for lane in 0..BLOCK {
            let some = if present >> lane & 1 != 0 { lane } else { first };
            let triangle = &self.triangles[indices[some] as usize];
            for (rows, corner) in corners.iter_mut().zip(&triangle.0) {
                for (row, x) in rows.iter_mut().zip(corner) {
                    row[lane] = *x;
                }
            }
        }
        self.level.run(CopyBlock { frame: &self.frame, corners: &corners, live })
    }
}

/// Copies eight triangles in structure-of-arrays layout to f32.
struct CopyBlock<'a> {
    frame: &'a LocalFrame,
    corners: &'a [[[f64; BLOCK]; 3]; 3],
    live: u32,
}

impl WithSimd for CopyBlock<'_> {
    type Output = TriangleBlock<8>;

    #[inline(always)]
    fn run<S: Simd>(self) -> TriangleBlock<8> {
        self.frame.block_in::<S>(self.corners, self.live)
    }
}

thread_local! {
    /// The f32 copies of several rays; the memory is kept between calls.
    static COPIES: RefCell<Vec<Ray>> = const { RefCell::new(Vec::new()) };
    /// Memory for the coefficients of triangles, which are recomputed for each bundle.
    static SCRATCH: RefCell<Vec<[HitCoefficients; 8]>> = const { RefCell::new(Vec::new()) };
}

/// The rays whose f32 copies are traced through a tree, and the original rays for the resolver.
#[derive(Debug)]
struct CopiedRays<'a> {
    tree: &'a Tree,
    originals: &'a Originals64,
    rays: &'a [Ray64],
    /// The rays that follow in the batch.
    later: &'a [Ray64],
    room: Room,
    rule: Rule,
    level: Level,
}

impl<'a> CopiedRays<'a> {
    fn new(
        tree: &'a Tree,
        originals: &'a Originals64,
        mode: Mode,
        (all, some): (&'a [Ray64], Range<usize>),
    ) -> Self {
        let room = Room::of_copies(originals.frame.reach());
        let (rays, later) = (&all[some.clone()], &all[some.end..]);
        let rule = mode.rule().unwrap_or_else(|| unreachable!("no other mode is offered for f64"));
        Self { tree, originals, rays, later, room, rule, level: mode.level() }
    }

    /// Returns the filter over the copies, backed by the originals.
    fn filter(&self) -> Filter<'_> {
        Filter::on_copies(self, &self.room, self.level)
    }

    #[inline]
    fn pair(&self, ray: RayId, slot: LeafSlot) -> (&Ray64, &Triangle64) {
        (&self.rays[ray.0 as usize], self.originals.triangle(slot))
    }

    /// Converts the bounds on t to units of the ray's copy.
    #[inline]
    fn in_units_of_copy(&self, ray: &Ray64, decision: PairDecision) -> PairDecision {
        match decision {
            // The copy's t is scaled, so the bounds do not apply. This is rare.
            PairDecision::Hit { .. } if self.originals.frame.exponent(ray) != 0 => {
                PairDecision::HIT_ANYWHERE
            }
            decision => decision,
        }
    }
}

impl Originals for CopiedRays<'_> {
    fn decide(&self, ray: RayId, slot: LeafSlot) -> PairDecision {
        let (ray, triangle) = self.pair(ray, slot);
        self.in_units_of_copy(ray, exact::decide_pair(self.rule, ray, triangle))
    }

    fn rule(&self) -> Rule {
        self.rule
    }

    fn decide_eight(&self, rule: Rule, pairs: &[(RayId, LeafSlot)]) -> [Option<PairDecision>; 8] {
        let mut eight = EightPairs::new();
        for (lane, &(ray, slot)) in pairs.iter().enumerate() {
            let (ray, triangle) = self.pair(ray, slot);
            eight.set(lane, ray, triangle);
        }
        let mut decisions = eight.decide(self.level, rule);
        for (decision, &(ray, slot)) in decisions.iter_mut().zip(pairs) {
            *decision =
                decision.map(|decision| self.in_units_of_copy(self.pair(ray, slot).0, decision));
        }
        decisions
    }

    fn t(&self, ray: RayId, slot: LeafSlot) -> f64 {
        let (ray, triangle) = self.pair(ray, slot);
        // The traversal's copy of a very long or very short ray is scaled, so t must be scaled as
        // well.
        exact::t_times(ray, triangle, self.originals.frame.exponent(ray))
    }

    fn order(&self, ray: RayId, one: LeafSlot, other: LeafSlot) -> Ordering {
        let ((ray, one), (_, other)) = (self.pair(ray, one), self.pair(ray, other));
        exact::order(ray, one, other)
    }

    fn order_by_coordinates(&self, ray: RayId, one: LeafSlot, other: LeafSlot) -> Option<Ordering> {
        let ((ray, one), (_, other)) = (self.pair(ray, one), self.pair(ray, other));
        exact::order_by_coordinates(ray, one, other)
    }

    fn ray(&self, ray: RayId) -> &Ray64 {
        &self.rays[ray.0 as usize]
    }

    fn plane(&self, ray: RayId, slot: LeafSlot) -> SeenPlane<f64> {
        let (ray, triangle) = self.pair(ray, slot);
        SeenPlane::new(triangle, ray.origin)
    }

    fn known_order(&self, ray: RayId, one: LeafSlot, other: LeafSlot) -> Option<Ordering> {
        let ((ray, one), (_, other)) = (self.pair(ray, one), self.pair(ray, other));
        exact::known_order(ray, one, other)
    }

    fn shares_feature(&self, ray: RayId, (one, edges): (LeafSlot, u8), other: LeafSlot) -> bool {
        let ((_, one), (_, other)) = (self.pair(ray, one), self.pair(ray, other));
        exact::shares_feature(one, edges, other)
    }

    fn starts_on(&self, ray: RayId, slot: LeafSlot) -> bool {
        let (ray, triangle) = self.pair(ray, slot);
        exact::is_on(triangle, ray.origin)
    }

    fn facing(&self, ray: RayId, slot: LeafSlot) -> Option<Side> {
        let (ray, triangle) = self.pair(ray, slot);
        exact::facing(ray, triangle)
    }

    fn crossing(&self, ray: RayId, slot: LeafSlot) -> Option<Side> {
        let (ray, triangle) = self.pair(ray, slot);
        exact::crossing(ray, triangle)
    }

    fn later(&self, ray: RayId, count: usize) -> &[u8] {
        let later = self.later.get(ray.0 as usize..).unwrap_or(&[]);
        bytemuck::cast_slice(&later[..later.len().min(count)])
    }

    fn prefetch(&self, ray: RayId, slot: LeafSlot) {
        let (ray, triangle) = self.pair(ray, slot);
        prefetch(from_ref(ray));
        prefetch(from_ref(triangle));
    }

    fn shared_origin_hits(
        &self,
        rays: Range<u32>,
        slots: &[LeafSlot],
        pairs: &[(u32, u32)],
        hits: &mut [Hit],
    ) {
        let first = rays.start;
        let rays = &self.rays[first as usize..rays.end as usize];
        // Different f64 origins may have the same f32 copy.
        let origin = |ray: &Ray64| ray.origin.map(f64::to_bits);
        if rays.iter().any(|ray| origin(ray) != origin(&rays[0])) {
            // The f64 origins differ, so the shared-origin method cannot compute t, u, and v.
            for (&(ray, number), hit) in pairs.iter().zip(hits) {
                let slot = slots.get(number as usize);
                *hit =
                    slot.map_or(Hit::MISS, |&slot| self.hit_attributes(RayId(first + ray), slot));
            }
            return;
        }
        let triangle =
            |&slot: &LeafSlot| (self.originals.triangle(slot), self.tree.index_of(slot).0);
        let triangles: Vec<_> = slots.iter().map(triangle).collect();
        SCRATCH.with_borrow_mut(|scratch| {
            exact::hits_of_origin64(self.level, rays, &triangles, pairs, scratch, hits);
        });
    }

    fn hit32(&self, hit: &Hit, ray: RayId, slot: LeafSlot) -> Hit32 {
        let (ray, triangle) = self.pair(ray, slot);
        exact::hit32(hit, ray, triangle)
    }

    fn hits(&self, pairs: &[(RayId, LeafSlot)], hits: &mut [Hit]) {
        for (pairs, hits) in pairs.chunks(8).zip(hits.chunks_mut(8)) {
            let of = |i: usize| {
                // If there are fewer than eight pairs, repeat the last one and drop the extra
                // results.
                let (ray, slot) = pairs[i.min(pairs.len() - 1)];
                let (ray, triangle) = self.pair(ray, slot);
                (ray, triangle, self.tree.index_of(slot).0)
            };
            let eight: [_; 8] = std::array::from_fn(of);
            exact::hits64(self.level, &eight[..pairs.len()], hits);
        }
    }
}
