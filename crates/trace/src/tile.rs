//! Many rays from one origin at once: a tile of a picture, or of what a light sees.
//!
//! ```text
//!   pyramid ──► boxes of nodes ──► triangles of a leaf, eight as the screen sees them
//!                                    │ in the window of the tile?
//!                                    ▼
//!                                  sixteen windows of sixteen rays: which does it reach?
//!                                    │
//!                                    ▼
//!                                  sixteen rays: two multiply-adds an edge
//! ```

use intertri::lanes::{Lanes, Mask, Simd, prefetch};
use intertri::{Certified, Counts, Judge, Nearest, Ray, Windows};

use crate::bvh::Bvh;
use crate::leaves::{Leaves, Test};
use crate::node::LEAF;
use crate::pyramid::Pyramid;
use crate::scratch::{NOTHING, Scratch, Stack};
use crate::screen::{PACKETS, Screen, around, smallest};
use crate::stack::far_to_near;
use crate::toward::Toward;

/// So much work a ray, in tests of a packet, and a tile is split.
const SPLIT: usize = 8;

/// So much, and a part of a tile is given up: its rays have too little in common. Half of it where any hit
/// will do, which a ray finds sooner by itself, too.
const PATIENCE: usize = 32;

/// Triangles larger than this share of a tile's window, along x or y, are held against the windows of
/// packets by their edges, too.
const LARGE: f32 = 0.5;

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
/// toward a point. The answers go to `answers`. What f32 leave open the judge settles, who
/// knows the rays by their places in `rays`, and the triangles by theirs in the packs.
///
/// `None` where they go too far apart; else bit p is set where the rays of packet p are left to be
/// asked one by one, because that is less work.
#[inline(always)]
pub(crate) fn search<S: Simd, R: AsRef<Ray>, A, J: Judge>(
    bvh: &Bvh,
    (mode, judge): (&Certified, &J),
    pencil: &Pencil<'_, R>,
    answers: &[A],
    any: bool,
    (screen, scratch): (&mut Screen<S>, &mut Scratch),
    counts: &mut Counts,
) -> Option<u32> {
    let (rays, origin) = (pencil.rays, pencil.origin());
    screen.lay(mode, pencil, answers, bvh.reach)?;
    let all = (1 << screen.used) - 1;
    let window = screen.window(all);
    let mut pyramid = Pyramid::new(&screen.frame, origin, window, bvh.reach);

    // Does the pyramid meet anything at all?
    let Scratch { stack, seen, found, split, leaves, .. } = scratch;
    stack.clear();
    seen.clear();
    found.clear();
    if bvh.boxed > 0 {
        stack.push((0, f32::NEG_INFINITY));
    }
    let mut next = next_leaves::<S>(bvh, &pyramid, stack, f32::INFINITY, &mut leaves.packs);
    if next == 0 && bvh.boxed == bvh.packs.len() {
        found.resize(rays.len(), NOTHING);
        return Some(0);
    }

    // Then its leaves, front to back, and the triangles without a box.
    let mut tile = Tile::new(bvh, (mode, judge), rays.len(), screen, window);
    let first = leaves.packs;
    for pack in bvh.boxed..bvh.packs.len() {
        leaves.packs[0] = pack as u32;
        tile.visit((leaves, 1), any, seen, counts);
    }
    leaves.packs = first;
    let patience = if any { PATIENCE / 2 } else { PATIENCE };
    let (mut quarters, mut budget) = match screen.used {
        ..=4 => (0..0, patience * rays.len()),
        used => (0..used.div_ceil(4), SPLIT * rays.len()),
    };
    let mut left = 0;
    loop {
        let mut far = tile.far();
        while next > 0 {
            if tile.visit((leaves, next), any, seen, counts) {
                far = tile.far();
            }
            if tile.work > budget {
                break;
            }
            next = next_leaves::<S>(bvh, &pyramid, stack, far, &mut leaves.packs);
        }

        let is_over = next == 0 || stack.is_empty();

        // What is too much for the whole goes on in four parts, from where it stands; a part for
        // which it is still too much is left.
        if tile.part == all {
            if is_over {
                break;
            }
            std::mem::swap(stack, split);
        }
        if !is_over && (tile.part != all || quarters.is_empty()) {
            left |= tile.part;
        }
        let part = |quarter: usize| tile.alive() & 0xf << (4 * quarter);
        let Some(quarter) = quarters.find(|&quarter| part(quarter) != 0) else { break };

        // Each with a pyramid of its own.
        tile.part = part(quarter);
        let window = screen.window(tile.part);
        tile.window = around::<S>(window);
        pyramid = Pyramid::new(&screen.frame, origin, window, bvh.reach);
        (tile.work, budget) = (0, 64 * patience);
        stack.clear();
        stack.extend_from_slice(split);
        let far = tile.far();
        next = next_leaves::<S>(bvh, &pyramid, stack, far, &mut leaves.packs);
    }

    for nearest in &tile.nearest[..screen.used] {
        found.extend_from_slice(&nearest.triangles());
    }
    found.truncate(rays.len());
    Some(left)
}

