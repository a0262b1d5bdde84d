//! Rays that have little in common: many in flight at once, each a step at a time.
//!
//! A ray alone waits at every step for the one before. Here 64 take turns, and while one waits, the
//! CPU does the others' steps.
//!
//! ```text
//!   rays of an octant ──► take off ◄────────── land
//!                            │                  ▲
//!                            ▼                  │ nothing left, or any hit will do
//!                     ┌──► leaves ──────► next from the stack
//!                     │      │                  ▲       │
//!                     │      ▼                  │       │
//!                     │    nodes ───────────────┘       │
//!                     │      │ at a child   nothing met │
//!                     └──────┴──────────────────────────┘
//! ```
//!
//! Where the hierarchy is larger than caches are, what a ray visits next is asked for from memory
//! at the end of its turn.
//!
//! Who goes where is written into lists without a branch, so no guess of the CPU's goes wrong. Rays of
//! one octant fly together: which side of a box is the near one is then known when this is compiled.

use intertri::lanes::{Simd, WithSimd, prefetch};
use intertri::{Best, Counts, Mode, PreparedRay, Ray};

use crate::ahead::Ahead;
use crate::answer::{Answer, Landing};
use crate::bvh::{Bvh, Leaf};
use crate::node::LEAF;
use crate::search;
use crate::slab::{SlabLanes, Slabs, octant};
use crate::stack::{BOTTOM, Stack};

/// Rays in flight.
const FLIGHT: usize = 64;

/// A hierarchy of more bytes than this is not expected to stay in the caches. Those of tests are small, and are
/// to be asked for, too.
const LARGE: usize = if cfg!(test) { 1 << 16 } else { 1 << 26 };

/// Where a ray is on its way, in a cache line.
#[derive(Clone, Copy, Default)]
#[repr(C, align(64))]
struct Way {
    slabs: Slabs,
    t_min: f32,
    /// No hit beyond it counts.
    far: f32,
    /// What it visits next.
    next: u32,
    /// The end of its stack.
    top: u32,
}

/// What a ray has at its leaves.
#[derive(Clone, Copy)]
struct Load<M: Mode> {
    ray: PreparedRay<M>,
    best: Best,
    /// Whose ray it is.
    number: u32,
}

/// Places of rays that have the same to do, one bit each.
#[derive(Clone, Copy)]
struct Set(u64);

impl Set {
    const EMPTY: Self = Self(0);
    const ALL: Self = Self(u64::MAX);

    /// Adds a place, or not.
    #[inline(always)]
    fn put(&mut self, place: usize, put: bool) {
        self.0 |= u64::from(put) << (place % FLIGHT);
    }

    /// Those that are in neither of two others.
    #[inline(always)]
    fn without(self, a: Self, b: Self) -> Self {
        Self(self.0 & !(a.0 | b.0))
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    #[inline(always)]
    fn places(self) -> impl Iterator<Item = usize> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            if left == 0 {
                return None;
            }
            let place = left.trailing_zeros() as usize % FLIGHT;
            left &= left - 1;
            Some(place)
        })
    }
}

/// The numbers of rays by octant.
fn by_octant(rays: &[Ray], numbers: &[u32]) -> [Vec<u32>; 8] {
    let mut octants = [const { Vec::new() }; 8];
    for &number in numbers {
        octants[octant(&rays[number as usize])].push(number);
    }
    octants
}

