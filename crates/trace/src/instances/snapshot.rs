//! Ray queries on a committed scene.

use std::cell::Cell;
use std::sync::Arc;

use intertri::internal::exact::{self, Side};
use intertri::simd::Level;
use intertri::{Counts, Hit, Ray64, Rule};

use super::collect::{All, Any, Candidate, Closest, Collect};
use super::committed::Committed;
use super::hit::{InstanceId, SceneHit};
use super::packet::{TraceSome, patience};
use super::trace::{SceneScratch, Trace};
use crate::batch::{Lists, chunks};
use crate::util::memory::OutOfMemory;
use crate::util::patience::Patience;
use crate::util::threads;
use crate::walk::packet::RAYS;

/// A committed [`Scene`](crate::Scene). It never changes, and clones share its data.
///
/// Results are those of the `exact` mode on the world-space corners defined by
/// [`Scene`](crate::Scene): t, u, and v are correctly rounded. If two hits have the same t, the
/// lower instance number wins, then the lower geometry number, then the lower triangle index.
/// Hidden instances and geometries with mask 0 are ignored; use [`SceneSnapshot::mask`] to ignore
/// others.
#[derive(Clone, Debug)]
pub struct SceneSnapshot {
    pub(super) committed: Arc<Committed>,
    level: Level,
    pub(super) mask: u32,
}

/// The number of rays or points that a thread processes per task.
pub(super) const PIECE: usize = 1 << 6;

thread_local! {
    /// The thread's traversal stacks, kept between queries.
    static SCRATCH: Cell<Option<SceneScratch>> = const { Cell::new(None) };
}

impl SceneSnapshot {
    pub(super) fn new(committed: Committed) -> Self {
        Self { committed: Arc::new(committed), level: Level::best(), mask: u32::MAX }
    }

