//! Lists hits with Embree, using a filter that collects each hit and then rejects it, so that
//! traversal continues.

use std::ops::Range;
use std::sync::Arc;

use intertri::Ray;
use rayon::prelude::*;

use super::collected::{Lists, sort};
use crate::embree::{Caller, Collector, Group, RayHit, Scene};
use crate::engine::{Answer, CHUNK, Engine, Question};
use crate::flush_to_zero::with_flush_to_zero;

/// A scene queried with N rays per call: 1, 8 or 16.
pub struct Every<const N: usize> {
    scene: Arc<Scene>,
    count: usize,
    groups: Vec<Group<N>>,
    lists: Vec<Lists>,
}

impl<const N: usize> Every<N> {
    pub fn new(scene: Arc<Scene>) -> Self {
        Self { scene, count: 0, groups: vec![], lists: vec![] }
    }
}

impl<const N: usize> Engine for Every<N> {
    fn load(&mut self, rays: &[Ray], _: Question) {
        self.groups = rays.chunks(N).map(Group::new).collect();
        self.lists = (0..rays.len().div_ceil(CHUNK)).map(|_| Lists::default()).collect();
        self.count = rays.len();
    }

    fn trace(&mut self, part: Range<usize>) {
        let Self { scene, count, groups, lists } = self;
        let chunks = part.start / CHUNK..part.end.div_ceil(CHUNK);
        let groups = groups[part.start / N..part.end.div_ceil(N)].par_chunks(CHUNK / N);
        let (first, count) = (chunks.start, *count);
        groups.zip(&mut lists[chunks]).enumerate().for_each(|(chunk, (groups, lists))| {
            lists.hits.clear();
            lists.ends.clear();
            let mut collector = Collector::default();
            let collector = &raw mut collector;
            let caller = Caller::collecting(scene, collector);
            let mut hit = RayHit::numbered();
            with_flush_to_zero(|| {
                for (i, group) in groups.iter().enumerate() {
                    let live = N.min(count - (first + chunk) * CHUNK - i * N);
                    caller.ask(group, live, &mut hit);
                    // SAFETY: the collector lives in this closure, and nothing else accesses it
                    // now.
                    for hits in unsafe { &mut *collector }.taken(live) {
                        sort(hits);
                        lists.hits.extend_from_slice(hits);
                        lists.ends.push(lists.hits.len());
                        hits.clear();
                    }
                }
            });
        });
    }

    fn answers(&self) -> Vec<Answer> {
        self.lists.iter().flat_map(Lists::answers).collect()
    }
}
