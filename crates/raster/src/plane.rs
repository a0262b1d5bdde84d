//! Computes the inverse view depth `q` of a plane, which is linear in the image coordinates.
//!
//! Let `n` be the plane's normal, and `a` the vector from the eye to a point of the plane. The line
//! of sight `w * d` meets the plane where `n · (w d - a) = 0`. Therefore,
//! `q = 1 / w = (n · d) / (n · a)`, which is linear over the image because `d` is. A larger q is
//! nearer, and a point at infinity has q = 0.

use intertri::simd::Lanes;

use crate::vector::{Vector, dot};
use crate::view::PixelDirections;

/// The `q` of one plane, clamped to the range of `q` at the facet's corners.
///
/// The limits matter for planes that are nearly edge-on: the quotient of two small numbers can take
/// any value, but no point of the facet is nearer than its nearest corner or farther than its
/// farthest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetPlane {
    q0: f64,
    dx: f64,
    dy: f64,
    lo: f64,
    hi: f64,
}

impl FacetPlane {
    /// Creates the plane through `eye + arm` with this normal, with `q` clamped to `lo..=hi`. A
    /// plane through the eye has no depth; its `q` is `lo` everywhere.
    pub(crate) fn new(
        directions: &PixelDirections,
        normal: Vector,
        arm: Vector,
        (lo, hi): (f64, f64),
    ) -> Self {
        let offset = dot(normal, arm);
        let [q0, dx, dy] = [directions.origin, directions.dx, directions.dy]
            .map(|part| dot(normal, part) / offset);
        if q0.is_finite() && dx.is_finite() && dy.is_finite() {
            Self { q0, dx, dy, lo, hi }
        } else {
            Self::flat(lo)
        }
    }

    /// Creates a plane with the same q everywhere. A q of 0 means infinitely far away.
    pub(crate) fn flat(q: f64) -> Self {
        Self { q0: q, dx: 0.0, dy: 0.0, lo: q, hi: q }
    }

    /// Returns the largest q, which is at the nearest corner.
    pub(crate) fn hi(&self) -> f64 {
        self.hi
    }

    /// Prepares the plane for the row with centre `y`.
    #[inline(always)]
    pub(crate) fn row<D: Lanes<Scalar = f64>>(&self, y: f64) -> Row<D> {
        Row {
            q0: D::splat(self.q0 + self.dy * y),
            dx: D::splat(self.dx),
            lo: D::splat(self.lo),
            hi: D::splat(self.hi),
        }
    }

    /// Returns the q at one point, with the same bits as [`Row::at`].
    pub(crate) fn at(&self, x: f64, y: f64) -> f64 {
        (self.dx * x + (self.q0 + self.dy * y)).max(self.lo).min(self.hi)
    }
}

/// A facet's plane along one row of pixels.
#[derive(Clone, Copy)]
pub(crate) struct Row<D> {
    q0: D,
    dx: D,
    lo: D,
    hi: D,
}

impl<D: Lanes<Scalar = f64>> Row<D> {
    /// Returns the q at pixel centres with these x coordinates. No operation is fused, so the bits
    /// are the same on every CPU.
    #[inline(always)]
    pub(crate) fn at(&self, x: D) -> D {
        (self.dx * x + self.q0).max(self.lo).min(self.hi)
    }
}

/// Returns the range of q between corners with these view depths, for the part of a facet in front
/// of the eye. The range is unbounded if a corner is behind the eye.
pub(crate) fn range(depths: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for w in depths {
        least = least.min(w);
        most = most.max(w);
    }
    (1.0 / most, if least > 0.0 { 1.0 / least } else { f64::INFINITY })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::View;

    #[test]
    fn a_plane_seen_edge_on_stays_between_its_corners() {
        // The facet has view depths from 1 to 3, and its plane passes extremely close to the eye.
        // Just outside the facet, the plane itself may have any depth.
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        let view = View::new([0.0; 3], axes, 1.0, 100, 100).unwrap();
        let plane = FacetPlane::new(
            &view.pixel_directions(),
            [1.0, 0.0, 0.0],
            [1e-9, 0.0, -1.0],
            range([1.0, 3.0]),
        );
        for x in [0.0, 49.0, 50.0, 51.0, 100.0] {
            let q = plane.at(x, 20.0);
            assert!((1.0 / 3.0..=1.0).contains(&q), "{x}: {q}");
        }
        // Test a plane through the eye, and a facet that reaches behind the eye.
        let through = FacetPlane::new(
            &view.pixel_directions(),
            [1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0],
            range([1.0, 4.0]),
        );
        assert_eq!(through.at(3.0, 4.0), 0.25);
        assert_eq!(range([-1.0, 2.0]), (0.5, f64::INFINITY));
        // For a plane that is not edge-on, the limits have no effect.
        let slope = FacetPlane::new(
            &view.pixel_directions(),
            [0.0, 1.0, 0.0],
            [0.0, -1.0, -1.0],
            range([1.0, 9.0]),
        );
        assert!((slope.at(50.0, 75.0) - 0.5).abs() < 1e-15);
        assert!((slope.at(50.0, 62.5) - 0.25).abs() < 1e-15);
    }
}
