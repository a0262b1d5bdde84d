//! Traces bundles: many rays of one apex, such as camera rays, rays from a light, or parallel rays.
//!
//! ```text
//!   frustum ──► boxes of nodes ──► triangles of a leaf, projected eight at a time
//!                                    │ inside the window of a group?
//!                                    ▼
//!                                  sixteen packets' windows: which ones does it reach?
//!                                    │
//!                                    ▼
//!                                  sixteen rays: two multiply-adds per edge
//! ```

use intertri::internal::{Apex, OpenPairs, Settle};
use intertri::simd::Simd;
use intertri::{Counts, Filter, LeafSlot, Triangle};

use super::culling::{Culling, Pending};
use super::density::too_dense;
use super::end_plane::EndPlane;
use super::frustum::Frustum;
use super::leaf_tests::{AT_ONCE, Leaves, ListedTests, PacketTest};
use super::parts::{WIDTHS, WaitingParts, budget};
use super::projection::{GROUPS, PACKETS, Projection, RAYS, least};
use super::rays::{BundleRays, Common};
use super::results::{NOTHING, PacketHits, Results, Shared};
use crate::tree::{EMPTY, Tree};
use crate::util::prefetch::Prefetch;

/// Traces bundles with a given goal: the closest hit of each ray or, if `any` is set, any hit.
/// Reversed rays must be traced with `any`.
#[derive(Clone, Copy)]
pub(crate) struct Bundle<'a> {
    pub(crate) tree: &'a Tree,
    pub(crate) filter: Filter<'a>,
    pub(crate) any: bool,
    /// Whether to list all hits of each ray.
    pub(crate) every: bool,
    /// The work after which the packets that are not finished are left.
    pub(crate) limit: usize,
}

/// The outcome of tracing several consecutive rays.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Outcome {
    /// The rays do not form a bundle.
    NotCoherent,
    /// The rays diverge too much to form a bundle, or their values are too large or too small.
    TooWide,
    /// The rays were traced in packets. Bit p of `left` is set if packet p was left untraced.
    InPackets { left: u64 },
    /// The rays were traced as a bundle. Bit p of `left` is set if the rays of packet p were left
    /// untraced because tracing them one by one is less work. `work` counts packet tests and
    /// comparable work.
    Traced { left: u64, work: usize },
}

/// Scratch memory for tracing, reused from bundle to bundle.
#[derive(Default)]
pub(crate) struct Scratch {
    stack: Pending,
    leaves: Leaves,
    open: OpenPairs,
    /// The entries left on the stack when the bundle was split, and when one of its parts was
    /// split.
    split: [Pending; 2],
}

impl Bundle<'_> {
    /// Traces several rays. The resolver decides the cases that the filter cannot.
    #[inline(always)]
    pub(crate) fn trace<S: Simd>(
        self,
        rays: &BundleRays<'_>,
        (projection, scratch, results): (&mut Projection<S>, &mut Scratch, &mut Results),
        counts: &mut Counts,
    ) -> Outcome {
        let Self { tree, filter, any, .. } = self;
        let after = (rays.first, RAYS);
        let mut prefetch = Prefetch::of(filter.resolver().memory_after(after, rays.next), RAYS);
        let Some(window) = projection.project(&filter, rays, tree.reach, &mut prefetch) else {
            return Outcome::TooWide;
        };
        let margin = tree.margin(filter.resolver());
        let apex = projection.frame.apex();
        let end_plane = any.then(|| EndPlane::new::<S>(projection, &margin));
        let frustum = Frustum::new(&projection.frame, window, &margin);
        let closest = !any && !self.every;
        let mut culling = Culling { frustum, end_plane: end_plane.as_ref(), closest };

        // Check whether the frustum reaches any leaf.
        let Scratch { stack, leaves, open, split } = scratch;
        stack.clear();
        results.clear();
        results.shared = match rays.common {
            Common::Origin => Shared::Origin,
            Common::Direction { .. } => Shared::Direction,
            Common::End(_) => Shared::Nothing,
        };
        let unboxed = tree.first_unboxed(filter.resolver());
        for root in [tree.thin_root_for(unboxed), 0] {
            if root != EMPTY {
                stack.push((root, f32::NEG_INFINITY));
            }
        }
        // Bundles that miss the whole scene end here, before any setup.
        let count = culling.next_leaves::<S>(tree, stack, f32::INFINITY, &mut leaves.blocks);
        if count == 0 && unboxed == tree.leaves.len() {
            results.found.resize(rays.rays.len(), NOTHING);
            return Outcome::Traced { left: 0, work: 0 };
        }

        let (find, index) = (|slot| tree.triangle_in(slot), |slot| tree.index_of(slot).0);
        let (resolver, reversed) = (filter.resolver(), rays.common.is_reversed());
        let (first, rays) = (rays.first, rays.rays);
        let settle = Settle { resolver, apex, rays, first, find, index, reversed };
        let (seen, every) = (&mut results.seen, &mut results.every);
        let mut tracing = Tracing {
            bundle: self,
            settle,
            projection,
            prefetch,
            seen,
            every,
            open,
            work: 0,
            density_known: false,
        };
        let (left, work) = tracing.parts(&mut culling, (stack, split, leaves), count, counts);
        let used = projection.used;
        for nearest in &projection.nearest[..used] {
            results.found.extend_from_slice(&nearest.triangles());
        }
        results.found.truncate(rays.len());
        Outcome::Traced { left, work }
    }
}

