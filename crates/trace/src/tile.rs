//! Many rays from one origin at once: a tile of a picture, or of what a light sees.
//!
//! ```text
//!   pyramid ──► boxes of nodes ──► triangles of a leaf, eight as seen from the origin
//!                                    │ in the beam of the tile?
//!                                    ▼
//!                                  sixteen beams of sixteen rays: which may hit it?
//!                                    │
//!                                    ▼
//!                                  sixteen rays: three dot products each
//! ```

use intertri::lanes::{Lanes, Mask, Simd};
use intertri::{Beams, Best, Bests, Certified, Counts, Hit, Pencil, Ray, Sights, Triangle, Vec3};

use crate::bvh::Bvh;
use crate::node::LEAF;
use crate::pyramid::Pyramid;
use crate::search::{Stack, mirror};

/// Rays of a tile, at most.
pub(crate) const RAYS: usize = 256;

/// Sixteen rays each.
const PACKETS: usize = RAYS / 16;

/// So much work a ray, in tests of a packet, and a tile is given up: its rays have too little in
/// common.
const PATIENCE: usize = 16;

/// What a search of tiles needs and need not make anew each time.
#[derive(Default)]
pub(crate) struct Scratch {
    stack: Stack,
    /// The places of the triangles that rays of the tile were tested against.
    seen: Vec<u32>,
    /// For each ray the number in `seen` of the triangle that it hits, or [`Best::NOTHING`].
    found: Vec<u32>,
    /// For each of `seen` its number among those that are hit, or [`Best::NOTHING`].
    slot: Vec<u32>,
    /// The places of those that are hit.
    hit: Vec<u32>,
    sights: Vec<Sights>,
}

impl Scratch {
    /// Whether each ray of the last tile hits something.
    pub(crate) fn any(&self, hits: &mut [bool]) {
        for (hit, found) in hits.iter_mut().zip(&self.found) {
            *hit = *found != Best::NOTHING;
        }
    }

    /// Where the rays of the last tile meet what they hit.
    #[inline(always)]
    pub(crate) fn hits<S: Simd>(&mut self, bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
        let Self { seen, slot, hit, sights, found, .. } = self;

        // Every triangle once, however many rays hit it.
        slot.clear();
        hit.clear();
        sights.clear();
        slot.resize(seen.len(), Best::NOTHING);
        for &number in found.iter().filter(|&&number| number != Best::NOTHING) {
            let slot = &mut slot[number as usize];
            if *slot == Best::NOTHING {
                *slot = hit.len() as u32;
                hit.push(seen[number as usize]);
            }
        }
        for places in hit.chunks(8) {
            let mut corners = [[[0.0; 8]; 3]; 3];
            for (lane, &place) in places.iter().enumerate() {
                let Triangle(from) = bvh.triangle_in(place);
                for (to, from) in corners.iter_mut().zip(&from) {
                    (to[0][lane], to[1][lane], to[2][lane]) = (from[0], from[1], from[2]);
                }
            }
            sights.push(Sights::new_in::<S>(&corners, rays[0].origin));
        }

        for ((ray, &number), to) in rays.iter().zip(found.iter()).zip(hits) {
            *to = if number == Best::NOTHING {
                Hit::MISS
            } else {
                let slot = slot[number as usize] as usize;
                let index = bvh.index_of(hit[slot]);
                sights[slot / 8].hit(slot % 8, ray.dir, index)
            };
        }
    }
}

/// Whether all rays start at the same point, to the bit.
#[inline(always)]
pub(crate) fn shares_origin(rays: &[Ray]) -> bool {
    let bits = |ray: &Ray| ray.origin.map(f32::to_bits);
    let first = bits(&rays[0]);
    let differ = rays.iter().fold(0, |differ, ray| {
        let [x, y, z] = bits(ray);
        differ | (x ^ first[0]) | (y ^ first[1]) | (z ^ first[2])
    });
    differ == 0 && rays.len() > 1
}

