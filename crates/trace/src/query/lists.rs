//! Every hit of many rays, in compact arrays.
//!
//! ```text
//!   rays      0   1     2          offsets   0 1 1 3
//!             │   │    ╱ ╲         hits      a b c
//!   hits      a        b  c
//! ```
//!
//! A chunk of rays lists pairs of a ray and a triangle, as streams and bundles find them. Of what bundles do not know
//! yet, t and weights are computed eight side by side. Pairs are put in the order of the rays, and each ray's are sorted.

use intertri::internal::{Filter, Pairs, Resolver, Test as _, Which};
use intertri::simd::{Simd, WithSimd};
use intertri::{Hit, Ray};

use std::ops::Range;

use super::batch::{self, Asked, Many};
use super::one;
use crate::answers::Answers;
use crate::memory::{NoMemory, room};
use crate::pairs::HitPairs;
use crate::threads;
use crate::tree::Tree;

/// The hits of many rays, one ray's after the other's: what [`Bvh::all_batch`](crate::Bvh::all_batch) gives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HitLists {
    /// Where the hits of each ray begin and, after the last, where they end: one more than there are rays, from
    /// 0 up, as in the lists of Arrow.
    pub offsets: Vec<i64>,
    /// The hits, of each ray in order of t; of equal t, of the index.
    pub hits: Vec<Hit>,
}

impl HitLists {
    /// How many rays there are.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there is no ray.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The hits of a ray.
    ///
    /// # Panics
    /// If there are not so many rays.
    pub fn of(&self, ray: usize) -> &[Hit] {
        &self.hits[self.offsets[ray] as usize..self.offsets[ray + 1] as usize]
    }

    /// The hits of each ray.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[Hit]> {
        (0..self.len()).map(|ray| self.of(ray))
    }
}

/// Rays a thread takes at a time: what is listed of them stays in the cache.
const CHUNK: usize = 1 << 12;

/// So many chunks a thread before they are put together. Their memory is taken once for all of them: the system
/// gives it slower than hits are found.
const ROUND: usize = 8;

/// See [`Bvh::all_batch`](crate::Bvh::all_batch).
pub(super) fn lists(many: &Many<'_>, limit: Option<usize>) -> Result<HitLists, NoMemory> {
    let rays = many.count;
    let mut lists = HitLists { offsets: room(rays + 1)?, hits: Vec::new() };
    lists.offsets.push(0);
    let mut chunks = Vec::new();
    chunks.resize_with((ROUND * threads::count()).min(rays.div_ceil(CHUNK)), Listed::default);
    for from in (0..rays).step_by(chunks.len().max(1) * CHUNK) {
        let starts = (from..rays).step_by(CHUNK);
        threads::pieces(chunks.iter_mut().zip(starts.clone()), |_, (listed, from)| {
            listed.list(many, from..rays.min(from + CHUNK), limit);
        });
        for (listed, _) in chunks.iter().zip(starts) {
            lists.add(listed)?;
        }
    }
    Ok(lists)
}

impl HitLists {
    /// Adds those of the next rays.
    fn add(&mut self, listed: &Listed) -> Result<(), NoMemory> {
        let Listed { ends, hits, is_full: false, .. } = listed else { return Err(NoMemory) };
        let first = self.hits.len();
        self.hits.try_reserve(hits.len())?;
        self.hits.extend_from_slice(hits);
        self.offsets.extend(ends.iter().map(|end| (first + end) as i64));
        Ok(())
    }
}

/// The hits of a chunk of rays.
#[derive(Default)]
struct Listed {
    /// As they are found.
    pairs: HitPairs,
    /// Where those of each ray end.
    ends: Vec<usize>,
    /// The places of the triangles, by ray.
    places: Vec<u32>,
    hits: Vec<Hit>,
    /// Whether there is too little memory.
    is_full: bool,
}

