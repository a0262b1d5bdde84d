//! What the search of a tile found, and what is asked of that: whether, which, where.

use intertri::fixed;
use intertri::lanes::Simd;
use intertri::{Hit, Ray, Sight, Triangle};

use crate::bvh::Bvh;

/// Nodes and leaves that are still to be visited, the nearest on top, each with its depth.
pub(crate) type Stack = Vec<(u32, f32)>;

/// The number of no triangle.
pub(crate) const NOTHING: u32 = u32::MAX;

/// What a search of tiles needs and need not make anew each time.
#[derive(Default)]
pub(crate) struct Scratch {
    pub(crate) stack: Stack,
    /// The places of the triangles that rays of the tile were tested against.
    pub(crate) seen: Vec<u32>,
    /// For each ray the number in `seen` of the triangle that it hits, or [`NOTHING`].
    pub(crate) found: Vec<u32>,
    /// For each of `seen` that is hit its number in `hit`.
    slot: Vec<u32>,
    /// The places of those that are hit.
    hit: Vec<u32>,
    sights: Vec<Sight>,
    on_grid: Vec<fixed::Sight>,
    /// What was left of the stack when a tile was split.
    pub(crate) split: Stack,
}

impl Scratch {
    /// Whether a ray is one of the last tile and hits something.
    pub(crate) fn is_hit(&self, ray: usize) -> bool {
        self.found.get(ray).is_some_and(|&found| found != NOTHING)
    }

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

    /// The places of the triangles that rays of the last tile hit, each once, however many hit it. For
    /// [`Scratch::number`].
    #[inline(always)]
    pub(crate) fn distinct(&mut self) -> &[u32] {
        let Self { seen, slot, hit, found, .. } = self;
        slot.clear();
        hit.clear();
        slot.resize(seen.len(), NOTHING);
        let mut last = NOTHING;
        for &number in found.iter() {
            if number != last && number != NOTHING && slot[number as usize] == NOTHING {
                slot[number as usize] = hit.len() as u32;
                hit.push(seen[number as usize]);
            }
            last = number;
        }
        hit
    }

    /// Where a ray of the last tile hits something, the number of that in [`Scratch::distinct`].
    #[inline(always)]
    pub(crate) fn number(&self, ray: usize) -> Option<usize> {
        match self.found[ray] {
            NOTHING => None,
            number => Some(self.slot[number as usize] as usize),
        }
    }

    /// Where the rays of the last tile meet what they hit.
    #[inline(always)]
    pub(crate) fn hits<S: Simd>(&mut self, bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
        let mut sights = std::mem::take(&mut self.sights);
        sights.clear();
        for places in self.distinct().chunks(8) {
            let (corners, indices) = eight(bvh, places);
            sights.extend(Sight::eight_in::<S>(&corners, &indices, rays[0].origin));
        }
        for (i, (ray, to)) in rays.iter().zip(hits).enumerate() {
            match self.number(i) {
                None => *to = Hit::MISS,
                Some(number) => sights[number].hit_in::<S>(ray.dir, to),
            }
        }
        self.sights = sights;
    }

    /// The same on a grid.
    #[inline(always)]
    pub(crate) fn hits_on_grid<S: Simd>(
        &mut self,
        bvh: &Bvh,
        rays: &[fixed::Ray],
        hits: &mut [Hit],
    ) {
        let mut sights = std::mem::take(&mut self.on_grid);
        sights.clear();
        for places in self.distinct().chunks(8) {
            let (corners, indices) = eight(bvh, places);
            let origin = rays[0].origin();
            sights.extend(fixed::Sight::eight_in::<S>(&corners, &indices, origin));
        }
        for (i, (ray, to)) in rays.iter().zip(hits).enumerate() {
            match self.number(i) {
                None => *to = Hit::MISS,
                Some(number) => {
                    if !sights[number].hit_in::<S>(ray, to) {
                        let place = self.hit[number];
                        let triangle = fixed::Triangle::from_f32(&bvh.triangle_in(place));
                        let crossing = fixed::Sides::new(&triangle, ray.origin()).crossing(ray);
                        *to = crossing.to_hit(ray, bvh.index_of(place));
                    }
                }
            }
        }
        self.on_grid = sights;
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
