//! The hit lists of another tracer: the hits of each ray sorted by t, concatenated for each chunk
//! of rays.

use std::ops::Range;

use intertri::Ray;
use rayon::prelude::*;

use super::answer;
use crate::engine::{Answer, CHUNK};

/// A hit as another tracer reports it.
#[derive(Clone, Copy)]
pub struct ListedHit {
    pub t: f32,
    pub triangle: u32,
    // u and v are stored only so that all lists cost the same: intertri's hits also contain them.
    #[expect(dead_code, reason = "only the time to write it matters")]
    pub u: f32,
    #[expect(dead_code, reason = "only the time to write it matters")]
    pub v: f32,
}

/// Sorts the hits of a ray.
#[inline(always)]
pub fn sort(hits: &mut [ListedHit]) {
    if hits.len() > 1 {
        hits.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
    }
}

/// The hits of a chunk of rays, and the position at which each ray's hits end.
#[derive(Default)]
pub struct Lists {
    pub hits: Vec<ListedHit>,
    pub ends: Vec<usize>,
}

impl Lists {
    /// Returns the number of hits of each ray.
    pub fn answers(&self) -> Vec<Answer> {
        let begins = [0].into_iter().chain(self.ends.iter().copied());
        begins.zip(&self.ends).map(|(begin, end)| answer(end - begin)).collect()
    }
}

/// The rays and their hits, collected by chunk. Memory is reused from one repeat to the next.
pub struct Collected<R> {
    rays: Vec<R>,
    lists: Vec<Lists>,
}

impl<R> Default for Collected<R> {
    fn default() -> Self {
        Self { rays: Vec::new(), lists: Vec::new() }
    }
}

impl<R: Send + Sync> Collected<R> {
    pub fn load(&mut self, rays: &[Ray], convert: impl Fn(&Ray) -> R) {
        self.rays = rays.iter().map(convert).collect();
        self.lists = (0..rays.len().div_ceil(CHUNK)).map(|_| Lists::default()).collect();
    }

    /// Traces a range of the rays, collecting the hits of each chunk in its own lists.
    pub fn trace(&mut self, part: Range<usize>, each: impl Fn(&[R], &mut Lists) + Sync) {
        let chunks = part.start / CHUNK..part.end.div_ceil(CHUNK);
        let rays = self.rays[part].par_chunks(CHUNK);
        rays.zip(&mut self.lists[chunks]).for_each(|(rays, lists)| {
            lists.hits.clear();
            lists.ends.clear();
            each(rays, lists);
        });
    }

    pub fn answers(&self) -> Vec<Answer> {
        self.lists.iter().flat_map(Lists::answers).collect()
    }
}
