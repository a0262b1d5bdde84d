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

use intertri::lanes::{Lanes, Mask, Simd};
use intertri::{
    Certified, Counts, Frame, Hit, Nearest, Points, Ranges, Ray, Sights, Triangle, Vec3, Windows,
};

use crate::bvh::Bvh;
use crate::node::LEAF;
use crate::pyramid::{self, Pyramid};
use crate::search::mirror;

/// Nodes and leaves that are still to be visited, the nearest on top, each with its depth.
type Stack = Vec<(u32, f32)>;

/// Rays of a tile, at most.
pub(crate) const RAYS: usize = 256;

/// Sixteen rays each.
const PACKETS: usize = RAYS / 16;

/// So much work a ray, in tests of a packet, and a tile is given up: its rays have too little in
/// common.
const PATIENCE: usize = 16;

/// The number of no triangle.
pub(crate) const NOTHING: u32 = u32::MAX;

/// What a search of tiles needs and need not make anew each time.
#[derive(Default)]
pub(crate) struct Scratch {
    stack: Stack,
    /// The places of the triangles that rays of the tile were tested against.
    seen: Vec<u32>,
    /// For each ray the number in `seen` of the triangle that it hits, or [`NOTHING`].
    found: Vec<u32>,
    /// For each of `seen` its number among those that are hit, or [`NOTHING`].
    slot: Vec<u32>,
    /// The places of those that are hit.
    hit: Vec<u32>,
    sights: Vec<Sights>,
}

impl Scratch {
    /// Whether each ray of the last tile hits something.
    pub(crate) fn any(&self, hits: &mut [bool]) {
        for (hit, found) in hits.iter_mut().zip(&self.found) {
            *hit = *found != NOTHING;
        }
    }

