//! Lists every hit of many rays in compact arrays.
//!
//! ```text
//!   rays      0   1     2          offsets   0 1 1 3
//!             │   │    ╱ ╲         hits      a b c
//!   hits      a        b  c
//! ```
//!
//! Streams and bundles list pairs of a ray and a triangle in the order in which the pairs are
//! found. If a bundle has not computed t and the weights of its pairs, these are computed for eight
//! pairs at a time. The pairs are then put in the order of the rays, and the pairs of each ray are
//! sorted.

use intertri::internal::exact::Side;
use intertri::internal::{Pairs, Resolver, sort_hits};
use intertri::simd::{Simd, WithSimd};
use intertri::{Crossing, Hit, LeafSlot, Ray, RayId};

use std::ops::Range;

use super::RayBatch;
use super::choice::Choice;
use super::chunk::Chunk;
use crate::scalar::Backend;
use crate::tree::Tree;
use crate::util::memory::{NoMemory, room};
use crate::util::threads;
use crate::walk::{BatchOutput, HitPairs};

/// The hits or crossings of many rays, one ray after another, as returned by
/// [`Query::all_batch`](crate::Query::all_batch) and
/// [`Query::crossings_batch`](crate::Query::crossings_batch).
#[derive(Clone, Debug, PartialEq)]
pub struct Lists<T> {
    /// The start of each ray's items, followed by the end of the last ray's items. The offsets
    /// start at 0 and have one more entry than there are rays, as in Apache Arrow's lists.
    pub offsets: Vec<i64>,
    /// The items. The items of each ray are sorted by t and, if several items have the same t, by
    /// index.
    pub items: Vec<T>,
}

/// The hits of many rays.
pub type HitLists = Lists<Hit>;

/// The crossings of many rays.
pub type CrossingLists = Lists<Crossing>;

impl<T> Lists<T> {
    /// Returns the number of rays.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Returns whether there are no rays.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the items of a ray.
    ///
    /// # Panics
    /// Panics if the ray is out of bounds.
    pub fn of(&self, ray: usize) -> &[T] {
        &self.items[self.offsets[ray] as usize..self.offsets[ray + 1] as usize]
    }

    /// Iterates over the items of each ray.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[T]> {
        (0..self.len()).map(|ray| self.of(ray))
    }
}

/// An item of a list: a hit or a crossing.
pub(crate) trait ListItem: Clone + Send {
    /// Creates an item from a hit. `leaves` computes whether the ray leaves the mesh at this hit,
    /// which is expensive.
    fn new(hit: Hit, leaves: impl FnOnce() -> bool) -> Self;
    /// Returns the hit.
    fn hit(&self) -> &Hit;
    /// Returns the hit, mutably, so that its triangle and geometry can be renamed.
    fn hit_mut(&mut self) -> &mut Hit;
}

impl ListItem for Hit {
    #[inline(always)]
    fn new(hit: Hit, _: impl FnOnce() -> bool) -> Self {
        hit
    }
    #[inline(always)]
    fn hit(&self) -> &Hit {
        self
    }
    #[inline(always)]
    fn hit_mut(&mut self) -> &mut Hit {
        self
    }
}

impl ListItem for Crossing {
    #[inline(always)]
    fn new(hit: Hit, leaves: impl FnOnce() -> bool) -> Self {
        Self { hit, leaves: leaves() }
    }
    #[inline(always)]
    fn hit(&self) -> &Hit {
        &self.hit
    }
    #[inline(always)]
    fn hit_mut(&mut self) -> &mut Hit {
        &mut self.hit
    }
}

/// The number of rays that a thread takes at a time, small enough for their lists to stay in the
/// cache.
const CHUNK: usize = 1 << 12;

/// The number of chunks per thread in a round. After a round, the lists of its chunks are
/// concatenated. Each round reuses the memory of the previous round, because allocating memory
/// takes longer than finding the hits.
const ROUND: usize = 8;

/// Lists every hit of many rays or, with a `limit`, the first hits of each ray.
pub(crate) fn lists<S: Backend, T: ListItem>(
    batch: &RayBatch<'_, S>,
    limit: Option<usize>,
) -> Result<Lists<T>, NoMemory> {
    let rays = batch.rays.len();
    let mut lists = Lists { offsets: room(rays + 1)?, items: Vec::new() };
    lists.offsets.push(0);
    let mut chunks = Vec::new();
    chunks.resize_with((ROUND * threads::count()).min(rays.div_ceil(CHUNK)), ChunkLists::new);
    // Work in rounds, so that the scratch memory of chunks is reused and only finished lists grow
    // with the number of rays.
    for from in (0..rays).step_by(chunks.len().max(1) * CHUNK) {
        let starts = (from..rays).step_by(CHUNK);
        threads::pieces(chunks.iter_mut().zip(starts.clone()), |_, (lists, from)| {
            lists.begin();
            batch.pieces(from..rays.min(from + CHUNK), |chunk, _| {
                // A thread cannot return an error, so it sets a flag.
                lists.is_full |= lists.list(&chunk, limit).is_err();
            });
        });
        for (chunk, _) in chunks.iter().zip(starts) {
            lists.add(chunk)?;
        }
    }
    Ok(lists)
}