/// The next leaves that the pyramid meets before the depth `far`, as many as there is room for.
#[inline(always)]
fn next_leaves<S: Simd>(
    bvh: &Bvh,
    pyramid: &Pyramid,
    stack: &mut Stack,
    far: f32,
    packs: &mut [u32],
) -> usize {
    let mut count = 0;
    for to in packs {
        let Some(pack) = next_leaf::<S>(bvh, pyramid, stack, far) else { break };
        *to = pack;
        count += 1;
    }
    count
}

/// The next leaf that the pyramid meets before the depth `far`.
#[inline(always)]
fn next_leaf<S: Simd>(bvh: &Bvh, pyramid: &Pyramid, stack: &mut Stack, far: f32) -> Option<u32> {
    loop {
        let (child, near) = stack.pop()?;
        if near > far {
            continue;
        }
        if child & LEAF != 0 {
            return Some(child ^ LEAF);
        }
        let node = &bvh.nodes[child as usize];
        let (met, near) = pyramid.meet::<S::F32x8>(node, far);
        let mut depth = [0.0; 8];
        near.store(&mut depth);
        let order = far_to_near(met, pyramid.octant).to_le_bytes();
        for &slot in &order[..met.count_ones() as usize] {
            let slot = usize::from(slot % 8);
            let child = node.children()[slot];
            stack.push((child, depth[slot]));
            match child & LEAF {
                0 => prefetch(&bvh.nodes[child as usize..][..1]),
                _ => prefetch(&bvh.packs[(child ^ LEAF) as usize..][..1]),
            }
        }
    }
}

/// The rays of a tile and what they have hit so far.
struct Tile<'a, S: Simd, J> {
    bvh: &'a Bvh,
    mode: &'a Certified,
    judge: &'a J,
    rays: usize,
    screen: &'a Screen<S>,
    /// A window a packet, and the one of all.
    windows: Windows<S::F32x16>,
    window: Windows<S::F32x8>,
    /// Larger triangles reach several packets.
    large: [f32; 2],
    nearest: [Nearest<S::F32x16, 16>; PACKETS],
    /// Bit i of `live[p]`: ray `16 p + i` still looks for a hit.
    live: [u32; PACKETS],
    /// The least inverse depth at which a hit still counts, of each packet and of those asked now.
    least: [f32; PACKETS],
    least_of_all: f32,
    /// Those packets that are asked now.
    part: u32,
    /// Tests of packets, and what costs about as much.
    work: usize,
}

