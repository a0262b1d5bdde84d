//! The segments of one ray, from the last to the first.
//!
//! Infinitely far away nothing winds around the ray. Going back from there to its start, each crossing
//! changes the winding number of one mesh by one:
//!
//! ```text
//!   rock    0 ─┤ enters ├─ 1 ──────────────── 1 ───────────┤ leaves ├─ 0        read from right to left
//!   steel   0 ──────────── 0 ─┤ enters ├─ 1 ─┤ leaves ├─ 0 ──────────── 0
//! ```
//!
//! Crossings with the same t change all their numbers at once. Rounding preserves order, so crossings with
//! the same exact t have the same rounded t, too.

use intertri::{Crossing, Hit, RayOf, Scalar};

use super::segment::{MediumCrossing, Segment};

/// The segments of a ray, from the last to the first.
pub(super) struct Path<'a> {
    media: &'a [u32],
    /// The crossings before `end`, and those at or beyond the ray's end that have not been counted yet, by t.
    crossings: &'a [Crossing],
    /// The meshes that wind around the ray before `end`, with their winding numbers.
    winding: Vec<(u32, i32)>,
    start: f64,
    /// The end of the next segment, and the wall there.
    end: f64,
    wall: Hit,
}

impl<'a> Path<'a> {
    /// Starts from all crossings after the start of a ray, whatever its `t_max`.
    pub(super) fn new<S: Scalar>(
        media: &'a [u32],
        ray: &RayOf<S>,
        crossings: &'a [Crossing],
    ) -> Self {
        let (start, end): (f64, f64) = (ray.t_min.into(), ray.t_max.into());
        // A crossing at 0 never counts.
        let start = if start < 0.0 { 0.0 } else { start };
        Self { media, crossings, winding: Vec::new(), start, end, wall: Hit::MISS }
    }

    /// The first segment, and the medium of the second.
    fn first_two(self) -> Option<(Segment, Option<u32>)> {
        self.fold(None, |later: Option<(Segment, _)>, segment| {
            Some((segment, later.and_then(|(next, _)| next.medium)))
        })
    }

    /// The medium in which the ray starts.
    pub(super) fn medium(self) -> Option<u32> {
        self.first_two()?.0.medium
    }

    /// The end of the first segment, unless the ray ends there.
    pub(super) fn next_crossing(self) -> Option<MediumCrossing> {
        let (Segment { medium: left, wall: hit, .. }, entered) = self.first_two()?;
        hit.is_hit().then_some(MediumCrossing { hit, left, entered })
    }

    /// The last of the meshes that wind around the ray.
    fn mesh(&self) -> Option<u32> {
        self.winding.iter().map(|&(mesh, _)| mesh).max()
    }

    fn medium_of(&self, mesh: Option<u32>) -> Option<u32> {
        mesh.map(|mesh| self.media[mesh as usize])
    }

    /// Moves back across a wall.
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
                // The ray crosses the later of the two meshes here, because only one of them winds around it
                // on each side.
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
