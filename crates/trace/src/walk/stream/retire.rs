//! Collects the hits of a stream's finished rays until t, u, and v can be computed for eight hits
//! at once.

use intertri::internal::{Pairs, Resolver};
use intertri::simd::Simd;
use intertri::{Hit, Hit32, LeafSlot, Ray, RayId, TriangleId};

use crate::tree::Tree;
use crate::walk::{BatchOutput, HitFormat};

/// The hits of finished rays whose t, u, and v have not been computed yet.
pub(crate) struct Retired<'a> {
    resolver: Resolver<'a>,
    /// The ID of the ray whose result is the first of the output.
    first: RayId,
    pairs: Pairs,
    ids: [(RayId, LeafSlot); 8],
    len: usize,
}

impl<'a> Retired<'a> {
    /// Creates an empty collection.
    pub(crate) fn new(resolver: Resolver<'a>, first: RayId) -> Self {
        Self { resolver, first, pairs: Pairs::new(), ids: Default::default(), len: 0 }
    }

    /// Adds the closest hit of a finished ray.
    #[inline(always)]
    pub(crate) fn retire<S: Simd>(
        &mut self,
        tree: &Tree,
        ray: &Ray,
        id: RayId,
        hit: Option<(TriangleId, LeafSlot)>,
        output: &mut BatchOutput<'_>,
    ) {
        // If the output does not store t, u, and v, or if the ray hits nothing, the result is
        // complete.
        if output.write((id.0 - self.first.0) as usize, hit) {
            return;
        }
        if let Some(hit) = hit
            && self.add(tree, ray, id, hit)
        {
            self.flush::<S>(output);
        }
    }

    /// Adds a hit. Returns whether there is no room for another one.
    #[inline(always)]
    pub(crate) fn add(
        &mut self,
        tree: &Tree,
        ray: &Ray,
        id: RayId,
        (index, slot): (TriangleId, LeafSlot),
    ) -> bool {
        let triangle = tree.triangle_in(slot);
        self.pairs.set(self.len, ray, &triangle, index);
        self.ids[self.len] = (id, slot);
        self.resolver.prefetch((id, slot));
        self.len += 1;
        // Eight pairs fill all lanes: computing t, u, and v for one pair at a time would leave most
        // lanes idle.
        self.len == 8
    }

    /// Computes and writes the hits collected so far.
    #[inline(always)]
    pub(crate) fn flush<S: Simd>(&mut self, output: &mut BatchOutput<'_>) {
        match output {
            BatchOutput::Hits(to) => self.write::<S, Hit>(to),
            BatchOutput::Hits32(to) => self.write::<S, Hit32>(to),
            _ => self.len = 0,
        }
    }

    /// Computes the hits collected so far, and writes each to `to`, at the index of its ray.
    #[inline(always)]
    pub(crate) fn write<S: Simd, H: HitFormat>(&mut self, to: &mut [H]) {
        let Self { resolver, first, ref pairs, ref ids, len } = *self;
        if len > 0 {
            let mut hits = [H::MISS; 8];
            H::met_in::<S>(resolver, (pairs, ids), len, &mut hits);
            for (hit, &(id, _)) in hits[..len].iter().zip(ids) {
                to[(id.0 - first.0) as usize] = *hit;
            }
            self.len = 0;
        }
    }
}
