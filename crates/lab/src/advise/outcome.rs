//! Bounds how far each arithmetic can deviate from the exact answer for a facet, and derives the
//! outcomes that are possible within the bound.

#![expect(clippy::neg_cmp_op_on_partial_ord, reason = "NaN counts as doubtful")]

use super::arithmetic::{Arithmetic, snap, snap_of_one, turn};
use super::facet::{Facet, PlaneHit};
use super::pixel_ray::PixelRay;

/// The unit roundoff of f32.
const U: f64 = 1.0 / (1_u64 << 24) as f64;
/// The unit roundoff of f64.
const W: f64 = 1.0 / (1_u64 << 53) as f64;

/// What an arithmetic may find for a facet at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Outcome {
    /// No hit.
    Miss,
    /// A hit with t in this range.
    Hit(f64, f64),
    /// Either a miss, or a hit with t in this range.
    Doubtful(f64, f64),
}

impl Facet {
    /// Returns a bound on an f32 test's error in an edge value, for directions of unit length.
    pub(super) fn single_bound(&self) -> f64 {
        let (small, large) = (2.0_f64.powi(-30), 2.0_f64.powi(30));
        if self.side.min(self.first) < small || self.side.max(self.reach()) > large {
            return f64::INFINITY;
        }
        U * self.side * (22.6 * self.first + 28.0 * self.side)
    }

    /// Returns a bound on the reference's error in an edge value, for directions of unit length and
    /// the given `rho = h4 h5 |d| / |n · d|`.
    fn double_bound(&self, rho: f64) -> f64 {
        // For a larger `rho`, the rounding errors are not small, as the derivation of the bound
        // assumes.
        if rho > 2.0_f64.powi(40) {
            return f64::INFINITY;
        }
        let Self { side, first, kappa, off, .. } = *self;
        2.0 * W * side * ((30.0 * kappa + 68.0 * rho) * first + off + 34.0 * kappa * side)
    }

    /// For a triangle seen edge-on, returns how far outside the triangle rounding can move a hit,
    /// as a multiple of the triangle's longest side.
    pub(super) fn spill(&self) -> f64 {
        let slope = self.height.abs() / self.reach();
        let rho = self.side * self.side / slope;
        8.0 * (self.single_bound() + self.double_bound(rho)) / slope
    }

    /// Returns the possible outcomes of an arithmetic for this facet.
    pub(super) fn outcome(
        &self,
        arithmetic: Arithmetic,
        plane_hit: &mut PlaneHit,
        pixel_ray: &PixelRay,
    ) -> Outcome {
        let outcome = match arithmetic {
            Arithmetic::Grid { step, q } => self.on_grid(step, q, plane_hit, pixel_ray),
            Arithmetic::Single => {
                let (side, steep) = (self.side, plane_hit.slope.abs());
                let near = 8.1 * U * side * side * pixel_ray.length;
                let t = plane_hit.t;
                let off = (12.2 * U * side * side * self.first + t.abs() * near) / (steep - near);
                let off = if steep > near { off + 2.0 * U * t.abs() } else { f64::INFINITY };
                self.by_edges(self.single_bound(), off, plane_hit, pixel_ray)
            }
            Arithmetic::Double { threshold } => {
                // The reference never reports a hit on a triangle with zero area, because the
                // triangle's normal is 0.
                if self.area == 0.0 {
                    return Outcome::Miss;
                }
                let noise = 12.0 * W * self.kappa * pixel_ray.length;
                let slope = plane_hit.slope.abs() / self.area;
                if slope + noise < threshold {
                    return Outcome::Miss;
                }
                let rho = self.kappa * pixel_ray.length / slope;
                let (t, far) = (plane_hit.t.abs(), pixel_ray.length);
                let off = 13.0 * W * rho * (self.first + t * far) / far + 2.0 * W * t;
                let outcome = self.by_edges(self.double_bound(rho), off, plane_hit, pixel_ray);
                match outcome {
                    Outcome::Hit(lo, hi) if slope < threshold + noise || lo <= threshold => {
                        Outcome::Doubtful(lo, hi)
                    }
                    outcome => outcome,
                }
            }
        };
        // Part of the range of t may be at or below 0, where hits do not count.
        match outcome {
            Outcome::Hit(_, hi) | Outcome::Doubtful(_, hi) if hi < 0.0 => Outcome::Miss,
            Outcome::Hit(lo, hi) if lo <= 0.0 => Outcome::Doubtful(lo, hi),
            outcome => outcome,
        }
    }

