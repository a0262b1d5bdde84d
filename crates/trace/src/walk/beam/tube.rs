//! The tube of a beam: a volume around the lines of its rays.
//!
//! ```text
//!         ┌─┐                     Each line intersects a plane perpendicular to the main axis of the
//!   o ────┼─┼───►                 direction. The tube starts at a rectangle around these points,
//!      o ─┼─┼────────►            at a different t for each ray.
//!         └─┘
//! ```

use intertri::simd::{Lanes, Mask, Simd, Vec3};
use intertri::{Ray, RayPacket};

use crate::tree::Margin;
use crate::util::lane_ops::smallest;
use crate::walk::single::Slabs;

/// The number of rays in a beam.
pub(super) const RAYS: usize = 16;

/// The error of points on the plane, as a fraction of the coordinates of the origins: 8u.
const OFF: f32 = 1.0 / (1 << 21) as f32;

/// The maximum sum of the magnitudes of an origin's coordinates: 2^100.
const FAR_OUT: f32 = f32::from_bits((127 + 100) << 23);

/// A plane through the coordinate origin, perpendicular to a coordinate axis, onto which points are
/// projected along a direction.
#[derive(Clone, Copy)]
pub(crate) struct ProjectionPlane {
    /// The axis of the direction's largest component, followed by the other two axes.
    pub(crate) axes: [usize; 3],
    /// The direction's slopes along the other two axes.
    pub(crate) slope: [f64; 2],
}

impl ProjectionPlane {
    #[inline(always)]
    pub(crate) fn new(dir: [f64; 3]) -> Self {
        let [x, y, z] = dir.map(f64::abs);
        let axes @ [along, a, b] = if x >= y && x >= z {
            [0, 1, 2]
        } else if y >= z {
            [1, 2, 0]
        } else {
            [2, 0, 1]
        };
        Self { axes, slope: [dir[a] / dir[along], dir[b] / dir[along]] }
    }

    /// Returns the intersection of the plane with the line through a point.
    #[inline(always)]
    pub(crate) fn place(&self, point: [f64; 3]) -> [f64; 2] {
        let ([along, a, b], [to_a, to_b]) = (self.axes, self.slope);
        [point[a] - point[along] * to_a, point[b] - point[along] * to_b]
    }
}

/// The volume around the lines of parallel rays.
pub(super) struct Tube<S: Simd> {
    /// A ray along the tube, from the centre of the lines' intersections with the plane.
    pub(super) axis: Ray,
    pub(super) slabs: Slabs,
    /// The maximum distance of a line from the tube's axis, measured along each coordinate.
    pub(super) reach: [f32; 3],
    /// The position of each ray's line relative to the axis.
    pub(super) beside: Vec3<S::F32x16>,
    /// A bound on the sum of the magnitudes of an origin's coordinates.
    pub(super) away: f32,
}

impl<S: Simd> Tube<S> {
    /// Creates the tube of rays that share a direction, have `t_min` 0, and have no far end.
    /// Returns `None` for other rays or if an origin is too far away.
    #[inline(always)]
    pub(super) fn new(packet: &RayPacket<RAYS>, margin: &Margin) -> Option<Self> {
        let (splat, load) = (S::F32x16::splat, |row: &[f32; RAYS]| S::F32x16::load(row));
        let dir = packet.ray(0).dir;
        let norm = Vec3::<S::F32x16>::load(&packet.origin).norm1();
        let alike = equal::<S>(&packet.dir[0], dir[0])
            & equal::<S>(&packet.dir[1], dir[1])
            & equal::<S>(&packet.dir[2], dir[2])
            & equal::<S>(&packet.t_min, 0.0)
            & equal::<S>(&packet.t_max, f32::INFINITY)
            & norm.lt(splat(FAR_OUT));
        if alike.bits() != 0xffff {
            return None;
        }

        let ProjectionPlane { axes: [along, a, b], slope } =
            ProjectionPlane::new(dir.map(f64::from));
        let away = -smallest::<S>(-norm);
        let off = away * OFF;
        let from = load(&packet.origin[along]);
        let (mut lo, mut hi, mut middle, mut reach) = ([0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]);
        let mut beside = [[0.0; RAYS]; 3];
        for (axis, slope) in [a, b].into_iter().zip(slope) {
            // Move each origin along its ray into the plane.
            let at = from.mul_add(splat(-slope as f32), load(&packet.origin[axis]));
            (lo[axis], hi[axis]) = (smallest::<S>(at) - off, off - smallest::<S>(-at));
            middle[axis] = 0.5 * lo[axis] + 0.5 * hi[axis];
            let (below, above) = (middle[axis] - lo[axis], hi[axis] - middle[axis]);
            reach[axis] = if below > above { below } else { above };
            (at - splat(middle[axis])).store(&mut beside[axis]);
        }

        // As measured from the plane, the tube starts where the first ray starts.
        let start = smallest::<S>(from * splat(1.0 / dir[along]));
        let axis = Ray::new(middle, dir).between(start - start.abs() * OFF, f32::INFINITY);
        let slabs = Slabs::around::<S>([lo, hi], dir, start, margin)?;
        Some(Self { axis, slabs, reach, beside: Vec3::load(&beside), away })
    }
}

