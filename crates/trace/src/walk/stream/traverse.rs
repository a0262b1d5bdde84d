//! The traversal of a ray stream.
//!
//! Each step of a single ray depends on the previous one. Here, 64 rays take turns, so while one
//! ray waits for memory or arithmetic, the CPU executes steps of the others.
//!
//! ```text
//!   rays of an octant ──► start ◄────────── retire
//!                           │                  ▲
//!                           ▼                  │ stack empty, or any hit found
//!                    ┌──► leaves ──────► next from the stack
//!                    │      │                  ▲       │
//!                    │      ▼                  │       │
//!                    │    nodes ───────────────┘       │
//!                    │      │ at a child        no hit │
//!                    └──────┴──────────────────────────┘
//! ```
//!
//! If the hierarchy is larger than the caches, the node or leaf that a ray visits next is
//! prefetched at the end of its turn. The sets of rays that are at nodes, at leaves, or done are
//! updated without branches, because branches would often be mispredicted here.

use intertri::simd::{Simd, WithSimd};
use intertri::{ClosestHit, Counts, Filter, Ray, RayId};

use super::active::{ACTIVE, AtLeaves, RayState, Set};
use super::every_hit::HitCollector;
use super::nodes::{prefetch_next, visit_nodes};
use super::retire::Retired;
use crate::selection::{ActiveSelection, closest_in_leaf, selected};
use crate::tree::{LEAF, Margin, Tree};
use crate::util::prefetch::Prefetch;
use crate::util::stop;
use crate::walk::BatchOutput;
use crate::walk::NearestFew;
use crate::walk::single::{
    All, BOTTOM, Closest, SingleRay, Slabs, Stack, TraversalScratch, octant,
};

/// A hierarchy larger than this many bytes is not expected to fit in the caches. In unit tests, the
/// limit is small so that prefetching is tested too.
const LARGE: usize = if cfg!(test) { 1 << 16 } else { 1 << 26 };

/// Traces the rays whose ids are in `ids`, and writes their results to `output`.
pub(crate) struct Stream<'a, 'b> {
    pub(crate) tree: &'a Tree,
    pub(crate) filter: Filter<'a>,
    pub(crate) rays: &'a [Ray],
    pub(crate) ids: &'a [RayId],
    pub(crate) output: &'a mut BatchOutput<'b>,
    /// The masks, skip lists, and predicates that determine which triangles count as hits.
    pub(crate) selection: &'a ActiveSelection<'a>,
    pub(crate) counts: &'a mut Counts,
}

impl WithSimd for Stream<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { tree, filter, rays, ids, output, selection, counts } = self;
        let (any, few) = (output.any(), nearest_few(output));
        let Some(first) = rays.first() else { return };
        // Slots that have not held a ray yet need a placeholder, which is never read.
        let idle = AtLeaves { ray: filter.prepare_ray(first), closest: ClosestHit::new(0.0) };
        // While this stream is traced, prefetch the rays that follow its last ray.
        let next = ids.last().map_or(0, |&last| last.0 as usize + 1);
        let after = (ids.first().copied().unwrap_or_default(), ids.len());
        let memory = filter.resolver().memory_after(after, &rays[next..]);
        let mut active = Active {
            tree,
            filter,
            rays,
            output,
            selection,
            counts,
            any,
            few,
            margin: tree.margin(filter.resolver()),
            all_boxed: tree.first_unboxed(filter.resolver()) == tree.leaves.len(),
            large: size_of_val(&tree.nodes[..]) + size_of_val(&tree.leaves[..]) > LARGE,
            stacks: Stack::for_rays(ACTIVE, tree),
            states: [RayState::default(); ACTIVE],
            at_leaves: [idle; ACTIVE],
            retired: Retired::new(filter.resolver(), RayId(0)),
            prefetch: Prefetch::of(memory, ids.len()),
        };
        // Rays in the same octant enter every box through the same three sides, so the near sides
        // need not be selected for each ray.
        for (octant, waiting) in by_octant(rays, ids).iter().enumerate() {
            active.traverse::<S>(octant, waiting);
        }
        active.retired.flush::<S>(active.output);
    }
}

