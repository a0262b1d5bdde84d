//! The frame for the f32 copies of a scene given in f64. The copies are relative to the scene's
//! centre and scaled by a power of two.
//!
//! ```text
//!        f64                          f32, for the filter and traversal
//!   528 980.13 ────────────┐
//!   528 981.20 ──┐ centre  │          c1 ──►  2ⁿ (c1 - centre)        rounded
//!                ▼    ▼    ▼          h4 ──►  2ⁿ (c2 - c1)            rounded; precise if short
//!   ─────────────●────┼────●───       o  ──►  2ⁿ (o - centre)         rounded
//!                                     d  ──►  2ᵐ d                    rounded
//! ```
//!
//! The filter's error bounds cover the rounding of the copies (`docs/numerics/f64.md`, section 4).

mod blocks;
mod rays;

use crate::exact::has_interval;
use crate::packet::{Copy32, LARGEST, SHORTEST};
use crate::scalar::Bits;
use crate::simd::Lanes;
use crate::{Ray, Ray64, Triangle64, TriangleOf};

/// The smallest and largest exponents of the scale. The scale is chosen so that the largest scaled
/// coordinate of any corner, relative to the centre, is between 1 and 2. Within the limits, the
/// scale is a normal f64, and numbers that the CPU may read as 0 stay below all error bounds.
const SCALES: (i32, i32) = (-1000, 800);

/// A direction is scaled like points if the exponent of its scaled length is at most this value in
/// magnitude. Any other direction gets its own scale, which brings its length close to 1.
const SAME: i32 = 30;

/// The limit to which coordinates of origins are clamped. It is beyond the limits of the slab test
/// and the filter, so a ray with a clamped origin is tested against all triangles in f64. A smaller
/// limit would bend the line of a ray that the slab test accepts.
const FAR_OUT: f64 = f32::MAX as f64;

/// A ray that hits nothing.
const DEAD: Ray = Ray { origin: [0.0; 3], t_min: 1.0, dir: [1.0, 0.0, 0.0], t_max: 0.0 };

/// Returns the f32 copy of an edge along an axis, which is 0 only if the two coordinates are equal: a
/// difference that is too small for f32 becomes the smallest normal number. Thus a copy tells whether
/// its original is perpendicular to the axis.
#[inline(always)]
fn nonzero_edge(copy: f32, x: f64, y: f64) -> f32 {
    // Compare bits, because a CPU may be set to read subnormal numbers as 0. Zeros of both signs are
    // equal.
    let (x, y) = (x.to_bits(), y.to_bits());
    let differ = x != y && (x | y) << 1 != 0;
    if copy.to_bits() << 1 == 0 && differ { f32::MIN_POSITIVE } else { copy }
}

/// The frame for the f32 copies of a scene given in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalFrame {
    centre: [f64; 3],
    /// The exponent of the scale.
    up: i32,
    /// An upper bound on the 1-norm of every corner, relative to the centre.
    reach: f32,
}

impl LocalFrame {
    /// Creates a frame for corners with coordinates from `lo` to `hi`, most of which are in the box
    /// `crowd`. If the limits are not finite, the frame is the identity. The frame's centre is the
    /// point of the crowd that is nearest to the centre of the whole scene, so that a few distant
    /// triangles do not cost the others precision.
    pub fn around([lo, hi]: [[f64; 3]; 2], crowd: [[f64; 3]; 2]) -> Self {
        if !lo.iter().chain(&hi).all(|x| x.is_finite()) {
            return Self { centre: [0.0; 3], up: 0, reach: 0.0 };
        }
        let middle = |k: usize| 0.5 * lo[k] + 0.5 * hi[k];
        // The centre of the scene, unless a few distant triangles pull it away from most of the
        // scene (f64.md, section 4).
        let centre = [0, 1, 2].map(|k| middle(k).max(crowd[0][k]).min(crowd[1][k]));
        // The distance from the centre to the farther side along each axis. The scale brings the
        // largest of these distances into the range from 1 to 2.
        let half = [0, 1, 2].map(|k| (hi[k] - centre[k]).max(centre[k] - lo[k]));
        let up = -exponent(half[0].max(half[1]).max(half[2]));
        let up = up.clamp(SCALES.0, SCALES.1);
        // Use slightly more than the sum, to cover the rounding of the copies and of the sum
        // itself.
        let reach = half.iter().map(|x| x * pow2(up)).sum::<f64>();
        Self { centre, up, reach: reach as f32 * (1.0 + 1.0 / 1024.0) }
    }

