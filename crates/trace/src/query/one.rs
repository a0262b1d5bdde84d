//! Queries about one ray, compiled here for both tests: what is generic over modes would be compiled again
//! by every crate that calls it.

use intertri::internal::exact::Side;
use intertri::internal::{Test, Which};
use intertri::{Crossing, Hit, Ray};

use crate::place::Place;
use crate::select::Choice;
use crate::single::{All, Closest, Hits, Kept};
use crate::tree::Tree;

/// The same of either test.
macro_rules! of_either {
    ($which:expr, $test:ident => $ask:expr) => {
        match $which {
            Which::Filter($test) => $ask,
            Which::Lanes64($test) => $ask,
        }
    };
}

/// See [`Bvh::closest`](crate::Bvh::closest).
pub(super) fn closest(
    bvh: &Tree,
    choice: &Choice<'_>,
    which: &Which<'_>,
    ray: &Ray,
    kept: &mut Kept,
) -> Option<Hit> {
    let mut hit =
        of_either!(which, test => test.level().run(Hits { bvh, test, ray, choice, kept }))?;
    bvh.geometries.tell(std::slice::from_mut(&mut hit));
    Some(hit)
}

/// The position of the closest hit's triangle in the whole.
pub(super) fn triangle(
    bvh: &Tree,
    choice: &Choice<'_>,
    which: &Which<'_>,
    ray: &Ray,
    kept: &mut Kept,
) -> Option<u32> {
    let choice = (choice, 0);
    let (closest, _) = of_either!(which, test => {
        test.level().run(Closest::<_, false> { bvh, test, ray, choice, kept })
    });
    closest.triangle().map(|(position, _)| position)
}

/// See [`Bvh::any`](crate::Bvh::any).
pub(super) fn any(
    bvh: &Tree,
    choice: &Choice<'_>,
    which: &Which<'_>,
    ray: &Ray,
    kept: &mut Kept,
) -> bool {
    let choice = (choice, 0);
    let (closest, _) = of_either!(which, test => {
        test.level().run(Closest::<_, true> { bvh, test, ray, choice, kept })
    });
    closest.is_hit()
}

/// See [`Bvh::all`](crate::Bvh::all).
pub(super) fn all(
    bvh: &Tree,
    choice: (&Choice<'_>, usize),
    which: &Which<'_>,
    ray: &Ray,
) -> Vec<Hit> {
    let (resolver, number) = (which.resolver(), choice.1 as u32);
    let hit = |place| {
        let (triangle, index) = (bvh.triangle_in(place), bvh.index_of(place));
        (resolver.hit_attributes(ray, &triangle, index, (number, place)), triangle, place)
    };
    let mut hits: Vec<_> = places(bvh, choice, which, ray).into_iter().map(hit).collect();
    hits.sort_unstable_by(|(a, at, one), (b, bt, other)| {
        resolver.first((ray, number), (a, at, *one), (b, bt, *other))
    });
    let mut hits: Vec<Hit> = hits.into_iter().map(|(hit, ..)| hit).collect();
    bvh.geometries.tell(&mut hits);
    hits
}

/// See [`Bvh::crossings`](crate::Bvh::crossings).
pub(super) fn crossings(
    bvh: &Tree,
    choice: &Choice<'_>,
    which: &Which<'_>,
    ray: &Ray,
) -> Vec<Crossing> {
    let resolver = which.resolver();
    let crossed = |place: u32| {
        let (triangle, index) = (bvh.triangle_in(place), bvh.index_of(place));
        let leaves = resolver.crossing(ray, &triangle, (0, place))? == Side::Leaves;
        let hit = resolver.hit_attributes(ray, &triangle, index, (0, place));
        Some((Crossing { hit, leaves }, triangle, place))
    };
    let places = places(bvh, (choice, 0), which, ray);
    let mut all: Vec<_> = places.into_iter().filter_map(crossed).collect();
    all.sort_unstable_by(|(a, at, one), (b, bt, other)| {
        resolver.first((ray, 0), (&a.hit, at, *one), (&b.hit, bt, *other))
    });
    let told = |(mut crossing, ..): (Crossing, _, _)| {
        bvh.geometries.tell(std::slice::from_mut(&mut crossing.hit));
        crossing
    };
    all.into_iter().map(told).collect()
}

/// Where a ray starts that is not on a triangle.
pub(super) fn winding(bvh: &Tree, which: &Which<'_>, ray: &Ray) -> Place {
    let resolver = which.resolver();
    let places = places(bvh, (&None, 0), which, ray);
    let crossed = |&place: &u32| resolver.crossing(ray, &bvh.triangle_in(place), (0, place));
    let sides = places.iter().filter_map(crossed);
    sides.fold(Place::Outside, |place, side| place.crossed(side == Side::Leaves))
}

/// The places of all triangles that a ray hits, in any order.
pub(super) fn places(
    bvh: &Tree,
    choice: (&Choice<'_>, usize),
    which: &Which<'_>,
    ray: &Ray,
) -> Vec<u32> {
    of_either!(*which, test => test.level().run(All { bvh, test, ray, choice }))
}
