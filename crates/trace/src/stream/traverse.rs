//! The traversal of a ray stream.
//!
//! A ray alone waits at every step for the one before. Here 64 take turns, and while one waits, the CPU
//! does the others' steps.
//!
//! ```text
//!   rays of an octant ──► start ◄────────── retire
//!                           │                  ▲
//!                           ▼                  │ nothing left, or any hit will do
//!                    ┌──► leaves ──────► next from the stack
//!                    │      │                  ▲       │
//!                    │      ▼                  │       │
//!                    │    nodes ───────────────┘       │
//!                    │      │ at a child   nothing met │
//!                    └──────┴──────────────────────────┘
//! ```
//!
//! Where the hierarchy is larger than caches are, what a ray visits next is prefetched at the end of its
//! turn. Who goes where is written into lists without a branch, so none mispredicts.

use intertri::internal::{Filter, Test};
use intertri::simd::{Simd, WithSimd};
use intertri::{ClosestHit, Counts, LaneQueries, Ray, fixed};

use super::active::{ACTIVE, AtLeaves, Set, Way};
use super::every_hit::Looking;
use super::nodes::{prefetch_next, visit_nodes};
use super::retire::Retired;
use crate::answers::Answers;
use crate::pairs::NearestFew;
use crate::prefetch::Prefetch;
use crate::select::{Choice, chosen};
use crate::single::{All, BOTTOM, Closest, Kept, Slabs, Stack, octant};
use crate::stop;
use crate::tree::{LEAF, Leaf, Margin, Tree};

/// A hierarchy of more bytes than this is not expected to stay in the caches. Those of tests are small, and
/// are to be prefetched, too.
const LARGE: usize = if cfg!(test) { 1 << 16 } else { 1 << 26 };

/// Answers those rays whose numbers are in `numbers`.
pub(crate) struct Stream<'a, 'b> {
    pub(crate) bvh: &'a Tree,
    pub(crate) test: Filter<'a>,
    /// The rays; of a grid, also as their caller has them.
    pub(crate) rays: (&'a [Ray], &'a [fixed::Ray]),
    pub(crate) numbers: &'a [u32],
    pub(crate) answers: &'a mut Answers<'b>,
    /// Which triangles count.
    pub(crate) choice: &'a Choice<'a>,
    pub(crate) counts: &'a mut Counts,
}

impl WithSimd for Stream<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { bvh, test, rays: (rays, on_grid), numbers, answers, choice, counts } = self;
        let (any, few) = (answers.any(), nearest_few(answers));
        let Some(first) = rays.first() else { return };
        let idle = AtLeaves { ray: test.prepare_ray(first), closest: ClosestHit::new(0.0) };
        let next = numbers.last().map_or(0, |&last| last as usize + 1);
        let after = (numbers.first().map_or(0, |&first| first), numbers.len());
        let memory = test.resolver().memory_after(after, &rays[next..]);
        let mut active = Active {
            bvh,
            test,
            rays,
            answers,
            choice,
            counts,
            any,
            few,
            margin: bvh.margin(test.resolver()),
            all_boxed: bvh.first_unboxed(test.resolver()) == bvh.leaves.len(),
            large: size_of_val(&bvh.nodes[..]) + size_of_val(&bvh.leaves[..]) > LARGE,
            stacks: Stack::for_rays(ACTIVE, bvh),
            ways: [Way::default(); ACTIVE],
            at_leaves: [idle; ACTIVE],
            retired: Retired::new(test.resolver(), on_grid),
            prefetch: Prefetch::of(memory, numbers.len()),
        };
        for (octant, waiting) in by_octant(rays, numbers).iter().enumerate() {
            active.traverse::<S>(octant, waiting);
        }
        active.retired.flush::<S>(active.answers);
    }
}

/// The nearest hits of each active ray, where a number of them is asked for.
fn nearest_few(answers: &Answers<'_>) -> Vec<NearestFew> {
    let is_limited = matches!(answers, Answers::Pairs(pairs) if pairs.limit.is_some());
    let few = if is_limited { ACTIVE } else { 0 };
    (0..few).map(|_| NearestFew::default()).collect()
}

/// The numbers of rays by octant.
fn by_octant(rays: &[Ray], numbers: &[u32]) -> [Vec<u32>; 8] {
    let mut octants = [const { Vec::new() }; 8];
    for &number in numbers {
        octants[octant(&rays[number as usize])].push(number);
    }
    octants
}

