//! Packet traversal: traces up to sixteen coherent rays through a scene together.
//!
//! ```text
//!   sixteen rays ──► tree of instances ──► instance ──► rays that reach it, in mesh space ──► its tree
//!                                                                                                │
//!              each ray that reaches the leaf ◄── moved to world space once ◄── a leaf ◄─────────┘
//! ```
//!
//! Each lane does what [`Trace`] does for a single ray. Boxes are widened by the largest margin
//! that any ray of the packet needs, so no ray loses a hit.

use std::marker::PhantomData;

use intertri::internal::exact;
use intertri::internal::prefetch;
use intertri::simd::{Lanes, Mask, Simd, Vec3, WithSimd};
use intertri::{Ray64, RayPacket, Rule, Triangle64};

use super::collect::Collect;
use super::committed::{Committed, MeshEntry};
use super::leaves::PlacedMesh;
use super::matrix::TreeRay;
use super::trace::{SceneScratch, Trace, VisitOne};
use super::tree_ray::{all_rounded_down, all_rounded_up, rounded_up};
use crate::tree::{EMPTY, Margin};
use crate::util::lane_ops::lanes_of;
use crate::util::patience::Patience;
use crate::walk::packet::{Boxes, RAYS, VisitTogether, is_coherent, negative, octants};
use crate::walk::single::{SlabLanes, Visit};

/// If fewer rays than this visit an instance or box together, tracing them one by one is faster.
const TOGETHER: usize = 2;

/// After the rays of a packet diverge, this many packets are traced ray by ray. The count starts at
/// the first value and doubles with each further failure, up to the second value.
const PATIENCE: [usize; 2] = [4, 256];

/// Returns the state that decides whether to try a packet, based on earlier packets of the batch.
pub(super) fn patience() -> Patience {
    Patience::new(PATIENCE)
}

/// Traces up to sixteen rays through a scene, together if that is faster.
pub(super) struct TraceSome<'a, 'c> {
    pub(super) scene: &'a Committed,
    pub(super) rays: &'a [Ray64],
    pub(super) rule: Rule,
    pub(super) mask: u32,
    pub(super) scratch: &'a mut SceneScratch,
    pub(super) patience: &'a mut Patience,
    /// The collector of each ray's hits.
    pub(super) collect: &'a mut [&'c mut (dyn Collect + 'c)],
}

/// Returns whether at least two rays can hit anything and all rays that can do so have similar
/// directions.
#[inline(always)]
fn are_coherent<S: Simd>(rays: &[Ray64]) -> bool {
    let (mut dir, mut live) = ([[0.0; RAYS]; 3], 0);
    for (lane, ray) in rays.iter().enumerate() {
        for (to, x) in dir.iter_mut().zip(ray.dir) {
            to[lane] = x as f32;
        }
        live |= u32::from(ray.t_min < ray.t_max) << lane;
    }
    is_coherent::<S>(&dir, live)
}

impl WithSimd for TraceSome<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { scene, rays, rule, mask, scratch, patience, collect } = self;
        let mut alone = u32::MAX >> (32 - rays.len());
        if patience.is_waiting() {
            patience.pass();
        } else if are_coherent::<S>(rays) {
            let mut packet = VisitInstances::<S> {
                scene,
                world: World::new(rays),
                rule,
                mask,
                scratch,
                collect,
                until: [f64::NAN; RAYS],
                live: 0,
                unit: [1.0; RAYS],
                far: [f32::NAN; RAYS],
                work: [0; 2],
                level: PhantomData,
            };
            alone = packet.run();
            let [visits, visitors] = packet.work;
            patience.tried(visitors >= TOGETHER * visits);
        }
        for lane in lanes_of(alone) {
            let (ray, scratch, collect) = (&rays[lane], &mut *scratch, &mut *collect[lane]);
            Trace { scene, ray, rule, mask, scratch, collect }.run::<S>();
        }
    }
}

/// Rays in world space.
struct World<'a> {
    rays: &'a [Ray64],
    origin: [[f64; RAYS]; 3],
    dir: [[f64; RAYS]; 3],
    t_min: [f64; RAYS],
    /// A mask of the rays that may hit something.
    live: u32,
    /// A mask of the rays whose values neither overflow nor underflow in f64 lanes.
    tame: u32,
}

