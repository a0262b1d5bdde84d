//! What users ask: of one point, or of many.

use intertri::Counts;
use intertri::simd::{Level, Simd, WithSimd};

use super::found::{Candidate, ClosestPoint, closest_of};
use super::order::along_curve;
use super::search::Search;
use crate::bvh::Bvh;
use crate::query::chunks;
use crate::single::Kept;
use crate::tree::Tree;

impl Bvh {
    /// The point of the mesh that is closest to a given one, where it is not farther than a radius, which may be
    /// infinite: its [`distance`](ClosestPoint::distance) is compared with that.
    ///
    /// The triangle is truly the closest; of those that are exactly as close, which neighbours often are, the
    /// lowest index. Triangles without an area, or with a corner that is not finite, are not there. A point that
    /// is not finite has no closest one.
    ///
    /// ```
    /// use intertri_trace::{Bvh, intertri::Triangle};
    /// let floor = Triangle::new([-1.0, 0.0, -1.0], [3.0, 0.0, -1.0], [-1.0, 0.0, 3.0]);
    /// let bvh = Bvh::new(&[floor])?;
    /// let closest = bvh.closest_point([0.0, 2.0, 0.0], f64::INFINITY).unwrap();
    /// assert_eq!((closest.distance, closest.point), (2.0, [0.0, 0.0, 0.0]));
    /// assert_eq!((closest.triangle, closest.u, closest.v), (0, 0.25, 0.25));
    /// assert_eq!(bvh.closest_point([0.0, 2.0, 0.0], 1.9), None);
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn closest_point(&self, point: [f32; 3], radius: f64) -> Option<ClosestPoint> {
        let mut answer = [ClosestPoint::NONE];
        closest_points(&self.tree, &[point], radius, &mut answer);
        answer[0].some()
    }

    /// [`Bvh::closest_point`] of many points, on all threads: `closest[i]` becomes that to `points[i]`,
    /// [`ClosestPoint::NONE`] where there is none.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_point_batch(
        &self,
        points: &[[f32; 3]],
        radius: f64,
        closest: &mut [ClosestPoint],
    ) {
        chunks(points, closest, |_, points, closest| {
            closest_points(&self.tree, points, radius, closest);
            Counts::default()
        });
    }
}

/// The closest points of some, on this thread.
fn closest_points(bvh: &Tree, points: &[[f32; 3]], radius: f64, closest: &mut [ClosestPoint]) {
    Level::best().run(Points { bvh, points, radius, closest });
}

struct Points<'a> {
    bvh: &'a Tree,
    points: &'a [[f32; 3]],
    radius: f64,
    closest: &'a mut [ClosestPoint],
}

impl WithSimd for Points<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { bvh, points, radius, closest } = self;
        let mut kept = Kept::lend(bvh);
        let mut candidates: Vec<Candidate> = Vec::new();

        // More than the square of the radius: what is in between is seen when the distance is known.
        let within = radius * radius * (1.0 + 1e-6) + 1e-60;
        let mut likely = None;
        for number in along_curve(bvh, points) {
            let point = points[number as usize];
            let closest = &mut closest[number as usize];
            *closest = ClosestPoint::NONE;
            let is_asked = radius >= 0.0 && point.iter().all(|x| x.is_finite());
            if !is_asked {
                continue;
            }
            let mut search = Search { bvh, point, most: within, candidates: &mut candidates };
            search.run::<S>(likely, &mut kept);
            if let Some((place, found)) = closest_of(bvh, point, &mut candidates)
                && found.distance <= radius
            {
                // The next point is often near.
                likely = Some(place / 8);
                *closest = found;
                (closest.geometry, closest.triangle) = bvh.geometries.name(found.triangle);
            }
        }
    }
}
