//! Computes winding numbers of any mesh: the signed crossings of a ray plus the solid angle of the
//! boundary.

use intertri::{RayOf, TriangleOf};

use super::Solid;
use super::angle::turns;
use super::boundary::Boundary;
use super::classify::{classify, classify_batch};
use super::whole_turns::{POINTS, whole_turns};
use crate::build::BuildError;
use crate::containment::Containment;
use crate::scalar::BvhScalar;
use crate::util::lane_ops::lanes_of;

impl<S: BvhScalar> Solid<S> {
    /// Creates a solid from any mesh. The mesh may be open or have holes, and faces may be flipped,
    /// duplicated, or degenerate. A point is inside if its winding number, rounded to an integer,
    /// is not 0. For a closed mesh, results are the same as with [`Solid::new`].
    ///
    /// Triangles that are not finite are ignored.
    ///
    /// # Errors
    /// Returns an error if the hierarchy cannot be built, or if memory runs out.
    ///
    /// ```
    /// use intertri_trace::{Containment, Solid, intertri::Triangle};
    /// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    /// // The slanted face is missing.
    /// let faces = [[o, y, x], [o, x, z], [o, z, y]].map(|[a, b, c]| Triangle::new(a, b, c));
    /// let solid = Solid::from_soup(&faces)?;
    /// assert_eq!(solid.open_edges(), 3);
    /// let points = [[0.5, 0.5, 0.5], [1.5, 1.5, 1.5], [2.0, 2.0, 0.0]];
    /// let containments = points.map(|point| solid.classify(point));
    /// assert_eq!(containments, [Containment::Inside(1), Containment::Outside, Containment::Surface]);
    /// // From a point next to the corner, faces cover seven eighths of all directions.
    /// assert!((solid.winding_number([1e-6; 3]).unwrap() - 0.875).abs() < 1e-5);
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn from_soup(triangles: &[TriangleOf<S>]) -> Result<Self, BuildError> {
        let boundary = boundary(triangles)?;
        Ok(Self { boundary, ..Self::assume_closed(triangles)? })
    }

    /// Returns a solid like the one that [`Solid::from_soup`] would create: it shares this solid's
    /// hierarchy but takes open edges into account.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    ///
    /// ```
    /// use intertri_trace::{Bvh, Solid, intertri::Triangle};
    /// let bvh = Bvh::new(&[Triangle::new([0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])])?;
    /// let solid = Solid::assume_closed_bvh(bvh).with_boundary()?;
    /// assert_eq!(solid.open_edges(), 3);
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn with_boundary(&self) -> Result<Self, BuildError> {
        let triangles = self.bvh.try_to_triangles();
        let triangles = triangles.map_err(|_| BuildError::OutOfMemory { count: self.bvh.len() })?;
        Ok(Self { bvh: self.bvh.clone(), boundary: boundary(&triangles)? })
    }

    /// Returns the number of open edges. An edge that triangles traverse more often in one
    /// direction than in the other is counted as many times as the difference. The result is 0 for
    /// a mesh that is closed or assumed to be closed.
    pub fn open_edges(&self) -> usize {
        self.boundary.edges()
    }

    /// Returns the winding number of a point: the sum of the solid angles of all triangles divided
    /// by 4π, where triangles seen from behind count as positive. Returns `None` on a triangle, and
    /// 0 if the point is not finite.
    ///
    /// The winding number is the sum of a ray's signed crossings, which are exact, and the solid
    /// angle of the boundary, which is rounded. It is therefore an integer if the mesh is closed.
    /// Otherwise, the error is at most `2^-47` for each open edge, multiplied by the ratio of the
    /// edge's length to its distance from the point if that ratio exceeds 1.
    pub fn winding_number(&self, point: [S; 3]) -> Option<f64> {
        self.number(point, classify(&self.bvh, point))
    }

    /// Like [`Solid::winding_number`], but for many points, using all threads.
    ///
    /// ```
    /// use intertri_trace::{Solid, intertri::Triangle};
    /// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    /// let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
    /// let solid = Solid::new(&[faces, faces].concat())?;
    /// let numbers = solid.winding_number_batch(&[[1.0; 3], [1.0, 1.0, 2.0], [3.0; 3]]);
    /// assert_eq!(numbers, [Some(2.0), None, Some(0.0)]);
    /// # Ok::<(), intertri_trace::SolidError>(())
    /// ```
    pub fn winding_number_batch(&self, points: &[[S; 3]]) -> Vec<Option<f64>> {
        let mut numbers = vec![None; points.len()];
        self.winding_number_batch_into(points, &mut numbers);
        numbers
    }

    /// Like [`Solid::winding_number_batch`], but writes the winding numbers to a slice.
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    pub fn winding_number_batch_into(&self, points: &[[S; 3]], numbers: &mut [Option<f64>]) {
        classify_batch(&self.bvh, points, numbers, |rays, crossed, numbers| {
            for ((number, ray), crossed) in numbers.iter_mut().zip(rays).zip(crossed) {
                *number = self.number(ray.origin, *crossed);
            }
        });
    }

    /// Returns the winding number of a point, given its containment computed from crossings alone.
    fn number(&self, point: [S; 3], crossed: Containment) -> Option<f64> {
        let times = match crossed {
            Containment::Outside => 0,
            Containment::Inside(times) => times,
            Containment::Surface => return None,
        };
        if self.boundary.edges() == 0 || !point.iter().all(|x| x.is_finite()) {
            return Some(times.into());
        }
        Some(f64::from(times) + turns(&self.boundary, point))
    }

    /// Returns the containment of a point, given its containment computed from crossings alone.
    pub(super) fn counted(&self, point: [S; 3], crossed: Containment) -> Containment {
        let mut all = [crossed];
        self.count_boundary(&[RayOf::new(point, [S::ONE; 3])], &mut all);
        all[0]
    }

    /// Adds the contribution of the boundary to containments that were computed from crossings
    /// alone, for the points where the rays start.
    pub(super) fn count_boundary(&self, rays: &[RayOf<S>], crossed: &mut [Containment]) {
        if self.boundary.edges() == 0 {
            return;
        }
        for (rays, crossed) in rays.chunks(POINTS).zip(crossed.chunks_mut(POINTS)) {
            let mut asked = 0;
            for (i, (ray, crossed)) in rays.iter().zip(&*crossed).enumerate() {
                let is_finite = ray.origin.iter().all(|x| x.is_finite());
                asked |= u32::from(is_finite && *crossed != Containment::Surface) << i;
            }
            if asked == 0 {
                continue;
            }
            let (turns, sure) = whole_turns(&self.boundary, rays, asked);
            for i in lanes_of(asked) {
                crossed[i] = if sure >> i & 1 == 1 {
                    crossed[i].wound(turns[i] as i32)
                } else {
                    self.rounded(rays[i].origin, crossed[i])
                };
            }
        }
    }

    /// Returns the containment of a point, based on its winding number rounded to an integer.
    #[cold]
    fn rounded(&self, point: [S; 3], crossed: Containment) -> Containment {
        let number = self.number(point, crossed).unwrap_or(0.0);
        // Exactly one half rounds to 0.
        match (number.abs() - 0.5).ceil().copysign(number) as i32 {
            0 => Containment::Outside,
            times => Containment::Inside(times),
        }
    }
}

/// Computes the boundary of a mesh.
fn boundary<S: BvhScalar>(triangles: &[TriangleOf<S>]) -> Result<Boundary<S>, BuildError> {
    Boundary::of(triangles).map_err(|_| BuildError::OutOfMemory { count: triangles.len() })
}