impl<'a, S: Simd, J: Judge> Tile<'a, S, J> {
    #[inline(always)]
    fn new(
        bvh: &'a Bvh,
        (mode, judge): (&'a Certified, &'a J),
        rays: usize,
        screen: &'a Screen<S>,
        window: ([f32; 2], [f32; 2]),
    ) -> Self {
        let mut tile = Self {
            bvh,
            mode,
            judge,
            rays,
            screen,
            windows: screen.windows(),
            window: around::<S>(window),
            large: [0, 1].map(|k| LARGE * (window.1[k] - window.0[k])),
            part: (1 << screen.used) - 1,
            nearest: [Nearest::new(&screen.points[0], &screen.rows.t_max[0]); PACKETS],
            live: screen.live,
            least: [0.0; PACKETS],
            least_of_all: 0.0,
            work: 0,
        };
        for packet in 0..screen.used {
            let nearest = Nearest::new(&screen.points[packet], &screen.rows.t_max[packet]);
            tile.nearest[packet] = nearest;
            if !screen.endless {
                tile.least[packet] = least::<S>(&nearest, tile.live[packet]);
            }
        }
        tile
    }

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
        let Self { bvh, mode, judge, rays, screen, .. } = *self;
        let first = seen.len();
        let (triangles, mut tests) = leaves.list(
            (bvh, used),
            (mode, screen),
            (&self.window, self.least_of_all, self.large),
            (&self.windows, &self.least, self.part),
            seen,
        );
        self.work += 8 * used + triangles + tests;
        counts.tests += (triangles * rays) as u64;

        // Rays that end before what they see are near most of what they miss: a first look at all,
        // without a branch.
        if any {
            let mut left = 0;
            for i in 0..tests {
                let test = leaves.test(i);
                let (points, live) = (&screen.points[test.packet], self.live[test.packet]);
                let (nearest, outline) = (&self.nearest[test.packet], leaves.outline(test.number));
                let maybe = nearest.maybe(&outline, points, &screen.ranges, live);
                leaves.put(left, test);
                left += usize::from(maybe);
            }
            tests = left;
        }

        let mut changed = 0_u32;
        for i in 0..tests {
            let Test { packet, number } = leaves.test(i);
            let may_change = self.nearest[packet].take(
                (&screen.points[packet], &screen.ranges),
                &leaves.outline(number),
                ((first + number) as u32, seen.as_slice()),
                (16 * packet, judge),
                self.live[packet],
                counts,
            );
            changed |= u32::from(may_change) << packet;
        }

        // As long as some ray has hit nothing, little is known.
        let mut known = false;
        while changed != 0 {
            let packet = changed.trailing_zeros() as usize % PACKETS;
            changed &= changed - 1;
            let nearest = &self.nearest[packet];
            if any {
                self.live[packet] &= !nearest.hits();
            }
            let live = self.live[packet];
            if live & !nearest.hits() == 0 {
                self.least[packet] = least::<S>(nearest, live);
                known = true;
            }
        }
        known
    }

    /// Bit p is set where rays of packet p still look for a hit.
    fn alive(&self) -> u32 {
        (0..PACKETS).map(|packet| u32::from(self.live[packet] != 0) << packet).sum()
    }

    /// No hit beyond this depth can count.
    #[inline(always)]
    fn far(&mut self) -> f32 {
        let which = <S::F32x16 as Lanes>::Mask::from_bits(self.part);
        let none = S::F32x16::splat(f32::INFINITY);
        let least = S::F32x16::select(which, S::F32x16::load(&self.least), none);
        self.least_of_all = smallest::<S>(least);
        let depth = 1.0 / self.least_of_all;
        depth + depth * (1.0 / (1 << 18) as f32)
    }
}

/// The least inverse depth at which a hit of some live ray still counts.
#[inline(always)]
fn least<S: Simd>(nearest: &Nearest<S::F32x16, 16>, live: u32) -> f32 {
    let live = <S::F32x16 as Lanes>::Mask::from_bits(live);
    smallest::<S>(S::F32x16::select(live, nearest.least(), S::F32x16::splat(f32::INFINITY)))
}