/// The answers of those rays whose numbers are in `flying`.
#[inline(always)]
pub(crate) fn search<M: Mode, S: Simd, A: Answer>(
    bvh: &Bvh,
    mode: &M,
    rays: &[Ray],
    flying: &[u32],
    answers: &mut [A],
    counts: &mut Counts,
) {
    let Some(first) = rays.first() else { return };
    let (stacks, kept) = (&mut bvh.stacks(FLIGHT), &mut bvh.kept());
    let landing = &mut Landing::default();
    let idle = Load { ray: mode.prepare_ray(first), best: Best::new(0.0), number: 0 };
    let mut loads = [idle; FLIGHT];
    let mut ways = [Way::default(); FLIGHT];

    let large = size_of_val(&bvh.nodes[..]) + size_of_val(&bvh.leaves[..]) > LARGE;
    let level = mode.level();
    let next = flying.last().map_or(0, |&last| last as usize + 1);
    let mut ahead = Ahead::of(&rays[next..], flying.len());
    let all_boxed = bvh.boxed == bvh.leaves.len();

    for (octant, waiting) in by_octant(rays, flying).iter().enumerate() {
        let mut waiting = waiting.iter();

        // At first all places are free.
        let (mut nodes, mut leaves, mut free) = (Set::EMPTY, Set::EMPTY, Set::ALL);
        loop {
            // The next rays take off. The few that must not are asked one by one.
            for place in free.places() {
                for &number in waiting.by_ref() {
                    let ray = &rays[number as usize];
                    let flies = all_boxed && ray.t_min < ray.t_max;
                    let Some(slabs) = Slabs::new::<S>(ray, bvh.reach).filter(|_| flies) else {
                        let best = S::vectorize(
                            #[inline(always)]
                            || search::closest::<M, S>(bvh, mode, ray, A::ANY, kept, counts),
                        );
                        landing.land::<S, A>(bvh, ray, number, &best, answers);
                        continue;
                    };
                    let (t_min, far, top) = (ray.t_min, ray.t_max, stacks.bottom(place));
                    ways[place] = Way { slabs, t_min, far, next: 0, top };
                    loads[place] =
                        Load { ray: mode.prepare_ray(ray), best: Best::new(far), number };
                    nodes.put(place, true);
                    // Where its answer will be written is hardly ever in the cache.
                    prefetch(&answers[number as usize..][..1]);
                    ahead.ask(1);
                    break;
                }
            }
            if nodes.and(leaves).0 == 0 {
                break;
            }

            // Leaves.
            free = Set::EMPTY;
            for place in leaves.places() {
                let (way, load) = (&mut ways[place], &mut loads[place]);
                let leaf = (way.next ^ LEAF) as usize;
                let Leaf { pack, indices } = &bvh.leaves[leaf];
                let (ray, best) = (&load.ray, &mut load.best);
                let find = |place| bvh.triangle_in(place);
                mode.closest_in::<S>(ray, pack, indices, 8 * leaf as u32, find, best, counts);
                way.far = best.t_hi();
                free.put(place, A::ANY && best.is_hit());
            }

            // Nodes.
            let (at_node, met_nothing) = match octant {
                0 => level.run(Nodes::<0> { bvh, ways: &mut ways, stacks, at: nodes }),
                1 => level.run(Nodes::<1> { bvh, ways: &mut ways, stacks, at: nodes }),
                2 => level.run(Nodes::<2> { bvh, ways: &mut ways, stacks, at: nodes }),
                3 => level.run(Nodes::<3> { bvh, ways: &mut ways, stacks, at: nodes }),
                4 => level.run(Nodes::<4> { bvh, ways: &mut ways, stacks, at: nodes }),
                5 => level.run(Nodes::<5> { bvh, ways: &mut ways, stacks, at: nodes }),
                6 => level.run(Nodes::<6> { bvh, ways: &mut ways, stacks, at: nodes }),
                _ => level.run(Nodes::<7> { bvh, ways: &mut ways, stacks, at: nodes }),
            };
            let at_leaf = nodes.without(at_node, met_nothing);
            nodes = at_node;

            // The next from the stack.
            let popping = met_nothing.and(leaves.without(free, Set::EMPTY));
            let (mut at_node, entries) = (Set::EMPTY, stacks.entries());
            for place in popping.places() {
                let way = &mut ways[place];
                let next = entries.pop::<S>(&mut way.top, way.far);
                way.next = next;
                at_node.put(place, next & LEAF == 0);
                free.put(place, next == BOTTOM);
            }
            leaves = at_leaf.and(popping.without(at_node, free));
            nodes = nodes.and(at_node);
            if large {
                ask(&bvh.leaves, &ways, leaves);
                ask(&bvh.nodes, &ways, nodes);
            }

            // Who has nothing left has arrived.
            for place in free.places() {
                let Load { number, best, .. } = &loads[place];
                let ray = &rays[*number as usize];
                landing.land::<S, A>(bvh, ray, *number, best, answers);
            }
        }
    }
    landing.finish::<S, A>(answers);
}

