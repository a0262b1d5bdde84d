//! Tests rays against the triangles that hid earlier rays, before they are sorted or traced.
//!
//! ```text
//!        ─────────────────────────  a roof        Where walls and roofs hide the light, most rays are
//!           ↗   ↗   ↗   ↗   ↗                      hidden by the same few triangles. These rays need
//!        ───────────────────────── the floor      neither sorting nor a traversal.
//! ```
//!
//! A triangle counts as an occluder only where the filter is certain of a hit, so this changes no answer.

use std::ops::Range;

use intertri::simd::{Simd, WithSimd};
use intertri::{Counts, Filter, LeafSlot, PreparedPacket, Ray, RayId, RayPacket};

use crate::tree::Tree;
use crate::util::lane_ops::lanes_of;
use crate::util::patience::Patience;
use crate::walk::packet::RAYS;
use crate::walk::single::{Closest, SingleRay, TraversalScratch};

/// The number of triangles that are remembered.
const REMEMBERED: usize = 4;

/// Fewer rays than this are not tested.
const FEWEST: usize = 1 << 12;

/// The number of rays in a group. After each group, it is decided again whether testing pays off, which it
/// does if at least a quarter of its rays are hidden.
const GROUP: usize = 64;
/// After a group for which testing did not pay off, this many groups are not tested. The number starts at
/// the first value and doubles with each further failure, up to the second value.
const GROUP_PATIENCE: [usize; 2] = [1, 256];

/// If the triangle that hides a ray hides less than half of the rays that are left of a packet, or if
/// nothing hides it, this many packets of which rays are left pass before the occluder of another ray is
/// searched for. The number grows like that of groups.
const SEARCH_PATIENCE: [usize; 2] = [2, 64];

/// Unless at least one in this many rays is hidden, all rays are traced: to trace only some, they must be
/// copied. After each [`FEWEST`] rays, testing ends if fewer than half as many are hidden so far.
const SHARE: usize = 4;

/// The triangles that occluded the last rays.
pub(super) struct Occluders {
    /// The slots of the triangles, the last one that hid a ray first.
    slots: [LeafSlot; REMEMBERED],
    len: usize,
    groups: Patience,
    searches: Patience,
}

impl Occluders {
    pub(super) fn new() -> Self {
        let [groups, searches] = [GROUP_PATIENCE, SEARCH_PATIENCE].map(Patience::new);
        Self { slots: [LeafSlot(0); REMEMBERED], len: 0, groups, searches }
    }

    /// Sets the answers of rays that are certain to hit something to true, and the others to false.
    /// `test` tests a range of the rays. Returns whether it is worth tracing only the others.
    pub(super) fn hide(
        &mut self,
        answers: &mut [bool],
        mut test: impl FnMut(&mut Self, Range<usize>, &mut [bool]) -> usize,
    ) -> bool {
        answers.fill(false);
        let (mut hidden, rays) = (0, answers.len());
        if rays < FEWEST {
            return false;
        }
        for (start, answers) in (0..).step_by(GROUP).zip(answers.chunks_mut(GROUP)) {
            if start % FEWEST == 0 && 2 * SHARE * hidden < start {
                return false;
            }
            if self.groups.is_waiting() {
                self.groups.pass();
                continue;
            }
            let some = test(self, start..start + answers.len(), answers);
            hidden += some;
            let has_paid = 4 * some >= answers.len();
            self.groups.tried(has_paid);
            if !has_paid {
                // The next group begins with a search.
                self.searches = Patience::new(SEARCH_PATIENCE);
            }
        }
        SHARE * hidden >= rays
    }

    /// Tests rays, and sets the answers of those that are certain to hit something. Returns their number.
    pub(super) fn test(
        &mut self,
        (tree, filter): (&Tree, &Filter<'_>),
        rays: &[Ray],
        answers: &mut [bool],
        counts: &mut Counts,
    ) -> usize {
        filter.level().run(Test { occluders: self, tree, filter, rays, answers, counts })
    }

    /// Remembers a triangle, in place of the one that has hidden no ray for the longest time.
    fn add(&mut self, slot: LeafSlot) {
        if self.slots[..self.len].contains(&slot) {
            return;
        }
        self.len = REMEMBERED.min(self.len + 1);
        self.slots[self.len - 1] = slot;
        self.slots[..self.len].rotate_right(1);
    }
}

/// Rays to be tested, and their answers.
struct Test<'a, 'b> {
    occluders: &'a mut Occluders,
    tree: &'a Tree,
    filter: &'a Filter<'b>,
    rays: &'a [Ray],
    answers: &'a mut [bool],
    counts: &'a mut Counts,
}

impl WithSimd for Test<'_, '_> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(mut self) -> usize {
        let mut scratch = TraversalScratch::lend(self.tree);
        let mut hidden = 0;
        for first in (0..self.rays.len()).step_by(RAYS) {
            let rays = &self.rays[first..self.rays.len().min(first + RAYS)];
            let packet = RayPacket::loaded_in::<S>(rays);
            let prepared = self.filter.prepare_packet_in::<S, RAYS>(&packet);
            let mut left = self.remembered::<S>(&prepared, packet.live());

            if left != 0 && self.occluders.searches.is_waiting() {
                self.occluders.searches.pass();
            } else if left != 0 {
                // Remember what hides the first of the rays that are left, if anything does.
                let (before, ray) = (left, first + left.trailing_zeros() as usize);
                if let Some(slot) = self.find(RayId(ray as u32), &mut scratch) {
                    self.occluders.add(slot);
                    left &= !self.hits::<S>(&prepared, slot, left);
                }
                let has_paid = 2 * left.count_ones() <= before.count_ones();
                self.occluders.searches.tried(has_paid);
            }
            let hit = packet.live() & !left;
            hidden += hit.count_ones() as usize;
            lanes_of(hit).for_each(|lane| self.answers[first + lane] = true);
        }
        hidden
    }
}

