//! Many rays from one origin at once: a tile of a picture, or of what a light sees.
//!
//! ```text
//!   pyramid ──► boxes of nodes ──► triangles of a leaf, eight as seen from the origin
//!                                    │ in the tile's beam?
//!                                    ▼
//!                                  sixteen beams of sixteen rays: which may hit it?
//!                                    │
//!                                    ▼
//!                                  sixteen rays: three dot products each
//! ```

use intertri::lanes::{Lanes, Simd};
use intertri::{Beams, Bests, Certified, Counts, Hit, Mode, PreparedPacket, Ray, RayPacket, Sights, Triangle};

use crate::bvh::Bvh;
use crate::node::LEAF;
use crate::pyramid::Pyramid;
use crate::search::Stack;

/// Rays of a tile, at most.
pub(crate) const RAYS: usize = 256;
const PACKETS: usize = 16;

/// What a search of tiles needs and need not make anew each time.
#[derive(Default)]
pub(crate) struct Scratch {
    stack: Stack,
    /// The places of the triangles that the tile's rays were tested against.
    seen: Vec<u32>,
    /// For each of those its place among the hit ones.
    slot: Vec<u32>,
    hit: Vec<u32>,
    sights: Vec<Sights>,
    /// Index and place in `seen` of each ray's hit.
    pub(crate) found: Vec<Option<(u32, u32)>>,
}

/// Whether rays can make a tile: all from one origin.
pub(crate) fn shares_origin(rays: &[Ray]) -> bool {
    let origin = rays[0].origin;
    rays.len() > 1 && rays.iter().all(|ray| ray.origin == origin)
}

struct Tile<'a, S: Simd> {
    bvh: &'a Bvh,
    mode: &'a Certified,
    origin: [f32; 3],
    packets: [PreparedPacket<'a, Certified, S, 16>; PACKETS],
    used: usize,
    beams: Beams<S::F32x16>,
    beam: Beams<S::F32x8>,
    bests: [Bests<S::F32x16, 16>; PACKETS],
    live: [u32; PACKETS],
    any: bool,
}

impl<S: Simd> Tile<'_, S> {
    /// The triangles of a pack, for whatever rays may hit them.
    #[inline(always)]
    fn visit(&mut self, pack: usize, seen: &mut Vec<u32>, counts: &mut Counts) -> bool {
        let Self { bvh, mode, .. } = *self;
        let triangles = &bvh.packs[pack];
        let views = mode.views_in::<S>(triangles, self.origin);
        let mut met = views.in_beam(&self.beam);
        let mut any = false;
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            let view = views.lane(lane);
            let mut packets = view.beams(&self.beams) & ((1 << self.used) - 1);
            if packets == 0 {
                continue;
            }
            any = true;
            let (index, local) = (bvh.indices[pack][lane], seen.len() as u32);
            seen.push(8 * pack as u32 + lane as u32);
            while packets != 0 {
                let p = packets.trailing_zeros() as usize;
                packets &= packets - 1;
                let find = |local: u32| bvh.triangle_in(seen[local as usize]);
                let (live, best) = (self.live[p], &mut self.bests[p]);
                mode.view_closest_in(&self.packets[p], &view, (index, local), find, live, best, counts);
                if self.any {
                    self.live[p] &= !best.hits();
                }
            }
        }
        any
    }
}

