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

/// The rays of a packet that hit a triangle.
#[derive(Clone, Copy)]
pub(super) struct PacketHits {
    pub(super) place: u32,
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
    /// Where every hit is asked for: the places of triangles, each with a packet of whose rays these hit it.
    pub(super) every: Vec<PacketHits>,
    /// For each of `seen` its index, or its number in `hit`; and one more, for none.
    slot: Vec<u32>,
    /// The places of those that are hit.
    hit: Vec<u32>,
    coefficients: Vec<[HitCoefficients; 8]>,
    on_grid: Vec<[fixed::HitCoefficients; 8]>,
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
    pub(crate) fn list(&self, pairs: &mut HitPairs, first: usize, left: u64) {
        for PacketHits { place, packet, lanes } in &self.every {
            if left >> packet & 1 != 0 || !pairs.reserve(16) {
                continue;
            }
            let (first, mut lanes) = (first as u32 + 16 * u32::from(*packet), *lanes);
            while lanes != 0 {
                pairs.push(first + lanes.trailing_zeros(), *place);
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
                self.slots();
                originals.shared_origin_hits(first, &self.hit, &self.found, hits);
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

    /// Makes of what each ray hits its number among those that are hit.
    fn slots(&mut self) {
        let Self { slot, found, .. } = self;
        for number in found.iter_mut().filter(|number| **number != NOTHING) {
            *number = slot[*number as usize];
        }
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
        grow(eights, hit.len());
        for (places, to) in hit.chunks(8).zip(&mut *eights) {
            let (corners, indices) = eight(bvh, places);
            C::eight_in::<S>(&corners, &indices, rays[0].origin, to);
        }
        let (coefficients, slot) = (eights.as_flattened(), &slot[..]);
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
                let place = hit[slot];
                let (triangle, index) = (bvh.triangle_in(place), bvh.index_of(place));
                let numbers = (first + i as u32, place);
                hits[i] = resolver.hit_attributes(ray, &triangle, index, numbers);
            }
            if let Some(ray) = on_grid.get(i) {
                hits[i].t = ray.t_of_caller(hits[i].t);
            }
        }
    }
}

/// Makes room for what is computed of so many triangles, eight at a time.
fn grow<T: Clone + Default>(eights: &mut Vec<[T; 8]>, triangles: usize) {
    if 8 * eights.len() < triangles {
        eights.resize_with(triangles.div_ceil(8), Default::default);
    }
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
