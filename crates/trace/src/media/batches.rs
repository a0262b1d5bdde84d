//! Media queries for many rays and points at once.

use intertri::RayOf;

use super::path::Path;
use super::{Media, MediumCrossing, Segment, endless, toward_outside};
use crate::batch::{CrossingLists, Lists};
use crate::scalar::BvhScalar;
use crate::util::memory::{NoMemory, OutOfMemory, filled, room};
use crate::util::threads;

/// The number of rays to trace together: few enough to keep their lists of crossings small.
const SLAB: usize = 1 << 16;

/// The number of rays whose segments a thread lists per task.
const CHUNK: usize = 1 << 10;

/// Batch queries for many points or rays, using all threads. Result `i` belongs to point or ray
/// `i`.
impl<S: BvhScalar> Media<S> {
    /// Like [`Media::medium_at`], but for many points.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    pub fn medium_at_batch(&self, points: &[[S; 3]]) -> Result<Vec<Option<u32>>, OutOfMemory> {
        let mut media = filled(points.len(), None)?;
        for (points, media) in points.chunks(SLAB).zip(media.chunks_mut(SLAB)) {
            let mut rays = room(points.len())?;
            rays.extend(points.iter().map(|point| toward_outside(*point)));
            let crossings = self.crossings(&rays)?;
            threads::write(media, 1 << 9, |i| self.path(&rays[i], crossings.of(i)).medium());
        }
        Ok(media)
    }

    /// Like [`Media::next_crossing`], but for many rays.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    pub fn next_crossing_batch(
        &self,
        rays: &[RayOf<S>],
    ) -> Result<Vec<Option<MediumCrossing>>, OutOfMemory> {
        let mut next = filled(rays.len(), None)?;
        for (rays, next) in rays.chunks(SLAB).zip(next.chunks_mut(SLAB)) {
            let crossings = self.crossings(rays)?;
            threads::write(next, 1 << 9, |i| self.path(&rays[i], crossings.of(i)).next_crossing());
        }
        Ok(next)
    }

    /// Like [`Media::segments`], but for many rays. Returns the segments in compact arrays.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    pub fn segments_batch(&self, rays: &[RayOf<S>]) -> Result<Lists<Segment>, OutOfMemory> {
        let mut lists = Lists { offsets: room(rays.len() + 1)?, items: Vec::new() };
        lists.offsets.push(0);
        for rays in rays.chunks(SLAB) {
            let crossings = self.crossings(rays)?;
            let mut chunks = room(rays.len().div_ceil(CHUNK))?;
            chunks.resize_with(rays.len().div_ceil(CHUNK), || Ok((Vec::new(), Vec::new())));
            let starts = (0..rays.len()).step_by(CHUNK);
            threads::pieces(chunks.iter_mut().zip(starts), |_, (chunk, start)| {
                let rays = rays[start..].iter().take(CHUNK);
                let paths = rays.zip(start..).map(|(ray, i)| self.path(ray, crossings.of(i)));
                *chunk = listed(paths);
            });
            for chunk in chunks {
                let (ends, mut segments) = chunk?;
                let first = lists.items.len();
                lists.items.try_reserve(segments.len()).map_err(NoMemory::from)?;
                lists.items.append(&mut segments);
                lists.offsets.extend(ends.iter().map(|end: &usize| (first + end) as i64));
            }
        }
        Ok(lists)
    }

    /// Returns all crossings of the rays, ignoring their `t_max`.
    fn crossings(&self, rays: &[RayOf<S>]) -> Result<CrossingLists, OutOfMemory> {
        let mut whole = room(rays.len())?;
        whole.extend(rays.iter().map(endless));
        self.bvh.crossings_batch(&whole)
    }
}

/// Lists the segments of all rays, and the position in the list at which each ray's segments end.
fn listed<'a>(
    paths: impl Iterator<Item = Path<'a>>,
) -> Result<(Vec<usize>, Vec<Segment>), NoMemory> {
    let (mut ends, mut segments) = (room(CHUNK)?, Vec::new());
    for path in paths {
        let first = segments.len();
        for segment in path {
            segments.try_reserve(1)?;
            segments.push(segment);
        }
        segments[first..].reverse();
        ends.push(segments.len());
    }
    Ok((ends, segments))
}
