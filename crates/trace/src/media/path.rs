//! Iterates over the segments of a single ray, from last to first.
//!
//! At infinity, the ray is outside all meshes. From there back toward the start, each crossing
//! changes the winding number of one mesh by one:
//!
//! ```text
//!   rock    0 ─┤ enters ├─ 1 ──────────────── 1 ───────────┤ leaves ├─ 0        Read from right to left.
//!   steel   0 ──────────── 0 ─┤ enters ├─ 1 ─┤ leaves ├─ 0 ──────────── 0
//! ```
//!
//! Crossings with the same t take effect together. Rounding preserves order, so crossings with the
//! same exact t also have the same rounded t.

use intertri::{Crossing, Hit, RayOf, Scalar};

use super::segment::{MediumCrossing, Segment};

/// Iterates over the segments of a ray, from last to first.
pub(super) struct Path<'a> {
    media: &'a [u32],
    /// The crossings that are still to be processed, sorted by t. All are before `end`, except that
    /// initially the list may extend beyond the ray's end.
    crossings: &'a [Crossing],
    /// The meshes that wind around the ray just before `end`, with their winding numbers.
    winding: Vec<(u32, i32)>,
    start: f64,
    /// The t at which the next segment to be returned ends.
    end: f64,
    /// The wall at `end`.
    wall: Hit,
}

impl<'a> Path<'a> {
    /// Creates the iterator from all crossings after the start of a ray, including those beyond
    /// `t_max`.
    pub(super) fn new<S: Scalar>(
        media: &'a [u32],
        ray: &RayOf<S>,
        crossings: &'a [Crossing],
    ) -> Self {
        let (start, end): (f64, f64) = (ray.t_min.into(), ray.t_max.into());
        // Replace a negative `t_min` with 0. A crossing at t = 0 never counts.
        let start = if start < 0.0 { 0.0 } else { start };
        Self { media, crossings, winding: Vec::new(), start, end, wall: Hit::MISS }
    }

    /// Returns the first segment and the medium of the second.
    fn first_two(self) -> Option<(Segment, Option<u32>)> {
        self.fold(None, |later: Option<(Segment, _)>, segment| {
            Some((segment, later.and_then(|(next, _)| next.medium)))
        })
    }

    /// Returns the medium in which the ray starts.
    pub(super) fn medium(self) -> Option<u32> {
        self.first_two()?.0.medium
    }

    /// Returns the crossing at the end of the first segment, unless the ray ends there.
    pub(super) fn next_crossing(self) -> Option<MediumCrossing> {
        let (Segment { medium: left, wall: hit, .. }, entered) = self.first_two()?;
        hit.is_hit().then_some(MediumCrossing { hit, left, entered })
    }

    /// Returns the mesh with the highest index among those that wind around the ray just before
    /// `end`.
    fn mesh(&self) -> Option<u32> {
        self.winding.iter().map(|&(mesh, _)| mesh).max()
    }

    fn medium_of(&self, mesh: Option<u32>) -> Option<u32> {
        mesh.map(|mesh| self.media[mesh as usize])
    }

    /// Steps backward across a wall by undoing the crossing's change to the winding number.
    fn cross(&mut self, Crossing { hit, leaves }: &Crossing) {
        let times = if *leaves { 1 } else { -1 };
        match self.winding.iter().position(|&(mesh, _)| mesh == hit.geometry) {
            None => self.winding.push((hit.geometry, times)),
            Some(at) if self.winding[at].1 == -times => {
                self.winding.swap_remove(at);
            }
            Some(at) => self.winding[at].1 += times,
        }
    }
}

impl Iterator for Path<'_> {
    type Item = Segment;

    fn next(&mut self) -> Option<Segment> {
        let Self { start, end, wall, .. } = *self;
        if start.partial_cmp(&end) != Some(std::cmp::Ordering::Less) {
            return None;
        }
        let mut after = self.mesh();
        while let Some(t) = self.crossings.last().map(|last| last.hit.t).filter(|&t| t > start) {
            let earlier = self.crossings.iter().rposition(|crossing| crossing.hit.t != t);
            let (rest, tied) = self.crossings.split_at(earlier.map_or(0, |last| last + 1));
            self.crossings = rest;
            for crossing in tied {
                self.cross(crossing);
            }
            let before = self.mesh();
            if t < end && self.medium_of(before) != self.medium_of(after) {
                // The wall belongs to the mesh with the higher index, because that mesh winds
                // around the ray on only one side of the crossing.
                let mesh = before.max(after);
                let wall_here = tied.iter().find(|crossing| Some(crossing.hit.geometry) == mesh);
                self.end = t;
                self.wall = wall_here.map_or(Hit::MISS, |crossing| crossing.hit);
                return Some(Segment { start: t, end, medium: self.medium_of(after), wall });
            }
            after = before;
        }
        self.end = start;
        Some(Segment { start, end, medium: self.medium_of(after), wall })
    }
}