/// Creates one list of nearest hits for each active ray, or none if the number of hits is not
/// limited.
fn nearest_few(output: &BatchOutput<'_>) -> Vec<NearestFew> {
    let is_limited = matches!(output, BatchOutput::Pairs(pairs) if pairs.limit.is_some());
    let few = if is_limited { ACTIVE } else { 0 };
    (0..few).map(|_| NearestFew::default()).collect()
}

/// Groups ray ids by octant.
fn by_octant(rays: &[Ray], ids: &[RayId]) -> [Vec<RayId>; 8] {
    let mut octants = [const { Vec::new() }; 8];
    for &id in ids {
        octants[octant(&rays[id.0 as usize])].push(id);
    }
    octants
}

/// The active rays, which take turns, and everything that their traversal needs.
struct Active<'a, 'b> {
    tree: &'a Tree,
    filter: Filter<'a>,
    rays: &'a [Ray],
    output: &'a mut BatchOutput<'b>,
    selection: &'a ActiveSelection<'a>,
    counts: &'a mut Counts,
    any: bool,
    /// One list of nearest hits for each slot; empty if the number of hits is not limited.
    few: Vec<NearestFew>,
    margin: Margin,
    /// Whether every leaf has a box, so that traversal reaches all triangles.
    all_boxed: bool,
    large: bool,
    stacks: Stack,
    states: [RayState; ACTIVE],
    at_leaves: [AtLeaves; ACTIVE],
    retired: Retired<'a>,
    prefetch: Prefetch<'a>,
}

impl Active<'_, '_> {
    /// Traces all rays in an octant.
    #[inline(always)]
    fn traverse<S: Simd>(&mut self, octant: usize, waiting: &[RayId]) {
        let mut waiting = waiting.iter();
        let every = self.output.every();

        // Initially, all slots are free.
        let (mut nodes, mut leaves, mut free) = (Set::EMPTY, Set::EMPTY, Set::ALL);
        loop {
            // Each round advances every active ray by one node or one leaf. A slot is in at most
            // one of the three sets.
            stop::heed();
            nodes = nodes.union(self.start::<S>(free, &mut waiting));
            // No ray is active, and `start` found no waiting ray.
            if nodes.union(leaves).is_empty() {
                return;
            }
            free =
                if every { self.visit_every::<S>(leaves) } else { self.visit_leaves::<S>(leaves) };

            let Self { tree, filter, states, stacks, .. } = self;
            let (at_node, met_nothing) =
                visit_nodes(filter.level(), octant, tree, states, stacks, nodes);
            let at_leaf = nodes.without(at_node, met_nothing);

            // Rays that hit no child, and rays that have tested a leaf but are not done, pop their
            // next entries from their stacks.
            let popping = met_nothing.union(leaves.without(free, Set::EMPTY));
            let (popped_node, done) = self.pop::<S>(popping);
            free = free.union(done);
            // A popped entry is a node, a leaf, or the bottom of the stack. At the bottom, the ray
            // is done and its slot is free.
            leaves = at_leaf.union(popping.without(popped_node, free));
            nodes = at_node.union(popped_node);
            if self.large {
                prefetch_next(&self.tree.leaves, &self.states, leaves);
                prefetch_next(&self.tree.nodes, &self.states, nodes);
            }
            if !every {
                self.retire::<S>(free);
            }
        }
    }