impl Test<'_, '_> {
    /// Tests a packet's rays against the remembered triangles. Returns the rays that are left.
    #[inline(always)]
    fn remembered<S: Simd>(&mut self, packet: &PreparedPacket<'_, S, RAYS>, rays: u32) -> u32 {
        let mut left = rays;
        for place in 0..self.occluders.len {
            if left == 0 {
                break;
            }
            let slot = self.occluders.slots[place];
            let hits = self.hits::<S>(packet, slot, left);
            if hits != 0 {
                self.occluders.slots[..=place].rotate_right(1);
            }
            left &= !hits;
        }
        left
    }

    /// Returns the rays that are certain to hit the triangle in a slot.
    #[inline(always)]
    fn hits<S: Simd>(
        &mut self,
        packet: &PreparedPacket<'_, S, RAYS>,
        LeafSlot(slot): LeafSlot,
        rays: u32,
    ) -> u32 {
        let (leaf, lane) = (slot as usize / 8, slot as usize % 8);
        let block = &self.tree.leaves[leaf].block;
        self.filter.lane_hits_in::<S>(packet, block, lane, rays, self.counts).sure
    }

    /// Returns the slot of a triangle that a ray hits, if there is one.
    #[inline(never)]
    fn find(&mut self, id: RayId, scratch: &mut TraversalScratch) -> Option<LeafSlot> {
        let Self { tree, filter, rays, .. } = *self;
        let (ray, selection) = (&rays[id.0 as usize], &None);
        let single = SingleRay { tree, filter, ray, id, selection, scratch };
        let (closest, counts) = filter.level().run(Closest::<true>(single));
        *self.counts += counts;
        closest.triangle().map(|(_, slot)| slot)
    }
}

#[cfg(test)]
mod tests {
    use intertri::{Counts, Mode, Ray, RayOf, Scalar, TriangleOf};

    use super::super::RayBatch;
    use super::Occluders;
    use crate::util::test_numbers::random;
    use crate::util::threads::on_this_thread;
    use crate::{Bvh, BvhScalar};

    /// Returns a floor of many triangles, most of it below a roof of two, and trees beside the roof.
    fn house<S: Scalar>() -> Vec<TriangleOf<S>> {
        let mut random = random();
        let mut triangles = Vec::new();
        let mut add = |corners: [[f32; 3]; 3]| {
            triangles.push(TriangleOf(corners.map(|c| c.map(|x| S::nearest(f64::from(x) + 0.1)))));
        };
        for i in 0..32 * 32 {
            let [x, y] = [i % 32, i / 32].map(|k| k as f32);
            add([[x, y, 0.0], [x + 1.0, y, 0.0], [x, y + 1.0, 0.1]]);
            add([[x + 1.0, y + 1.0, 0.0], [x + 1.0, y, 0.0], [x, y + 1.0, 0.1]]);
            let at = [25.0 + 7.0 * random(), 32.0 * random(), 4.0 + random()];
            let mut near = || at.map(|x| x + 0.5 * random());
            add([near(), near(), near()]);
        }
        add([[0.0, -20.0, 3.0], [24.0, -20.0, 3.0], [0.0, 40.0, 3.0]]);
        add([[24.0, 40.0, 3.0], [24.0, -20.0, 3.0], [0.0, 40.0, 3.0]]);
        triangles
    }

    /// Returns rays from the floor toward the sun, in rows, and a few that differ.
    fn rays<S: Scalar>() -> Vec<RayOf<S>> {
        let ray = |i: usize| {
            let [x, y] = [i % 128, i / 128].map(|k| k as f64 / 4.0 + 0.1);
            let up = [x, y, 0.5];
            let (mut origin, mut dir) = (up.map(S::nearest), [0.1, 0.2, 1.0].map(S::nearest));
            let [mut near, mut far] = [S::ZERO, S::INFINITY];
            match i % 23 {
                3 => far = S::nearest(2.0),
                5 => near = S::nearest(20.0),
                7 => (near, far) = (S::nearest(5.0), S::nearest(1.0)),
                11 => dir = dir.map(|d| S::nearest(-d.into())),
                13 => origin[2] = S::nearest(9.0),
                17 => dir = [S::ZERO; 3],
                19 => dir[i % 3] = S::nearest(f64::NAN),
                21 => origin[i % 3] = S::INFINITY,
                _ => {}
            }
            RayOf { origin, t_min: near, dir, t_max: far }
        };
        (0..128 * 128).map(ray).collect()
    }

