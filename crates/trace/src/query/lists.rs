//! Every hit of many rays, in compact arrays.
//!
//! ```text
//!   rays      0   1     2          offsets   0 1 1 3
//!             │   │    ╱ ╲         hits      a b c
//!   hits      a        b  c
//! ```
//!
//! A chunk of rays lists pairs of a ray and a triangle, as streams and bundles find them. They are put in the
//! order of the rays, t and weights are computed eight side by side, and each ray's are sorted.

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
    lists.hits.shrink_to_fit();
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
        self.by_ray(rays.len())?;
        test.level().run(WithAttributes { bvh, rays, resolver, limit, listed: self })
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
        let Self { pairs: HitPairs { pairs, is_full: false, .. }, ends, places, .. } = self else {
            return Err(NoMemory);
        };

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
        for &(ray, place) in &*pairs {
            let at = &mut ends[ray as usize];
            places[*at] = place;
            *at += 1;
        }
        Ok(())
    }

    /// The first and last places of each ray's hits.
    fn ranges(ends: &[usize]) -> impl Iterator<Item = Range<usize>> {
        ends.iter().scan(0, |begin, &end| Some(std::mem::replace(begin, end)..end))
    }
}

/// Pairs with t and weights, those of each ray in order.
struct WithAttributes<'a> {
    bvh: &'a Tree,
    rays: &'a [Ray],
    resolver: Resolver<'a>,
    limit: Option<usize>,
    listed: &'a mut Listed,
}

impl WithSimd for WithAttributes<'_> {
    type Output = Result<(), NoMemory>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let Self { bvh, rays, resolver, limit, listed } = self;
        let Listed { ends, places, hits, .. } = listed;
        hits.try_reserve(places.len())?;
        hits.resize(places.len(), Hit::MISS);

        // Eight pairs side by side, whosever they are.
        let (mut pairs, mut waiting, mut first) = (Pairs::new(), 0, 0);
        let mut numbers = [(0, 0); 8];
        for ((number, ray), range) in (0..).zip(rays).zip(Listed::ranges(ends)) {
            for &place in &places[range] {
                pairs.set(waiting, ray, &bvh.triangle_in(place), bvh.index_of(place));
                numbers[waiting] = (number, place);
                waiting += 1;
                if waiting == 8 {
                    let eight = resolver.hits_in::<S>(&pairs, &numbers, 8);
                    hits[first..first + 8].copy_from_slice(&eight);
                    (first, waiting) = (first + 8, 0);
                }
            }
        }
        let last = resolver.hits_in::<S>(&pairs, &numbers, waiting);
        hits[first..].copy_from_slice(&last[..waiting]);

        for ((number, ray), range) in (0..).zip(rays).zip(Listed::ranges(ends)) {
            let (places, hits) = (&places[range.clone()], &mut hits[range]);
            sort(bvh, resolver, (ray, number), places, hits);
        }
        if let Some(limit) = limit {
            cut(ends, hits, limit);
        }
        bvh.geometries.tell(hits);
        Ok(())
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
    let hit = |&place: &u32| {
        let (triangle, index) = (bvh.triangle_in(place), bvh.index_of(place));
        (resolver.hit_attributes(ray.0, &triangle, index, (ray.1, place)), triangle, place)
    };
    let mut all: Vec<_> = places.iter().map(hit).collect();
    all.sort_unstable_by(|(a, at, one), (b, bt, other)| {
        resolver.first(ray, (a, at, *one), (b, bt, *other))
    });
    for (to, (hit, ..)) in hits.iter_mut().zip(all) {
        *to = hit;
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