impl<'a> World<'a> {
    fn new(rays: &'a [Ray64]) -> Self {
        let ([origin, dir], t_min) = ([[[0.0; RAYS]; 3]; 2], [0.0; RAYS]);
        let mut world = Self { rays, origin, dir, t_min, live: 0, tame: 0 };
        for (lane, ray) in rays.iter().enumerate() {
            for axis in 0..3 {
                world.origin[axis][lane] = ray.origin[axis];
                world.dir[axis][lane] = ray.dir[axis];
            }
            world.t_min[lane] = ray.t_min;
            let is_finite = ray.origin.iter().chain(&ray.dir).all(|x| x.is_finite());
            // The comparison is false for NaN.
            world.live |= u32::from(is_finite && ray.t_min < ray.t_max) << lane;
            let is_tame = exact::is_plain(ray, &Triangle64([[0.0; 3]; 3]));
            world.tame |= u32::from(is_tame) << lane;
        }
        world
    }

    /// Transforms the rays in `some` to a tree's units, eight at a time. `into` also returns a mask
    /// of the rays that it could transform.
    #[inline(always)]
    fn in_tree<S: Simd>(
        &self,
        some: u32,
        into: impl Fn([Vec3<S::F64x8>; 2]) -> (TreeRay<S::F64x8>, <S::F64x8 as Lanes>::Mask),
    ) -> InTree {
        let mut rays = InTree {
            packet: RayPacket::new(&[]),
            unit: [1.0; RAYS],
            room: 0.0,
            some: 0,
            negative: [0; 3],
        };
        let mut most = S::F64x8::splat(0.0);
        for first in [0, 8] {
            let some = some >> first & 0xFF;
            if some == 0 {
                continue;
            }
            let (ray, is_near) =
                into([eight::<S>(&self.origin, first), eight::<S>(&self.dir, first)]);
            let (TreeRay { origin, dir, room }, unit, is_sane) = ray.scaled();
            let some = some & (is_near & is_sane).bits();
            rays.some |= some << first;
            unit.store(&mut rays.unit[first..]);
            let [x, y, z] = &mut rays.packet.origin;
            origin.x.store_f32(&mut x[first..]);
            origin.y.store_f32(&mut y[first..]);
            origin.z.store_f32(&mut z[first..]);
            let [x, y, z] = &mut rays.packet.dir;
            dir.x.store_f32(&mut x[first..]);
            dir.y.store_f32(&mut y[first..]);
            dir.z.store_f32(&mut z[first..]);
            let some = <S::F64x8 as Lanes>::Mask::from_bits(some);
            most = most.max(Lanes::select(some, room, Lanes::splat(0.0)));
        }
        let mut rooms = [0.0; 8];
        most.store(&mut rooms);
        rays.room = rooms.into_iter().fold(0.0, f64::max);
        rays.negative = negative::<S>(&rays.packet.dir);
        rays
    }
}

/// Loads eight of sixteen vectors, starting at `first`.
#[inline(always)]
fn eight<S: Simd>([x, y, z]: &[[f64; RAYS]; 3], first: usize) -> Vec3<S::F64x8> {
    Vec3 { x: Lanes::load(&x[first..]), y: Lanes::load(&y[first..]), z: Lanes::load(&z[first..]) }
}

/// Rays in the units of a tree.
struct InTree {
    packet: RayPacket<RAYS>,
    /// The factor that converts each ray's t to the packet's units.
    unit: [f64; RAYS],
    /// The largest distance outside a triangle's box at which a hit of any ray may lie.
    room: f64,
    /// A mask of the rays that could be transformed.
    some: u32,
    negative: [u32; 3],
}

impl InTree {
    fn margin(&self, reach: f32) -> Margin {
        Margin::new(reach, Some((self.room as f32).next_up()))
    }
}

/// Traces rays together through each instance that any of them may hit.
struct VisitInstances<'a, 'b, 'c, S> {
    scene: &'a Committed,
    world: World<'a>,
    rule: Rule,
    mask: u32,
    scratch: &'b mut SceneScratch,
    collect: &'b mut [&'c mut (dyn Collect + 'c)],
    /// For each ray, the t beyond which hits no longer count; NaN if the ray is finished.
    until: [f64; RAYS],
    /// A mask of the active rays.
    live: u32,
    /// The factor that converts each ray's t to the units of the top tree.
    unit: [f64; RAYS],
    /// [`VisitInstances::until`] in the units of the top tree; NaN for inactive rays.
    far: [f32; RAYS],
    /// The number of boxes visited, and the total number of rays that visited them.
    work: [usize; 2],
    level: PhantomData<S>,
}

