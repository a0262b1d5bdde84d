//! What the search of a tile found, and what is asked of that: whether, which, where.

use intertri::fixed;
use intertri::lanes::{Simd, prefetch};
use intertri::{Hit, Ray, Sight, Triangle};

use crate::bvh::Bvh;
use crate::leaves::Leaves;

/// Nodes and leaves that are still to be visited, the nearest on top, each with its depth.
pub(crate) type Stack = Vec<(u32, f32)>;

/// The number of no triangle.
pub(crate) const NOTHING: u32 = u32::MAX;

/// The memory of a hit is asked for so many hits before it is written: it is hardly ever in the cache, and the
/// stores of more than some tens of hits cannot wait for it.
const AHEAD: usize = 40;

/// What a search of tiles needs and need not make anew each time.
#[derive(Default)]
pub(crate) struct Scratch {
    pub(crate) stack: Stack,
    pub(crate) leaves: Leaves,
    /// The places of the triangles that rays of the tile were tested against.
    pub(crate) seen: Vec<u32>,
    /// For each ray the number in `seen` of the triangle that it hits, or [`NOTHING`].
    pub(crate) found: Vec<u32>,
    /// For each of `seen` its index, or its number in `hit`; and one more, for none.
    slot: Vec<u32>,
    /// The places of those that are hit.
    hit: Vec<u32>,
    sights: Vec<[Sight; 8]>,
    on_grid: Vec<[fixed::Sight; 8]>,
    /// What was left of the stack when a tile was split, and a part of it.
    pub(crate) split: [Stack; 2],
}

impl Scratch {
    /// Whether a ray is one of the last tile and hits something.
    pub(crate) fn is_hit(&self, ray: usize) -> bool {
        self.found.get(ray).is_some_and(|&found| found != NOTHING)
    }

    /// Whether each ray of the last tile hits something.
    #[inline(always)]
    pub(crate) fn any(&self, hits: &mut [bool]) {
        for (hit, found) in hits.iter_mut().zip(&self.found) {
            *hit = *found != NOTHING;
        }
    }

    /// The index of the triangle that each ray of the last tile hits, or [`NOTHING`].
    #[inline(always)]
    pub(crate) fn triangles(&mut self, bvh: &Bvh, triangles: &mut [u32]) {
        // Without a branch, which the CPU would have to guess: the last slot stands for none.
        let Self { seen, slot, found, .. } = self;
        slot.clear();
        slot.extend(seen.iter().map(|&place| bvh.index_of(place)));
        slot.push(NOTHING);
        let (slot, none) = (&slot[..=seen.len()], seen.len());
        for (triangle, &number) in triangles.iter_mut().zip(&found[..]) {
            *triangle = slot[none.min(number as usize)];
        }
    }

    /// Numbers the triangles that rays of the last tile hit, each once, however many hit it: `hit` becomes
    /// their places, and `slot` of each of `seen` its number among them.
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

    /// Where the rays of the last tile meet what they hit.
    #[inline(always)]
    pub(crate) fn hits<S: Simd>(&mut self, bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
        self.distinct();
        let Self { found, slot, hit, sights, .. } = self;
        grow(sights, hit.len());
        for (places, to) in hit.chunks(8).zip(&mut *sights) {
            let (corners, indices) = eight(bvh, places);
            Sight::eight_in::<S>(&corners, &indices, rays[0].origin, to);
        }
        let (sights, slot) = (sights.as_flattened(), &slot[..]);
        for (i, (ray, &number)) in rays.iter().zip(&found[..]).enumerate() {
            ask_ahead(hits, i);
            match number {
                NOTHING => hits[i] = Hit::MISS,
                number => sights[slot[number as usize] as usize].hit_in::<S>(ray.dir, &mut hits[i]),
            }
        }
    }

    /// The same on a grid.
    #[inline(always)]
    pub(crate) fn hits_on_grid<S: Simd>(
        &mut self,
        bvh: &Bvh,
        rays: &[fixed::Ray],
        hits: &mut [Hit],
    ) {
        self.distinct();
        let Self { found, slot, hit, on_grid: sights, .. } = self;
        grow(sights, hit.len());
        for (places, to) in hit.chunks(8).zip(&mut *sights) {
            let (corners, indices) = eight(bvh, places);
            fixed::Sight::eight_in::<S>(&corners, &indices, rays[0].origin(), to);
        }
        let sights = sights.as_flattened();
        for (i, (ray, &number)) in rays.iter().zip(&*found).enumerate() {
            ask_ahead(hits, i);
            if number == NOTHING {
                hits[i] = Hit::MISS;
                continue;
            }
            let slot = slot[number as usize] as usize;
            if !sights[slot].hit_in::<S>(ray, &mut hits[i]) {
                let triangle = fixed::Triangle::from_f32(&bvh.triangle_in(hit[slot]));
                let crossing = fixed::Sides::new(&triangle, ray.origin()).crossing(ray);
                hits[i] = crossing.to_hit(ray, bvh.index_of(hit[slot]));
            }
        }
    }
}

/// Asks for the memory of a hit that is written some time after one.
#[inline(always)]
fn ask_ahead(hits: &[Hit], after: usize) {
    if let Some(hit) = hits.get(after + AHEAD) {
        prefetch(std::slice::from_ref(hit));
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
fn eight(bvh: &Bvh, places: &[u32]) -> ([[[f32; 8]; 3]; 3], [u32; 8]) {
    let (mut corners, mut indices) = ([[[0.0; 8]; 3]; 3], [0; 8]);
    for (lane, &place) in places.iter().enumerate() {
        let Triangle(from) = bvh.triangle_in(place);
        for (to, from) in corners.iter_mut().zip(&from) {
            (to[0][lane], to[1][lane], to[2][lane]) = (from[0], from[1], from[2]);
        }
        indices[lane] = bvh.index_of(place);
    }
    (corners, indices)
}
