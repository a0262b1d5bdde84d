//! Which triangles count: asked where lanes that may be hits are offered, so that the walk knows nothing of it.

use std::fmt;

use intertri::internal::Resolver;
use intertri::internal::exact::Side;
use intertri::simd::Simd;
use intertri::{ClosestHit, Counts, Hit, LaneQueries, PreparedRay, Ray};

use crate::tree::{Leaf, Tree};

/// Which side of a triangle counts.
///
/// A triangle is met from its front where the ray runs against its normal: from there its corners run
/// counter-clockwise. The sign of the direction along the normal decides, exactly and in every mode; where
/// that is 0 neither side is met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Faces {
    /// Either side.
    #[default]
    Both,
    /// The front alone: back faces are culled.
    Front,
    /// The back alone: front faces are culled.
    Back,
}

/// Which triangles count in a query by [`Bvh::only`](crate::Bvh::only); by default all.
///
/// ```
/// use intertri_trace::intertri::{Exact, Ray, Triangle};
/// use intertri_trace::{Bvh, Faces, Select};
/// // Two walls whose corners run clockwise, and counter-clockwise, as the ray sees them.
/// let back = Triangle::new([0.0, 0.0, 3.0], [1.0, 0.0, 3.0], [0.0, 1.0, 3.0]);
/// let front = Triangle::new([0.0, 0.0, 5.0], [0.0, 1.0, 5.0], [1.0, 0.0, 5.0]);
/// let (bvh, mode) = (Bvh::new(&[back, front])?, Exact::default());
/// let ray = Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]);
/// let first = bvh.closest(&mode, &ray).unwrap();
/// assert_eq!(first.triangle, 0);
///
/// let culled = Select { faces: Faces::Front, ..Select::default() };
/// assert_eq!(bvh.only(&culled).closest(&mode, &ray).unwrap().triangle, 1);
/// // All but what was hit so far.
/// let others = Select { skip: &[&[first]], ..Select::default() };
/// assert_eq!(bvh.only(&others).closest(&mode, &ray).unwrap().triangle, 1);
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Select<'a> {
    /// A geometry counts where this and its own mask ([`Bvh::set_mask`](crate::Bvh::set_mask)) have a bit in common. The mask is the
    /// query's: rays stay the eight numbers that they are in files and arrays.
    pub mask: u32,
    /// Which side of a triangle counts.
    pub faces: Faces,
    /// What each ray skips, such as what it leaves: the triangles of a list of hits for each ray of the query,
    /// by [`Hit::geometry`] and [`Hit::triangle`]. A miss skips nothing, and without lists nobody does.
    pub skip: &'a [&'a [Hit]],
}

impl Select<'_> {
    /// All triangles.
    pub const ALL: Select<'static> = Select { mask: u32::MAX, faces: Faces::Both, skip: &[] };
}

impl Default for Select<'_> {
    fn default() -> Self {
        Self::ALL
    }
}

/// What is left of the choice in a walk: nothing, where all triangles count.
pub(crate) type Choice<'a> = Option<Filtered<'a>>;

/// Whether a triangle counts for a ray, by the ray's number in the query and the triangle's place in the leaves.
pub(crate) type Predicate<'a> = &'a (dyn Fn(usize, u32) -> bool + Sync);

/// A choice, and a predicate that triangles have to meet besides.
#[derive(Clone, Copy)]
pub(crate) struct Filtered<'a> {
    select: Select<'a>,
    predicate: Option<Predicate<'a>>,
    /// The number in the query of the first ray of the walk.
    first: usize,
}

impl fmt::Debug for Filtered<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.select.fmt(f)
    }
}

