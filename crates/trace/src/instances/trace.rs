//! Traces one ray through a scene: the tree of instances, then their meshes, then triangles in
//! world space.
//!
//! ```text
//!   world   tree of instances ──► an instance             triangles in world space, in f64 lanes ──► exact
//!   mesh                            └──► its tree, by a ray in mesh space ─┘
//!                                        or by its boxes in world space, if there is no useful inverse
//! ```

use std::marker::PhantomData;

use intertri::internal::exact;
use intertri::simd::{Simd, Vec3, WithSimd};
use intertri::{Ray64, Rule, Triangle64};

use super::collect::Collect;
use super::committed::{Committed, MeshEntry};
use super::leaves::{PlacedMesh, VisitLeaves};
use super::matrix::sizes;
use super::tree_ray::{TreeSlabs, rounded_down, rounded_up};
use super::world_walk::WorldWalk;
use crate::tree::{EMPTY, LEAF, Node};
use crate::walk::packet::PacketStack;
use crate::walk::single::{SlabLanes, TraversalScratch, Visit, Walk};

/// The traversal stacks for single rays and packets: one each for the instances and for a mesh.
pub(super) struct SceneScratch {
    instances: Box<TraversalScratch>,
    pub(super) mesh: Box<TraversalScratch>,
    pub(super) packets: [PacketStack; 2],
}

impl SceneScratch {
    pub(super) fn new(scene: &Committed) -> Self {
        Self {
            instances: TraversalScratch::new(scene.top.stack),
            mesh: TraversalScratch::new(scene.mesh_stack),
            packets: Default::default(),
        }
    }

    pub(super) fn fits(&self, scene: &Committed) -> bool {
        self.instances.fits(scene.top.stack) && self.mesh.fits(scene.mesh_stack)
    }
}

/// Traces one ray through a scene.
pub(super) struct Trace<'a> {
    pub(super) scene: &'a Committed,
    pub(super) ray: &'a Ray64,
    pub(super) rule: Rule,
    /// Hits count only if the masks of the instance and the geometry both share a bit with this
    /// mask.
    pub(super) mask: u32,
    pub(super) scratch: &'a mut SceneScratch,
    pub(super) collect: &'a mut (dyn Collect + 'a),
}

impl WithSimd for Trace<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { scene, ray, rule, mask, scratch, collect } = self;
        let is_finite = ray.origin.iter().chain(&ray.dir).all(|x| x.is_finite());
        // The comparison is false for NaN.
        if !(is_finite && ray.t_min < ray.t_max) {
            return;
        }
        let top = &scene.top;
        let is_tame = exact::is_plain(ray, &Triangle64([[0.0; 3]; 3]));
        let mut visitor = VisitOne {
            scene,
            ray,
            rule,
            mask,
            is_tame,
            scratch: &mut scratch.mesh,
            collect,
            unit: 1.0,
            level: PhantomData::<S>,
        };
        // Visit instances without finite boxes first, because their hits shorten the traversal.
        for &instance in &top.everywhere {
            if visitor.visit(instance as usize).is_none() {
                return;
            }
        }
        let in_tree = top.tree_ray([ray.origin, ray.dir].map(Vec3::<f64>::splat));
        let Some(TreeSlabs { slabs, octant, unit }) = TreeSlabs::new::<S>(in_tree, top.reach)
        else {
            // The origin is too far away, or the direction is too long or too short: test all
            // instances.
            let mut all = instances_below(&top.nodes);
            let _ = all.try_for_each(|instance| visitor.visit(instance).map(|_| ()));
            return;
        };
        visitor.unit = unit;
        let shortens = visitor.collect.shortens();
        let walk = Walk {
            nodes: &top.nodes,
            leaves: top.boxed,
            unboxed: top.boxed,
            thin_root: EMPTY,
            octant,
            t_min: rounded_down(ray.t_min, unit),
            far: rounded_up(visitor.collect.far(), unit),
            shortens,
            closest: shortens,
        };
        walk.run::<S>(&SlabLanes::splat(&slabs, octant), &mut scratch.instances, &mut visitor);
    }
}