impl<S: Simd> VisitInstances<'_, '_, '_, S> {
    /// Traces the rays. Returns a mask of the rays that must be traced alone because their values
    /// are too extreme for a packet.
    #[inline(always)]
    fn run(&mut self) -> u32 {
        let (scene, live) = (self.scene, self.world.live);
        let top = &scene.top;
        let rays = self.world.in_tree::<S>(
            live,
            #[inline(always)]
            |rays| (top.tree_ray(rays), Mask::from_bits(0xFF)),
        );
        let (margin, t_min) =
            (rays.margin(top.reach), all_rounded_down::<S>(&self.world.t_min, &rays.unit));
        let mut alone = live & !rays.some;
        for lane in lanes_of(rays.some) {
            self.until[lane] = self.collect[lane].far();
        }
        // Visit instances without finite boxes first, because their hits shorten the traversal.
        for &instance in &top.everywhere {
            self.visit_instance(instance as usize, rays.some & self.searching());
        }
        self.unit = rays.unit;
        let root = if top.boxed == 0 { EMPTY } else { 0 };
        let boxes = Boxes { nodes: &top.nodes, roots: [EMPTY, root], stack: top.stack };
        let mut stack = std::mem::take(&mut self.scratch.packets[0]);
        for (octant, same) in octants(rays.negative, rays.some) {
            let (lanes, is_plain) =
                SlabLanes::<S::F32x16>::of_packet(&rays.packet, octant, &margin);
            alone |= same & !is_plain.bits();
            self.live = same & is_plain.bits();
            self.update_far();
            let work = stack.traverse::<S>(boxes, (&lanes, octant), t_min, self);
            self.work = [self.work[0] + work[0], self.work[1] + work[1]];
        }
        self.scratch.packets[0] = stack;
        let found = rays.some & !self.searching();
        alone & !found
    }

    /// Returns a mask of the rays that are not finished.
    fn searching(&self) -> u32 {
        (0..RAYS).map(|lane| u32::from(!self.until[lane].is_nan()) << lane).sum()
    }

    #[inline(always)]
    fn update_far(&mut self) {
        far_of::<S>(self.live, &self.until, &self.unit).store(&mut self.far);
    }

    /// Traces rays through an instance.
    #[inline(always)]
    fn visit_instance(&mut self, instance: usize, some: u32) {
        let scene = self.scene;
        let is_seen = scene.frames[instance].mask & self.mask != 0;
        let Some(entry) = scene.mesh(instance).filter(|_| is_seen) else { return };
        let mut alone = some;
        let is_useful = scene.frames[instance].inverse.is_useful();
        if some.count_ones() as usize >= TOGETHER && is_useful {
            // Call a separate function to leave registers free for the traversal.
            alone = S::vectorize(
                #[inline(always)]
                || self.enter(entry, instance, some),
            );
        }
        for lane in lanes_of(alone) {
            if self.until[lane].is_nan() {
                continue;
            }
            let mut one = VisitOne::<S> {
                scene,
                ray: &self.world.rays[lane],
                rule: self.rule,
                mask: self.mask,
                is_tame: self.world.tame >> lane & 1 != 0,
                scratch: &mut self.scratch.mesh,
                collect: &mut *self.collect[lane],
                unit: 1.0,
                level: PhantomData,
            };
            let go_on = one.visit(instance).is_some();
            self.until[lane] = if go_on { self.collect[lane].far() } else { f64::NAN };
        }
        self.update_far();
    }

    /// Traces rays together through the mesh of an instance. Returns a mask of the rays that must
    /// be traced alone.
    #[inline(always)]
    fn enter(&mut self, MeshEntry { mesh, .. }: &MeshEntry, instance: usize, some: u32) -> u32 {
        let Self { scene, world, rule, mask, scratch, collect, until, work, .. } = self;
        let (tree, matrix) = (mesh.tree(), &scene.placed[instance].matrix);
        let frame = &scene.frames[instance];
        let rays = world.in_tree::<S>(
            some,
            #[inline(always)]
            |rays| frame.inverse.tree_ray(rays, frame.reach),
        );
        let (margin, t_min) =
            (rays.margin(frame.reach), all_rounded_down::<S>(&world.t_min, &rays.unit));
        let mut alone = some & !rays.some;
        let (rule, mask, level) = (*rule, *mask, PhantomData);
        let mut leaves = VisitLeaves::<S> {
            mesh: PlacedMesh { mesh, matrix, instance: instance as u32, rule, mask, level },
            rays: world.rays,
            tame: if frame.is_tame { world.tame } else { 0 },
            collect,
            until,
            unit: rays.unit,
            far: [f32::NAN; RAYS],
        };
        for (octant, same) in octants(rays.negative, rays.some) {
            let (lanes, is_plain) =
                SlabLanes::<S::F32x16>::of_packet(&rays.packet, octant, &margin);
            alone |= same & !is_plain.bits();
            leaves.begin(same & is_plain.bits());
            let (boxes, stack) = (Boxes::of(tree), &mut scratch.packets[1]);
            let more = stack.traverse::<S>(boxes, (&lanes, octant), t_min, &mut leaves);
            *work = [work[0] + more[0], work[1] + more[1]];
        }
        alone
    }
}