/// The closest hits of a tile; with `any`, some hits. `false` where the rays are no tile.
#[inline(always)]
pub(crate) fn closest<S: Simd>(
    bvh: &Bvh,
    mode: &Certified,
    rays: &[Ray],
    any: bool,
    scratch: &mut Scratch,
    counts: &mut Counts,
) -> bool {
    // The rays side by side, as packets and as the rays of beams.
    let mut rows = [[[0.0; 16]; 3]; 16];
    let used = rays.len().div_ceil(16);
    for (i, row) in rows.iter_mut().enumerate() {
        for p in 0..PACKETS {
            let ray = &rays[(16 * p + i).min(rays.len() - 1)];
            for k in 0..3 {
                row[k][p] = ray.dir[k];
            }
        }
    }
    let Some(pyramid) = Pyramid::new::<S>(&[rays[0], rays[1]], &rows, bvh.reach) else {
        return false;
    };
    let empty = RayPacket::<16>::new(&rays[..1]);
    let mut packets = [empty; PACKETS];
    for (packet, rays) in packets.iter_mut().zip(rays.chunks(16)) {
        *packet = RayPacket::new(rays);
    }
    let first = mode.prepare_packet_in::<S, 16>(&packets[0]);
    let mut prepared = [first; PACKETS];
    let mut bests = [Bests::new(&packets[0].t_max); PACKETS];
    let mut live = [0; PACKETS];
    for p in 0..used {
        prepared[p] = mode.prepare_packet_in(&packets[p]);
        bests[p] = Bests::new(&packets[p].t_max);
        live[p] = packets[p].live();
    }
    let beams = Beams::new(&rows);
    let beam = beams.all();
    let mut tile = Tile { bvh, mode, origin: rays[0].origin, packets: prepared, used, beams, beam, bests, live, any };

    // How deep each ray goes along the axis in a unit of t.
    let axis = pyramid.axis();
    let splat = S::F32x16::splat;
    let mut depth = [splat(0.0); PACKETS];
    for p in 0..used {
        let dir = &packets[p].dir;
        depth[p] = S::F32x16::load(&dir[0]) * splat(axis[0])
            + S::F32x16::load(&dir[1]) * splat(axis[1])
            + S::F32x16::load(&dir[2]) * splat(axis[2]);
    }

    let Scratch { stack, seen, .. } = scratch;
    seen.clear();
    stack.clear();
    if bvh.boxed > 0 {
        stack.push((0, f32::NEG_INFINITY));
    }
    for pack in bvh.boxed..bvh.packs.len() {
        tile.visit(pack, seen, counts);
    }
    let mut far = f32::INFINITY;
    'walk: while let Some((child, near)) = stack.pop() {
        if near > far {
            continue;
        }
        if child & LEAF == 0 {
            let node = &bvh.nodes[child as usize];
            let (met, near) = pyramid.meet::<S::F32x8>(node, far);
            if met == 0 {
                continue;
            }
            let mut t = [0.0; 8];
            near.store(&mut t);
            let mut order = crate::search::mirror(met, pyramid.octant);
            while order != 0 {
                let last = order.ilog2();
                order ^= 1 << last;
                let slot = last as usize ^ pyramid.octant;
                stack.push((node.child[slot], t[slot]));
            }
            continue;
        }
        if tile.visit((child ^ LEAF) as usize, seen, counts) {
            // The farthest depth that still counts.
            let mut deepest = splat(f32::NEG_INFINITY);
            let mut left = 0;
            for p in 0..used {
                left |= tile.live[p];
                if tile.live[p] != 0 {
                    deepest = deepest.max(tile.bests[p].t_hi() * depth[p]);
                }
            }
            if left == 0 {
                break 'walk;
            }
            let mut lanes = [0.0; 16];
            deepest.store(&mut lanes);
            far = lanes.into_iter().fold(0.0, f32::max) * (1.0 + 1.0 / 65536.0);
        }
    }

    scratch.found.clear();
    scratch.found.extend((0..rays.len()).map(|i| tile.bests[i / 16].triangle(i % 16)));
    true
}

/// Where the rays of the last tile hit what they hit.
#[inline(always)]
pub(crate) fn hits<S: Simd>(bvh: &Bvh, rays: &[Ray], scratch: &mut Scratch, hits: &mut [Hit]) {
    let Scratch { seen, slot, hit, sights, found, .. } = scratch;

    // Every triangle once, however many rays hit it.
    slot.clear();
    slot.resize(seen.len(), u32::MAX);
    hit.clear();
    for &(_, local) in found.iter().flatten() {
        let slot = &mut slot[local as usize];
        if *slot == u32::MAX {
            *slot = hit.len() as u32;
            hit.push(seen[local as usize]);
        }
    }
    sights.clear();
    for eight in hit.chunks(8) {
        let mut corners = [[[0.0; 8]; 3]; 3];
        for (lane, &place) in eight.iter().enumerate() {
            let Triangle(from) = bvh.triangle_in(place);
            for (to, from) in corners.iter_mut().zip(&from) {
                for k in 0..3 {
                    to[k][lane] = from[k];
                }
            }
        }
        sights.push(Sights::new_in::<S>(&corners, rays[0].origin));
    }

    for ((ray, found), hit) in rays.iter().zip(found).zip(hits) {
        *hit = match *found {
            None => Hit::MISS,
            Some((index, local)) => {
                let slot = slot[local as usize] as usize;
                sights[slot / 8].hit(slot % 8, ray.dir, index)
            }
        };
    }
}