/// The state of a bundle that is being traced.
struct Tracing<'a, S: Simd, T, I> {
    bundle: Bundle<'a>,
    settle: Settle<'a, T, I>,
    projection: &'a mut Projection<S>,
    prefetch: Prefetch<'a>,
    seen: &'a mut Vec<LeafSlot>,
    every: &'a mut Vec<PacketHits>,
    /// Pairs that are not settled yet. There are none between two visits.
    open: &'a mut OpenPairs,
    /// The amount of work so far: the number of packet tests and comparable operations.
    work: usize,
    /// Whether the density of triangles is known from the first leaves.
    density_known: bool,
}

impl<S: Simd, T: Fn(LeafSlot) -> Triangle, I: Fn(LeafSlot) -> u32> Tracing<'_, S, T, I> {
    /// Traces all rays, splitting them into parts if they take too much work together. The first
    /// `count` leaves are already listed. Returns a mask of the packets left untraced, and the
    /// amount of work.
    #[inline(always)]
    fn parts(
        &mut self,
        culling: &mut Culling<'_>,
        (stack, split, leaves): (&mut Pending, &mut [Pending; 2], &mut Leaves),
        mut count: usize,
        counts: &mut Counts,
    ) -> (u64, usize) {
        self.visit_unboxed(leaves, counts);
        let (tree, used) = (self.bundle.tree, self.projection.used);
        let mut level = WIDTHS.iter().rposition(|&width| used <= width).unwrap_or(0);
        let (mut part, mut left, mut work) = (self.projection.all(), 0, 0);
        let mut waiting = WaitingParts::default();
        loop {
            let budget = budget(level, self.bundle.any).min(self.bundle.limit - work);
            let (dense, rest) = self.part(culling, (stack, leaves, count), (part, budget), counts);
            left |= dense;
            part &= !dense;
            work += std::mem::take(&mut self.work);
            if work >= self.bundle.limit {
                left |= if rest { part } else { 0 };
                while let Some((part, _)) = waiting.next(self.alive()) {
                    left |= part;
                }
                return (left, work);
            }

            // If a part takes too much work, continue with smaller parts from the current position.
            // If one of the smallest parts still takes too much work, or if smaller parts would be
            // no narrower, leave the rays to a stream.
            if rest && !stack.is_empty() {
                match split.get_mut(level) {
                    Some(split) if !self.projection.is_scattered(part) => {
                        std::mem::swap(stack, split);
                        waiting.add(part, level + 1);
                    }
                    _ => left |= part,
                }
            }

            // Take the next part that has live rays, and give it a frustum of its own.
            let Some(next) = waiting.next(self.alive()) else { return (left, work) };
            (part, level) = next;
            self.ask(part, culling);
            stack.clear();
            stack.extend_from_slice(&split[level - 1]);
            let far = self.far();
            count = culling.next_leaves::<S>(tree, stack, far, &mut leaves.blocks);
        }
    }

    /// Visits the leaves that every ray may hit, regardless of their boxes.
    #[inline(always)]
    fn visit_unboxed(&mut self, leaves: &mut Leaves, counts: &mut Counts) {
        let tree = self.bundle.tree;
        self.far();
        let first = leaves.blocks;
        for leaf in tree.first_unboxed(self.bundle.filter.resolver())..tree.leaves.len() {
            leaves.blocks[0] = leaf as u32;
            self.visit((leaves, 1), counts);
        }
        leaves.blocks = first;
    }

    /// Visits the leaves that a part reaches, front to back, until that takes too much work.
    /// Returns a mask of the packets that would reach too many triangles, and whether any leaves
    /// remain.
    #[inline(always)]
    fn part(
        &mut self,
        culling: &mut Culling<'_>,
        (stack, leaves, mut count): (&mut Pending, &mut Leaves, usize),
        (part, budget): (u64, usize),
        counts: &mut Counts,
    ) -> (u64, bool) {
        let tree = self.bundle.tree;
        let (mut far, mut dense) = (self.far(), 0);
        while count > 0 {
            if self.visit((leaves, count), counts) {
                far = self.far();
            }
            // There are too many tests per ray. Smaller parts have narrower frustums and reach
            // fewer triangles.
            if self.work > budget {
                return (dense, true);
            }

            // The first leaves show which packets will reach too many triangles.
            if !std::mem::replace(&mut self.density_known, true) && count == AT_ONCE {
                let outlines = leaves.outlines(count);
                dense = too_dense(self.projection, outlines, culling.closest) & part;
                if dense == part {
                    stack.clear();
                    return (dense, true);
                }
                if dense != 0 {
                    self.ask(part & !dense, culling);
                    far = self.far();
                }
            }
            count = culling.next_leaves::<S>(tree, stack, far, &mut leaves.blocks);
        }
        (dense, false)
    }

    /// Makes the given packets the current ones.
    #[inline(always)]
    fn ask(&mut self, packets: u64, culling: &mut Culling<'_>) {
        let window = self.projection.ask(packets);
        let margin = self.bundle.tree.margin(self.bundle.filter.resolver());
        culling.frustum = Frustum::new(&self.projection.frame, window, &margin);
    }

    /// Tests the triangles of several leaves, each against the packets whose windows it reaches.
    /// Returns whether the far end of any packet changed. This function is never inlined, so that it
    /// is compiled once for each level.
    #[inline(never)]
    fn visit(&mut self, leaves: (&mut Leaves, usize), counts: &mut Counts) -> bool {
        S::vectorize(
            #[inline(always)]
            || self.visit_leaves(leaves, counts),
        )
    }

    #[inline(always)]
    fn visit_leaves(&mut self, (leaves, used): (&mut Leaves, usize), counts: &mut Counts) -> bool {
        let Self { bundle, settle, projection, prefetch, seen, open, .. } = self;
        let Bundle { tree, filter, any, every, .. } = *bundle;
        let first = seen.len();
        let ListedTests { pairs, mut tests } =
            leaves.list((tree, used), (&filter, projection), seen, prefetch);
        self.work += 8 * used + pairs.iter().sum::<usize>() + tests;
        for (group, pairs) in pairs.iter().enumerate() {
            let rays = settle.rays.len().saturating_sub(group * RAYS / GROUPS).min(RAYS / GROUPS);
            counts.tests += (pairs * rays) as u64;
        }

        if every {
            self.visit_every((leaves, tests), first, counts);
            return false;
        }

        // Rays that end just before a surface pass close to most of the triangles that they miss,
        // so precheck all tests first, without a branch.
        if any {
            let mut left = 0;
            for i in 0..tests {
                let test = leaves.test(i);
                let (points, live) =
                    (&projection.points[test.packet], projection.live[test.packet]);
                let nearest = &projection.nearest[test.packet];
                let outline = leaves.outline(test.number);
                let maybe = nearest.maybe(&outline, points, &projection.ranges, live);
                // Always write the test. The next test overwrites it unless `left` advances.
                leaves.put(left, test);
                left += usize::from(maybe);
            }
            tests = left;
        }

        let mut changed = 0_u64;
        for i in 0..tests {
            prefetch.lines(1);
            let PacketTest { packet, number } = leaves.test(i);
            if open.is_full() {
                settle_open::<S, _, _>(projection, (seen, settle), open, any);
            }
            let may_change = projection.nearest[packet].take(
                (&projection.points[packet], &projection.ranges),
                &leaves.outline(number),
                ((first + number) as u32, 16 * packet),
                projection.live[packet],
                open,
                counts,
            );
            changed |= u64::from(may_change) << packet;
        }
        if !open.is_empty() {
            settle_open::<S, _, _>(projection, (seen, settle), open, any);
        }
        update::<S>(projection, changed, any)
    }

    /// Lists all hits found by the tests of several leaves. The triangles of these leaves start at
    /// `first` in `seen`; those that are not hit are removed.
    #[inline(always)]
    fn visit_every(
        &mut self,
        (leaves, tests): (&mut Leaves, usize),
        first: usize,
        counts: &mut Counts,
    ) {
        let Self { settle, projection, seen, every, .. } = self;
        // Tests are sorted by pair, so each entry that is kept is written to a position that has
        // already been read.
        let (mut stay, mut last) = (first, usize::MAX);
        for i in 0..tests {
            let PacketTest { packet, number } = leaves.test(i);
            let slot = seen[first + number];
            let lanes = projection.nearest[packet].hit_by(
                (&projection.points[packet], &projection.ranges),
                &leaves.outline(number),
                slot,
                (16 * packet, settle),
                projection.live[packet],
                counts,
            );
            if lanes != 0 {
                if number != last {
                    seen[stay] = slot;
                    (stay, last) = (stay + 1, number);
                }
                let (number, lanes) = (stay as u32 - 1, lanes as u16);
                every.push(PacketHits { number, packet: packet as u16, lanes });
            }
        }
        seen.truncate(stay);
    }

    /// Returns a mask of the packets with at least one ray that is still searching for a hit.
    fn alive(&self) -> u64 {
        let is_alive = |packet: usize| u64::from(self.projection.live[packet] != 0) << packet;
        (0..self.projection.used).map(is_alive).sum()
    }

    /// Returns the depth beyond which no hit of the current packets can count.
    #[inline(always)]
    fn far(&mut self) -> f32 {
        // Compute the farthest depth at which any ray is still searching for a hit, with a margin
        // for the rounding of the inverse.
        let (least, margin) = (self.projection.least(), 1.0 / (1 << 18) as f32);
        match self.settle.apex {
            Apex::Finite => {
                let depth = 1.0 / least;
                depth + depth * margin
            }
            Apex::AtInfinity { .. } => -least + least.abs() * margin,
        }
    }
}

