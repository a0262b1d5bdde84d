//! Many rays from one origin at once: a tile of a picture, or of what a light sees.
//!
//! ```text
//!   pyramid ──► boxes of nodes ──► triangles of a leaf, eight as the screen sees them
//!                                    │ in the window of a group?
//!                                    ▼
//!                                  sixteen windows of sixteen rays: which does it reach?
//!                                    │
//!                                    ▼
//!                                  sixteen rays: two multiply-adds an edge
//! ```

use intertri::lanes::{Lanes, Simd, prefetch};
use intertri::{Certified, Counts, Judge, Ray};

use crate::ahead::Ahead;
use crate::bvh::Bvh;
use crate::dense::dense;
use crate::ends::Ends;
use crate::leaves::{AT_ONCE, Leaves, Listed, Test};
use crate::node::LEAF;
use crate::pyramid::Pyramid;
use crate::scratch::{NOTHING, Scratch, Stack};
use crate::screen::{GROUPS, PACKETS, RAYS, Screen, least};
use crate::stack::far_to_near;
use crate::toward::Toward;

/// A tile that is too much work goes on in parts of so many packets, and those in smaller ones.
const WIDTHS: [usize; 3] = [PACKETS, 16, 4];

/// So much work a ray, in tests of a packet, and a part is split.
const SPLIT: usize = 8;

/// So much, and one of the smallest parts is given up: its rays have too little in common. A quarter of it
/// where any hit will do, which a ray finds sooner by itself, too.
const PATIENCE: usize = 32;

/// Rays of one origin, or toward one point.
#[derive(Clone, Copy)]
pub(crate) struct Pencil<'a, R> {
    pub(crate) rays: &'a [R],
    /// Those that come later.
    pub(crate) next: &'a [R],
    /// The point toward which they go: then they are asked from there.
    pub(crate) toward: Option<Toward>,
}

impl<R: AsRef<Ray>> Pencil<'_, R> {
    /// The point that all rays have in common.
    #[inline(always)]
    pub(crate) fn origin(&self) -> [f32; 3] {
        self.toward.map_or(self.rays[0].as_ref().origin, |toward| toward.point)
    }
}

