//! What the trace of a bundle found, and what is asked of that: whether, which, where.

use intertri::internal::{HitCoefficients, Resolver, SharedOriginHit, exact, prefetch};
use intertri::simd::Simd;
use intertri::{Hit, Ray, TriangleOf, fixed};

use crate::answers::Answers;
use crate::pairs::HitPairs;
use crate::tree::Tree;

/// The number of no triangle.
pub(super) const NOTHING: u32 = u32::MAX;

/// The memory of a hit is prefetched so many hits before it is written: it is hardly ever in the cache, and
/// the stores of more than some tens of hits cannot wait for it.
const AHEAD: usize = 40;

/// Where fewer rays than this hit a triangle, what they share is not worth its while.
const SHARED: u32 = 3;

/// The rays of a packet that hit a triangle.
#[derive(Clone, Copy)]
pub(super) struct PacketHits {
    /// The triangle's number in `seen`.
    pub(super) number: u32,
    pub(super) packet: u16,
    pub(super) lanes: u16,
}

/// What a bundle's rays hit.
#[derive(Default)]
pub(crate) struct Results {
    /// The places of the triangles that rays were tested against.
    pub(super) seen: Vec<u32>,
    /// For each ray the number in `seen` of the triangle that it hits, or [`NOTHING`].
    pub(super) found: Vec<u32>,
    /// Where every hit is asked for: triangles, each with a packet of whose rays these hit it. Then only triangles
    /// that are hit are in `seen`.
    pub(super) every: Vec<PacketHits>,
    /// For each of `seen` its index, or its number in `hit`; and one more, for none.
    slot: Vec<u32>,
    /// The places of those that are hit.
    hit: Vec<u32>,
    coefficients: Vec<[HitCoefficients; 8]>,
    on_grid: Vec<[fixed::HitCoefficients; 8]>,
    /// Rays of originals, each with the number of the triangle that it hits.
    pairs: Vec<(u32, u32)>,
    exact: Vec<[exact::HitCoefficients; 8]>,
}

impl Results {
    /// Whether a ray is one of the last bundle and hits something.
    pub(crate) fn is_hit(&self, ray: usize) -> bool {
        self.found.get(ray).is_some_and(|&found| found != NOTHING)
    }

    /// Forgets the last bundle.
    pub(crate) fn clear(&mut self) {
        self.seen.clear();
        self.found.clear();
        self.every.clear();
    }

    /// Lists every hit of the last bundle, whose first ray has this number, but for the packets that are left.
    #[inline(always)]
    pub(crate) fn list<S: Simd>(
        &mut self,
        bvh: &Tree,
        resolver: Resolver<'_>,
        (rays, first, left): (&[Ray], u32, u64),
        pairs: &mut HitPairs,
    ) {
        let hits: u32 = self.every.iter().map(|hits| hits.lanes.count_ones()).sum();
        let is_shared = hits >= SHARED * self.seen.len() as u32;
        match resolver {
            Resolver::Document(_) if is_shared => {
                let mut eights = std::mem::take(&mut self.coefficients);
                self.list_met::<S, _>(bvh, resolver, (rays, first, left), &mut eights, pairs);
                self.coefficients = eights;
            }
            Resolver::Exact if is_shared => {
                let mut eights = std::mem::take(&mut self.exact);
                self.list_met::<S, _>(bvh, resolver, (rays, first, left), &mut eights, pairs);
                self.exact = eights;
            }
            Resolver::Originals(originals) if is_shared => {
                let (mut known, begin) = (std::mem::take(&mut self.pairs), pairs.pairs.len());
                known.clear();
                self.each_hit(left, pairs, |pairs, ray, number| {
                    pairs.push(first + ray as u32, self.seen[number]);
                    known.push((ray as u32, number as u32));
                });
                pairs.level();
                let (rays, hits) = (first..first + rays.len() as u32, &mut pairs.hits[begin..]);
                originals.shared_origin_hits(rays, &self.seen, &known, hits);
                self.pairs = known;
            }
            // Where these meet, is found later.
            _ => {
                self.each_hit(left, pairs, |pairs, ray, number| {
                    pairs.push(first + ray as u32, self.seen[number]);
                });
            }
        }
    }