    /// Creates the frame with the given centre and exponent, if they are valid. `farthest` bounds
    /// the scaled distance of corners from the centre along each axis.
    pub fn of(centre: [f64; 3], up: i32, farthest: [f32; 3]) -> Option<Self> {
        let sane = centre.iter().all(|x| x.is_finite()) && (SCALES.0..=SCALES.1).contains(&up);
        let reach = farthest.iter().map(|&x| f64::from(x)).sum::<f64>() as f32;
        sane.then_some(Self { centre, up, reach: reach * (1.0 + 1.0 / 1024.0) })
    }

    /// Returns the centre and the exponent of the scale.
    pub fn centre_and_exponent(&self) -> ([f64; 3], i32) {
        (self.centre, self.up)
    }

    /// Returns an upper bound on the 1-norm of every corner's copy.
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// Returns the scale, a power of two.
    pub fn scale(&self) -> f64 {
        pow2(self.up)
    }

    /// Converts a coordinate along an axis to the frame's scaled coordinate.
    #[inline(always)]
    fn place(&self, x: f64, axis: usize) -> f64 {
        (x - self.centre[axis]) * pow2(self.up)
    }

    /// Returns the box of a triangle's copy. The box contains the scaled triangle. Returns `None`
    /// if a corner is not finite.
    #[inline]
    pub fn bounds(&self, TriangleOf(corners): &Triangle64) -> Option<[[f32; 3]; 2]> {
        if !corners.as_flattened().iter().all(|x| x.is_finite()) {
            return None;
        }
        let mut bounds = [[0.0; 3]; 2];
        // One f32 step outward exceeds all rounding errors, so the scaled triangle is inside the
        // box.
        for axis in 0..3 {
            let [a, b, c] = corners.map(|corner| corner[axis]);
            bounds[0][axis] = (self.place(a.min(b).min(c), axis) as f32).next_down();
            bounds[1][axis] = (self.place(a.max(b).max(c), axis) as f32).next_up();
        }
        Some(bounds)
    }