/// Finds the closest hit of each ray of a tile; with `any`, some hit, as it must be of rays
/// toward a point. What f32 leave open the judge settles, who
/// knows the rays by their places in `rays`, and the triangles by theirs in the leaves.
#[inline(always)]
pub(crate) fn search<S: Simd, R: AsRef<Ray> + Copy, J: Judge>(
    bvh: &Bvh,
    (mode, judge): (&Certified, &J),
    pencil: &Pencil<'_, R>,
    any: bool,
    (screen, scratch): (&mut Screen<S>, &mut Scratch),
    counts: &mut Counts,
) -> Tiled {
    let rays = pencil.rays;
    let mut ahead = Ahead::of(pencil.next, RAYS);
    let Some(window) = screen.lay(mode, pencil, bvh.reach, &mut ahead) else {
        return Tiled::TooWide;
    };
    let (used, all) = (screen.used, screen.all());
    let mut pyramid = Pyramid::new(&screen.frame, window, bvh.reach);
    let ends = if any { Some(Ends::new::<S>(screen, bvh.reach)) } else { None };
    let ends = ends.as_ref();

    // Does the pyramid meet anything at all?
    let Scratch { stack, seen, found, split, leaves, .. } = scratch;
    stack.clear();
    seen.clear();
    found.clear();
    if bvh.boxed > 0 {
        stack.push((0, f32::NEG_INFINITY));
    }
    let mut next = next_leaves::<S>(bvh, (&pyramid, ends), stack, f32::INFINITY, &mut leaves.packs);
    if next == 0 && bvh.boxed == bvh.leaves.len() {
        found.resize(rays.len(), NOTHING);
        return Tiled::Done { left: 0, work: 0 };
    }

    // Then its leaves, front to back, and the triangles without a box.
    let mut tile = Tile { bvh, mode, judge, rays: rays.len(), screen, ahead, work: 0 };
    tile.far();
    let first = leaves.packs;
    for pack in bvh.boxed..bvh.leaves.len() {
        leaves.packs[0] = pack as u32;
        S::vectorize(
            #[inline(always)]
            || tile.visit((leaves, 1), any, seen, counts),
        );
    }
    leaves.packs = first;

    let mut level = WIDTHS.iter().rposition(|&width| used <= width).unwrap_or(0);
    let (mut part, mut left, mut work) = (all, 0, 0);
    let (mut waiting, mut begun) = (Waiting::default(), false);
    loop {
        let patience = if any { PATIENCE / 4 } else { PATIENCE };
        let a_ray = if level + 1 < WIDTHS.len() { SPLIT } else { patience };
        let budget = a_ray * 16 * WIDTHS[level];
        let mut far = tile.far();
        while next > 0 {
            if tile.visit((leaves, next), any, seen, counts) {
                far = tile.far();
            }
            if tile.work > budget {
                break;
            }

            // The first leaves tell for which packets there will be too many triangles.
            if !std::mem::replace(&mut begun, true) && next == AT_ONCE {
                left = dense(tile.screen, leaves.outlines(next)) & all;
                part &= !left;
                if part == 0 {
                    stack.clear();
                    break;
                }
                if left != 0 {
                    let window = tile.screen.ask(part);
                    pyramid = Pyramid::new(&tile.screen.frame, window, bvh.reach);
                    far = tile.far();
                }
            }
            next = next_leaves::<S>(bvh, (&pyramid, ends), stack, far, &mut leaves.packs);
        }
        work += std::mem::take(&mut tile.work);

        // What is too much for a part goes on in smaller ones, from where it stands; one of the smallest
        // for which it is still too much is left.
        if next > 0 && !stack.is_empty() {
            match split.get_mut(level) {
                None => left |= part,
                Some(split) => {
                    std::mem::swap(stack, split);
                    waiting.add(part, level + 1);
                }
            }
        }

        // The next part whose rays still look for hits, with a pyramid of its own.
        let alive = tile.alive();
        (part, level) = loop {
            match waiting.next() {
                Some((part, level)) if part & alive != 0 => break (part & alive, level),
                Some(_) => {}
                None => {
                    for nearest in &tile.screen.nearest[..used] {
                        found.extend_from_slice(&nearest.triangles());
                    }
                    found.truncate(rays.len());
                    return Tiled::Done { left, work };
                }
            }
        };
        let window = tile.screen.ask(part);
        pyramid = Pyramid::new(&tile.screen.frame, window, bvh.reach);
        stack.clear();
        stack.extend_from_slice(&split[level - 1]);
        let far = tile.far();
        next = next_leaves::<S>(bvh, (&pyramid, ends), stack, far, &mut leaves.packs);
    }
}

/// What became of some rays in a row.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Tiled {
    /// They make no tile.
    Not,
    /// They go too far apart for one, or their numbers are too large or too small.
    TooWide,
    /// They are searched. Bit p of `left` is set where the rays of packet p are left to be asked one by
    /// one, because that is less work; `work` counts tests of packets, and what costs about as much.
    Done { left: u64, work: usize },
}

/// The parts of a tile that wait, the smaller ones first: at most all of the smallest kinds.
#[derive(Default)]
struct Waiting {
    parts: [(u64, usize); 2 * (WIDTHS.len() - 1) * GROUPS],
    len: usize,
}

impl Waiting {
    /// Adds what a part consists of, at the level of the smaller ones.
    fn add(&mut self, part: u64, level: usize) {
        let width = WIDTHS[level];
        for first in (0..PACKETS).step_by(width).rev() {
            let smaller = part & (u64::MAX >> (PACKETS - width)) << first;
            if smaller != 0 {
                self.parts[self.len] = (smaller, level);
                self.len += 1;
            }
        }
    }

    /// The next part, and its level.
    fn next(&mut self) -> Option<(u64, usize)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.parts[self.len])
    }
}

/// The next leaves that the pyramid meets before the depth `far` and, where that is known, before rays end; as
/// many as there is room for.
#[inline(always)]
fn next_leaves<S: Simd>(
    bvh: &Bvh,
    (pyramid, ends): (&Pyramid, Option<&Ends>),
    stack: &mut Stack,
    far: f32,
    packs: &mut [u32],
) -> usize {
    let mut count = 0;
    for to in packs {
        let Some(pack) = next_leaf::<S>(bvh, (pyramid, ends), stack, far) else { break };
        *to = pack;
        count += 1;
    }
    count
}

