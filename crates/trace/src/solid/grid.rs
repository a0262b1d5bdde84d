//! Classifies the points of a grid, tracing one ray per column.
//!
//! ```text
//!        z ▲  ·    ·    ·          One ray runs up each column. The winding number is 0 at the top, and
//!          │  ·   ╱·╲   ·          changes with each crossing on the way down.
//!          │  ·  ● · ╲  ·
//!          │  · ╱  ·  ╲ ·          Points on triangles are found beforehand; see `grid_surface`.
//!          └───────────────▶ x, y
//! ```

use intertri::{Crossing, RayOf};

use super::Solid;
use super::grid_surface::points_on_triangles;
use crate::containment::Containment;
use crate::scalar::BvhScalar;
use crate::util::memory::{OutOfMemory, room};
use crate::util::threads;

/// The number of columns whose rays are traced together.
const SLAB: usize = 1 << 14;

/// The number of columns that a thread fills per task.
const PIECE: usize = 1 << 6;

impl<S: BvhScalar> Solid<S> {
    /// Classifies all points of a grid, like [`Solid::classify`]. The grid is given by its
    /// coordinates along each axis. The index of the result for the point `[x[i], y[j], z[k]]` is
    /// `(i * y.len() + j) * z.len() + k`.
    ///
    /// If the coordinates are ascending and the mesh is closed, this method traces only one ray per
    /// column of points along z, which takes a fraction of the time of
    /// [`classify_batch`](Solid::classify_batch). Otherwise, or if memory runs out, it classifies
    /// the points one by one.
    ///
    /// ```
    /// use intertri_trace::{Containment, Solid, intertri::Triangle};
    /// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    /// let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
    /// let solid = Solid::new(&faces)?;
    /// let centres = [0.5, 1.5, 2.5];
    /// let voxels = solid.classify_grid([&centres, &centres, &centres]);
    /// assert_eq!(voxels[0], Containment::Inside(1));
    /// // The points (0.5, 0.5, 2.5) and (0.5, 2.5, 1.5).
    /// assert_eq!((voxels[2], voxels[7]), (Containment::Inside(1), Containment::Outside));
    /// # Ok::<(), intertri_trace::SolidError>(())
    /// ```
    pub fn classify_grid(&self, axes: [&[S]; 3]) -> Vec<Containment> {
        let mut all = vec![Containment::Outside; axes.iter().map(|axis| axis.len()).product()];
        self.classify_grid_into(axes, &mut all);
        all
    }

    /// Like [`Solid::classify_grid`], but writes the results to a slice.
    ///
    /// # Panics
    /// Panics if the length of the slice differs from the number of points.
    pub fn classify_grid_into(&self, axes: [&[S]; 3], all: &mut [Containment]) {
        let count = axes.iter().map(|axis| axis.len()).product::<usize>();
        assert_eq!(all.len(), count, "one result per point");
        let goes_up = |axis: &&[S]| {
            axis.iter().all(|x| x.is_finite()) && axis.windows(2).all(|pair| pair[0] <= pair[1])
        };
        let is_by_columns = self.boundary.edges() == 0 && axes.iter().all(goes_up);
        if !is_by_columns || self.classify_columns(axes, all).is_err() {
            self.classify_points(axes, all);
        }
    }

    /// Classifies the points one by one.
    fn classify_points(&self, [x, y, z]: [&[S]; 3], all: &mut [Containment]) {
        let mut points = Vec::new();
        for (i, all) in all.chunks_mut((y.len() * z.len()).max(1)).enumerate() {
            for (j, all) in all.chunks_mut(z.len().max(1)).enumerate() {
                points.clear();
                points.extend(z.iter().map(|z| [x[i], y[j], *z]));
                self.classify_batch_into(&points, all);
            }
        }
    }

    /// Classifies the points column by column.
    fn classify_columns(
        &self,
        axes: [&[S]; 3],
        all: &mut [Containment],
    ) -> Result<(), OutOfMemory> {
        let [x, y, z] = axes;
        let Some(&bottom) = z.first() else { return Ok(()) };
        all.fill(Containment::Outside);
        for point in points_on_triangles(&self.bvh, axes)? {
            all[point] = Containment::Surface;
        }
        let column = |number: usize| [x[number / y.len()], y[number % y.len()]];
        let up = [S::ZERO, S::ZERO, S::ONE];
        for (slab, all) in all.chunks_mut(SLAB * z.len()).enumerate() {
            let columns = slab * SLAB..slab * SLAB + all.len() / z.len();
            let mut rays = room(columns.len())?;
            rays.extend(columns.clone().map(column).map(|[x, y]| RayOf::new([x, y, bottom], up)));
            let crossings = self.bvh.crossings_batch(&rays)?;
            threads::pieces(all.chunks_mut(PIECE * z.len()), |piece, all| {
                for (i, all) in (piece * PIECE..).zip(all.chunks_mut(z.len())) {
                    self.fill(column(columns.start + i), z, crossings.of(i), all);
                }
            });
        }
        Ok(())
    }

    /// Fills a column from the top down, except for points on triangles, which are already known.
    fn fill(&self, [x, y]: [S; 2], z: &[S], crossings: &[Crossing], all: &mut [Containment]) {
        let bottom: f64 = z[0].into();
        let (mut above, mut containment) = (crossings, Containment::Outside);
        for (z, to) in z.iter().zip(all).rev() {
            let height = Into::<f64>::into(*z) - bottom;
            // Both heights are rounded once, so a crossing that is higher after rounding is also
            // higher in exact arithmetic.
            while let Some((last, rest)) = above.split_last().filter(|(c, _)| c.hit.t > height) {
                containment = containment.crossed(last.leaves);
                above = rest;
            }
            if *to == Containment::Surface {
                continue;
            }
            let is_tied = above.last().is_some_and(|crossing| crossing.hit.t == height);
            *to = if is_tied { self.classify([x, y, *z]) } else { containment };
        }
    }
}