/// Finds the closest hit of each ray of a tile; with `any`, some hit. The rays share an origin.
/// `false` where that is not worth while.
#[inline(always)]
pub(crate) fn search<S: Simd>(
    bvh: &Bvh,
    mode: &Certified,
    rays: &[Ray],
    any: bool,
    scratch: &mut Scratch,
    counts: &mut Counts,
) -> bool {
    // The directions side by side. The last packet is filled with the last ray.
    let used = rays.len().div_ceil(16);
    let mut dirs = [[[0.0; 16]; 3]; PACKETS];
    for (packet, dir) in dirs[..used].iter_mut().enumerate() {
        for lane in 0..16 {
            let ray = &rays[(16 * packet + lane).min(rays.len() - 1)];
            (dir[0][lane], dir[1][lane], dir[2][lane]) = (ray.dir[0], ray.dir[1], ray.dir[2]);
        }
    }
    let dirs = &dirs[..used];
    let Some(pyramid) = Pyramid::new::<S>([&rays[0], &rays[1]], dirs, bvh.reach) else {
        return false;
    };

    // Does the pyramid meet anything at all?
    let Scratch { stack, seen, found, .. } = scratch;
    stack.clear();
    seen.clear();
    found.clear();
    if bvh.boxed > 0 {
        stack.push((0, f32::NEG_INFINITY));
    }
    let mut next = next_leaf::<S>(bvh, &pyramid, stack, f32::INFINITY);
    if next.is_none() && bvh.boxed == bvh.packs.len() {
        found.resize(rays.len(), Best::NOTHING);
        return true;
    }

    // Then its leaves, front to back, and the triangles without a box.
    let mut tile = Tile::<S>::new(bvh, mode, rays, dirs, &pyramid);
    for pack in bvh.boxed..bvh.packs.len() {
        tile.visit(pack, any, seen, counts);
    }
    let mut far = f32::INFINITY;
    while let Some(pack) = next {
        if tile.visit(pack as usize, any, seen, counts) {
            far = tile.far();
        }
        if tile.work > PATIENCE * rays.len() {
            return false;
        }
        next = next_leaf::<S>(bvh, &pyramid, stack, far);
    }

    for bests in &tile.bests[..used] {
        found.extend_from_slice(&bests.places());
    }
    found.truncate(rays.len());
    true
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
        let mut order = mirror(met, pyramid.octant);
        while order != 0 {
            let last = order.ilog2();
            order ^= 1 << last;
            let slot = last as usize ^ pyramid.octant;
            stack.push((node.child[slot], depth[slot]));
        }
    }
}

/// The rays of a tile and what they have hit so far.
struct Tile<'a, S: Simd> {
    bvh: &'a Bvh,
    mode: &'a Certified,
    rays: &'a [Ray],
    /// The rays, sixteen by sixteen.
    pencils: [Pencil<S::F32x16>; PACKETS],
    bests: [Bests<S::F32x16, 16>; PACKETS],
    /// How far along the pyramid's axis each ray goes in a unit of t.
    depth: [S::F32x16; PACKETS],
    /// Bit i of `live[p]`: ray `16 p + i` still looks for a hit.
    live: [u32; PACKETS],
    /// A beam a packet, and the one of all.
    beams: Beams<S::F32x16>,
    beam: Beams<S::F32x8>,
    /// Bit p: there is a packet p.
    used: u32,
    /// Tests of packets, and what costs about as much.
    work: usize,
}