/// The next leaf that the pyramid meets there.
#[inline(always)]
fn next_leaf<S: Simd>(
    bvh: &Bvh,
    (pyramid, ends): (&Pyramid, Option<&Ends>),
    stack: &mut Stack,
    far: f32,
) -> Option<u32> {
    loop {
        let (child, near) = stack.pop()?;
        if near > far {
            continue;
        }
        if child & LEAF != 0 {
            return Some(child ^ LEAF);
        }
        let node = &bvh.nodes[child as usize];
        let (met, near) = pyramid.meet::<S::F32x8>(node, far, ends);
        let mut depth = [0.0; 8];
        near.store(&mut depth);
        let order = far_to_near(met, pyramid.octant).to_le_bytes();
        for &slot in &order[..met.count_ones() as usize] {
            let slot = usize::from(slot % 8);
            let child = node.children()[slot];
            stack.push((child, depth[slot]));
            match child & LEAF {
                0 => prefetch(&bvh.nodes[child as usize..][..1]),
                _ => prefetch(&bvh.leaves[(child ^ LEAF) as usize..][..1]),
            }
        }
    }
}

/// The rays of a tile on their way.
struct Tile<'a, S: Simd, J, R> {
    bvh: &'a Bvh,
    mode: &'a Certified,
    judge: &'a J,
    rays: usize,
    screen: &'a mut Screen<S>,
    ahead: Ahead<'a, R>,
    /// Tests of packets, and what costs about as much.
    work: usize,
}

impl<S: Simd, J: Judge, R> Tile<'_, S, J, R> {
    /// Tests the triangles of some leaves, each with those packets whose window it reaches. Whether
    /// the far end of a packet changed.
    #[inline(always)]
    fn visit(
        &mut self,
        (leaves, used): (&mut Leaves, usize),
        any: bool,
        seen: &mut Vec<u32>,
        counts: &mut Counts,
    ) -> bool {
        let Self { bvh, mode, judge, rays, ref mut screen, ref mut ahead, .. } = *self;
        let first = seen.len();
        let Listed { pairs, mut tests } = leaves.list((bvh, used), (mode, screen), seen, ahead);
        self.work += 8 * used + pairs.iter().sum::<usize>() + tests;
        for (group, pairs) in pairs.iter().enumerate() {
            let rays = rays.saturating_sub(group * RAYS / GROUPS).min(RAYS / GROUPS);
            counts.tests += (pairs * rays) as u64;
        }

        // Rays that end before what they see are near most of what they miss: a first look at all,
        // without a branch.
        if any {
            let mut left = 0;
            for i in 0..tests {
                let test = leaves.test(i);
                let (points, live) = (&screen.points[test.packet], screen.live[test.packet]);
                let (nearest, outline) =
                    (&screen.nearest[test.packet], leaves.outline(test.number));
                let maybe = nearest.maybe(&outline, points, &screen.ranges, live);
                leaves.put(left, test);
                left += usize::from(maybe);
            }
            tests = left;
        }

        let mut changed = 0_u64;
        for i in 0..tests {
            ahead.ask(1);
            let Test { packet, number } = leaves.test(i);
            let may_change = screen.nearest[packet].take(
                (&screen.points[packet], &screen.ranges),
                &leaves.outline(number),
                ((first + number) as u32, seen.as_slice()),
                (16 * packet, judge),
                screen.live[packet],
                counts,
            );
            changed |= u64::from(may_change) << packet;
        }

        // As long as some ray has hit nothing, little is known.
        let mut known = false;
        while changed != 0 {
            let packet = changed.trailing_zeros() as usize % PACKETS;
            changed &= changed - 1;
            let nearest = &screen.nearest[packet];
            if any {
                screen.live[packet] &= !nearest.hits();
            }
            let live = screen.live[packet];
            if live & !nearest.hits() == 0 {
                screen.groups[packet / 16].least[packet % 16] = least::<S>(nearest, live);
                known = true;
            }
        }
        known
    }

    /// Bit p is set where rays of packet p still look for a hit.
    fn alive(&self) -> u64 {
        (0..self.screen.used).map(|packet| u64::from(self.screen.live[packet] != 0) << packet).sum()
    }

    /// No hit of those asked now can count beyond this depth.
    #[inline(always)]
    fn far(&mut self) -> f32 {
        let depth = 1.0 / self.screen.least();
        depth + depth * (1.0 / (1 << 18) as f32)
    }
}
