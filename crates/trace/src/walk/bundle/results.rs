//! Converts the results of tracing a bundle to the requested form: whether rays hit anything, which
//! triangles they hit, or complete hits.

use intertri::internal::{HitCoefficients, Resolver, SharedHit, exact, prefetch};
use intertri::simd::Simd;
use intertri::{Hit, Hit32, LeafSlot, Ray, RayId, TriangleId, TriangleOf};

use crate::tree::{MeshTriangle, Tree};
use crate::walk::stream::Retired;
use crate::walk::{BatchOutput, HitFormat, HitPairs};

/// The value that marks a ray without a hit.
pub(super) const NOTHING: u32 = u32::MAX;

/// The prefetch distance, in hits. The memory for a hit is rarely in the cache, and the CPU can
/// buffer the stores of a few dozen hits at most.
const AHEAD: usize = 40;

/// If, on average, fewer rays than this hit a triangle, precomputing the values that they share is
/// not worthwhile for lists of hits.
const SHARED: u32 = 3;

/// The rays of a packet that hit a triangle.
#[derive(Clone, Copy)]
pub(super) struct PacketHits {
    /// The index of the triangle in `seen`.
    pub(super) number: u32,
    pub(super) packet: u16,
    pub(super) lanes: u16,
}

/// What the rays of a bundle share, and t, u, and v can be computed from.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) enum Shared {
    #[default]
    Nothing,
    Origin,
    Direction,
}

/// The hits of a bundle's rays.
#[derive(Default)]
pub(crate) struct Results {
    /// The slots of the triangles that rays were tested against.
    pub(super) seen: Vec<LeafSlot>,
    /// For each ray, the index in `seen` of the triangle that it hits, or [`NOTHING`].
    pub(super) found: Vec<u32>,
    /// Triangles, each with a packet and a mask of the packet's rays that hit it. Used only for
    /// all-hits queries; `seen` then contains only triangles that are hit.
    pub(super) every: Vec<PacketHits>,
    /// What the rays share.
    pub(super) shared: Shared,
    /// For each entry of `seen`, its triangle's index or its position in `hit`, plus one entry for
    /// rays without a hit.
    number: Vec<u32>,
    /// The slots of the triangles that are hit.
    hit: Vec<LeafSlot>,
    coefficients: Vec<[HitCoefficients; 8]>,
    /// Rays, each with the position of the triangle that it hits. Used only for f64 hierarchies.
    pairs: Vec<(u32, u32)>,
    exact: Vec<[exact::HitCoefficients; 8]>,
    exact32: Vec<[exact::HitCoefficients32; 8]>,
    parallel: Vec<[exact::DirectionCoefficients; 8]>,
    parallel32: Vec<[exact::DirectionCoefficients32; 8]>,
    /// The hits on the original f64 triangles, before rounding to f32.
    hits64: Vec<Hit>,
}

impl Results {
    /// Returns whether a ray of the last bundle hits something.
    pub(crate) fn is_hit(&self, ray: usize) -> bool {
        self.found.get(ray).is_some_and(|&found| found != NOTHING)
    }

    /// Clears the results of the last bundle.
    pub(crate) fn clear(&mut self) {
        self.seen.clear();
        self.found.clear();
        self.every.clear();
    }

    /// Lists all hits of the last bundle, except those of packets that were left untraced. `first`
    /// is the ID of the first ray.
    #[inline(always)]
    pub(crate) fn list<S: Simd>(
        &mut self,
        tree: &Tree,
        resolver: Resolver<'_>,
        (rays, first, left): (&[Ray], RayId, u64),
        pairs: &mut HitPairs,
    ) {
        let hits: u32 = self.every.iter().map(|hits| hits.lanes.count_ones()).sum();
        let pays = hits >= SHARED * self.seen.len() as u32;
        let is_shared = self.shared == Shared::Origin && pays;
        match resolver {
            Resolver::Document(_) if is_shared => {
                let mut eights = std::mem::take(&mut self.coefficients);
                self.list_met::<S, _>(tree, resolver, (rays, first, left), &mut eights, pairs);
                self.coefficients = eights;
            }
            Resolver::Exact(_) if is_shared => {
                let mut eights = std::mem::take(&mut self.exact);
                self.list_met::<S, _>(tree, resolver, (rays, first, left), &mut eights, pairs);
                self.exact = eights;
            }
            Resolver::Exact(_) if self.shared == Shared::Direction && pays => {
                let mut eights = std::mem::take(&mut self.parallel);
                self.list_met::<S, _>(tree, resolver, (rays, first, left), &mut eights, pairs);
                self.parallel = eights;
            }
            Resolver::Originals(originals) if is_shared => {
                let (mut known, begin) = (std::mem::take(&mut self.pairs), pairs.pairs.len());
                known.clear();
                self.each_hit(left, pairs, |pairs, ray, number| {
                    pairs.push(RayId(first.0 + ray as u32), self.seen[number]);
                    known.push((ray as u32, number as u32));
                });
                pairs.level();
                let rays = first.0..first.0 + rays.len() as u32;
                let hits = &mut pairs.hits[begin..];
                originals.shared_origin_hits(rays, &self.seen, &known, hits);
                self.pairs = known;
            }
            // The t, u, and v of these hits are computed later.
            _ => {
                self.each_hit(left, pairs, |pairs, ray, number| {
                    pairs.push(RayId(first.0 + ray as u32), self.seen[number]);
                });
            }
        }
    }