impl Listed {
    /// Lists the hits of some rays.
    fn list(&mut self, many: &Many<'_>, range: Range<usize>, limit: Option<usize>) {
        self.ends.clear();
        self.hits.clear();
        many.ask(range, &mut |asked, which| {
            let listed = match which {
                Which::Filter(test) => self.by_filter(asked, test, limit),
                Which::Lanes64(_) => self.one_by_one(asked, which, limit),
            };
            self.is_full = listed.is_err();
        });
    }

    /// By the filter.
    fn by_filter<'a>(
        &mut self,
        asked: Asked<'a>,
        test: Filter<'a>,
        limit: Option<usize>,
    ) -> Result<(), NoMemory> {
        self.pairs.clear(limit);
        batch::chunk(asked, test, Answers::Pairs(&mut self.pairs));
        let (bvh, rays, resolver) = (asked.bvh, asked.rays, test.resolver());
        if self.pairs.is_full {
            return Err(NoMemory);
        }
        self.pairs.level();
        test.level().run(Meet { bvh, rays, resolver, pairs: &mut self.pairs });
        self.by_ray(rays.len())?;
        for ((number, ray), range) in (0..).zip(rays).zip(Listed::ranges(&self.ends)) {
            let (places, hits) = (&self.places[range.clone()], &mut self.hits[range]);
            sort(bvh, resolver, (ray, number), places, hits);
        }
        if let Some(limit) = limit {
            cut(&mut self.ends, &mut self.hits, limit);
        }
        bvh.geometries.tell(&mut self.hits);
        Ok(())
    }

    /// The same, a ray a call.
    fn one_by_one(
        &mut self,
        asked: Asked<'_>,
        which: Which<'_>,
        limit: Option<usize>,
    ) -> Result<(), NoMemory> {
        let Asked { bvh, choice, rays, .. } = asked;
        self.ends.try_reserve(rays.len())?;
        for (number, ray) in rays.iter().enumerate() {
            let all = one::all(bvh, (&choice, number), &which, ray);
            let some = &all[..all.len().min(limit.unwrap_or(usize::MAX))];
            self.hits.try_reserve(some.len())?;
            self.hits.extend_from_slice(some);
            self.ends.push(self.hits.len());
        }
        Ok(())
    }

    /// Puts the pairs in the order of their rays.
    fn by_ray(&mut self, rays: usize) -> Result<(), NoMemory> {
        let Self { pairs: HitPairs { pairs, hits: met, .. }, ends, places, hits, .. } = self;

        // How many each ray has, then where they begin; placing them moves that to where they end.
        ends.try_reserve(rays)?;
        ends.resize(rays, 0);
        for &(ray, _) in &*pairs {
            ends[ray as usize] += 1;
        }
        let mut begin = 0;
        for end in &mut *ends {
            begin += std::mem::replace(end, begin);
        }
        places.clear();
        places.try_reserve(pairs.len())?;
        places.resize(pairs.len(), 0);
        hits.try_reserve(pairs.len())?;
        hits.resize(pairs.len(), Hit::MISS);
        for (&(ray, place), hit) in pairs.iter().zip(met) {
            let at = &mut ends[ray as usize];
            (places[*at], hits[*at]) = (place, *hit);
            *at += 1;
        }
        Ok(())
    }

    /// The first and last places of each ray's hits.
    fn ranges(ends: &[usize]) -> impl Iterator<Item = Range<usize>> {
        ends.iter().scan(0, |begin, &end| Some(std::mem::replace(begin, end)..end))
    }
}

/// Finds where the pairs meet of which that is not known yet.
struct Meet<'a> {
    bvh: &'a Tree,
    rays: &'a [Ray],
    resolver: Resolver<'a>,
    pairs: &'a mut HitPairs,
}

