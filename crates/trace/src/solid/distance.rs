//! Signed distances: the distance from a point to the mesh, negative if the point is inside.

use intertri::internal::Bits;

use super::Solid;
use super::classify::classify_batch;
use crate::containment::Containment;
use crate::nearest::ClosestPoint;
use crate::scalar::BvhScalar;
use crate::util::memory::filled;

/// The number of points to process at once, small enough to keep temporary memory small.
const SLAB: usize = 1 << 16;

impl<S: BvhScalar> Solid<S> {
    /// Returns the distance from a point to the mesh: negative inside, 0 on a triangle, and
    /// positive outside. The sign follows [`Solid::classify`], and the distance is
    /// [`ClosestPoint::distance`], which also considers triangles with zero area. The result is NaN
    /// if the point is not finite and infinite if there are no triangles.
    ///
    /// ```
    /// use intertri_trace::{Solid, intertri::Triangle};
    /// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    /// let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
    /// let solid = Solid::new(&faces)?;
    /// let points = [[0.5, 1.0, 1.0], [-3.0, 1.0, -4.0], [1.0, 1.0, 2.0]];
    /// assert_eq!(points.map(|point| solid.signed_distance(point)), [-0.5, 5.0, 0.0]);
    /// # Ok::<(), intertri_trace::SolidError>(())
    /// ```
    pub fn signed_distance(&self, point: [S; 3]) -> f64 {
        let mut distance = [0.0];
        self.signed_distance_batch_into(&[point], &mut distance);
        distance[0]
    }

    /// Like [`Solid::signed_distance`], but for many points, using all threads.
    pub fn signed_distance_batch(&self, points: &[[S; 3]]) -> Vec<f64> {
        let mut distances = vec![0.0; points.len()];
        self.signed_distance_batch_into(points, &mut distances);
        distances
    }

    /// Like [`Solid::signed_distance_batch`], but writes the distances to a slice.
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    pub fn signed_distance_batch_into(&self, points: &[[S; 3]], distances: &mut [f64]) {
        assert_eq!(points.len(), distances.len(), "one distance per point");
        let mut slab = SLAB.min(points.len()).max(1);
        let (mut closest, mut inside) = loop {
            match (filled(slab, ClosestPoint::NONE), filled(slab, false)) {
                (Ok(closest), Ok(inside)) => break (closest, inside),
                // If memory runs out, process fewer points at a time.
                _ if slab > 1 => slab /= 2,
                _ => break (vec![ClosestPoint::NONE], vec![false]),
            }
        };
        for (points, distances) in points.chunks(slab).zip(distances.chunks_mut(slab)) {
            let (closest, inside) = (&mut closest[..points.len()], &mut inside[..points.len()]);
            self.bvh.closest_point_batch_into(points, f64::INFINITY, closest);
            classify_batch(&self.bvh, points, inside, |rays, crossed, inside| {
                self.count_boundary(rays, crossed);
                for (inside, containment) in inside.iter_mut().zip(crossed) {
                    *inside = matches!(containment, Containment::Inside(_));
                }
            });
            for (i, distance) in distances.iter_mut().enumerate() {
                let far = closest[i].distance;
                *distance = if !points[i].iter().all(|x| Bits::is_finite(*x)) {
                    f64::NAN
                } else if inside[i] && far > 0.0 {
                    -far
                } else {
                    far
                };
            }
        }
    }
}
