//! Settles the ray-triangle pairs that the f32 filter leaves undecided.
//!
//! ```text
//!   filter (f32 lanes) ──► certain miss       nearly all pairs
//!                     ├──► certain hit        its t is in an f32 interval
//!                     └──► undecided ──► Resolver ──► document   the f64 operations of document A
//!                                                ├──► exact      f64 with a bound, or integers
//!                                                └──► originals  the same, for the f64 originals
//! ```
//!
//! Modes differ only in their resolvers: the filter and the traversal of a BVH are the same for all
//! modes. The resolver is called rarely and out of line.

mod exact;
mod originals;
mod several;
mod shared_origin;

pub use originals::Originals;
pub(crate) use several::SEVERAL;
pub use shared_origin::SharedOrigin;

use core::cmp::Ordering;

use crate::exact::{PairDecision, Rule, Side};
use crate::hit_attributes::Pairs;
use crate::simd::Simd;
use crate::{Hit, Hit32, LeafSlot, Ray, RayId, Triangle, TriangleId, document};

/// Decides the pairs that the filter leaves undecided.
#[derive(Clone, Copy, Debug)]
pub enum Resolver<'a> {
    /// The operations of document A in f64, with this threshold.
    Document(f64),
    /// Exact arithmetic on the given coordinates. The rule determines which triangles own a shared
    /// edge or corner.
    Exact(Rule),
    /// Exact arithmetic on the f64 originals, for a filter that tests their f32 copies.
    Originals(&'a dyn Originals),
}

impl<'a> Resolver<'a> {
    /// Returns whether every hit is on its triangle. Exact resolvers guarantee this; the document's
    /// rounded operations may report a hit just outside its triangle.
    #[inline]
    pub fn hits_lie_on_triangles(self) -> bool {
        !matches!(self, Self::Document(_))
    }