impl<T: Clone> Lists<T> {
    /// Appends the items of the next rays.
    fn add(&mut self, chunk: &ChunkLists<T>) -> Result<(), NoMemory> {
        let ChunkLists { ends, items, is_full: false, .. } = chunk else { return Err(NoMemory) };
        let first = self.items.len();
        self.items.try_reserve(items.len())?;
        self.items.extend_from_slice(items);
        self.offsets.extend(ends.iter().map(|end| (first + end) as i64));
        Ok(())
    }
}

/// The items of a chunk of rays.
struct ChunkLists<T> {
    /// The pairs in the order in which they are found.
    pairs: HitPairs,
    /// The end of each ray's items.
    ends: Vec<usize>,
    /// For each ray in turn, the slots of the triangles that it hits, each with the index of its
    /// pair in `pairs`.
    slots: Vec<(LeafSlot, u32)>,
    items: Vec<T>,
    /// Whether memory has run out.
    is_full: bool,
}

impl<T: ListItem> ChunkLists<T> {
    fn new() -> Self {
        let (pairs, ends, slots) = (HitPairs::default(), Vec::new(), Vec::new());
        Self { pairs, ends, slots, items: Vec::new(), is_full: false }
    }

    /// Discards the lists of the previous chunk.
    fn begin(&mut self) {
        self.ends.clear();
        self.items.clear();
    }

    /// Lists the hits of a chunk of rays.
    fn list(&mut self, chunk: &Chunk<'_>, limit: Option<usize>) -> Result<(), NoMemory> {
        let Chunk { tree, filter, rays, .. } = *chunk;
        self.pairs.clear(limit);
        chunk.trace(BatchOutput::Pairs(&mut self.pairs), &mut Choice::new(false));
        if self.pairs.is_full {
            return Err(NoMemory);
        }
        self.pairs.level();
        let resolver = filter.resolver();
        filter.level().run(ComputeHits { tree, rays, resolver, pairs: &mut self.pairs });
        self.by_ray(chunk)?;
        for ((id, ray), range) in (0..).map(RayId).zip(rays).zip(ranges(&self.ends)) {
            let (slots, items) = (&mut self.slots[range.clone()], &mut self.items[range]);
            sort(tree, resolver, (ray, id), slots, items);
        }
        if let Some(limit) = limit {
            cut(&mut self.ends, &mut self.items, limit);
        }
        tree.geometries.rename(self.items.iter_mut().map(ListItem::hit_mut));
        Ok(())
    }

    /// Sorts the pairs by ray.
    fn by_ray(&mut self, chunk: &Chunk<'_>) -> Result<(), NoMemory> {
        let Chunk { tree, filter, rays, .. } = *chunk;
        let Self { pairs: HitPairs { pairs, hits: met, .. }, ends, slots, items, .. } = self;

        // Count the pairs of each ray, and add up the counts to find where the items of each ray
        // start. Placing the pairs advances the starts to the ends.
        ends.try_reserve(rays.len())?;
        ends.resize(rays.len(), 0);
        // A counting sort by ray takes two passes over the pairs and no comparisons.
        for &(ray, _) in &*pairs {
            ends[ray.0 as usize] += 1;
        }
        let mut begin = 0;
        for end in &mut *ends {
            begin += std::mem::replace(end, begin);
        }
        slots.clear();
        slots.try_reserve(pairs.len())?;
        slots.resize(pairs.len(), (LeafSlot(0), 0));
        for (i, &(ray, slot)) in (0..).zip(&*pairs) {
            let at = &mut ends[ray.0 as usize];
            slots[*at] = (slot, i);
            *at += 1;
        }
        items.try_reserve(pairs.len())?;
        items.extend(slots.iter().map(|&(slot, i)| {
            let (id, _) = pairs[i as usize];
            let (ray, triangle) = (&rays[id.0 as usize], || tree.triangle_in(slot));
            let leaves =
                || filter.resolver().facing(ray, &triangle(), (id, slot)) == Some(Side::Leaves);
            T::new(met[i as usize], leaves)
        }));
        Ok(())
    }
}

/// Iterates over the range of each ray's items.
fn ranges(ends: &[usize]) -> impl Iterator<Item = Range<usize>> {
    ends.iter().scan(0, |begin, &end| Some(std::mem::replace(begin, end)..end))
}

/// Computes the hits of the pairs whose hits are not known yet.
struct ComputeHits<'a> {
    tree: &'a Tree,
    rays: &'a [Ray],
    resolver: Resolver<'a>,
    pairs: &'a mut HitPairs,
}

