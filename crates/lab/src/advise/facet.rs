//! A triangle relative to the eye, and the point where a pixel's ray meets the triangle's plane.

use intertri::{Triangle, TriangleOf};

use super::pixel_ray::PixelRay;
use super::vector::{Vec3d, distance, length, vector};

/// A triangle's corners relative to the eye, and values derived from them.
pub(super) struct Facet {
    pub(super) corners: [Vec3d; 3],
    pub(super) normal: Vec3d,
    /// `B × C`, `C × A`, and `A × B`, the normals of the planes through the eye and a side.
    pub(super) planes: [Vec3d; 3],
    /// The lengths of the three normals in `planes`.
    pub(super) lengths: [f64; 3],
    /// The distance from the eye to the farther end of each side.
    pub(super) reaches: [f64; 3],
    /// A lower bound on the distance from the eye to any side.
    pub(super) near: f64,
    /// The distance from the eye to the first corner.
    pub(super) first: f64,
    /// The length of the longest side.
    pub(super) side: f64,
    /// The length of the normal, which is twice the triangle's area.
    pub(super) area: f64,
    /// `h4 h5 / |n|`, document A's condition number.
    pub(super) kappa: f64,
    /// The smallest and largest depths of the triangle's corners along the view direction.
    pub(super) depth: (f64, f64),
    /// `A · n`. Its absolute value is the eye's distance from the plane times `|n|`.
    pub(super) height: f64,
    /// The distance of the eye from the coordinate origin.
    pub(super) off: f64,
}

/// A pixel's ray relative to a facet: the edge values, which are all positive inside the triangle,
/// and the t at which the ray meets the facet's plane.
pub(super) struct PlaneHit {
    pub(super) edges: [f64; 3],
    pub(super) slope: f64,
    pub(super) t: f64,
    /// A lower bound on the ray's distance from the nearest side; negative if the ray passes
    /// outside.
    pub(super) margin: f64,
    /// The ray's distance from each side, computed only if the margin is not decisive.
    pub(super) sides: Option<[f64; 3]>,
}

impl Facet {
    pub(super) fn new(&TriangleOf(corners): &Triangle, eye: [f32; 3], forward: Vec3d) -> Self {
        let origin = vector(eye);
        let [a, b, c] = corners.map(|corner| vector(corner) - origin);
        let (h4, h5) = (b - a, c - a);
        let normal = h4.cross(h5);
        let sides = [(b, c), (c, a), (a, b)];
        let planes = sides.map(|(p, q)| p.cross(q));
        let depths = [a, b, c].map(|corner| corner.dot(forward));
        let far = [a, b, c].map(length);
        let (long4, long5, area) = (length(h4), length(h5), length(normal));
        Self {
            corners: [a, b, c],
            normal,
            planes,
            lengths: planes.map(length),
            reaches: [far[1].max(far[2]), far[2].max(far[0]), far[0].max(far[1])],
            near: sides.map(|(p, q)| distance(p, q)).into_iter().fold(f64::INFINITY, f64::min),
            first: far[0],
            side: long4.max(long5).max(length(c - b)),
            area,
            kappa: long4 * long5 / area,
            depth: (
                depths.into_iter().fold(f64::INFINITY, f64::min),
                depths.into_iter().fold(f64::NEG_INFINITY, f64::max),
            ),
            height: a.dot(normal),
            off: length(origin),
        }
    }

    /// Returns whether all corners are finite.
    pub(super) fn is_finite(&self) -> bool {
        self.corners.iter().all(|c| c.dot(*c).is_finite())
    }

    /// Returns the distance to the farthest corner.
    pub(super) fn reach(&self) -> f64 {
        self.reaches[0].max(self.reaches[1])
    }

    /// Computes where a pixel's ray meets the triangle's plane.
    pub(super) fn plane_hit(&self, pixel_ray: &PixelRay) -> PlaneHit {
        let slope = self.normal.dot(pixel_ray.dir);
        let sign = if slope < 0.0 { -1.0 } else { 1.0 };
        let edges = self.planes.map(|plane| sign * plane.dot(pixel_ray.dir));
        let mut margin = f64::INFINITY;
        for (edge, length) in edges.iter().zip(self.lengths) {
            let sine = edge / (length * pixel_ray.length);
            margin = margin.min(if sine.is_nan() { 0.0 } else { sine });
        }
        PlaneHit { edges, slope, t: self.height / slope, margin: margin * self.near, sides: None }
    }

    /// Returns whether the ray certainly passes outside the triangle, even if the edge values in
    /// `plane_hit` have rounding errors.
    pub(super) fn is_outside(&self, plane_hit: &PlaneHit, pixel_ray: &PixelRay) -> bool {
        let own = 1e-10 * self.reach() * self.reach() * pixel_ray.length;
        let most = plane_hit.edges.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
        let least = plane_hit.edges.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        most > own && least < -own
    }

    /// Returns a bound on the error of the computed t.
    fn t_error_bound(&self, plane_hit: &PlaneHit, pixel_ray: &PixelRay) -> f64 {
        let rho = self.side * self.side * pixel_ray.length / plane_hit.slope.abs();
        if rho < 1e10 {
            1e-14 * rho * (self.first / pixel_ray.length + plane_hit.t.abs())
        } else {
            f64::INFINITY
        }
    }

    /// Returns an upper bound on the exact t.
    pub(super) fn latest(&self, plane_hit: &PlaneHit, pixel_ray: &PixelRay) -> f64 {
        let t = plane_hit.t + self.t_error_bound(plane_hit, pixel_ray);
        if t.is_nan() { f64::INFINITY } else { t }
    }

    /// Returns whether the ray certainly meets the plane beyond `t`.
    pub(super) fn is_behind(&self, plane_hit: &PlaneHit, pixel_ray: &PixelRay, t: f64) -> bool {
        plane_hit.t - self.t_error_bound(plane_hit, pixel_ray) > t
    }

    /// Returns the distance of the ray's line from each side.
    pub(super) fn sides(&self, pixel_ray: &PixelRay) -> [f64; 3] {
        // Projected along the ray, the ray's line becomes a point.
        let unit = pixel_ray.dir * (1.0 / pixel_ray.length);
        let [a, b, c] = self.corners.map(|p| p - unit * p.dot(unit));
        [(b, c), (c, a), (a, b)].map(|(p, q)| distance(p, q) * (1.0 - 1e-9))
    }
}