/// Returns the lanes that are equal to a number. NaN is not.
#[inline(always)]
fn equal<S: Simd>(row: &[f32; RAYS], x: f32) -> <S::F32x16 as Lanes>::Mask {
    let (row, x) = (S::F32x16::load(row), S::F32x16::splat(x));
    row.le(x) & row.ge(x)
}

#[cfg(test)]
mod tests {
    use super::{RAYS, Tube};
    use crate::tree::Margin;
    use crate::util::test_numbers::random;
    use intertri::simd::{Lanes, Level, Simd, WithSimd};
    use intertri::{Ray, RayPacket};

    /// Computes the errors of the lines' positions, as multiples of the rounding error of an
    /// origin: the sum along both axes, and the largest error along a single axis.
    struct Off<'a>(&'a [Ray], Margin);
    impl WithSimd for Off<'_> {
        type Output = [f64; 2];
        #[inline(always)]
        fn run<S: Simd>(self) -> [f64; 2] {
            let tube = Tube::<S>::new(&RayPacket::new(self.0), &self.1).unwrap();
            let mut beside = [[0.0; RAYS]; 3];
            tube.beside.x.store(&mut beside[0]);
            tube.beside.y.store(&mut beside[1]);
            tube.beside.z.store(&mut beside[2]);
            let u = f64::from(f32::EPSILON) / 2.0;
            let mut most = [0.0_f64; 2];
            for (i, ray) in self.0.iter().enumerate() {
                let (o, d) = (ray.origin.map(f64::from), ray.dir.map(f64::from));
                let m = (0..3).max_by(|&a, &b| d[a].abs().total_cmp(&d[b].abs())).unwrap();
                let norm = o.iter().fold(0.0, |sum, x| sum + x.abs());
                let off = [0, 1, 2].map(|k| {
                    let b = f64::from(beside[k][i]);
                    let at = f64::from(tube.axis.origin[k]) + b;
                    let exact = if k == m { 0.0 } else { o[k] - o[m] * d[k] / d[m] };
                    ((at - exact).abs() - u * b.abs()).max(0.0) / (u * norm)
                });
                most[0] = most[0].max(off.iter().sum());
                most[1] = off.iter().fold(most[1], |most, &off| most.max(off));
            }
            most
        }
    }

    /// Checks that the errors are at most 6 and 4 times the rounding error of an origin. The first
    /// error exceeds half of what the filter allows: `AWAY = 7u` in `exact.md`.
    #[test]
    fn places_on_the_plane_are_known_so_well() {
        let margin = Margin::new(1.0, None);
        let (mut random, mut most) = (random(), [0.0_f64; 2]);
        for _ in 0..100_000 {
            // Choose directions for which the error is proportional to a single coordinate, and
            // mostly coordinates with a relatively large ulp.
            let dir = [0.9999 - 1e-3 * random(), 0.9999 - 1e-3 * random(), 1.0];
            let ray = |_| {
                let origin = [1e-3 * random(), 1e-3 * random(), 1.0 + 1e-2 * random()];
                Ray::new(origin, dir)
            };
            let rays: Vec<Ray> = (0..RAYS).map(ray).collect();
            for level in Level::all() {
                let [both, one] = level.run(Off(&rays, margin));
                most = [most[0].max(both), most[1].max(one)];
            }
        }
        assert!(most[0] <= 6.0 && most[1] <= 4.0 && most[0] > 3.5, "{most:?}");
    }
}