/// The rays that take turns.
struct Active<'a, 'b> {
    bvh: &'a Tree,
    test: Filter<'a>,
    rays: &'a [Ray],
    answers: &'a mut Answers<'b>,
    choice: &'a Choice<'a>,
    counts: &'a mut Counts,
    any: bool,
    /// The nearest hits of each, where a number of them is asked for.
    few: Vec<NearestFew>,
    margin: Margin,
    /// Whether a walk finds all triangles by their boxes.
    all_boxed: bool,
    large: bool,
    stacks: Stack,
    ways: [Way; ACTIVE],
    at_leaves: [AtLeaves<Filter<'a>>; ACTIVE],
    retired: Retired<'a>,
    prefetch: Prefetch<'a>,
}

impl Active<'_, '_> {
    /// All rays of an octant.
    #[inline(always)]
    fn traverse<S: Simd>(&mut self, octant: usize, waiting: &[u32]) {
        let mut waiting = waiting.iter();
        let every = self.answers.every();

        // At first all places are free.
        let (mut nodes, mut leaves, mut free) = (Set::EMPTY, Set::EMPTY, Set::ALL);
        loop {
            stop::heed();
            nodes = nodes.union(self.start::<S>(free, &mut waiting));
            if nodes.union(leaves).is_empty() {
                return;
            }
            free =
                if every { self.visit_every::<S>(leaves) } else { self.visit_leaves::<S>(leaves) };

            let Self { bvh, test, ways, stacks, .. } = self;
            let (at_node, met_nothing) =
                visit_nodes(test.level(), octant, bvh, ways, stacks, nodes);
            let at_leaf = nodes.without(at_node, met_nothing);

            // The next from the stack.
            let popping = met_nothing.union(leaves.without(free, Set::EMPTY));
            let (popped_node, done) = self.pop::<S>(popping);
            free = free.union(done);
            leaves = at_leaf.union(popping.without(popped_node, free));
            nodes = at_node.union(popped_node);
            if self.large {
                prefetch_next(&self.bvh.leaves, &self.ways, leaves);
                prefetch_next(&self.bvh.nodes, &self.ways, nodes);
            }
            if !every {
                self.retire::<S>(free);
            }
        }
    }

    /// Rays that wait start in free places. The few that must not are asked one by one.
    #[inline(always)]
    fn start<'n, S: Simd>(
        &mut self,
        free: Set,
        waiting: &mut impl Iterator<Item = &'n u32>,
    ) -> Set {
        let (bvh, test) = (self.bvh, self.test);
        let mut started = Set::EMPTY;
        for place in free.places() {
            for &number in waiting.by_ref() {
                let ray = &self.rays[number as usize];
                let starts = self.all_boxed && ray.t_min < ray.t_max;
                let Some(slabs) = Slabs::new::<S>(ray, &self.margin).filter(|_| starts) else {
                    if self.answers.every() {
                        self.every_alone(number);
                        continue;
                    }
                    let closest = self.alone(ray, number);
                    self.retired.retire::<S>(bvh, ray, number, &closest, self.answers);
                    continue;
                };
                let (t_min, far, mut top) = (ray.t_min, ray.t_max, self.stacks.bottom(place));
                if bvh.thin_root != BOTTOM {
                    self.stacks.entries().push_root(&mut top, bvh.thin_root);
                }
                let slabs = slabs.packed();
                self.ways[place] = Way { slabs, t_min, far, next: 0, top };
                let (ray, closest) = (test.prepare_numbered(ray, number), test.no_hit(ray));
                self.at_leaves[place] = AtLeaves { ray, closest };
                if let Some(few) = self.few.get_mut(place) {
                    few.clear();
                }
                started.put(place, true);
                self.answers.prefetch(number as usize);
                self.prefetch.lines(1);
                break;
            }
        }
        started
    }

    /// A ray that must not start is asked by itself.
    #[cold]
    fn alone(&mut self, ray: &Ray, number: u32) -> ClosestHit {
        let (bvh, test, choice) = (self.bvh, &self.test, (self.choice, number as usize));
        let kept = &mut *Kept::lend(bvh);
        let (closest, counts) = if self.any {
            test.level().run(Closest::<_, true> { bvh, test, ray, choice, kept })
        } else {
            test.level().run(Closest::<_, false> { bvh, test, ray, choice, kept })
        };
        *self.counts += counts;
        closest
    }

    /// The same for every hit.
    #[cold]
    fn every_alone(&mut self, number: u32) {
        let (bvh, test, choice) = (self.bvh, self.test, (self.choice, number as usize));
        let ray = &self.rays[number as usize];
        let places = test.level().run(All { bvh, test, ray, choice });
        let mut looking = Looking { bvh, test, number, ray, few: None, far: ray.t_max };
        looking.take_alone(&places, self.answers);
    }