    /// Starts waiting rays in the free slots, and returns the slots in which a ray was started. The
    /// few rays that a stream cannot handle are traced one by one instead.
    #[inline(always)]
    fn start<'n, S: Simd>(
        &mut self,
        free: Set,
        waiting: &mut impl Iterator<Item = &'n RayId>,
    ) -> Set {
        let (tree, filter) = (self.tree, self.filter);
        let mut started = Set::EMPTY;
        for place in free.places() {
            for &id in waiting.by_ref() {
                let ray = &self.rays[id.0 as usize];
                // A ray with an empty interval or extreme coordinates is traced alone. If the tree
                // has leaves without a box, every ray is traced alone, because those leaves need a
                // different traversal.
                let starts = self.all_boxed && ray.t_min < ray.t_max;
                let Some(slabs) = Slabs::new::<S>(ray, &self.margin).filter(|_| starts) else {
                    if self.output.every() {
                        self.every_alone(id);
                        continue;
                    }
                    let closest = self.alone(ray, id);
                    self.retired.retire::<S>(tree, ray, id, closest.triangle(), self.output);
                    continue;
                };
                let (t_min, far, mut top) = (ray.t_min, ray.t_max, self.stacks.bottom(place));
                if tree.thin_root != BOTTOM {
                    // The second tree is pushed first, so it is visited after the main one.
                    self.stacks.entries().push_root(&mut top, tree.thin_root);
                }
                let slabs = slabs.packed();
                self.states[place] = RayState { slabs, t_min, far, next: 0, top };
                let (ray, closest) = (filter.prepare_numbered(ray, id), filter.no_hit(ray));
                self.at_leaves[place] = AtLeaves { ray, closest };
                if let Some(few) = self.few.get_mut(place) {
                    few.clear();
                }
                started.put(place, true);
                self.output.prefetch(id.0 as usize);
                self.prefetch.lines(1);
                break;
            }
        }
        started
    }

    /// Finds the closest or any hit of a ray that a stream cannot handle.
    #[cold]
    fn alone(&mut self, ray: &Ray, id: RayId) -> ClosestHit {
        let Self { tree, ref filter, selection, any, .. } = *self;
        let scratch = &mut *TraversalScratch::lend(tree);
        let single = SingleRay { tree, filter, ray, id, selection, scratch };
        let (closest, counts) = if any {
            filter.level().run(Closest::<true>(single))
        } else {
            filter.level().run(Closest::<false>(single))
        };
        *self.counts += counts;
        closest
    }

    /// Finds every hit of a ray that a stream cannot handle.
    #[cold]
    fn every_alone(&mut self, id: RayId) {
        let Self { tree, ref filter, rays, selection, .. } = *self;
        let ray = &rays[id.0 as usize];
        let scratch = &mut *TraversalScratch::lend(tree);
        let single = SingleRay { tree, filter, ray, id, selection, scratch };
        let slots = filter.level().run(All(single));
        let far = ray.t_max;
        let mut collector = HitCollector { tree, filter: *filter, id, ray, few: None, far };
        collector.take_alone(&slots, self.output);
    }

    /// Tests each ray against the triangles of its leaf. Returns the rays that are done.
    #[inline(always)]
    fn visit_leaves<S: Simd>(&mut self, leaves: Set) -> Set {
        let Self { tree, filter, any, selection, states, at_leaves, counts, .. } = self;
        let mut done = Set::EMPTY;
        for place in leaves.places() {
            let (state, at) = (&mut states[place], &mut at_leaves[place]);
            let leaf = (state.next ^ LEAF) as usize;
            let (ray, closest) = (&at.ray, &mut at.closest);
            closest_in_leaf::<S>(selection, tree, filter, ray, leaf, closest, counts);
            // From now on, boxes beyond the closest hit so far are culled.
            state.far = closest.t_hi();
            done.put(place, *any && closest.is_hit());
        }
        done
    }

    /// Like `visit_leaves`, but collects all hits.
    #[inline(always)]
    fn visit_every<S: Simd>(&mut self, leaves: Set) -> Set {
        let Self { tree, filter, rays, selection, states, at_leaves, few, output, counts, .. } =
            self;
        let mut done = Set::EMPTY;
        for place in leaves.places() {
            let (state, at) = (&mut states[place], &at_leaves[place]);
            let leaf = (state.next ^ LEAF) as usize;
            let block = &tree.leaves[leaf].block;
            let Some(mut hits) = filter.block_hits_in::<S>(&at.ray, block, state.far, counts)
            else {
                continue;
            };
            let id = at.ray.id();
            let ray = &rays[id.0 as usize];
            let lanes = hits.sure | hits.undecided;
            // Masks and predicates are evaluated only for the few lanes that may be hits.
            let lanes = selected(selection, tree, (id, ray), leaf, lanes, filter.resolver());
            (hits.sure, hits.undecided) = (hits.sure & lanes, hits.undecided & lanes);
            let (tree, filter, few, far) = (*tree, *filter, few.get_mut(place), state.far);
            let mut collector = HitCollector { tree, filter, id, ray, few, far };
            done.put(place, collector.take(&hits, leaf, output));
            state.far = collector.far;
        }
        done
    }

    /// Pops the next entry of each ray's stack. Returns the rays that are now at an inner node, and
    /// the rays whose stacks are empty.
    #[inline(always)]
    fn pop<S: Simd>(&mut self, popping: Set) -> (Set, Set) {
        let (mut at_node, mut done) = (Set::EMPTY, Set::EMPTY);
        let entries = self.stacks.entries();
        for place in popping.places() {
            let state = &mut self.states[place];
            let next = entries.pop::<S>(&mut state.top, state.far);
            state.next = next;
            // `BOTTOM` has the leaf bit set, so a finished ray does not count as being at a node.
            at_node.put(place, next & LEAF == 0);
            done.put(place, next == BOTTOM);
        }
        (at_node, done)
    }

    #[inline(always)]
    fn retire<S: Simd>(&mut self, done: Set) {
        for place in done.places() {
            let AtLeaves { ray, closest } = &self.at_leaves[place];
            let id = ray.id();
            let ray = &self.rays[id.0 as usize];
            self.retired.retire::<S>(self.tree, ray, id, closest.triangle(), self.output);
        }
    }
}