impl<'a, S: Simd> Tile<'a, S> {
    #[inline(always)]
    fn new(
        bvh: &'a Bvh,
        mode: &'a Certified,
        rays: &'a [Ray],
        dirs: &[[[f32; 16]; 3]],
        pyramid: &Pyramid,
    ) -> Self {
        let axis = Vec3::splat(pyramid.axis());
        let mut tile = {
            let (pencil, zero) =
                (mode.pencil_in::<S, 16>(&dirs[0], &[0.0; 16]), S::F32x16::splat(0.0));
            let beams = bundles::<S>(dirs);
            Self {
                bvh,
                mode,
                rays,
                pencils: [pencil; PACKETS],
                bests: [Bests::new(&[0.0; 16]); PACKETS],
                depth: [zero; PACKETS],
                live: [0; PACKETS],
                beams,
                beam: beams.all(),
                used: (1 << dirs.len()) - 1,
                work: 0,
            }
        };
        for (packet, (rays, dir)) in rays.chunks(16).zip(dirs).enumerate() {
            let (mut t_min, mut t_max) = ([0.0; 16], [0.0; 16]);
            for (lane, ray) in rays.iter().enumerate() {
                (t_min[lane], t_max[lane]) = (ray.t_min, ray.t_max);
            }
            tile.pencils[packet] = mode.pencil_in::<S, 16>(dir, &t_min);
            tile.bests[packet] = Bests::new(&t_max);
            tile.depth[packet] = Vec3::load(dir).dot_fused(axis);
            tile.live[packet] = (1 << rays.len()) - 1;
        }
        tile
    }

    /// Tests the triangles of a pack, each with those packets of which some ray may hit it. Whether
    /// any was tested.
    #[inline(always)]
    fn visit(&mut self, pack: usize, any: bool, seen: &mut Vec<u32>, counts: &mut Counts) -> bool {
        let Self { bvh, mode, rays, .. } = *self;
        let views = mode.views_in::<S>(&bvh.packs[pack], rays[0].origin);
        let mut triangles = views.in_beam(&self.beam);
        self.work += 4 + triangles.count_ones() as usize;
        let before = seen.len();
        while triangles != 0 {
            let lane = triangles.trailing_zeros() as usize;
            triangles &= triangles - 1;
            let view = views.lane(lane);
            let mut packets = view.beams(&self.beams) & self.used;
            if packets == 0 {
                continue;
            }
            self.work += packets.count_ones() as usize;
            let (index, number) = (bvh.indices[pack][lane], seen.len() as u32);
            seen.push(8 * pack as u32 + lane as u32);
            while packets != 0 {
                let packet = packets.trailing_zeros() as usize;
                packets &= packets - 1;
                let (live, bests) = (self.live[packet], &mut self.bests[packet]);
                if live == 0 {
                    continue;
                }
                mode.pencil_closest_in::<S, 16>(
                    &self.pencils[packet],
                    &view,
                    (index, number),
                    |lane| rays[16 * packet + lane],
                    |number| bvh.triangle_in(seen[number as usize]),
                    live,
                    bests,
                    counts,
                );
                if any {
                    self.live[packet] &= !bests.hits();
                }
            }
        }
        seen.len() > before
    }

    /// No hit beyond this depth can count.
    #[inline(always)]
    fn far(&self) -> f32 {
        let mut deepest = S::F32x16::splat(f32::NEG_INFINITY);
        for packet in 0..PACKETS {
            let t = self.bests[packet].t_hi() * self.depth[packet];
            let live = <S::F32x16 as Lanes>::Mask::from_bits(self.live[packet]);
            deepest = S::F32x16::select(live, deepest.max(t), deepest);
        }
        let mut lanes = [0.0; 16];
        deepest.store(&mut lanes);
        let deepest = lanes.into_iter().fold(f32::NEG_INFINITY, f32::max);
        deepest + deepest.abs() * (1.0 / (1 << 18) as f32)
    }
}

/// A beam around each packet, in the packet's lane.
#[inline(always)]
fn bundles<S: Simd>(dirs: &[[[f32; 16]; 3]]) -> Beams<S::F32x16> {
    let mut rays = [[[0.0; 16]; 3]; 16];
    for (lane, ray) in rays.iter_mut().enumerate() {
        for packet in 0..PACKETS {
            // Where there are fewer packets the first stands in: it takes no part.
            let dir = dirs.get(packet).unwrap_or(&dirs[0]);
            for (to, from) in ray.iter_mut().zip(dir) {
                to[packet] = from[lane];
            }
        }
    }
    Beams::new(&rays)
}
