//! Closest-point queries for single points and batches.

use intertri::Counts;

use super::Bvh;
use crate::batch::chunks;
use crate::nearest::ClosestPoint;
use crate::scalar::BvhScalar;

impl<S: BvhScalar> Bvh<S> {
    /// Returns the closest point on the mesh to a given point, or `None` if its
    /// [`distance`](ClosestPoint::distance) exceeds `radius`, which may be infinite. A negative or
    /// NaN radius yields `None`. Geometry masks have no effect.
    ///
    /// The returned triangle is the closest one in exact arithmetic. If several triangles are
    /// equally close, as neighbours often are, the lowest index wins. A triangle with zero area
    /// counts as the segment or point that its corners span. Triangles with a non-finite corner are
    /// ignored, and a non-finite point has no closest point.
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
    pub fn closest_point(&self, point: [S; 3], radius: f64) -> Option<ClosestPoint> {
        let mut answer = [ClosestPoint::NONE];
        S::closest_points(&self.tree, &self.originals, &[point], radius, &mut answer);
        answer[0].some()
    }

    /// Calls [`Bvh::closest_point`] for many points, using all threads. A point without a closest
    /// point yields [`ClosestPoint::NONE`].
    pub fn closest_point_batch(&self, points: &[[S; 3]], radius: f64) -> Vec<ClosestPoint> {
        let mut closest = vec![ClosestPoint::NONE; points.len()];
        self.closest_point_batch_into(points, radius, &mut closest);
        closest
    }

    /// Like [`Bvh::closest_point_batch`], but writes the results to a slice.
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    pub fn closest_point_batch_into(
        &self,
        points: &[[S; 3]],
        radius: f64,
        closest: &mut [ClosestPoint],
    ) {
        chunks(points, closest, |points, closest| {
            S::closest_points(&self.tree, &self.originals, points, radius, closest);
            Counts::default()
        });
    }
}
