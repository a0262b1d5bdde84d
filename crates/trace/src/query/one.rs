//! Queries about one ray, compiled here for both tests: what is generic over modes would be compiled again
//! by every crate that calls it.

use intertri::internal::{Test, Which};
use intertri::{Counts, Hit, Ray};

use crate::select::Choice;
use crate::single::{All, Closest, Hits, Kept};
use crate::tree::Bvh;

/// The same of either test.
macro_rules! of_either {
    ($which:expr, $test:ident => $ask:expr) => {
        match $which {
            Which::Filter($test) => $ask,
            Which::Lanes64($test) => $ask,
        }
    };
}

/// See [`Bvh::closest`].
pub(super) fn closest(bvh: &Bvh, choice: &Choice<'_>, which: Which, ray: &Ray) -> Option<Hit> {
    let mut hit = of_either!(which, test => test.level().run(Hits { bvh, test, ray, choice }))?;
    bvh.geometries.tell(std::slice::from_mut(&mut hit));
    Some(hit)
}

/// See [`Bvh::any`].
pub(super) fn any(bvh: &Bvh, choice: &Choice<'_>, which: Which, ray: &Ray) -> bool {
    let (kept, counts) = (&mut *Kept::lend(bvh), &mut Counts::default());
    let choice = (choice, 0);
    let closest = of_either!(which, test => {
        test.level().run(Closest::<_, true> { bvh, test, ray, choice, kept, counts })
    });
    closest.is_hit()
}

/// See [`Bvh::all`].
pub(super) fn all(bvh: &Bvh, choice: (&Choice<'_>, usize), which: Which, ray: &Ray) -> Vec<Hit> {
    let resolver = which.resolver();
    let hit = |place| {
        let triangle = bvh.triangle_in(place);
        (resolver.hit_attributes(ray, &triangle, bvh.index_of(place)), triangle)
    };
    let mut hits: Vec<_> = places(bvh, choice, which, ray).into_iter().map(hit).collect();
    hits.sort_unstable_by(|(a, at), (b, bt)| resolver.first(ray, (a, at), (b, bt)));
    let mut hits: Vec<Hit> = hits.into_iter().map(|(hit, _)| hit).collect();
    bvh.geometries.tell(&mut hits);
    hits
}

/// The places of all triangles that a ray hits, in any order.
pub(super) fn places(bvh: &Bvh, choice: (&Choice<'_>, usize), which: Which, ray: &Ray) -> Vec<u32> {
    of_either!(which, test => test.level().run(All { bvh, test, ray, choice }))
}