    /// Returns the memory to prefetch while `count` rays, starting with `ray`, are traced: the
    /// `next` rays or, if rays are copies, their originals.
    #[inline]
    pub fn memory_after<'b>(self, (ray, count): (RayId, usize), next: &'b [Ray]) -> &'b [u8]
    where
        'a: 'b,
    {
        match self {
            Self::Originals(originals) => originals.later(ray, count),
            _ => bytemuck::cast_slice(&next[..next.len().min(count)]),
        }
    }

    /// Prefetches the memory that a query about a pair will read. Only originals are prefetched,
    /// because everything else is already loaded.
    #[inline(always)]
    pub fn prefetch(self, (id, slot): (RayId, LeafSlot)) {
        if let Self::Originals(originals) = self {
            originals.prefetch(id, slot);
        }
    }

    /// Decides a pair. This is much faster than [`Resolver::hit`], which computes t exactly.
    #[cold]
    #[inline(never)]
    pub fn decide(
        self,
        ray: &Ray,
        triangle: &Triangle,
        (id, slot): (RayId, LeafSlot),
    ) -> PairDecision {
        match self {
            Self::Document(threshold) => document::hit(ray, triangle, threshold)
                .map_or(PairDecision::Miss, PairDecision::HitAt),
            Self::Exact(rule) => crate::exact::decide_pair(rule, ray, triangle),
            Self::Originals(originals) => originals.decide(id, slot),
        }
    }

    /// Returns whether the ray hits the triangle within its interval. This is faster than
    /// [`Resolver::hit`] if you do not need t.
    #[cold]
    #[inline(never)]
    pub fn meets(self, ray: &Ray, triangle: &Triangle, ids: (RayId, LeafSlot)) -> bool {
        self.decide(ray, triangle, ids) != PairDecision::Miss
    }

    /// Returns the t of the hit, rounded to f64, if the ray hits the triangle within its interval.
    #[cold]
    #[inline(never)]
    pub fn hit(self, ray: &Ray, triangle: &Triangle, ids: (RayId, LeafSlot)) -> Option<f64> {
        match self.decide(ray, triangle, ids) {
            PairDecision::Miss => None,
            PairDecision::Hit { .. } => Some(self.t(ray, triangle, ids)),
            PairDecision::HitAt(t) => Some(t),
        }
    }

    /// Returns the t of a hit, rounded to f64. The ray must be known to hit the triangle.
    #[inline(never)]
    pub fn t(self, ray: &Ray, triangle: &Triangle, (id, slot): (RayId, LeafSlot)) -> f64 {
        match self {
            Self::Document(_) => document::t(ray, triangle),
            Self::Exact(_) => exact::t(ray, triangle),
            Self::Originals(originals) => originals.t(id, slot),
        }
    }

    /// Returns the side from which a ray crosses a triangle that it is known to hit, under the
    /// *once* rule: each point of a mesh belongs to only one of its triangles. Returns `None` if
    /// the point belongs to another triangle. The result is always exact.
    #[inline(never)]
    pub fn crossing(
        self,
        ray: &Ray,
        triangle: &Triangle,
        (id, slot): (RayId, LeafSlot),
    ) -> Option<Side> {
        match self {
            Self::Originals(originals) => originals.crossing(id, slot),
            // The document has no rule for shared edges, so its modes also count crossings by exact
            // signs.
            _ => crate::exact::crossing(ray, triangle),
        }
    }

    /// Determines exactly whether a ray starts on a triangle.
    #[inline(never)]
    pub fn starts_on(self, ray: &Ray, triangle: &Triangle, (id, slot): (RayId, LeafSlot)) -> bool {
        match self {
            Self::Originals(originals) => originals.starts_on(id, slot),
            _ => crate::exact::is_on(triangle, ray.origin),
        }
    }

    /// Determines exactly whether a ray crosses a triangle's plane in the direction of the normal
    /// or against it. Returns `None` if the ray is parallel to the plane.
    #[inline(never)]
    pub fn facing(
        self,
        ray: &Ray,
        triangle: &Triangle,
        (id, slot): (RayId, LeafSlot),
    ) -> Option<Side> {
        match self {
            Self::Originals(originals) => originals.facing(id, slot),
            _ => crate::exact::facing(ray, triangle),
        }
    }

    /// Returns which of two triangles the ray hits first if both values of t round to the same f64.
    /// For the document, the rounded t is the only t, so the result is `Equal`.
    #[cold]
    #[inline(never)]
    pub fn order(
        self,
        ray: &Ray,
        [a, b]: [&Triangle; 2],
        (id, [one, other]): (RayId, [LeafSlot; 2]),
    ) -> Ordering {
        match self {
            Self::Document(_) => Ordering::Equal,
            Self::Exact(_) => exact::order(ray, a, b),
            Self::Originals(originals) => originals.order(id, one, other),
        }
    }

    /// Returns which of two triangles the ray hits first, if their coordinates alone tell: both are
    /// perpendicular to the same axis, or both have the same corners. This is much faster than
    /// computing t. If the ray misses one of the triangles, the result is meaningless. A resolver
    /// that orders hits by a rounded t returns `None`.
    #[inline(always)]
    pub fn order_by_coordinates(
        self,
        pair: impl FnOnce() -> (Ray, [Triangle; 2]),
        (id, [one, other]): (RayId, [LeafSlot; 2]),
    ) -> Option<Ordering> {
        match self {
            Self::Exact(_) => {
                let (ray, [a, b]) = pair();
                exact::order_by_coordinates(&ray, &a, &b)
            }
            Self::Originals(originals) => originals.order_by_coordinates(id, one, other),
            Self::Document(_) => None,
        }
    }

    /// Returns which of two triangles the ray hits first, if that is known without an exact t: because
    /// of their coordinates, because the ray meets them where they touch, or because bounds on both
    /// values of t do not overlap. If the ray misses one of the triangles, the result is meaningless.
    #[inline(always)]
    pub fn known_order(
        self,
        pair: impl FnOnce() -> (Ray, [Triangle; 2]),
        (id, [one, other]): (RayId, [LeafSlot; 2]),
    ) -> Option<Ordering> {
        match self {
            Self::Exact(_) => {
                // Only this resolver needs the triangles themselves; the others never load them.
                let (ray, [a, b]) = pair();
                exact::known_order(&ray, &a, &b)
            }
            Self::Originals(originals) => originals.known_order(id, one, other),
            Self::Document(_) => None,
        }
    }

    /// Returns whether the corner or the edge on which a ray meets one triangle also belongs to the
    /// other. `edges` tells on which edges the ray meets the first one ([`PairDecision::Hit`]).
    #[inline(always)]
    pub fn shares_feature(
        self,
        pair: impl FnOnce() -> [Triangle; 2],
        edges: u8,
        (ray, [one, other]): (RayId, [LeafSlot; 2]),
    ) -> bool {
        match self {
            Self::Exact(_) => {
                let [one, other] = pair();
                crate::exact::shares_feature(&one, edges, &other)
            }
            Self::Originals(originals) => originals.shares_feature(ray, (one, edges), other),
            Self::Document(_) => false,
        }
    }

    /// Computes the values of a triangle that rays from one origin share. They determine which of
    /// two triangles comes first.
    #[inline(always)]
    pub fn shared_origin(
        self,
        triangle: &Triangle,
        origin: [f32; 3],
        (id, slot): (RayId, LeafSlot),
    ) -> SharedOrigin<'a> {
        match self {
            Self::Document(_) => SharedOrigin::document(triangle, origin),
            Self::Exact(_) => {
                SharedOrigin::Exact(crate::exact::SeenPlane::new(triangle, origin), *triangle)
            }
            Self::Originals(originals) => {
                SharedOrigin::Originals(originals.plane(id, slot), originals, slot)
            }
        }
    }

    /// Computes where a ray meets a triangle that it is known to hit.
    #[inline(always)]
    pub fn hit_attributes(
        self,
        ray: &Ray,
        triangle: &Triangle,
        triangle_id: TriangleId,
        (id, slot): (RayId, LeafSlot),
    ) -> Hit {
        match self {
            Self::Document(_) => crate::hit_attributes::of_pair(ray, triangle, triangle_id),
            Self::Exact(_) => exact::hit_attributes(ray, triangle, triangle_id),
            Self::Originals(originals) => originals.hit_attributes(id, slot),
        }
    }

    /// Like [`Resolver::hit_attributes`], but in f32.
    #[inline(always)]
    pub fn hit32(
        self,
        ray: &Ray,
        triangle: &Triangle,
        triangle_id: TriangleId,
        (id, slot): (RayId, LeafSlot),
    ) -> Hit32 {
        match self {
            Self::Document(_) => self.hit_attributes(ray, triangle, triangle_id, (id, slot)).into(),
            Self::Exact(_) => crate::exact::hit32_alone(ray, triangle, triangle_id.0),
            Self::Originals(originals) => {
                originals.hit32(&originals.hit_attributes(id, slot), id, slot)
            }
        }
    }

    /// Computes where rays meet triangles that they are known to hit, for the first `len` of eight
    /// pairs.
    #[inline(always)]
    pub fn hits_in<S: Simd>(
        self,
        pairs: &Pairs,
        ids: &[(RayId, LeafSlot); 8],
        len: usize,
    ) -> [Hit; 8] {
        // Keep this out of line: it has many callers and is called once per eight hits.
        S::vectorize(
            #[inline(always)]
            || match self {
                Self::Exact(_) => crate::exact::hits_in::<S>(pairs, len),
                Self::Originals(originals) => {
                    let mut hits = [Hit::MISS; 8];
                    originals.hits(&ids[..len], &mut hits);
                    hits
                }
                Self::Document(_) => pairs.hits_in::<S>(),
            },
        )
    }

    /// Like [`Resolver::hits_in`], but in f32. Writes to `hits32`, because returning the hits would
    /// copy them.
    #[inline(always)]
    pub fn hits32_in<S: Simd>(
        self,
        pairs: &Pairs,
        ids: &[(RayId, LeafSlot); 8],
        len: usize,
        hits32: &mut [Hit32; 8],
    ) {
        S::vectorize(
            #[inline(always)]
            || match self {
                Self::Exact(_) => crate::exact::hits32_in::<S>(pairs, len, hits32),
                Self::Originals(originals) => {
                    let mut hits = [Hit::MISS; 8];
                    originals.hits(&ids[..len], &mut hits);
                    for ((to, hit), &(id, slot)) in hits32.iter_mut().zip(&hits).zip(&ids[..len]) {
                        *to = originals.hit32(hit, id, slot);
                    }
                }
                Self::Document(_) => *hits32 = pairs.hits_in::<S>().map(Hit32::from),
            },
        );
    }
}