    /// Puts rays in a random order.
    fn mixed<S: Scalar>(rays: &[RayOf<S>]) -> Vec<RayOf<S>> {
        let (mut mixed, mut random) = (rays.to_vec(), random());
        for i in (1..mixed.len()).rev() {
            mixed.swap(i, ((random() * i as f32) as usize).min(i));
        }
        mixed
    }

    fn answers_are_those_of_single_rays<S: BvhScalar + Scalar>(modes: &[Mode]) {
        let (bvh, rays) = (Bvh::new(&house::<S>()).unwrap(), rays::<S>());
        let mixed = mixed(&rays);
        for &mode in modes {
            for rays in [&rays, &mixed] {
                let (tree, originals) = (&bvh.tree, &bvh.originals);
                let batch = RayBatch { tree, originals, mode, selection: None, rays };
                // What was in the memory before must not matter.
                let mut any = vec![true; rays.len()];
                on_this_thread(|| batch.trace(&mut any));
                let alone = |ray| {
                    let mut any = [true];
                    RayBatch { rays: std::slice::from_ref(ray), ..batch }.trace(&mut any);
                    any[0]
                };
                let alone: Vec<bool> = rays.iter().map(alone).collect();
                assert!(any == alone, "{mode:?}");

                // Occluders alone find at least a quarter of the hidden rays, and no others.
                let (mut occluders, mut counts) = (Occluders::new(), Counts::default());
                assert!(batch.hides_some(&mut occluders, &mut any, &mut counts), "{mode:?}");
                assert!(any.iter().zip(&alone).all(|(some, any)| !some || *any), "{mode:?}");
                let hidden = |any: &[bool]| any.iter().filter(|any| **any).count();
                assert!(4 * hidden(&any) > hidden(&alone), "{mode:?}: {}", hidden(&any));
            }
        }
    }

    #[test]
    fn answers_are_the_same_as_without_occluders() {
        answers_are_those_of_single_rays::<f32>(&[Mode::exact(), Mode::once(), Mode::certified()]);
        answers_are_those_of_single_rays::<f64>(&[Mode::exact(), Mode::once()]);
    }

    /// Traces rays that are sorted if no occluder hides them. The window has as many as indices allow.
    #[test]
    fn the_rays_that_are_left_may_be_sorted() {
        let bvh = Bvh::new(&house::<f32>()).unwrap();
        let ray = |i: usize| {
            let [x, y] = [i % 256, i / 256].map(|k| k as f32 / 8.0 + 0.1);
            // Hills, so that rows are curves as seen from the sun.
            let hills = (0.4 * x).sin() * (0.2 * y).cos();
            Ray::new([x, y, 1.2 + hills], [0.8, 0.9, 1.0])
        };
        let rows: Vec<Ray> = (0..1 << 16).map(ray).collect();
        let mut mixed = mixed(&rows);
        // A tree hides the last one.
        let by_tree = |ray: &Ray| ray.origin[0] > 26.0 && bvh.any(ray);
        let at = mixed.iter().position(by_tree).unwrap();
        mixed.swap(at, (1 << 16) - 1);
        for rays in [&mixed, &rows] {
            let (tree, originals, mode) = (&bvh.tree, &bvh.originals, Mode::exact());
            let batch = RayBatch { tree, originals, mode, selection: None, rays };
            assert!(batch.sorting::<bool>(&(0..rays.len())).is_some());
            let (mut any, mut counts) = (vec![true; rays.len()], Counts::default());
            assert!(batch.hides_some(&mut Occluders::new(), &mut any, &mut counts));
            on_this_thread(|| batch.trace(&mut any));
            let alone: Vec<bool> = rays.iter().map(|ray| bvh.any(ray)).collect();
            assert!(any == alone);
            assert!(alone.contains(&false));
        }
    }

    /// Rays that small triangles hide are traced as ever.
    #[test]
    fn small_triangles_are_soon_left_alone() {
        let (bvh, rays) = (Bvh::new(&house::<f32>()).unwrap(), rays::<f32>());
        // Below the trees.
        let rays: Vec<_> = rays.into_iter().filter(|ray| ray.origin[0] > 25.0).collect();
        let (tree, originals, mode) = (&bvh.tree, &bvh.originals, Mode::exact());
        let batch = RayBatch { tree, originals, mode, selection: None, rays: &rays };
        let (mut any, mut counts) = (vec![true; rays.len()], Counts::default());
        assert!(!batch.hides_some(&mut Occluders::new(), &mut any, &mut counts));
        assert!(counts.tests < rays.len() as u64, "{}", counts.tests);
    }
}