impl<'a> Select<'a> {
    /// What a walk has to ask about.
    #[inline(always)]
    pub(crate) fn of(self, bvh: &Tree) -> Choice<'a> {
        let all = self.faces == Faces::Both && self.skip.is_empty();
        if all && bvh.geometries.all_have(self.mask) {
            None
        } else {
            Some(Filtered { select: self, predicate: None, first: 0 })
        }
    }

    /// The choice with a predicate.
    pub(crate) fn filtered(self, predicate: Predicate<'a>) -> Filtered<'a> {
        Filtered { select: self, predicate: Some(predicate), first: 0 }
    }
}

impl Filtered<'_> {
    /// The choice for some of the query's rays.
    pub(crate) fn part(self, from: usize, to: usize) -> Self {
        let Self { mut select, first, .. } = self;
        if !select.skip.is_empty() {
            select.skip = &select.skip[from..to];
        }
        Self { select, first: first + from, ..self }
    }

    /// Offers the triangles of a leaf that count to the closest hit of a ray. In a frame of its own, so that
    /// the walk without a choice keeps its registers.
    #[inline(always)]
    pub(crate) fn closest_in<S: Simd, T: LaneQueries>(
        &self,
        bvh: &Tree,
        test: T,
        ray: &PreparedRay<T>,
        leaf: usize,
        closest: &mut ClosestHit,
        counts: &mut Counts,
    ) {
        S::vectorize(
            #[inline(always)]
            || {
                let Leaf { block, indices } = &bvh.leaves[leaf];
                let find = |place| bvh.triangle_in(place);
                let numbered = (ray.number() as usize, ray.ray());
                let keep = |lanes| self.keep(bvh, numbered, leaf, lanes, test.resolver());
                let place = 8 * leaf as u32;
                test.closest_among_in::<S>(ray, block, indices, place, find, keep, closest, counts);
            },
        );
    }

    /// The lanes of a leaf that count, of those that may be hits of a ray, which is the `number`-th of the query.
    #[inline(never)]
    pub(crate) fn keep(
        &self,
        bvh: &Tree,
        (number, ray): (usize, &Ray),
        leaf: usize,
        lanes: u32,
        resolver: Resolver<'_>,
    ) -> u32 {
        let skipped = self.select.skip.get(number).copied().unwrap_or(&[]);
        let counts = |lane: &u32| {
            let position = bvh.leaves[leaf].indices[*lane as usize];
            let place = 8 * leaf as u32 + lane;
            bvh.geometries.mask_of(position) & self.select.mask != 0
                && !is_among(bvh, skipped, position)
                && self.faces_count(resolver, bvh, (ray, number as u32), place)
                && self.predicate.is_none_or(|predicate| predicate(self.first + number, place))
        };
        let listed = (0..8_u32).filter(|lane| lanes >> lane & 1 != 0);
        listed.filter(counts).map(|lane| 1 << lane).sum()
    }

    /// Whether the side from which a ray comes counts.
    fn faces_count(
        &self,
        resolver: Resolver<'_>,
        bvh: &Tree,
        (ray, number): (&Ray, u32),
        place: u32,
    ) -> bool {
        let side = match self.select.faces {
            Faces::Both => return true,
            Faces::Front => Side::Enters,
            Faces::Back => Side::Leaves,
        };
        resolver.facing(ray, &bvh.triangle_in(place), (number, place)) == Some(side)
    }
}

/// Whether a triangle is one of those that were hit.
fn is_among(bvh: &Tree, hits: &[Hit], position: u32) -> bool {
    let name = bvh.geometries.name(position);
    !hits.is_empty() && hits.iter().any(|hit| (hit.geometry, hit.triangle) == name)
}

/// The lanes of a leaf that count, of those that may be hits.
#[inline(always)]
pub(crate) fn chosen(
    choice: &Choice<'_>,
    bvh: &Tree,
    ray: (usize, &Ray),
    leaf: usize,
    lanes: u32,
    resolver: Resolver<'_>,
) -> u32 {
    match choice {
        None => lanes,
        Some(select) => select.keep(bvh, ray, leaf, lanes, resolver),
    }
}
