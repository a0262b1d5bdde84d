//! The output of tracing many rays: closest hits, closest triangles, whether rays hit anything, or
//! all hits.

use intertri::internal::{Pairs, Resolver, prefetch};
use intertri::simd::Simd;
use intertri::{Crossings, Hit, Hit32, LeafSlot, Ray, RayId, TriangleId};

use super::HitPairs;
use crate::containment::Containment;
use crate::tree::{MeshTriangle, NamesTriangle, Tree};

/// The results of tracing rays: a slice with one result per ray, or a list of hits.
pub enum BatchOutput<'a> {
    /// The closest hits.
    Hits(&'a mut [Hit]),
    /// The closest hits in f32.
    Hits32(&'a mut [Hit32]),
    /// The triangles of the closest hits. Until they are renamed, they are identified by their
    /// positions among the triangles of all meshes.
    Triangles(&'a mut [MeshTriangle]),
    /// Whether rays hit anything.
    Any(&'a mut [bool]),
    /// All hits.
    Pairs(&'a mut HitPairs),
    /// The numbers of crossings.
    Crossings(&'a mut [Crossings]),
    /// The containments of the rays' origins.
    Containments(&'a mut [Containment]),
}

impl BatchOutput<'_> {
    /// Returns whether any hit is enough, instead of the closest hit or all hits.
    #[inline(always)]
    pub(crate) fn any(&self) -> bool {
        matches!(self, Self::Any(_))
    }

    /// Returns whether all hits are needed, rather than the closest hit or any hit.
    #[inline(always)]
    pub(crate) fn every(&self) -> bool {
        matches!(self, Self::Pairs(_) | Self::Crossings(_) | Self::Containments(_))
    }

    /// Returns the output for a range of rays.
    #[inline(always)]
    pub(crate) fn part(&mut self, from: usize, to: usize) -> BatchOutput<'_> {
        match self {
            Self::Hits(hits) => BatchOutput::Hits(&mut hits[from..to]),
            Self::Hits32(hits) => BatchOutput::Hits32(&mut hits[from..to]),
            Self::Triangles(triangles) => BatchOutput::Triangles(&mut triangles[from..to]),
            Self::Any(any) => BatchOutput::Any(&mut any[from..to]),
            Self::Pairs(pairs) => BatchOutput::Pairs(pairs),
            Self::Crossings(crossings) => BatchOutput::Crossings(&mut crossings[from..to]),
            Self::Containments(all) => BatchOutput::Containments(&mut all[from..to]),
        }
    }

    /// Prefetches the memory of a result, which is rarely in the cache.
    #[inline(always)]
    pub(crate) fn prefetch(&self, ray: usize) {
        match self {
            Self::Hits(hits) => prefetch(&hits[ray..][..1]),
            Self::Hits32(hits) => prefetch(&hits[ray..][..1]),
            Self::Triangles(triangles) => prefetch(&triangles[ray..][..1]),
            Self::Any(any) => prefetch(&any[ray..][..1]),
            Self::Pairs(_) => (),
            Self::Crossings(crossings) => prefetch(&crossings[ray..][..1]),
            Self::Containments(all) => prefetch(&all[ray..][..1]),
        }
    }

    /// Writes the result of a ray, unless t and the weights must still be computed for it. Returns
    /// whether it was written.
    #[inline(always)]
    pub(crate) fn write(&mut self, ray: usize, hit: Option<(TriangleId, LeafSlot)>) -> bool {
        match self {
            Self::Hits(hits) => {
                // t, u, and v are not known yet: they are computed eight hits at a time.
                if hit.is_some() {
                    return false;
                }
                hits[ray] = Hit::MISS;
            }
            Self::Hits32(hits) => {
                if hit.is_some() {
                    return false;
                }
                hits[ray] = Hit32::MISS;
            }
            Self::Triangles(triangles) => {
                let position = hit.map_or(TriangleId::NONE, |(position, _)| position);
                // For now, store the position among the triangles of all meshes. `rename` later
                // converts it to a geometry and an index.
                triangles[ray] = MeshTriangle { triangle: position.0, geometry: 0 };
            }
            Self::Any(any) => any[ray] = hit.is_some(),
            Self::Pairs(_) | Self::Crossings(_) | Self::Containments(_) => (),
        }
        true
    }

    /// Replaces the overall positions of triangles with their geometries and indices.
    pub(crate) fn rename(self, tree: &Tree) {
        match self {
            Self::Hits(hits) => tree.geometries.rename(hits),
            Self::Hits32(hits) => tree.geometries.rename(hits),
            Self::Triangles(triangles) => tree.geometries.rename(triangles),
            _ => (),
        }
    }
}

/// A hit in the format in which a query returns it: with t, u, and v in f64 or in f32.
pub(crate) trait HitFormat: Copy + NamesTriangle {
    const MISS: Self;

    /// Computes the hit of a ray on the triangle in a slot.
    fn met_alone(tree: &Tree, resolver: Resolver<'_>, ray: &Ray, ids: (RayId, LeafSlot)) -> Self;

    /// Writes the hits of the first `len` of eight pairs.
    fn met_in<S: Simd>(
        resolver: Resolver<'_>,
        pairs: (&Pairs, &[(RayId, LeafSlot); 8]),
        len: usize,
        hits: &mut [Self; 8],
    );
}

impl HitFormat for Hit {
    const MISS: Self = Self::MISS;

    fn met_alone(tree: &Tree, resolver: Resolver<'_>, ray: &Ray, ids: (RayId, LeafSlot)) -> Self {
        let (triangle, index) = (tree.triangle_in(ids.1), tree.index_of(ids.1));
        resolver.hit_attributes(ray, &triangle, index, ids)
    }

    #[inline(always)]
    fn met_in<S: Simd>(
        resolver: Resolver<'_>,
        (pairs, ids): (&Pairs, &[(RayId, LeafSlot); 8]),
        len: usize,
        hits: &mut [Self; 8],
    ) {
        *hits = resolver.hits_in::<S>(pairs, ids, len);
    }
}

impl HitFormat for Hit32 {
    const MISS: Self = Self::MISS;

    fn met_alone(tree: &Tree, resolver: Resolver<'_>, ray: &Ray, ids: (RayId, LeafSlot)) -> Self {
        let (triangle, index) = (tree.triangle_in(ids.1), tree.index_of(ids.1));
        resolver.hit32(ray, &triangle, index, ids)
    }

    #[inline(always)]
    fn met_in<S: Simd>(
        resolver: Resolver<'_>,
        (pairs, ids): (&Pairs, &[(RayId, LeafSlot); 8]),
        len: usize,
        hits: &mut [Self; 8],
    ) {
        resolver.hits32_in::<S>(pairs, ids, len, hits);
    }
}