/// Iterates over all instances below the given nodes.
fn instances_below(nodes: &[Node]) -> impl Iterator<Item = usize> {
    let children = nodes.iter().flat_map(Node::children);
    let leaves = children.filter(|&&child| child != EMPTY && child & LEAF != 0);
    leaves.map(|child| (child ^ LEAF) as usize)
}

/// Traces one ray through each instance that it may hit.
pub(super) struct VisitOne<'a, S> {
    pub(super) scene: &'a Committed,
    pub(super) ray: &'a Ray64,
    pub(super) rule: Rule,
    pub(super) mask: u32,
    /// Whether f64 lanes can process the ray without overflow or underflow.
    pub(super) is_tame: bool,
    pub(super) scratch: &'a mut TraversalScratch,
    pub(super) collect: &'a mut (dyn Collect + 'a),
    /// The factor that converts the ray's t to the units of the top tree.
    pub(super) unit: f64,
    pub(super) level: PhantomData<S>,
}

impl<S: Simd> Visit for VisitOne<'_, S> {
    #[inline(always)]
    fn visit(&mut self, instance: usize) -> Option<f32> {
        let is_seen = self.scene.frames[instance].mask & self.mask != 0;
        let Some(entry) = self.scene.mesh(instance).filter(|_| is_seen) else {
            return Some(rounded_up(self.collect.far(), self.unit));
        };
        // Call a separate function to leave registers free for the traversal.
        let go_on = S::vectorize(
            #[inline(always)]
            || self.enter(entry, instance),
        );
        go_on.then(|| rounded_up(self.collect.far(), self.unit))
    }
}

impl<S: Simd> VisitOne<'_, S> {
    /// Traces the ray through the mesh of an instance. Returns false if no further hit can count.
    #[inline(always)]
    fn enter(&mut self, MeshEntry { mesh, extent }: &MeshEntry, instance: usize) -> bool {
        let Self { scene, ray, rule, mask, is_tame, scratch, collect, .. } = self;
        let (tree, matrix) = (mesh.tree(), &scene.placed[instance].matrix);
        let frame = &scene.frames[instance];
        let (rule, mask, instance) = (*rule, *mask, instance as u32);
        let level = PhantomData;
        let mut leaves = VisitLeaves::<S> {
            mesh: PlacedMesh { mesh, matrix, instance, rule, mask, level },
            ray,
            is_tame: *is_tame && frame.is_tame,
            collect: &mut **collect,
            unit: 1.0,
            go_on: true,
        };
        let slabs = frame.inverse.is_useful().then(
            #[inline(always)]
            || {
                let from = [ray.origin, ray.dir].map(Vec3::<f64>::splat);
                let (ray, is_near) = frame.inverse.tree_ray(from, frame.reach);
                is_near.then(|| TreeSlabs::new::<S>(ray, frame.reach))?
            },
        );
        let slabs = slabs.flatten();
        let Some(TreeSlabs { slabs, octant, unit }) = slabs else {
            let sizes = sizes(matrix, extent);
            WorldWalk { tree, extent, matrix, sizes, ray }.run(&mut leaves);
            return leaves.go_on;
        };
        // The direction may have been scaled by a power of two, so from here on the traversal's t is
        // the ray's t times that factor.
        leaves.unit = unit;
        let interval = [rounded_down(ray.t_min, unit), leaves.far()];
        let shortens = leaves.collect.shortens();
        let walk = Walk {
            shortens,
            closest: shortens,
            ..Walk::new(tree, octant, interval, tree.leaves.len())
        };
        walk.run::<S>(&SlabLanes::splat(&slabs, octant), scratch, &mut leaves);
        leaves.go_on
    }
}
