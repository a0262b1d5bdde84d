//! Many rays on a grid: tiles whose f32 integers judge, and rays one by one.

use intertri::fixed::{Best, Crossing, Ratio, Ray, Sides};
use intertri::lanes::{Level, Simd};
use intertri::{Certified, Counts, Hit, Judge, Threshold};

use crate::answer::Answer;
use crate::batch::Tracer;
use crate::bvh::Bvh;
use crate::fixed::FixedBvh;
use crate::scratch::Scratch;
use crate::screen::{Screen, shares_origin};
use crate::tile::{self, Pencil, Tiled};

/// A hierarchy over a grid, at the level of a mode.
pub(crate) struct OfGrid<'a> {
    pub(crate) bvh: &'a FixedBvh,
    pub(crate) level: Level,
}

impl Tracer for OfGrid<'_> {
    type Ray = Ray;

    fn level(&self) -> Level {
        self.level
    }

    fn tree(&self) -> &Bvh {
        &self.bvh.tree
    }

    /// What f32 decide of integers that they hold exactly is so, and of the rest the integers are the
    /// judge (`docs/numerics/screen.md`, section 5).
    #[inline(always)]
    fn search<S: Simd, A: Answer>(
        &self,
        (rays, next): (&[Ray], &[Ray]),
        room: (&mut Screen<S>, &mut Scratch),
        counts: &mut Counts,
    ) -> Tiled {
        if !shares_origin(rays) {
            return Tiled::Not;
        }
        let filter = Certified::new(Threshold::ZERO).at(self.level);
        let by = (&filter, &Integers { bvh: self.bvh, rays });
        let tree = &self.bvh.tree;
        tile::search::<S, _, _>(
            tree,
            by,
            &Pencil { rays, next, toward: None },
            A::ANY,
            room,
            counts,
        )
    }

    #[inline(always)]
    fn hits<S: Simd>(&self, rays: &[Ray], tile: &mut Scratch, hits: &mut [Hit]) {
        tile.hits_on_grid::<S>(&self.bvh.tree, rays, hits);
    }

    #[inline(always)]
    fn others<S: Simd, A: Answer>(
        &self,
        rays: &[Ray],
        numbers: &[u32],
        answers: &mut [A],
        _: &mut Counts,
    ) {
        let kept = &mut self.bvh.tree.kept();
        for &number in numbers {
            let ray = &rays[number as usize];
            let mut best = Best::default();
            self.bvh.walk::<S>(ray, kept, !A::ANY, |crossing, index| {
                best.offer(crossing, index);
                if A::ANY { None } else { Some(best.t_hi()) }
            });
            answers[number as usize] = A::of_hit(best.to_hit(ray));
        }
    }
}

/// The integers as the judge of what f32 leave open.
struct Integers<'a> {
    bvh: &'a FixedBvh,
    rays: &'a [Ray],
}

impl Judge for Integers<'_> {
    type T = Ratio;
    type Seen = Sides;

    #[inline(always)]
    fn see(&self, place: u32) -> Sides {
        Sides::new(&self.bvh.triangle_in(place), self.rays[0].origin())
    }

    #[inline(always)]
    fn t(&self, seen: &Sides, ray: usize) -> Ratio {
        seen.crossing(&self.rays[ray]).t
    }

    #[inline(always)]
    fn hit(&self, place: u32, ray: usize) -> Option<Ratio> {
        Crossing::of(&self.rays[ray], &self.bvh.triangle_in(place)).map(|crossing| crossing.t)
    }

    #[inline(always)]
    fn index(&self, place: u32) -> u32 {
        self.bvh.tree.index_of(place)
    }

    #[inline(always)]
    fn rounded(t: Ratio) -> f32 {
        t.to_f64(0) as f32
    }
}