    /// The same with where the rays meet the triangles: from what depends on the triangle and the shared origin,
    /// computed once.
    #[inline(always)]
    fn list_met<S: Simd, C: SharedOriginHit>(
        &self,
        bvh: &Tree,
        resolver: Resolver<'_>,
        (rays, first, left): (&[Ray], u32, u64),
        eights: &mut Vec<[C; 8]>,
        pairs: &mut HitPairs,
    ) {
        let places = &self.seen[..];
        let coefficients = coefficients::<S, C>(bvh, places, rays[0].origin, eights);
        pairs.level();
        self.each_hit(left, pairs, |pairs, ray, number| {
            // In its place: copied from where it is put together, it would keep the CPU waiting.
            let numbers = (first + ray as u32, places[number]);
            let hit = pairs.push_hit(numbers.0, numbers.1);
            if !coefficients[number].hit_in::<S>(rays[ray].dir, hit) {
                *hit = met_alone(bvh, resolver, &rays[ray], numbers);
            }
        });
    }

    /// Every hit of the last bundle but for the packets that are left: the ray among its rays, and the number of the
    /// triangle in `seen`. There is room for it.
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

    /// Writes the answers of the last bundle. Of a grid, `on_grid` are the rays as their caller has them.
    #[inline(always)]
    pub(crate) fn write<S: Simd>(
        &mut self,
        bvh: &Tree,
        resolver: Resolver<'_>,
        (rays, on_grid, first): (&[Ray], &[fixed::Ray], u32),
        answers: Answers<'_>,
    ) {
        let hits = match answers {
            Answers::Any(any) => {
                for (any, found) in any.iter_mut().zip(&self.found) {
                    *any = *found != NOTHING;
                }
                return;
            }
            Answers::Pairs(_) | Answers::Crossings(_) | Answers::Places(_) => return,
            Answers::Triangles(triangles) => return self.triangles(bvh, triangles),
            Answers::Hits(hits) => hits,
        };
        self.distinct();
        match resolver {
            Resolver::Document(_) => {
                let mut eights = std::mem::take(&mut self.coefficients);
                self.hits::<S, _>(bvh, resolver, (rays, &[], first), &mut eights, hits);
                self.coefficients = eights;
            }
            Resolver::Grid => {
                let mut eights = std::mem::take(&mut self.on_grid);
                self.hits::<S, _>(bvh, resolver, (rays, on_grid, first), &mut eights, hits);
                self.on_grid = eights;
            }
            Resolver::Exact => {
                let mut eights = std::mem::take(&mut self.exact);
                self.hits::<S, _>(bvh, resolver, (rays, &[], first), &mut eights, hits);
                self.exact = eights;
            }
            Resolver::Originals(originals) => {
                let Self { slot, found, hit, pairs, .. } = self;
                let of =
                    |number: u32| if number == NOTHING { NOTHING } else { slot[number as usize] };
                pairs.clear();
                pairs.extend((0..).zip(found.iter().map(|&number| of(number))));
                originals.shared_origin_hits(first..first + rays.len() as u32, hit, pairs, hits);
            }
        }
    }

    /// The index of the triangle that each ray hits, or none.
    #[inline(always)]
    fn triangles(&mut self, bvh: &Tree, triangles: &mut [u32]) {
        // Without a branch, which would mispredict: the last slot stands for none.
        let Self { seen, slot, found, .. } = self;
        slot.clear();
        slot.extend(seen.iter().map(|&place| bvh.index_of(place)));
        slot.push(Hit::NO_TRIANGLE);
        let (slot, none) = (&slot[..=seen.len()], seen.len());
        for (triangle, &number) in triangles.iter_mut().zip(&found[..]) {
            *triangle = slot[none.min(number as usize)];
        }
    }