/// Settles the pairs that the filter left open. The function is out of line to keep registers free for
/// the common case.
#[cold]
#[inline(never)]
fn settle_open<S: Simd, T: Fn(LeafSlot) -> Triangle, I: Fn(LeafSlot) -> u32>(
    projection: &mut Projection<S>,
    (seen, settle): (&[LeafSlot], &Settle<'_, T, I>),
    open: &mut OpenPairs,
    any: bool,
) {
    let Projection { nearest, points, .. } = projection;
    S::vectorize(
        #[inline(always)]
        || open.settle((&mut nearest[..], &points[..]), seen, settle, any),
    );
}

/// Updates packets after hits. In any-hit queries, rays with a hit are finished. Returns whether a
/// far end came nearer.
#[inline(always)]
fn update<S: Simd>(projection: &mut Projection<S>, mut changed: u64, any: bool) -> bool {
    // The far end of a packet stays in place as long as one of its rays has no hit.
    let mut known = false;
    while changed != 0 {
        let packet = changed.trailing_zeros() as usize % PACKETS;
        changed &= changed - 1;
        let nearest = &projection.nearest[packet];
        if any {
            // A ray with a hit does not need further tests.
            projection.live[packet] &= !nearest.hits();
        }
        let live = projection.live[packet];
        // The far end of a packet comes nearer only once all its rays have hit something.
        if live & !nearest.hits() == 0 {
            projection.groups[packet / 16].least[packet % 16] = least::<S>(nearest, live);
            known = true;
        }
    }
    known
}