    /// Lists all hits with t, u, and v. Values that depend only on a triangle and the shared origin
    /// or direction are computed only once.
    #[inline(always)]
    fn list_met<S: Simd, C: SharedHit>(
        &self,
        tree: &Tree,
        resolver: Resolver<'_>,
        (rays, first, left): (&[Ray], RayId, u64),
        eights: &mut Vec<[C; 8]>,
        pairs: &mut HitPairs,
    ) {
        let slots = &self.seen[..];
        let coefficients = coefficients::<S, C, Hit>(tree, slots, &rays[0], eights);
        pairs.level();
        self.each_hit(left, pairs, |pairs, ray, number| {
            // Build the hit in place, because copying it right after writing it would stall the
            // CPU.
            let ids = (RayId(first.0 + ray as u32), slots[number]);
            let hit = pairs.push_hit(ids.0, ids.1);
            if !coefficients[number].hit_in::<S>(&rays[ray], hit) {
                *hit = Hit::met_alone(tree, resolver, &rays[ray], ids);
            }
        });
    }

    /// Calls a function for each hit of the last bundle, except those of packets that were left
    /// untraced. Passes the ray's position in the bundle and the triangle's position in `seen`,
    /// after reserving memory for the pair.
    #[inline(always)]
    fn each_hit(
        &self,
        left: u64,
        pairs: &mut HitPairs,
        mut each: impl FnMut(&mut HitPairs, usize, usize),
    ) {
        for &PacketHits { number, packet, mut lanes } in &self.every {
            if left >> packet & 1 != 0 || !pairs.reserve(16) {
                continue;
            }
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                each(pairs, 16 * usize::from(packet) + lane, number as usize);
                lanes &= lanes - 1;
            }
        }
    }

    /// Writes the results of the last bundle.
    #[inline(always)]
    pub(crate) fn write<S: Simd>(
        &mut self,
        tree: &Tree,
        resolver: Resolver<'_>,
        (rays, first): (&[Ray], RayId),
        output: BatchOutput<'_>,
    ) {
        match output {
            BatchOutput::Any(any) => {
                for (any, found) in any.iter_mut().zip(&self.found) {
                    *any = *found != NOTHING;
                }
            }
            BatchOutput::Pairs(_) | BatchOutput::Crossings(_) | BatchOutput::Containments(_) => (),
            BatchOutput::Triangles(triangles) => self.triangles(tree, triangles),
            output if self.shared != Shared::Origin => {
                let is_exact = matches!(resolver, Resolver::Exact(_));
                if self.shared == Shared::Direction && is_exact {
                    self.write_parallel::<S>(tree, resolver, (rays, first), output);
                } else {
                    self.write_alone::<S>(tree, resolver, (rays, first), output);
                }
            }
            BatchOutput::Hits(hits) => {
                self.distinct();
                self.write_hits::<S>(tree, resolver, (rays, first), hits);
            }
            BatchOutput::Hits32(hits) => {
                self.distinct();
                self.write_hits32::<S>(tree, resolver, (rays, first), hits);
            }
        }
    }

    /// Writes the hits of rays that share a direction in an f32 hierarchy, including t, u, and v.
    #[inline(always)]
    fn write_parallel<S: Simd>(
        &mut self,
        tree: &Tree,
        resolver: Resolver<'_>,
        rays: (&[Ray], RayId),
        output: BatchOutput<'_>,
    ) {
        self.distinct();
        match output {
            BatchOutput::Hits(hits) => {
                let mut eights = std::mem::take(&mut self.parallel);
                self.hits::<S, _, _>(tree, resolver, rays, &mut eights, hits);
                self.parallel = eights;
            }
            BatchOutput::Hits32(hits) => {
                let mut eights = std::mem::take(&mut self.parallel32);
                self.hits::<S, _, _>(tree, resolver, rays, &mut eights, hits);
                self.parallel32 = eights;
            }
            _ => (),
        }
    }

    /// Writes the hits of rays that share neither, or of parallel rays in an f64 hierarchy, including
    /// t, u, and v.
    #[inline(always)]
    fn write_alone<S: Simd>(
        &self,
        tree: &Tree,
        resolver: Resolver<'_>,
        (rays, first): (&[Ray], RayId),
        mut output: BatchOutput<'_>,
    ) {
        let mut retired = Retired::new(resolver, first);
        for (i, (ray, &seen)) in rays.iter().zip(&self.found).enumerate() {
            let slot = |seen: u32| self.seen[seen as usize];
            let hit = (seen != NOTHING).then(|| (tree.index_of(slot(seen)), slot(seen)));
            let id = RayId(first.0 + i as u32);
            retired.retire::<S>(tree, ray, id, hit, &mut output);
        }
        retired.flush::<S>(&mut output);
    }

    /// Writes the hits, including t, u, and v.
    #[inline(always)]
    fn write_hits<S: Simd>(
        &mut self,
        tree: &Tree,
        resolver: Resolver<'_>,
        (rays, first): (&[Ray], RayId),
        hits: &mut [Hit],
    ) {
        match resolver {
            Resolver::Document(_) => {
                let mut eights = std::mem::take(&mut self.coefficients);
                self.hits::<S, _, _>(tree, resolver, (rays, first), &mut eights, hits);
                self.coefficients = eights;
            }
            Resolver::Exact(_) => {
                let mut eights = std::mem::take(&mut self.exact);
                self.hits::<S, _, _>(tree, resolver, (rays, first), &mut eights, hits);
                self.exact = eights;
            }
            Resolver::Originals(originals) => {
                let Self { number, found, hit, pairs, .. } = self;
                let of = |seen: u32| if seen == NOTHING { NOTHING } else { number[seen as usize] };
                pairs.clear();
                pairs.extend((0..).zip(found.iter().map(|&seen| of(seen))));
                let rays = first.0..first.0 + rays.len() as u32;
                originals.shared_origin_hits(rays, hit, pairs, hits);
            }
        }
    }

    /// Like [`Results::write_hits`], but in f32.
    #[inline(always)]
    fn write_hits32<S: Simd>(
        &mut self,
        tree: &Tree,
        resolver: Resolver<'_>,
        (rays, first): (&[Ray], RayId),
        hits: &mut [Hit32],
    ) {
        match resolver {
            Resolver::Document(_) => {
                let mut eights = std::mem::take(&mut self.coefficients);
                self.hits::<S, _, _>(tree, resolver, (rays, first), &mut eights, hits);
                self.coefficients = eights;
            }
            Resolver::Exact(_) => {
                let mut eights = std::mem::take(&mut self.exact32);
                self.hits::<S, _, _>(tree, resolver, (rays, first), &mut eights, hits);
                self.exact32 = eights;
            }
            Resolver::Originals(originals) => {
                let mut hits64 = std::mem::take(&mut self.hits64);
                hits64.resize(rays.len(), Hit::MISS);
                self.write_hits::<S>(tree, resolver, (rays, first), &mut hits64);
                let slots = (0..).map(RayId).zip(&self.pairs);
                for ((to, hit), (id, &(_, number))) in hits.iter_mut().zip(&hits64).zip(slots) {
                    *to = match self.hit.get(number as usize) {
                        Some(&slot) => originals.hit32(hit, RayId(first.0 + id.0), slot),
                        None => Hit32::MISS,
                    };
                }
                self.hits64 = hits64;
            }
        }
    }

    /// Writes the triangle that each ray hits, if any. A triangle is given by its position among
    /// the triangles of all meshes.
    #[inline(always)]
    fn triangles(&mut self, tree: &Tree, triangles: &mut [MeshTriangle]) {
        // Avoid a branch, which would be mispredicted: the last entry stands for no triangle.
        let Self { seen, number, found, .. } = self;
        number.clear();
        number.extend(seen.iter().map(|&slot| tree.index_of(slot).0));
        number.push(Hit::NO_TRIANGLE);
        let (number, none) = (&number[..=seen.len()], seen.len());
        for (triangle, &seen) in triangles.iter_mut().zip(&found[..]) {
            *triangle = MeshTriangle { triangle: number[none.min(seen as usize)], geometry: 0 };
        }
    }

    /// Collects the distinct triangles that rays hit. Sets `hit` to their slots, and `number` to
    /// the position in `hit` for each entry of `seen`.
    #[inline(always)]
    fn distinct(&mut self) {
        let Self { seen, number, hit, found, .. } = self;
        // Mark the triangles that are hit, then list them without a branch. The last entry stands
        // for no triangle.
        let none = seen.len();
        number.clear();
        number.resize(none + 1, 0);
        let marks = &mut number[..=none];
        for &seen in &found[..] {
            marks[none.min(seen as usize)] = 1;
        }
        hit.clear();
        hit.resize(none + 1, LeafSlot(0));
        let (slots, mut count) = (&mut hit[..=none], 0);
        for (&slot, number) in seen.iter().zip(marks) {
            slots[count.min(none)] = slot;
            (*number, count) = (count as u32, count + *number as usize);
        }
        hit.truncate(count);
    }

    /// Computes the hits. Values that depend only on a triangle and the shared origin or direction
    /// are computed only once.
    #[inline(always)]
    fn hits<S: Simd, C: SharedHit<H>, H: HitFormat>(
        &self,
        tree: &Tree,
        resolver: Resolver<'_>,
        (rays, first): (&[Ray], RayId),
        eights: &mut Vec<[C; 8]>,
        hits: &mut [H],
    ) {
        let Self { found, number, hit, .. } = self;
        let coefficients = coefficients::<S, C, H>(tree, hit, &rays[0], eights);
        let number = &number[..];
        let mut unsure = Retired::new(resolver, first);
        for (i, (ray, &seen)) in rays.iter().zip(&found[..]).enumerate() {
            if let Some(later) = hits.get(i + AHEAD) {
                prefetch(std::slice::from_ref(later));
            }
            if seen == NOTHING {
                hits[i] = H::MISS;
                continue;
            }
            let number = number[seen as usize] as usize;
            if !coefficients[number].hit_in::<S>(ray, &mut hits[i]) {
                let (id, slot) = (RayId(first.0 + i as u32), hit[number]);
                if unsure.add(tree, ray, id, (tree.index_of(slot), slot)) {
                    unsure.write::<S, H>(hits);
                }
            }
        }
        unsure.write::<S, H>(hits);
    }
}