impl<S: Simd> VisitTogether<S::F32x16> for VisitInstances<'_, '_, '_, S> {
    #[inline(always)]
    fn far(&self) -> S::F32x16 {
        Lanes::load(&self.far)
    }

    #[inline(always)]
    fn visit(&mut self, instance: usize, reaching: <S::F32x16 as Lanes>::Mask) {
        self.visit_instance(instance, reaching.bits());
    }

    #[inline(always)]
    fn prefetch(&self, instance: usize) {
        prefetch(&self.scene.frames[instance..][..1]);
        prefetch(&self.scene.placed[instance..][..1]);
    }
}

/// Tests rays against the triangles of leaves in world space.
struct VisitLeaves<'a, 'c, S> {
    mesh: PlacedMesh<'a, S>,
    rays: &'a [Ray64],
    /// A mask of the rays whose values neither overflow nor underflow in f64 lanes.
    tame: u32,
    collect: &'a mut [&'c mut (dyn Collect + 'c)],
    /// For each ray, the t beyond which hits no longer count; NaN if the ray is finished.
    until: &'a mut [f64; RAYS],
    /// The factor that converts each ray's t to the units of the mesh's tree.
    unit: [f64; RAYS],
    /// [`VisitLeaves::until`] in the units of the mesh's tree; NaN for inactive rays.
    far: [f32; RAYS],
}

impl<S: Simd> VisitLeaves<'_, '_, S> {
    /// Makes exactly the rays in `some` active.
    #[inline(always)]
    fn begin(&mut self, some: u32) {
        far_of::<S>(some, self.until, &self.unit).store(&mut self.far);
    }
}

/// Returns, for each ray in `some`, the t beyond which hits no longer count, in a tree's units; NaN
/// for the other rays.
#[inline(always)]
fn far_of<S: Simd>(some: u32, until: &[f64; RAYS], unit: &[f64; RAYS]) -> S::F32x16 {
    let some = <S::F32x16 as Lanes>::Mask::from_bits(some);
    Lanes::select(some, all_rounded_up::<S>(until, unit), Lanes::splat(f32::NAN))
}

impl<S: Simd> VisitTogether<S::F32x16> for VisitLeaves<'_, '_, S> {
    #[inline(always)]
    fn far(&self) -> S::F32x16 {
        Lanes::load(&self.far)
    }

    #[inline(always)]
    fn visit(&mut self, leaf: usize, reaching: <S::F32x16 as Lanes>::Mask) {
        let corners = self.mesh.corners(leaf);
        for lane in lanes_of(reaching.bits()) {
            let (ray, is_tame) = (&self.rays[lane], self.tame >> lane & 1 != 0);
            let collect = &mut *self.collect[lane];
            let go_on = self.mesh.test((leaf, corners), (ray, is_tame), collect);
            self.until[lane] = if go_on { collect.far() } else { f64::NAN };
            self.far[lane] = rounded_up(self.until[lane], self.unit[lane]);
        }
    }

    #[inline(always)]
    fn prefetch(&self, leaf: usize) {
        prefetch(&self.mesh.mesh.tree().leaves[leaf..][..1]);
    }
}
