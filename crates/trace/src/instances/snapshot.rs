//! The queries of a committed scene.

use std::cell::Cell;
use std::sync::Arc;

use intertri::internal::exact::{self, Side};
use intertri::simd::Level;
use intertri::{Hit, Ray64, Rule};

use super::collect::{All, Any, Candidate, Closest, Collect};
use super::committed::Committed;
use super::hit::{InstanceId, SceneHit};
use super::trace::{SceneScratch, Trace};
use crate::batch::Lists;
use crate::util::memory::OutOfMemory;
use crate::util::threads;

/// A [`Scene`](crate::Scene) as it was committed. It never changes; clones share it.
///
/// Answers are those of the mode `exact` on the corners in world space, as [`Scene`](crate::Scene) defines
/// them: t, u and v are correctly rounded. If two hits have the same t, the lower instance wins, then the
/// lower geometry, then the lower triangle. Hidden instances, and geometries whose mask is 0, are ignored.
#[derive(Clone, Debug)]
pub struct SceneSnapshot {
    committed: Arc<Committed>,
    level: Level,
}

/// The number of rays of a batch that a thread takes at a time.
const PIECE: usize = 1 << 6;

thread_local! {
    /// The thread's stacks, which are kept between queries.
    static SCRATCH: Cell<Option<SceneScratch>> = const { Cell::new(None) };
}

impl SceneSnapshot {
    pub(super) fn new(committed: Committed) -> Self {
        Self { committed: Arc::new(committed), level: Level::best() }
    }

    /// Sets the level of CPU instructions. Answers do not depend on it.
    pub fn at(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// The closest hit.
    pub fn closest(&self, ray: &Ray64) -> Option<SceneHit> {
        let mut closest = Closest { ray, best: None };
        self.trace(ray, Rule::Closed, &mut closest);
        let (_, best) = closest.best?;
        self.hits(ray, &[best]).pop()
    }

    /// Whether anything is hit.
    pub fn any(&self, ray: &Ray64) -> bool {
        let mut any = Any { t_max: ray.t_max, is_hit: false };
        self.trace(ray, Rule::Closed, &mut any);
        any.is_hit
    }

    /// Every hit, by t; if two have the same t, by instance, geometry, and triangle.
    pub fn all(&self, ray: &Ray64) -> Vec<SceneHit> {
        self.all_by(ray, Rule::Closed)
    }

    /// The crossings of a ray with the meshes, sorted like [`SceneSnapshot::all`]; but a point on an edge or
    /// a corner of a mesh belongs to only one of its triangles.
    pub fn crossings(&self, ray: &Ray64) -> Vec<SceneHit> {
        self.all_by(ray, Rule::Once)
    }

    fn all_by(&self, ray: &Ray64, rule: Rule) -> Vec<SceneHit> {
        let mut all = All { t_max: ray.t_max, hits: Vec::new() };
        self.trace(ray, rule, &mut all);
        let mut found = all.hits;
        // Sort by index, then by t with a stable sort.
        found.sort_unstable_by_key(Candidate::key);
        let t: Vec<f64> = found.iter().map(|hit| exact::t(ray, &hit.triangle)).collect();
        let mut order: Vec<usize> = (0..found.len()).collect();
        order.sort_by(|&a, &b| {
            let rounded = t[a].total_cmp(&t[b]);
            rounded.then_with(|| exact::order(ray, &found[a].triangle, &found[b].triangle))
        });
        let sorted: Vec<Candidate> = order.into_iter().map(|i| found[i]).collect();
        self.hits(ray, &sorted)
    }

    /// The hits of triangles that a ray is known to hit.
    fn hits(&self, ray: &Ray64, found: &[Candidate]) -> Vec<SceneHit> {
        let pairs: Vec<_> = found.iter().map(|hit| (ray, &hit.triangle, hit.position)).collect();
        let mut hits = vec![Hit::MISS; found.len()];
        exact::hits64(self.level, &pairs, &mut hits);
        let named = |(mut hit, found): (Hit, &Candidate)| {
            if let Some(entry) = self.committed.mesh(found.instance as usize) {
                entry.mesh.tree().geometries.rename([&mut hit]);
            }
            let leaves = exact::facing(ray, &found.triangle) == Some(Side::Leaves);
            SceneHit { hit, instance: InstanceId(found.instance), leaves }
        };
        hits.into_iter().zip(found).map(named).collect()
    }

    fn trace<C: Collect>(&self, ray: &Ray64, rule: Rule, collect: &mut C) {
        let scene = &*self.committed;
        // Taken out while in use: a query within a query finds none, and creates its own.
        let kept = SCRATCH.try_with(Cell::take).ok().flatten();
        let mut scratch =
            kept.filter(|kept| kept.fits(scene)).unwrap_or_else(|| SceneScratch::new(scene));
        self.level.run(Trace { scene, ray, rule, scratch: &mut scratch, collect });
        // If the thread is about to end, it is not needed any more.
        let _ = SCRATCH.try_with(|last| last.set(Some(scratch)));
    }
}

/// Many rays per call, on all threads; `answers[i]` belongs to `rays[i]`.
impl SceneSnapshot {
    /// [`SceneSnapshot::closest`] for many rays; [`SceneHit::MISS`] for a ray that hits nothing.
    pub fn closest_batch(&self, rays: &[Ray64]) -> Vec<SceneHit> {
        let mut hits = vec![SceneHit::MISS; rays.len()];
        let closest = |i: usize| self.closest(&rays[i]).unwrap_or(SceneHit::MISS);
        threads::write(&mut hits, PIECE, closest);
        hits
    }

    /// [`SceneSnapshot::any`] for many rays.
    pub fn any_batch(&self, rays: &[Ray64]) -> Vec<bool> {
        let mut any = vec![false; rays.len()];
        threads::write(&mut any, PIECE, |i| self.any(&rays[i]));
        any
    }

    /// [`SceneSnapshot::all`] for many rays, in compact arrays.
    ///
    /// # Errors
    /// Fails if there is too little memory for the hits.
    pub fn all_batch(&self, rays: &[Ray64]) -> Result<Lists<SceneHit>, OutOfMemory> {
        self.lists(rays, Rule::Closed)
    }

    /// [`SceneSnapshot::crossings`] for many rays, in compact arrays.
    ///
    /// # Errors
    /// Fails if there is too little memory for the crossings.
    pub fn crossings_batch(&self, rays: &[Ray64]) -> Result<Lists<SceneHit>, OutOfMemory> {
        self.lists(rays, Rule::Once)
    }

    fn lists(&self, rays: &[Ray64], rule: Rule) -> Result<Lists<SceneHit>, OutOfMemory> {
        let mut each = vec![Vec::new(); rays.len()];
        threads::write(&mut each, PIECE, |i| self.all_by(&rays[i], rule));
        let mut lists = Lists { offsets: Vec::new(), items: Vec::new() };
        let count = each.iter().map(Vec::len).sum();
        let no_memory = |_| OutOfMemory;
        lists.offsets.try_reserve_exact(rays.len() + 1).map_err(no_memory)?;
        lists.items.try_reserve_exact(count).map_err(no_memory)?;
        lists.offsets.push(0);
        for hits in each {
            lists.items.extend(hits);
            lists.offsets.push(lists.items.len() as i64);
        }
        Ok(lists)
    }
}
