//! One ray against the eight boxes of a node, so that no hit is ever lost.
//!
//! ```text
//!        lo      hi               near = lo·rd - (o·rd + pad·|rd|)
//!   o ───│───────│──► d           far  = hi·rd - (o·rd - pad·|rd|)
//!      pad     pad                and the other way round where d < 0
//! ```
//!
//! The padding is in the ray's constants, so a node costs one multiply-add a plane. It covers the
//! rounding here and in the reference; `docs/numerics/hierarchy.md` has the proof.

use intertri::Ray;
use intertri::simd::Vec3;
use intertri::simd::{Lanes, Simd};

use crate::tree::Node;

/// The padding, relative to the largest coordinate of origin and scene: 2^-19.
const PAD: f32 = 1.0 / (1 << 19) as f32;

/// No direction component counts as smaller than this share of the largest, which moves no point of
/// the ray by more than a part of the padding: 2^-36.
const STEEPEST: f32 = 1.0 / (1_u64 << 36) as f32;

/// What underflow can take: 2^-120.
const TINY: f32 = f32::from_bits((127 - 120) << 23);

/// Beyond this, products could overflow: 2^120.
const HUGE: f32 = f32::from_bits((127 + 120) << 23);

/// Bit k: the direction is negative along axis k.
#[inline(always)]
pub(crate) fn octant(ray: &Ray) -> usize {
    let [x, y, z] = ray.dir.map(|d| usize::from(d.is_sign_negative()));
    x | y << 1 | z << 2
}

/// The largest coordinate.
#[inline(always)]
fn largest([x, y, z]: [f32; 3]) -> f32 {
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    larger(larger(x.abs(), y.abs()), z.abs())
}

/// A ray as the slab test wants it: x, y, z, and one that does not count.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Slabs {
    /// One over the direction.
    rd: [f32; 4],
    /// The ray's part of the near planes' t, which is taken from a side's, with the other sign.
    minus_near: [f32; 4],
    /// The ray's part of the far planes' t, likewise.
    minus_far: [f32; 4],
}

impl Slabs {
    /// A ray in a scene whose coordinates reach to ±`reach`. `None` where the numbers are too large
    /// or too small for f32: then only a plain loop is safe.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(ray: &Ray, reach: f32) -> Option<Self> {
        Self::around::<S>((ray.origin, ray.origin), ray.dir, largest(ray.origin) + reach)
    }

    /// The same of parallel lines that meet a box, where nothing is farther out than `far_off`.
    #[inline(always)]
    pub(crate) fn around<S: Simd>(
        (lo, hi): ([f32; 3], [f32; 3]),
        dir: [f32; 3],
        far_off: f32,
    ) -> Option<Self> {
        let length = largest(dir);

        // Everything below is at most this large, and length is not so small that it is lost.
        if !(far_off < length * (STEEPEST * HUGE) && length > TINY / STEEPEST && length < HUGE) {
            return None;
        }

        let [dx, dy, dz] = dir;
        let load = |[x, y, z]: [f32; 3]| S::F32x4::load(&[x, y, z, 0.0]);
        let dir = S::F32x4::load(&[dx, dy, dz, length]);
        let splat = S::F32x4::splat;
        let rd = splat(1.0) / dir.abs().max(splat(length * STEEPEST)).flip(dir);
        let (a, b) = (load(lo) * rd, load(hi) * rd);
        let pad = splat(far_off * PAD + TINY) * rd.abs() + splat(TINY);
        let mut slabs = Self::default();
        rd.store(&mut slabs.rd);
        (-(a.max(b) + pad)).store(&mut slabs.minus_near);
        (pad - a.min(b)).store(&mut slabs.minus_far);
        Some(slabs)
    }
}

/// A ray's slabs in lanes.
#[derive(Clone, Copy)]
pub(crate) struct SlabLanes<F> {
    rd: Vec3<F>,
    minus_near: Vec3<F>,
    minus_far: Vec3<F>,
    negative: [bool; 3],
}

impl<F: Lanes<Scalar = f32>> SlabLanes<F> {
    /// The same ray in every lane.
    #[inline(always)]
    pub(crate) fn splat(slabs: &Slabs, octant: usize) -> Self {
        let splat = |v: &[f32; 4]| Vec3::splat([v[0], v[1], v[2]]);
        Self {
            rd: splat(&slabs.rd),
            minus_near: splat(&slabs.minus_near),
            minus_far: splat(&slabs.minus_far),
            negative: [0, 1, 2].map(|k| octant >> k & 1 != 0),
        }
    }

    /// Which of a node's boxes the ray meets within `t_min..=t_max`, and from which t on. No box
    /// that holds a hit in that interval is missing.
    #[inline(always)]
    pub(crate) fn meet(&self, node: &Node, t_min: f32, t_max: f32) -> (F::Mask, F) {
        // Along each axis the ray enters through one plane and leaves through the other.
        let [x, y, z] = self.negative;
        let first = |axis, negative| F::load(node.sides(axis, negative));
        let last = |axis, negative: bool| F::load(node.sides(axis, !negative));
        let near = (first(0, x).mul_add(self.rd.x, self.minus_near.x))
            .max(first(1, y).mul_add(self.rd.y, self.minus_near.y))
            .max(first(2, z).mul_add(self.rd.z, self.minus_near.z).max(F::splat(t_min)));
        let far = (last(0, x).mul_add(self.rd.x, self.minus_far.x))
            .min(last(1, y).mul_add(self.rd.y, self.minus_far.y))
            .min(last(2, z).mul_add(self.rd.z, self.minus_far.z).min(F::splat(t_max)));
        (near.le(far), near)
    }
}