/// Sorts the hits of a ray by t, and those with the same t by index. `order` returns which of two hits
/// comes first if both values of t round to the same f64.
///
/// ```
/// use core::cmp::Ordering;
/// use intertri::Hit;
/// use intertri::internal::sort_hits;
/// let mut hits = [(2.0, 0), (1.0, 3), (1.0, 1), (1.0, 2)]
///     .map(|(t, triangle)| Hit { t, u: 0.0, v: 0.0, triangle, geometry: 0 });
/// // The exact t of triangle 3 is a little smaller than the others.
/// let order = |a: &Hit, b: &Hit| (a.triangle != 3).cmp(&(b.triangle != 3));
/// sort_hits(&mut hits, |hit| hit, order);
/// assert_eq!(hits.map(|hit| hit.triangle), [3, 1, 2, 0]);
/// ```
#[inline]
pub fn sort_hits<T>(hits: &mut [T], hit: impl Fn(&T) -> &Hit, order: impl Fn(&T, &T) -> Ordering) {
    hits.sort_unstable_by(|a, b| {
        let (a, b) = (hit(a), hit(b));
        a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle))
    });
    for tied in hits.chunk_by_mut(|a, b| hit(a).t == hit(b).t) {
        // Exact values nearly always are equal if rounded ones are: where triangles meet. The hits are
        // then in order already, which neighbours tell.
        if !tied.is_sorted_by(|a, b| order(a, b).is_le()) {
            tied.sort_unstable_by(|a, b| order(a, b).then(hit(a).triangle.cmp(&hit(b).triangle)));
        }
    }
}