    /// Computes the copy of a triangle.
    #[inline]
    pub fn triangle(&self, TriangleOf([c1, c2, c3]): &Triangle64) -> Copy32 {
        // Edges are differences of the originals, not of the copies, so a small triangle far from
        // the centre keeps its precision.
        let scale = pow2(self.up);
        let sub = |a: &[f64; 3], b: &[f64; 3]| [0, 1, 2].map(|k| (a[k] - b[k]) * scale);
        let (minus_h4, h5, h6) = (sub(c1, c2), sub(c3, c1), sub(c3, c2));
        let at = [0, 1, 2].map(|k| self.place(c1[k], k));
        let square = |v: &[f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let (a, b, c) = (square(&minus_h4), square(&h5), square(&h6));

        // A NaN in any edge makes the sum NaN, and the comparison is then false.
        let far = f64::from(LARGEST);
        let near =
            (0..3).all(|k| at[k].abs() <= far && minus_h4[k].abs() <= far && h5[k].abs() <= far);
        let known = near && a + b + c < f64::INFINITY;
        let longest = Lanes::sqrt(a.max(b).max(c)) as f32;
        // Two steps up cover all rounding errors of the length.
        let above = f32::from_bits((longest + SHORTEST).to_bits() + 2);
        let mut parts = [at, minus_h4, h5].map(|v| v.map(|x| x as f32));
        for k in 0..3 {
            parts[1][k] = nonzero_edge(parts[1][k], c1[k], c2[k]);
            parts[2][k] = nonzero_edge(parts[2][k], c1[k], c3[k]);
        }
        Copy32 { parts, longest: if known { above } else { f32::NAN } }
    }

    /// Computes the copy of a point. It is inside the box that [`LocalFrame::bounds`] returns for
    /// any triangle whose own box contains the point.
    #[inline]
    pub fn point(&self, point: [f64; 3]) -> [f32; 3] {
        [0, 1, 2].map(|k| self.place(point[k], k) as f32)
    }

    /// Returns two points that enclose the scaled original of a finite point.
    #[inline]
    pub fn around_point(&self, point: [f64; 3]) -> [[f32; 3]; 2] {
        // Halve both first, because the difference may exceed the range of f64.
        let half = |k: usize| (0.5 * point[k] - 0.5 * self.centre[k]) * pow2(self.up + 1);
        let near = [0, 1, 2].map(|k| half(k) as f32);
        [near.map(f32::next_down), near.map(f32::next_up)]
    }

    /// Returns the maximum distance, along an axis, between a scaled corner and the sum of its
    /// copy's parts in f32.
    #[inline]
    pub fn corner_room(&self) -> f32 {
        self.reach * (5.0 / (1 << 24) as f32)
    }

    /// Computes the copy of a ray. Its interval contains the scaled interval of the original.
    #[inline]
    pub fn ray(&self, ray: &Ray64) -> Ray {
        let scale = pow2(self.up);
        let origin = [0, 1, 2].map(|k| self.place(ray.origin[k], k));
        let dir = ray.dir.map(|x| x * scale);

        // The condition below is nearly always true; it is false for NaN. If it is true, the copy's
        // t is the ray's t.
        let has_interval = ray.t_min < ray.t_max && ray.t_max > 0.0;
        let is_near = origin.iter().all(|x| x.abs() <= FAR_OUT);
        let is_short = dir.iter().all(|x| x.abs() <= pow2(SAME));
        let goes = dir.iter().any(|x| x.abs() >= pow2(-SAME));
        if has_interval & is_near & is_short & goes {
            return Ray {
                origin: origin.map(|x| x as f32),
                t_min: below(ray.t_min.max(0.0)),
                dir: dir.map(|x| x as f32),
                t_max: end(ray.t_max),
            };
        }
        self.odd_ray(ray)
    }

    /// Computes the copy of a ray that hits nothing, starts far out, or needs its own scale.
    #[cold]
    #[inline(never)]
    fn odd_ray(&self, ray: &Ray64) -> Ray {
        let finite = |v: &[f64; 3]| v.iter().all(|x| x.is_finite());
        let goes = ray.dir.iter().any(|x| x.rank() != 0);
        if !(has_interval(ray) && finite(&ray.origin) && finite(&ray.dir) && goes) {
            return DEAD;
        }
        // A clamped origin is finite in f32, but so far out that no test in f32 depends on it.
        let at = |k: usize| self.place(ray.origin[k], k).clamp(-FAR_OUT, FAR_OUT) as f32;
        // The ray's direction may be so short or so long that the copy needs its own scale, and t
        // then has different units.
        let times = self.exponent(ray);
        Ray {
            origin: [at(0), at(1), at(2)],
            t_min: below(scaled(ray.t_min.max(0.0), times)),
            dir: ray.dir.map(|x| scaled(x, self.up - times) as f32),
            t_max: end(scaled(ray.t_max, times)),
        }
    }

    /// Returns the exponent e for which the copy's t is the ray's t times `2^e`. The exponent is
    /// nearly always 0.
    #[inline]
    pub fn exponent(&self, ray: &Ray64) -> i32 {
        let length = self.up + longest_exponent(ray);
        if length.abs() <= SAME { 0 } else { length }
    }
}

/// Returns the exponent of the largest component of a direction, or 0 if all components are 0.
#[inline]
fn longest_exponent(ray: &Ray64) -> i32 {
    let [x, y, z] = ray.dir.map(Bits::rank);
    exponent(f64::from_bits(x.max(y).max(z)))
}

/// Returns the exponent e for which `2^e <= x < 2^(e+1)` for a positive x, or 0 if x is 0.
#[inline]
fn exponent(x: f64) -> i32 {
    let (m, e) = x.parts();
    if m == 0 { 0 } else { 63 - m.leading_zeros() as i32 + e }
}

/// Computes `x 2^by`, rounded. The result is infinite on overflow and about 0 on underflow. This
/// function works on the bits, because a CPU may be set to read a subnormal x as 0.
#[inline]
fn scaled(x: f64, by: i32) -> f64 {
    if !Bits::is_finite(x) {
        return x;
    }
    let (m, e) = x.parts();
    // Use two factors, because 2^by may be beyond the range of f64.
    let to = e + by;
    let half = (to / 2).clamp(-600, 600);
    m as f64 * pow2(half) * pow2((to - half).clamp(-1000, 1000))
}

/// Rounds a nonnegative number down.
#[inline]
fn below(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x || near == f32::INFINITY { near.next_down().max(0.0) } else { near }
}

/// Rounds a positive far end up. The result is at least the smallest normal number, because a CPU
/// may read smaller numbers as 0.
#[inline]
fn end(x: f64) -> f32 {
    let near = x as f32;
    let above = if f64::from(near) < x { near.next_up() } else { near };
    above.max(f32::MIN_POSITIVE)
}

/// Returns `2^e`, which must be a normal number.
#[inline(always)]
fn pow2(e: i32) -> f64 {
    f64::from_bits(((e + 1023) as u64) << 52)
}
