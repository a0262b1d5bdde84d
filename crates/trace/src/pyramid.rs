//! The pyramid around rays that share an origin, against the eight boxes of a node.
//!
//! ```text
//!            ╱│ far corner: inside of all four planes?
//!         ╱ ┌─┼──┐
//!   o  ◄────┤ │  │   near corner: before the farthest t that still counts?
//!         ╲ └────┘
//!            ╲
//! ```
//!
//! No ray is tested against any box. `docs/numerics/hierarchy.md` proves that nothing is lost.

use intertri::lanes::{Lanes, Mask, Simd};
use intertri::{Ray, Vec3};

use crate::node::Node;

/// The padding of a plane, relative to the largest coordinate of origin and scene: 2^-18.
const PAD: f32 = 1.0 / (1 << 18) as f32;

/// The slopes reach this much further than those of any ray: 2^-18.
const MARGIN: f32 = 1.0 / (1 << 18) as f32;

/// Coordinates and lengths beyond this, or below its reciprocal, are nothing for a pyramid: 2^30.
const LARGEST: f32 = (1 << 30) as f32;

/// A plane through the origin, looking inwards.
#[derive(Clone, Copy, Debug, Default)]
struct Plane {
    normal: [f32; 3],
    /// `normal · origin`
    at: f32,
    /// What rounding can take.
    pad: f32,
}

impl Plane {
    fn new(normal: [f32; 3], origin: [f32; 3], reach: f32) -> Self {
        let size = normal[0].abs() + normal[1].abs() + normal[2].abs();
        Self { normal, at: dot(normal, origin), pad: PAD * reach * size + f32::MIN_POSITIVE }
    }

    /// The largest signed distances of eight boxes, in multiples of the normal's length; with `low`,
    /// the smallest.
    #[inline(always)]
    fn of_boxes<F: Lanes<Scalar = f32>>(&self, node: &Node, low: bool) -> F {
        let Self { normal, at, .. } = *self;
        let x = if (normal[0] > 0.0) == low { &node.lo[0] } else { &node.hi[0] };
        let y = if (normal[1] > 0.0) == low { &node.lo[1] } else { &node.hi[1] };
        let z = if (normal[2] > 0.0) == low { &node.lo[2] } else { &node.hi[2] };
        let sum = F::load(x).mul_add(F::splat(normal[0]), F::splat(-at));
        let sum = F::load(y).mul_add(F::splat(normal[1]), sum);
        F::load(z).mul_add(F::splat(normal[2]), sum)
    }
}

/// Four planes around rays from one origin, and the axis along which they go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pyramid {
    sides: [Plane; 4],
    axis: Plane,
    /// Bit k: the axis is negative along coordinate k.
    pub(crate) octant: usize,
}

impl Pyramid {
    /// The pyramid around some rays, which start where the first one does; in a scene whose
    /// coordinates reach to ±`reach`. `dirs[i][axis][lane]` are the directions. `None` where they go
    /// too far apart, or numbers are too large or too small.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(
        first: [&Ray; 2],
        dirs: &[[[f32; 16]; 3]],
        reach: f32,
    ) -> Option<Self> {
        let splat = S::F32x16::splat;
        let origin = first[0].origin;
        let reach = origin.iter().fold(reach, |m, x| m.max(x.abs()));
        if reach >= LARGEST {
            return None;
        }

        // Along the rays, across them as the first two lie, and across both.
        let mut sum = [splat(0.0); 3];
        for dir in dirs {
            for k in 0..3 {
                sum[k] = sum[k] + S::F32x16::load(&dir[k]);
            }
        }
        let mut axis = [0.0; 3];
        for k in 0..3 {
            let mut lanes = [0.0; 16];
            sum[k].store(&mut lanes);
            axis[k] = lanes.iter().sum();
        }
        let axis = unit(axis)?;
        let step = [0, 1, 2].map(|k| first[1].dir[k] - first[0].dir[k]);
        let along = dot(step, axis);
        let right = unit([0, 1, 2].map(|k| step[k] - along * axis[k]))
            .or_else(|| unit(cross(axis, [1.0, 0.0, 0.0])))
            .or_else(|| unit(cross(axis, [0.0, 1.0, 0.0])))?;
        let up = cross(axis, right);

        // The slopes of all rays.
        let mut right_slope = (splat(f32::INFINITY), splat(f32::NEG_INFINITY));
        let mut up_slope = right_slope;
        let mut sane = S::F32x16::splat(0.0).le(splat(1.0));
        for dir in dirs {
            let d = Vec3::<S::F32x16>::load(dir);
            let (square, forward) = (d.dot_fused(d), d.dot_fused(Vec3::splat(axis)));
            sane = sane
                & forward.gt(splat(1.0 / LARGEST))
                & forward.lt(splat(LARGEST))
                & (forward * forward).gt(square * splat(0.25));
            let recip = splat(1.0) / forward;
            let (a, b) =
                (d.dot_fused(Vec3::splat(right)) * recip, d.dot_fused(Vec3::splat(up)) * recip);
            right_slope = (right_slope.0.min(a), right_slope.1.max(a));
            up_slope = (up_slope.0.min(b), up_slope.1.max(b));
        }
        if sane.bits() != 0xffff {
            return None;
        }
        let (left, right_most) = ends(right_slope);
        let (low, high) = ends(up_slope);

        let plane = |v: [f32; 3]| Plane::new(v, origin, reach);
        let leaning = |across: [f32; 3], slope: f32, sign: f32| {
            plane([0, 1, 2].map(|k| sign * (across[k] - slope * axis[k])))
        };
        let sides = [
            leaning(right, left, 1.0),
            leaning(right, right_most, -1.0),
            leaning(up, low, 1.0),
            leaning(up, high, -1.0),
        ];
        let octant = usize::from(axis[0] < 0.0)
            | usize::from(axis[1] < 0.0) << 1
            | usize::from(axis[2] < 0.0) << 2;
        Some(Self { sides, axis: plane(axis), octant })
    }

    /// The direction along which depth is measured.
    pub(crate) fn axis(&self) -> [f32; 3] {
        self.axis.normal
    }

    /// Which of a node's boxes a ray may meet before the depth `far`, and from which depth on.
    #[inline(always)]
    pub(crate) fn meet<F: Lanes<Scalar = f32>>(&self, node: &Node, far: f32) -> (u32, F) {
        let near = self.axis.of_boxes::<F>(node, true) - F::splat(self.axis.pad);
        let mut met = near.le(F::splat(far));
        for side in &self.sides {
            met = met & side.of_boxes::<F>(node, false).ge(F::splat(-side.pad));
        }
        (met.bits(), near)
    }
}

/// The smallest and largest slope, and a little beyond.
#[inline(always)]
fn ends<F: Lanes<Scalar = f32>>((lo, hi): (F, F)) -> (f32, f32) {
    let (mut a, mut b) = ([0.0; 16], [0.0; 16]);
    lo.store(&mut a);
    hi.store(&mut b);
    (
        a.into_iter().fold(f32::INFINITY, f32::min) - MARGIN,
        b.into_iter().fold(f32::NEG_INFINITY, f32::max) + MARGIN,
    )
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The vector of length 1, or `None` where the length is nearly nothing or not finite.
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let square = dot(v, v);
    (square > f32::MIN_POSITIVE * LARGEST && square < f32::MAX)
        .then(|| v.map(|x| x / square.sqrt()))
}