/// Computes the values that all hits on the triangles in these slots share, for rays from one
/// origin or in one direction, of which `ray` is one. This function is never inlined, so that it is
/// compiled once for each level and form of hits.
#[inline(never)]
fn coefficients<'a, S: Simd, C: SharedHit<H>, H>(
    tree: &Tree,
    slots: &[LeafSlot],
    ray: &Ray,
    eights: &'a mut Vec<[C; 8]>,
) -> &'a [C] {
    if 8 * eights.len() < slots.len() {
        eights.resize_with(slots.len().div_ceil(8), Default::default);
    }
    S::vectorize(
        #[inline(always)]
        || {
            for (slots, to) in slots.chunks(8).zip(&mut *eights) {
                let (corners, indices) = eight(tree, slots);
                C::eight_in::<S>(&corners, &indices, ray, to);
            }
        },
    );
    eights.as_flattened()
}

/// Returns the corners of up to eight triangles in lanes, and their indices.
#[inline(always)]
fn eight(tree: &Tree, slots: &[LeafSlot]) -> ([[[f32; 8]; 3]; 3], [u32; 8]) {
    let (mut corners, mut indices) = ([[[0.0; 8]; 3]; 3], [0; 8]);
    for (lane, &slot) in slots.iter().enumerate() {
        let TriangleOf(from) = tree.triangle_in(slot);
        for (to, from) in corners.iter_mut().zip(&from) {
            (to[0][lane], to[1][lane], to[2][lane]) = (from[0], from[1], from[2]);
        }
        TriangleId(indices[lane]) = tree.index_of(slot);
    }
    (corners, indices)
}