    /// Numbers the triangles that rays hit, each once, however many hit it: `hit` becomes their places, and
    /// `slot` of each of `seen` its number among them.
    #[inline(always)]
    fn distinct(&mut self) {
        let Self { seen, slot, hit, found, .. } = self;
        // Those that are hit are marked, then listed, without a branch. The last stands for none.
        let none = seen.len();
        slot.clear();
        slot.resize(none + 1, 0);
        let marks = &mut slot[..=none];
        for &number in &found[..] {
            marks[none.min(number as usize)] = 1;
        }
        hit.clear();
        hit.resize(none + 1, 0);
        let (places, mut count) = (&mut hit[..=none], 0);
        for (&place, slot) in seen.iter().zip(marks) {
            places[count.min(none)] = place;
            (*slot, count) = (count as u32, count + *slot as usize);
        }
        hit.truncate(count);
    }

    /// Where the rays meet what they hit: from what depends on the triangle and the shared origin, computed
    /// once.
    #[inline(always)]
    fn hits<S: Simd, C: SharedOriginHit>(
        &self,
        bvh: &Tree,
        resolver: Resolver<'_>,
        (rays, on_grid, first): (&[Ray], &[fixed::Ray], u32),
        eights: &mut Vec<[C; 8]>,
        hits: &mut [Hit],
    ) {
        let Self { found, slot, hit, .. } = self;
        let coefficients = coefficients::<S, C>(bvh, hit, rays[0].origin, eights);
        let slot = &slot[..];
        for (i, (ray, &number)) in rays.iter().zip(&found[..]).enumerate() {
            if let Some(later) = hits.get(i + AHEAD) {
                prefetch(std::slice::from_ref(later));
            }
            if number == NOTHING {
                hits[i] = Hit::MISS;
                continue;
            }
            let slot = slot[number as usize] as usize;
            if !coefficients[slot].hit_in::<S>(ray.dir, &mut hits[i]) {
                hits[i] = met_alone(bvh, resolver, ray, (first + i as u32, hit[slot]));
            }
            if let Some(ray) = on_grid.get(i) {
                hits[i].t = ray.t_of_caller(hits[i].t);
            }
        }
    }
}

/// What the triangles in these places share in telling where rays from one origin meet them.
#[inline(always)]
fn coefficients<'a, S: Simd, C: SharedOriginHit>(
    bvh: &Tree,
    places: &[u32],
    origin: [f32; 3],
    eights: &'a mut Vec<[C; 8]>,
) -> &'a [C] {
    if 8 * eights.len() < places.len() {
        eights.resize_with(places.len().div_ceil(8), Default::default);
    }
    for (places, to) in places.chunks(8).zip(&mut *eights) {
        let (corners, indices) = eight(bvh, places);
        C::eight_in::<S>(&corners, &indices, origin, to);
    }
    eights.as_flattened()
}

/// Where a ray meets the triangle in a place. The numbers are the ray's and the place.
fn met_alone(bvh: &Tree, resolver: Resolver<'_>, ray: &Ray, numbers: (u32, u32)) -> Hit {
    let (triangle, index) = (bvh.triangle_in(numbers.1), bvh.index_of(numbers.1));
    resolver.hit_attributes(ray, &triangle, index, numbers)
}

/// The corners of eight triangles side by side, and their indices.
#[inline(always)]
fn eight(bvh: &Tree, places: &[u32]) -> ([[[f32; 8]; 3]; 3], [u32; 8]) {
    let (mut corners, mut indices) = ([[[0.0; 8]; 3]; 3], [0; 8]);
    for (lane, &place) in places.iter().enumerate() {
        let TriangleOf(from) = bvh.triangle_in(place);
        for (to, from) in corners.iter_mut().zip(&from) {
            (to[0][lane], to[1][lane], to[2][lane]) = (from[0], from[1], from[2]);
        }
        indices[lane] = bvh.index_of(place);
    }
    (corners, indices)
}
