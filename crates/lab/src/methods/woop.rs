//! The watertight test (S. Woop, C. Benthin, I. Wald, "Watertight ray/triangle intersection",
//! Journal of Computer Graphics Techniques 2(1), 2013). It shears the scene so that the ray runs
//! along the longest axis of its direction, and then tests the sides in the plane perpendicular to
//! that axis. If the value of a side is exactly 0 in f32, the values of all three sides are
//! recomputed in f64.

use intertri::simd::Vec3;
use intertri::simd::{Lanes, Mask};

use super::axis::Axis;
use super::intersector::{Intersector, splat3};
use super::real::{Number, Real};

/// The watertight test. Without `fall_back`, it computes only in f32, as some implementations do.
#[derive(Clone, Copy, Debug)]
pub struct Woop {
    /// Whether to recompute the sides' values in f64 if one of them is 0 in f32.
    pub fall_back: bool,
}

/// The ray's origin and shear.
#[derive(Clone, Copy)]
pub struct Ray<L: Lanes> {
    origin: Vec3<L>,
    axis: Axis<L::Mask>,
    shear: Vec3<L>,
}

impl<L: Lanes> Ray<L> {
    /// Returns a corner relative to the ray's origin, with its coordinates permuted so that the
    /// ray's axis comes last.
    #[inline(always)]
    fn see(&self, corner: Vec3<L>) -> Vec3<L> {
        self.axis.turn(corner - self.origin)
    }
}

impl Intersector for Woop {
    type Ray<L: Real> = Ray<L>;
    type Triangle<L: Real> = [Vec3<L>; 3];

    #[inline(always)]
    fn ray<L: Real>(self, origin: Vec3<L>, dir: Vec3<L>) -> Ray<L> {
        // The paper also swaps x and y if the axis is negative, to preserve the winding; a
        // two-sided test does not need this.
        let axis = Axis::longest(dir);
        let d = axis.turn(dir);
        Ray { origin, axis, shear: Vec3 { x: d.x / d.z, y: d.y / d.z, z: L::of(1.0) / d.z } }
    }

    #[inline(always)]
    fn triangle<L: Real>(self, corners: [Vec3<L>; 3]) -> [Vec3<L>; 3] {
        corners
    }

    #[inline(always)]
    fn spread<L: Real>(one: &[Vec3<L::Scalar>; 3]) -> [Vec3<L>; 3] {
        splat3(*one)
    }

    #[inline(always)]
    fn test<L: Real>(self, corners: &[Vec3<L>; 3], ray: &Ray<L>) -> (L::Mask, L) {
        let shear = ray.shear;
        let &[pa, pb, pc] = corners;
        let (pa, pb, pc) = (ray.see(pa), ray.see(pb), ray.see(pc));
        let across = |p: Vec3<L>| [p.x - shear.x * p.z, p.y - shear.y * p.z];
        let (a, b, c) = (across(pa), across(pb), across(pc));

        let side = |p: [L; 2], q: [L; 2]| p[0] * q[1] - p[1] * q[0];
        let (mut u, mut v, mut w) = (side(c, b), side(a, c), side(b, a));
        let zero = L::of(0.0);
        if self.fall_back && L::Scalar::BITS == f32::MANTISSA_DIGITS {
            let is_zero = |x: L| x.ge(zero) & x.le(zero);
            let again = is_zero(u) | is_zero(v) | is_zero(w);
            if again.any() {
                u = L::select(again, side_f64(c, b), u);
                v = L::select(again, side_f64(a, c), v);
                w = L::select(again, side_f64(b, a), w);
            }
        }

        let same = (u.ge(zero) & v.ge(zero) & w.ge(zero)) | (u.le(zero) & v.le(zero) & w.le(zero));
        let det = u + v + w;
        let z = |p: Vec3<L>| p.z * shear.z;
        let t = (u * z(pa) + v * z(pb) + w * z(pc)).flip(det);
        (same & det.abs().gt(zero) & t.gt(zero), t / det.abs())
    }
}

/// Computes the value of a side in f64, lane by lane, and rounds it back to f32, as in the paper.
#[inline(always)]
fn side_f64<L: Real>(p: [L; 2], q: [L; 2]) -> L {
    let zero = [L::Scalar::nearest(0.0); 16];
    let (mut px, mut py, mut qx, mut qy, mut side) = (zero, zero, zero, zero, zero);
    p[0].store(&mut px);
    p[1].store(&mut py);
    q[0].store(&mut qx);
    q[1].store(&mut qy);
    for k in 0..L::N {
        let (a, b, c, d): (f64, f64, f64, f64) =
            (px[k].into(), qy[k].into(), py[k].into(), qx[k].into());
        side[k] = L::Scalar::nearest(a * b - c * d);
    }
    L::load(&side)
}

#[cfg(test)]
mod tests {
    use intertri::simd::Vec3;

    use super::{Axis, Intersector, Woop};

    #[test]
    fn the_shear_by_hand() {
        // After the permutation that puts the longest axis last, the shear maps the direction to
        // (0, 0, 1).
        let woop = Woop { fall_back: true };
        let dirs = [[4.0, 1.0, 2.0], [2.0, 4.0, 1.0], [1.0, 2.0, 4.0]];
        for (axis, [x, y, z]) in dirs.into_iter().enumerate() {
            let ray = woop.ray(Vec3::splat([0.0_f64; 3]), Vec3 { x, y, z });
            assert!(matches!(ray.axis, Axis::Same(k) if k == axis));
            assert_eq!([ray.shear.x, ray.shear.y, ray.shear.z], [0.25, 0.5, 0.25]);
        }
    }
}