    /// Sets the instruction set level to use. Results do not depend on it.
    pub fn at(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// Restricts queries to the instances and geometries whose masks
    /// ([`Scene::set_mask`](crate::Scene::set_mask), [`Bvh::set_mask`](crate::Bvh::set_mask)) share
    /// a bit with `mask`.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use intertri_trace::{Bvh, Scene};
    /// use intertri_trace::intertri::{Ray64, Triangle};
    /// const GLASS: u32 = 0b01;
    /// const WALLS: u32 = 0b10;
    /// let pane = Arc::new(Bvh::new(&[Triangle::new([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0])])?);
    /// let at = |z| [1.0, 0.0, 0.0, 0.0, /**/ 0.0, 1.0, 0.0, 0.0, /**/ 0.0, 0.0, 1.0, z];
    /// let mut scene = Scene::new();
    /// let window = scene.add(pane.clone(), at(3.0))?;
    /// let wall = scene.add(pane, at(5.0))?;
    /// scene.set_mask(window, GLASS)?;
    /// scene.set_mask(wall, WALLS)?;
    /// let ray = Ray64::new([0.0, 0.5, 0.0], [0.0, 0.0, 1.0]);
    /// assert_eq!(scene.commit()?.mask(WALLS).closest(&ray).unwrap().instance, wall);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }

    /// Returns the closest hit, if any.
    pub fn closest(&self, ray: &Ray64) -> Option<SceneHit> {
        let mut closest = Closest::of(ray);
        self.trace(ray, Rule::Closed, &mut closest);
        let found = closest.best()?;
        let mut hit = [Hit::MISS];
        exact::hits64(self.level, &[(ray, &found.triangle, found.position)], &mut hit);
        Some(self.named(ray, &found, hit[0]))
    }

    /// Returns whether the ray hits anything.
    pub fn any(&self, ray: &Ray64) -> bool {
        let mut any = Any { t_max: ray.t_max, is_hit: false };
        self.trace(ray, Rule::Closed, &mut any);
        any.is_hit
    }

    /// Returns all hits, sorted by t. Hits with the same t are sorted by instance, then by
    /// geometry, then by triangle.
    pub fn all(&self, ray: &Ray64) -> Vec<SceneHit> {
        self.all_by(ray, Rule::Closed)
    }

    /// Returns the ray's crossings with the meshes, sorted like [`SceneSnapshot::all`]. A crossing
    /// at an edge or corner of a mesh counts for only one of the triangles that share the edge or
    /// corner.
    pub fn crossings(&self, ray: &Ray64) -> Vec<SceneHit> {
        self.all_by(ray, Rule::Once)
    }

    fn all_by(&self, ray: &Ray64, rule: Rule) -> Vec<SceneHit> {
        let mut all = All { t_max: ray.t_max, hits: Vec::new() };
        self.trace(ray, rule, &mut all);
        let mut found = all.hits;
        // Sort by index first, then stably by t.
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

    /// Computes the hits of a ray on triangles that it is known to hit.
    fn hits(&self, ray: &Ray64, found: &[Candidate]) -> Vec<SceneHit> {
        let pairs: Vec<_> = found.iter().map(|hit| (ray, &hit.triangle, hit.position)).collect();
        let mut hits = vec![Hit::MISS; found.len()];
        exact::hits64(self.level, &pairs, &mut hits);
        hits.into_iter().zip(found).map(|(hit, found)| self.named(ray, found, hit)).collect()
    }

    /// Completes a hit: sets the geometry and the triangle's index within it, and adds the
    /// instance.
    fn named(&self, ray: &Ray64, found: &Candidate, mut hit: Hit) -> SceneHit {
        if let Some(entry) = self.committed.mesh(found.instance as usize) {
            entry.mesh.tree().geometries.rename([&mut hit]);
        }
        let leaves = exact::facing(ray, &found.triangle) == Some(Side::Leaves);
        SceneHit { hit, instance: InstanceId(found.instance), leaves }
    }

    pub(super) fn trace(&self, ray: &Ray64, rule: Rule, collect: &mut dyn Collect) {
        let (scene, mask) = (&*self.committed, self.mask);
        self.with_scratch(|scratch| {
            self.level.run(Trace { scene, ray, rule, mask, scratch, collect });
        });
    }

    /// Traces at most [`PIECE`] rays on this thread, together if that is faster. `collect[i]` belongs
    /// to `rays[i]`.
    fn trace_each<C: Collect>(&self, rays: &[Ray64], collect: &mut [C], patience: &mut Patience) {
        let mut collect: Vec<&mut dyn Collect> =
            collect.iter_mut().map(|collect| collect as &mut dyn Collect).collect();
        let (scene, mask, rule) = (&*self.committed, self.mask, Rule::Closed);
        self.with_scratch(|scratch| {
            for (rays, collect) in rays.chunks(RAYS).zip(collect.chunks_mut(RAYS)) {
                let (scratch, patience) = (&mut *scratch, &mut *patience);
                let some = TraceSome { scene, rays, rule, mask, scratch, patience, collect };
                self.level.run(some);
            }
        });
    }

    fn with_scratch(&self, trace: impl FnOnce(&mut SceneScratch)) {
        let scene = &*self.committed;
        // Take the scratch memory out while it is in use. A nested query finds none and creates its
        // own.
        let kept = SCRATCH.try_with(Cell::take).ok().flatten();
        let mut scratch =
            kept.filter(|kept| kept.fits(scene)).unwrap_or_else(|| SceneScratch::new(scene));
        trace(&mut scratch);
        // This call fails if the thread is exiting; the scratch memory is then no longer needed.
        let _ = SCRATCH.try_with(|last| last.set(Some(scratch)));
    }
}

/// Batch queries for many rays, using all threads. Result `i` belongs to `rays[i]`.
impl SceneSnapshot {
    /// Like [`SceneSnapshot::closest`], but for many rays. A ray without a hit yields
    /// [`SceneHit::MISS`].
    pub fn closest_batch(&self, rays: &[Ray64]) -> Vec<SceneHit> {
        let mut hits = vec![SceneHit::MISS; rays.len()];
        self.closest_batch_into(rays, &mut hits);
        hits
    }

    /// Like [`SceneSnapshot::closest_batch`], but writes the hits to a slice.
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    pub fn closest_batch_into(&self, rays: &[Ray64], hits: &mut [SceneHit]) {
        chunks(rays, hits, |rays, hits| {
            let mut patience = patience();
            for (rays, hits) in rays.chunks(PIECE).zip(hits.chunks_mut(PIECE)) {
                self.closest_of(rays, hits, &mut patience);
            }
            Counts::default()
        });
    }

    /// Finds the closest hits of at most [`PIECE`] rays, on this thread.
    fn closest_of(&self, rays: &[Ray64], hits: &mut [SceneHit], patience: &mut Patience) {
        let mut closest: Vec<Closest<'_>> = rays.iter().map(Closest::of).collect();
        self.trace_each(rays, &mut closest, patience);
        let found: Vec<Option<Candidate>> = closest.iter().map(Closest::best).collect();
        // Compute t, u, and v for several rays in SIMD lanes.
        let rays_and_found = || rays.iter().zip(&found).filter_map(|(r, f)| Some((r, f.as_ref()?)));
        let pairs: Vec<_> = rays_and_found().map(|(r, f)| (r, &f.triangle, f.position)).collect();
        let mut numbers = [Hit::MISS; PIECE];
        exact::hits64(self.level, &pairs, &mut numbers[..pairs.len()]);
        let mut named = rays_and_found().zip(numbers).map(|((r, f), hit)| self.named(r, f, hit));
        for (hit, found) in hits.iter_mut().zip(&found) {
            *hit = found.and_then(|_| named.next()).unwrap_or(SceneHit::MISS);
        }
    }

    /// Like [`SceneSnapshot::any`], but for many rays.
    pub fn any_batch(&self, rays: &[Ray64]) -> Vec<bool> {
        let mut any = vec![false; rays.len()];
        self.any_batch_into(rays, &mut any);
        any
    }

    /// Like [`SceneSnapshot::any_batch`], but writes the results to a slice.
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    pub fn any_batch_into(&self, rays: &[Ray64], any: &mut [bool]) {
        chunks(rays, any, |rays, any| {
            let mut patience = patience();
            for (rays, any) in rays.chunks(PIECE).zip(any.chunks_mut(PIECE)) {
                let start = rays.iter().map(|ray| Any { t_max: ray.t_max, is_hit: false });
                let mut found: Vec<Any> = start.collect();
                self.trace_each(rays, &mut found, &mut patience);
                any.iter_mut().zip(found).for_each(|(any, found)| *any = found.is_hit);
            }
            Counts::default()
        });
    }

    /// Like [`SceneSnapshot::all`], but for many rays. Returns the hits in compact arrays.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    pub fn all_batch(&self, rays: &[Ray64]) -> Result<Lists<SceneHit>, OutOfMemory> {
        self.lists(rays, Rule::Closed)
    }

    /// Like [`SceneSnapshot::crossings`], but for many rays. Returns the crossings in compact
    /// arrays.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
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