    /// The index of the triangle that each ray of the last tile hits, or [`NOTHING`].
    #[inline(always)]
    pub(crate) fn triangles(&self, bvh: &Bvh, triangles: &mut [u32]) {
        for (triangle, &number) in triangles.iter_mut().zip(&self.found) {
            *triangle = match number {
                NOTHING => NOTHING,
                number => bvh.index_of(self.seen[number as usize]),
            };
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
        slot.resize(seen.len(), NOTHING);
        for &number in found.iter().filter(|&&number| number != NOTHING) {
            let slot = &mut slot[number as usize];
            if *slot == NOTHING {
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
            *to = if number == NOTHING {
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

/// The rays of a tile side by side, as points of a screen.
struct Screen<S: Simd> {
    frame: Frame,
    points: [Points<S::F32x16>; PACKETS],
    /// The smallest and largest x and y of each packet, by packet.
    lo: [[f32; PACKETS]; 2],
    hi: [[f32; PACKETS]; 2],
    /// How many packets there are.
    used: usize,
    /// No z is smaller.
    slowest: f32,
}

impl<S: Simd> Screen<S> {
    /// `None` where the rays go too far apart, or numbers are too large or too small.
    #[inline(always)]
    fn new(rays: &[Ray], reach: f32) -> Option<Self> {
        // The directions side by side. The last packet is filled with the last ray.
        let used = rays.len().div_ceil(16);
        let mut dirs = [[[0.0; 16]; 3]; PACKETS];
        for (packet, dir) in dirs[..used].iter_mut().enumerate() {
            for lane in 0..16 {
                let ray = &rays[(16 * packet + lane).min(rays.len() - 1)];
                (dir[0][lane], dir[1][lane], dir[2][lane]) = (ray.dir[0], ray.dir[1], ray.dir[2]);
            }
        }

        // A frame that looks where they go.
        let mut sum = Vec3::<S::F32x16>::splat([0.0; 3]);
        for dir in &dirs[..used] {
            sum = sum + Vec3::load(dir);
        }
        let mut sums = [[0.0; 16]; 3];
        sum.store(&mut sums);
        let frame = pyramid::frame(rays, sums.map(|lanes| lanes.iter().sum()), reach)?;

        let first = frame.points(Vec3::load(&dirs[0]));
        let mut screen = Self {
            frame,
            points: [first; PACKETS],
            lo: [[0.0; PACKETS]; 2],
            hi: [[0.0; PACKETS]; 2],
            used,
            slowest: 0.0,
        };
        let (mut sane, mut slowest) = (first.on_screen(), first.z);
        for (packet, dir) in dirs[..used].iter().enumerate() {
            let points = frame.points(Vec3::<S::F32x16>::load(dir));
            screen.points[packet] = points;
            sane = sane & points.on_screen();
            slowest = slowest.min(points.z);
            (screen.lo[0][packet], screen.hi[0][packet]) = extremes(points.x);
            (screen.lo[1][packet], screen.hi[1][packet]) = extremes(points.y);
        }
        screen.slowest = extremes(slowest).0 * (1.0 - 1e-6);
        (sane.bits() == 0xffff).then_some(screen)
    }

    /// A window a packet; where there are fewer packets, windows that nothing reaches.
    #[inline(always)]
    fn windows(&self) -> Windows<S::F32x16> {
        let (mut lo, mut hi) = (self.lo, self.hi);
        for k in 0..2 {
            lo[k][self.used..].fill(f32::INFINITY);
            hi[k][self.used..].fill(f32::NEG_INFINITY);
        }
        let load = |side: &[f32; 16]| Lanes::load(side);
        Windows::new([load(&lo[0]), load(&lo[1])], [load(&hi[0]), load(&hi[1])])
    }

    /// The smallest and largest x and y of all.
    #[inline(always)]
    fn window(&self) -> ([f32; 2], [f32; 2]) {
        let least =
            |side: &[f32; PACKETS]| side[..self.used].iter().copied().fold(side[0], f32::min);
        let most =
            |side: &[f32; PACKETS]| side[..self.used].iter().copied().fold(side[0], f32::max);
        ([least(&self.lo[0]), least(&self.lo[1])], [most(&self.hi[0]), most(&self.hi[1])])
    }
}

/// The smallest and largest lane.
#[inline(always)]
fn extremes<F: Lanes<Scalar = f32>>(lanes: F) -> (f32, f32) {
    let mut lo = [0.0; 16];
    lanes.store(&mut lo);
    let mut hi = lo;
    for half in [8, 4, 2, 1] {
        for i in 0..half {
            lo[i] = if lo[i + half] < lo[i] { lo[i + half] } else { lo[i] };
            hi[i] = if hi[i + half] > hi[i] { hi[i + half] } else { hi[i] };
        }
    }
    (lo[0], hi[0])
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
    let Some(screen) = Screen::<S>::new(rays, bvh.reach) else { return false };
    let window = screen.window();
    let pyramid = Pyramid::new(&screen.frame, rays[0].origin, window, bvh.reach);

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
        found.resize(rays.len(), NOTHING);
        return true;
    }

    // Then its leaves, front to back, and the triangles without a box.
    let mut tile = Tile::new(bvh, mode, rays, &screen, window);
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

    for nearest in &tile.nearest[..screen.used] {
        found.extend_from_slice(&nearest.triangles());
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
    screen: &'a Screen<S>,
    /// A window a packet, and the one of all.
    windows: Windows<S::F32x16>,
    window: Windows<S::F32x8>,
    ranges: [Ranges<S::F32x16>; PACKETS],
    nearest: [Nearest<S::F32x16, 16>; PACKETS],
    /// Bit i of `live[p]`: ray `16 p + i` still looks for a hit.
    live: [u32; PACKETS],
    /// Tests of packets, and what costs about as much.
    work: usize,
}

impl<'a, S: Simd> Tile<'a, S> {
    #[inline(always)]
    fn new(
        bvh: &'a Bvh,
        mode: &'a Certified,
        rays: &'a [Ray],
        screen: &'a Screen<S>,
        (lo, hi): ([f32; 2], [f32; 2]),
    ) -> Self {
        let splat = S::F32x8::splat;
        let mut tile = Self {
            bvh,
            mode,
            rays,
            screen,
            windows: screen.windows(),
            window: Windows::new([splat(lo[0]), splat(lo[1])], [splat(hi[0]), splat(hi[1])]),
            ranges: [mode.ranges_in(&screen.points[0], &[0.0; 16]); PACKETS],
            nearest: [Nearest::new(&screen.points[0], &[0.0; 16]); PACKETS],
            live: [0; PACKETS],
            work: 0,
        };
        for (packet, rays) in rays.chunks(16).enumerate() {
            let (mut t_min, mut t_max, mut live) = ([0.0; 16], [0.0; 16], 0);
            for (lane, ray) in rays.iter().enumerate() {
                (t_min[lane], t_max[lane]) = (ray.t_min, ray.t_max);
                live |= u32::from(ray.t_min < ray.t_max && ray.t_max > 0.0) << lane;
            }
            let points = &screen.points[packet];
            tile.ranges[packet] = mode.ranges_in(points, &t_min);
            tile.nearest[packet] = Nearest::new(points, &t_max);
            tile.live[packet] = live;
        }
        tile
    }

    /// Tests the triangles of a pack, each with those packets whose window it reaches. Whether any
    /// was tested.
    #[inline(always)]
    fn visit(&mut self, pack: usize, any: bool, seen: &mut Vec<u32>, counts: &mut Counts) -> bool {
        let Self { bvh, mode, rays, screen, .. } = *self;
        let outlines = mode.outlines_in::<S>(&bvh.packs[pack], &screen.frame, screen.slowest);
        let (mut triangles, plain) = outlines.within(&self.window);
        self.work += 8 + triangles.count_ones() as usize;
        counts.tests += u64::from(triangles.count_ones()) * rays.len() as u64;
        let before = seen.len();
        while triangles != 0 {
            let lane = triangles.trailing_zeros() as usize;
            triangles &= triangles - 1;
            let outline = outlines.lane(lane);
            let mut packets = outline.within(&self.windows);
            if packets == 0 {
                continue;
            }
            self.work += packets.count_ones() as usize;
            let number = seen.len() as u32;
            seen.push(8 * pack as u32 + lane as u32);
            while packets != 0 {
                let packet = packets.trailing_zeros() as usize;
                packets &= packets - 1;
                let (live, nearest) = (self.live[packet], &mut self.nearest[packet]);
                if live == 0 {
                    continue;
                }
                mode.outline_closest_in(
                    (&screen.points[packet], &self.ranges[packet]),
                    (&outline, plain >> lane & 1 != 0),
                    number,
                    |lane| rays[16 * packet + lane],
                    |number| bvh.triangle_in(seen[number as usize]),
                    |number| bvh.index_of(seen[number as usize]),
                    live,
                    nearest,
                    counts,
                );
                if any {
                    self.live[packet] &= !nearest.hits();
                }
            }
        }
        seen.len() > before
    }

    /// No hit beyond this depth can count.
    #[inline(always)]
    fn far(&self) -> f32 {
        let mut least = S::F32x16::splat(f32::INFINITY);
        for (nearest, live) in self.nearest.iter().zip(self.live) {
            let live = <S::F32x16 as Lanes>::Mask::from_bits(live);
            least = S::F32x16::select(live, least.min(nearest.least()), least);
        }
        let depth = 1.0 / extremes(least).0;
        depth + depth * (1.0 / (1 << 18) as f32)
    }
}