impl WithSimd for Meet<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { bvh, rays, resolver, pairs: HitPairs { pairs, hits, .. } } = self;

        // Eight pairs side by side, whosever they are.
        let (mut eight, mut waiting) = (Pairs::new(), 0);
        let (mut numbers, mut to) = ([(0, 0); 8], [0; 8]);
        for (i, &(number, place)) in pairs.iter().enumerate() {
            if hits[i].is_hit() {
                continue;
            }
            let (triangle, index) = (bvh.triangle_in(place), bvh.index_of(place));
            eight.set(waiting, &rays[number as usize], &triangle, index);
            (numbers[waiting], to[waiting]) = ((number, place), i);
            waiting += 1;
            if waiting == 8 {
                let met = resolver.hits_in::<S>(&eight, &numbers, 8);
                (0..8).for_each(|k| hits[to[k]] = met[k]);
                waiting = 0;
            }
        }
        let met = resolver.hits_in::<S>(&eight, &numbers, waiting);
        (0..waiting).for_each(|k| hits[to[k]] = met[k]);
    }
}

/// The hits of a ray on the triangles in these places, in order of t; of equal t, of the index.
#[inline(always)]
fn sort(bvh: &Tree, resolver: Resolver<'_>, ray: (&Ray, u32), places: &[u32], hits: &mut [Hit]) {
    if hits.len() > 1 {
        hits.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
        if hits.windows(2).any(|pair| pair[0].t == pair[1].t) {
            sort_ties(bvh, resolver, ray, places, hits);
        }
    }
}

/// The same where rounded t do not tell.
#[cold]
#[inline(never)]
fn sort_ties(
    bvh: &Tree,
    resolver: Resolver<'_>,
    ray: (&Ray, u32),
    places: &[u32],
    hits: &mut [Hit],
) {
    let triangle = |hit: &Hit| {
        let is_it = |&&place: &&u32| bvh.index_of(place) == hit.triangle;
        let place = *places.iter().find(is_it).expect("each hit is of one of the places");
        (bvh.triangle_in(place), place)
    };
    for tied in hits.chunk_by_mut(|a, b| a.t == b.t).filter(|tied| tied.len() > 1) {
        tied.sort_unstable_by(|a, b| {
            let ((at, one), (bt, other)) = (triangle(a), triangle(b));
            resolver.first(ray, (a, &at, one), (b, &bt, other))
        });
    }
}

/// Leaves so many hits of each ray.
fn cut(ends: &mut [usize], hits: &mut Vec<Hit>, limit: usize) {
    let (mut begin, mut kept) = (0_usize, 0);
    for end in ends {
        let some = begin..(*end).min(begin.saturating_add(limit));
        begin = *end;
        hits.copy_within(some.clone(), kept);
        kept += some.len();
        *end = kept;
    }
    hits.truncate(kept);
}

#[cfg(test)]
mod tests {
    use intertri::{Certified, Double, Ray, Triangle};

    use super::{CHUNK, ROUND};
    use crate::{Bvh, threads};

    /// More than a round: each ray has its own list, whatever the chunks before it left behind.
    #[test]
    fn rounds_of_chunks_follow_each_other() {
        let wall = |z| Triangle([[0.0, 0.0, z], [9.0, 0.0, z], [0.0, 9.0, z]]);
        let bvh = Bvh::new(&[wall(7.0), wall(5.0), wall(6.0)]).unwrap();
        let count = ROUND * threads::count() * CHUNK + 2 * CHUNK + 3;
        // So many hits of the i-th.
        let hits = |i: usize| [3, 0, 1, 2][(i / 5 + i / CHUNK) % 4];
        let ray = |i: usize| {
            let from = [[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 6.5], [1.0, 1.0, 5.5]];
            Ray::new(from[(i / 5 + i / CHUNK) % 4], [0.0, 0.0, 1.0])
        };
        let rays: Vec<Ray> = (0..count).map(ray).collect();
        for limit in [None, Some(2)] {
            let lists = bvh.all_batch(&Certified::default(), &rays, limit).unwrap();
            assert_eq!(lists, bvh.all_batch(&Double::default(), &rays, limit).unwrap());
            assert_eq!(lists.len(), count);
            for (i, list) in lists.iter().enumerate() {
                let (all, most) = ([1, 2, 0], limit.unwrap_or(3));
                let expected = all[3 - hits(i)..].iter().take(most);
                assert!(list.iter().map(|hit| hit.triangle).eq(expected.copied()), "ray {i}");
            }
        }
    }
}