#[cfg(test)]
mod tests {
    use intertri::{Hit, Mode, Ray, Triangle};

    use crate::Bvh;
    use crate::util::test_numbers::random;

    /// Compares the results of a stream with those of single-ray queries, for random rays and for a
    /// few rays that a stream cannot handle.
    #[test]
    fn in_a_stream_each_ray_gets_its_own_answer() {
        let mut random = random();
        let mut random = || random() - 0.5;
        let mut point = |size: f32| [random() * size, random() * size, random() * size];
        let mut triangles: Vec<Triangle> = (0..3000)
            .map(|_| {
                let at = point(2.0);
                Triangle([0; 3].map(|_| {
                    let d = point(0.2);
                    [at[0] + d[0], at[1] + d[1], at[2] + d[2]]
                }))
            })
            .collect();
        let mut rays: Vec<Ray> = (0..5000).map(|_| Ray::new(point(3.0), point(1.0))).collect();
        rays[17].dir = [0.0; 3];
        rays[18].origin[1] = f32::NAN;
        rays[19].t_max = f32::NAN;
        rays[20].dir = [f32::INFINITY, 0.0, 0.0];
        rays[21].t_max = -1.0;
        rays[22].dir = [1e-40, 0.0, -1e-40];
        rays[23].dir = [0.0, -0.0, -1.0];
        rays[24].dir = [f32::NAN, f32::NAN, 1.0];

        // If a triangle has no box, every ray is traced alone.
        for huge in [false, true] {
            if huge {
                triangles.push(Triangle([[3e38; 3], [-3e38, 0.0, 3e38], [0.0, 3e38, -3e38]]));
            }
            let bvh = Bvh::new(&triangles).unwrap();
            let mut query = bvh.query().mode(Mode::certified());
            let (hits, any) = (query.closest_batch(&rays), query.any_batch(&rays));
            let closest = query.closest_triangle_batch(&rays);
            for (i, ray) in rays.iter().enumerate() {
                let hit = query.closest(ray);
                assert_eq!(hits[i].some(), hit, "ray {i}");
                assert_eq!(hit, Mode::certified().closest(&triangles, ray), "ray {i}");
                let triangle = hit.map_or(Hit::NO_TRIANGLE, |hit| hit.triangle);
                assert_eq!((any[i], closest[i].triangle), (hit.is_some(), triangle), "ray {i}");
            }
            assert!(any.iter().filter(|&&any| any).count() > 1000);
        }
    }
}