impl WithSimd for ComputeHits<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { tree, rays, resolver, pairs: HitPairs { pairs, hits, .. } } = self;

        // Process eight pairs at a time; they may belong to different rays.
        let (mut eight, mut waiting) = (Pairs::new(), 0);
        let (mut ids, mut to) = ([(RayId(0), LeafSlot(0)); 8], [0; 8]);
        for (i, &(id, slot)) in pairs.iter().enumerate() {
            if hits[i].is_hit() {
                continue;
            }
            let (triangle, index) = (tree.triangle_in(slot), tree.index_of(slot));
            eight.set(waiting, &rays[id.0 as usize], &triangle, index);
            (ids[waiting], to[waiting]) = ((id, slot), i);
            waiting += 1;
            if waiting == 8 {
                let met = resolver.hits_in::<S>(&eight, &ids, 8);
                (0..8).for_each(|k| hits[to[k]] = met[k]);
                waiting = 0;
            }
        }
        let met = resolver.hits_in::<S>(&eight, &ids, waiting);
        (0..waiting).for_each(|k| hits[to[k]] = met[k]);
    }
}

/// Sorts the items of a ray by t, then by triangle. `slots` contains the slots of the triangles.
#[inline(always)]
fn sort<T: ListItem>(
    tree: &Tree,
    resolver: Resolver<'_>,
    ray: (&Ray, RayId),
    slots: &mut [(LeafSlot, u32)],
    items: &mut [T],
) {
    if items.len() > 1 {
        items.sort_unstable_by(|a, b| {
            let (a, b) = (a.hit(), b.hit());
            a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle))
        });
        // Most rays have no rounded values of t that are equal, so their slots are not needed.
        if items.windows(2).any(|pair| pair[0].hit().t == pair[1].hit().t) {
            sort_ties(tree, resolver, ray, slots, items);
        }
    }
}

/// Sorts the items if some rounded values of t are equal.
#[cold]
#[inline(never)]
fn sort_ties<T: ListItem>(
    tree: &Tree,
    resolver: Resolver<'_>,
    (ray, id): (&Ray, RayId),
    slots: &mut [(LeafSlot, u32)],
    items: &mut [T],
) {
    // Many triangles may have the same t, so each comparison finds its triangles by bisection.
    let index = |&(slot, _): &(LeafSlot, u32)| tree.index_of(slot).0;
    slots.sort_unstable_by_key(index);
    let slot = |hit: &Hit| {
        let i = slots.binary_search_by_key(&hit.triangle, index);
        slots[i.expect("each hit is in one of the slots")].0
    };
    sort_hits(items, T::hit, |a, b| {
        let slots = [slot(a.hit()), slot(b.hit())];
        let [a, b] = slots.map(|slot| tree.triangle_in(slot));
        resolver.order(ray, [&a, &b], (id, slots))
    });
}

/// Keeps at most `limit` items of each ray.
fn cut<T: Clone>(ends: &mut [usize], items: &mut Vec<T>, limit: usize) {
    let (mut begin, mut kept) = (0_usize, 0);
    for end in ends {
        let some = begin..(*end).min(begin.saturating_add(limit));
        begin = *end;
        for i in some {
            // Kept items move to the front, in order; `kept` never exceeds `i`.
            items.swap(kept, i);
            kept += 1;
        }
        *end = kept;
    }
    items.truncate(kept);
}

#[cfg(test)]
mod tests {
    use intertri::{Mode, Ray, Triangle};

    use super::{CHUNK, ROUND};
    use crate::Bvh;
    use crate::util::threads;

    /// Traces more rays than fit in a round. Each ray must get its own list, regardless of what
    /// earlier chunks left behind.
    #[test]
    fn rounds_of_chunks_follow_each_other() {
        let wall = |z| Triangle([[0.0, 0.0, z], [9.0, 0.0, z], [0.0, 9.0, z]]);
        let bvh = Bvh::new(&[wall(7.0), wall(5.0), wall(6.0)]).unwrap();
        let count = ROUND * threads::count() * CHUNK + 2 * CHUNK + 3;
        // The number of hits of the i-th ray.
        let hits = |i: usize| [3, 0, 1, 2][(i / 5 + i / CHUNK) % 4];
        let ray = |i: usize| {
            let from = [[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 6.5], [1.0, 1.0, 5.5]];
            Ray::new(from[(i / 5 + i / CHUNK) % 4], [0.0, 0.0, 1.0])
        };
        let rays: Vec<Ray> = (0..count).map(ray).collect();
        for limit in [None, Some(2)] {
            let lists = bvh.query().mode(Mode::certified()).all_batch(&rays, limit).unwrap();
            assert_eq!(lists.len(), count);
            for (i, list) in lists.iter().enumerate() {
                let (all, most) = ([1, 2, 0], limit.unwrap_or(3));
                let expected = all[3 - hits(i)..].iter().take(most);
                assert!(list.iter().map(|hit| hit.triangle).eq(expected.copied()), "ray {i}");
            }
        }
    }
}