/// Asks for those of `things` that rays visit next.
#[inline(always)]
fn ask<T>(things: &[T], ways: &[Way; FLIGHT], at: Set) {
    for place in at.places() {
        prefetch(&things[(ways[place].next & !LEAF) as usize..][..1]);
    }
}

/// The nodes that rays of an octant are at. Entered by its level, so that it is compiled once for all modes and
/// questions.
struct Nodes<'a, const OCTANT: usize> {
    bvh: &'a Bvh,
    ways: &'a mut [Way; FLIGHT],
    stacks: &'a mut Stack,
    at: Set,
}

impl<const OCTANT: usize> WithSimd for Nodes<'_, OCTANT> {
    type Output = (Set, Set);

    /// Tests their boxes. Gives who is at a node next, and who met nothing.
    #[inline(always)]
    fn run<S: Simd>(self) -> (Set, Set) {
        let Self { bvh, ways, stacks, at } = self;
        let (mut at_node, mut met_nothing) = (Set::EMPTY, Set::EMPTY);
        let mut stacks = stacks.entries();
        for place in at.places() {
            let way = &mut ways[place];
            let node = &bvh.nodes[way.next as usize];
            let lanes = SlabLanes::<S::F32x8>::splat(&way.slabs, OCTANT);
            let (met, near) = lanes.meet(node, way.t_min, way.far);
            let next = stacks.push::<S>(&mut way.top, node, OCTANT, met, near);
            way.next = next;
            at_node.put(place, next & LEAF == 0);
            met_nothing.put(place, next == BOTTOM);
        }
        (at_node, met_nothing)
    }
}

const _: () = assert!(size_of::<Way>() == 64);

#[cfg(test)]
mod tests {
    use intertri::{Certified, Double, Hit, Ray, Triangle};

    use crate::Bvh;
    use crate::random::random;

    /// Rays of every direction and origin, and a few that must not fly, one by one and in flight.
    #[test]
    fn in_flight_each_ray_gets_its_own_answer() {
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

        // With a triangle that has no box, none flies.
        for huge in [false, true] {
            if huge {
                triangles.push(Triangle([[3e38; 3], [-3e38, 0.0, 3e38], [0.0, 3e38, -3e38]]));
            }
            let bvh = Bvh::new(&triangles).unwrap();
            let (mode, double) = (Certified::default(), Double::default());
            let mut hits = [vec![Hit::MISS; rays.len()], vec![Hit::MISS; rays.len()]];
            let (mut any, mut index) = (vec![false; rays.len()], vec![0; rays.len()]);
            bvh.closest_of_each(&mode, &rays, &mut hits[0]);
            bvh.closest_of_each(&double, &rays, &mut hits[1]);
            bvh.any_of_each(&mode, &rays, &mut any);
            bvh.triangles_of_each(&mode, &rays, &mut index);
            for (i, ray) in rays.iter().enumerate() {
                let hit = bvh.closest(&mode, ray);
                assert_eq!([hits[0][i], hits[1][i]], [hit, hit], "ray {i}");
                assert_eq!((any[i], index[i]), (hit.is_hit(), hit.triangle as u32), "ray {i}");
            }
            assert!(any.iter().filter(|&&any| any).count() > 1000);
        }
    }
}