    /// Returns the possible outcomes if the edge values, for a direction of unit length, have
    /// errors up to `bound`, and t has errors up to `off`.
    fn by_edges(
        &self,
        bound: f64,
        off: f64,
        plane_hit: &PlaneHit,
        pixel_ray: &PixelRay,
    ) -> Outcome {
        // Account for the rounding in this computation.
        let bound = (bound + 32.0 * W * self.reach() * self.reach()) * pixel_ray.length;
        let (lo, hi) = if (plane_hit.t - off).is_nan() {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            (plane_hit.t - off, plane_hit.t + off)
        };
        if plane_hit.edges.iter().any(|&e| e < -bound) {
            Outcome::Miss
        } else if plane_hit.edges.iter().all(|&e| e > bound) {
            Outcome::Hit(lo, hi)
        } else {
            Outcome::Doubtful(lo, hi)
        }
    }

    /// Returns the possible outcomes if snapping moves the corners and the ray. A ray can change
    /// between inside and outside only if a side crosses the ray during the move.
    fn on_grid(
        &self,
        step: f64,
        q: u32,
        plane_hit: &mut PlaneHit,
        pixel_ray: &PixelRay,
    ) -> Outcome {
        let (snap, turn) = (snap(step), turn(q));
        let most = snap + turn * self.reach();

        // After snapping, every point on the triangle is between `front` and `back` in the view
        // direction.
        let (front, back) = (self.depth.0 - snap, self.depth.1 + snap);
        let off = turn * pixel_ray.length;
        let lo = front / (pixel_ray.depth + if front > 0.0 { off } else { -off });
        let hi = back / (pixel_ray.depth - off);
        let doubt = Outcome::Doubtful(lo, hi);

        if plane_hit.margin < -most {
            return Outcome::Miss;
        }
        if !(plane_hit.margin > most) {
            let sides = plane_hit.sides.get_or_insert_with(|| self.sides(pixel_ray));
            for (distance, reach) in sides.iter().zip(self.reaches) {
                if !(*distance > snap + turn * reach) {
                    return doubt;
                }
            }
            if plane_hit.margin < 0.0 {
                return Outcome::Miss;
            }
        }

        // The ray is inside and stays inside, but its hit point moves with the corners, and the
        // plane tilts.
        let apart = 2.0 * snap_of_one(step);
        let tilt = apart * (2.0 * self.side + apart) / self.area;
        let cosine = plane_hit.slope.abs() / (self.area * pixel_ray.length);
        let cosine = (cosine - tilt - turn) / (1.0 + tilt);
        let off = (snap / pixel_ray.length + turn * plane_hit.t.abs()) / cosine;
        if cosine > 0.0 {
            Outcome::Hit(lo.max(plane_hit.t - off), hi.min(plane_hit.t + off))
        } else {
            Outcome::Hit(lo, hi)
        }
    }

    /// Returns a bound on how far the visible triangle moves at this pixel, as an angle.
    pub(super) fn shift(
        &self,
        arithmetic: Arithmetic,
        plane_hit: &PlaneHit,
        pixel_ray: &PixelRay,
    ) -> f64 {
        let bound = match arithmetic {
            Arithmetic::Grid { step, q } => {
                return snap(step) / (plane_hit.t.abs() * pixel_ray.length) + turn(q);
            }
            Arithmetic::Single => self.single_bound(),
            Arithmetic::Double { .. } => {
                self.double_bound(self.side * self.side * pixel_ray.length / plane_hit.slope.abs())
            }
        };
        bound / self.lengths.iter().fold(f64::INFINITY, |a, &b| a.min(b))
    }
}