    /// Tests the triangles of the leaves that rays are at. Gives who needs no more.
    #[inline(always)]
    fn visit_leaves<S: Simd>(&mut self, leaves: Set) -> Set {
        let Self { bvh, test, any, choice, ways, at_leaves, counts, .. } = self;
        let mut done = Set::EMPTY;
        for place in leaves.places() {
            let (way, at) = (&mut ways[place], &mut at_leaves[place]);
            let leaf = (way.next ^ LEAF) as usize;
            let (ray, closest) = (&at.ray, &mut at.closest);
            match choice {
                None => {
                    let Leaf { block, indices } = &bvh.leaves[leaf];
                    let (find, first) = (|place| bvh.triangle_in(place), 8 * leaf as u32);
                    test.closest_in::<S>(ray, block, indices, first, find, closest, counts);
                }
                Some(select) => select.closest_in::<S, _>(bvh, *test, ray, leaf, closest, counts),
            }
            way.far = closest.t_hi();
            done.put(place, *any && closest.is_hit());
        }
        done
    }

    /// The same for every hit.
    #[inline(always)]
    fn visit_every<S: Simd>(&mut self, leaves: Set) -> Set {
        let Self { bvh, test, rays, choice, ways, at_leaves, few, answers, counts, .. } = self;
        let mut done = Set::EMPTY;
        for place in leaves.places() {
            let (way, at) = (&mut ways[place], &at_leaves[place]);
            let leaf = (way.next ^ LEAF) as usize;
            let block = &bvh.leaves[leaf].block;
            let Some(mut hits) = test.block_hits_in::<S>(&at.ray, block, way.far, counts) else {
                continue;
            };
            let number = at.ray.number();
            let ray = &rays[number as usize];
            let lanes = hits.sure | hits.undecided;
            let lanes = chosen(choice, bvh, (number as usize, ray), leaf, lanes, test.resolver());
            (hits.sure, hits.undecided) = (hits.sure & lanes, hits.undecided & lanes);
            let (bvh, test, few, far) = (*bvh, *test, few.get_mut(place), way.far);
            let mut looking = Looking { bvh, test, number, ray, few, far };
            done.put(place, looking.take(&hits, leaf, answers));
            way.far = looking.far;
        }
        done
    }

    /// What rays visit next, from their stacks. Gives who is at a node, and who has nothing left.
    #[inline(always)]
    fn pop<S: Simd>(&mut self, popping: Set) -> (Set, Set) {
        let (mut at_node, mut done) = (Set::EMPTY, Set::EMPTY);
        let entries = self.stacks.entries();
        for place in popping.places() {
            let way = &mut self.ways[place];
            let next = entries.pop::<S>(&mut way.top, way.far);
            way.next = next;
            at_node.put(place, next & LEAF == 0);
            done.put(place, next == BOTTOM);
        }
        (at_node, done)
    }

    #[inline(always)]
    fn retire<S: Simd>(&mut self, done: Set) {
        for place in done.places() {
            let AtLeaves { ray, closest } = &self.at_leaves[place];
            let number = ray.number();
            let ray = &self.rays[number as usize];
            self.retired.retire::<S>(self.bvh, ray, number, closest, self.answers);
        }
    }
}

#[cfg(test)]
mod tests {
    use intertri::{Certified, Double, Hit, Ray, Triangle};

    use crate::Bvh;
    use crate::test_numbers::random;

    /// Rays of every direction and origin, and a few that must not start, one by one and in a stream.
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

        // With a triangle that has no box, none starts.
        for huge in [false, true] {
            if huge {
                triangles.push(Triangle([[3e38; 3], [-3e38, 0.0, 3e38], [0.0, 3e38, -3e38]]));
            }
            let bvh = Bvh::new(&triangles).unwrap();
            let (mode, double) = (Certified::default(), Double::default());
            let mut hits = [vec![Hit::MISS; rays.len()], vec![Hit::MISS; rays.len()]];
            let (mut any, mut index) = (vec![false; rays.len()], vec![0; rays.len()]);
            bvh.closest_batch(&mode, &rays, &mut hits[0]);
            bvh.closest_batch(&double, &rays, &mut hits[1]);
            bvh.any_batch(&mode, &rays, &mut any);
            bvh.triangles_batch(&mode, &rays, &mut index);
            for (i, ray) in rays.iter().enumerate() {
                let hit = bvh.closest(&mode, ray);
                assert_eq!([hits[0][i].some(), hits[1][i].some()], [hit, hit], "ray {i}");
                assert_eq!(
                    (any[i], index[i]),
                    (hit.is_some(), hit.map_or(Hit::NO_TRIANGLE, |hit| hit.triangle)),
                    "ray {i}"
                );
            }
            assert!(any.iter().filter(|&&any| any).count() > 1000);
        }
    }
}
