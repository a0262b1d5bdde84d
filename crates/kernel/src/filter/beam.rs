//! A packet of rays from one origin as a whole: a box of directions against eight triangles at once.
//!
//! ```text
//!           d in  middle ± reach, axis by axis:    f·d  <=  f·middle + |f|·reach
//! ```
//!
//! Where that is surely negative for a form of a triangle, its edge makes a sure miss of every ray. Rays that are
//! alike hit few of many triangles, and only those are looked at ray by ray. Bound and proof:
//! `docs/numerics/certified.md`.

use crate::simd::Vec3;
use crate::simd::{Lanes, Mask};

use super::bound;
use super::edges::Rays;
use super::shared_origin::SharedOriginBlock;

/// The box of a packet's directions.
#[derive(Clone, Copy)]
pub(super) struct Beam {
    middle: [f32; 3],
    reach: [f32; 3],
    /// No less than the length of any direction, and of middle and reach together; NaN where f32 must
    /// not decide about a ray.
    len: f32,
}

impl Beam {
    /// Of N rays; dead lanes may only widen it.
    #[inline(always)]
    pub(super) fn of<F: Lanes<Scalar = f32>, const N: usize>(rays: &Rays<F>) -> Self {
        let (mut dir, mut lens) = ([[0.0; N]; 3], [0.0; N]);
        rays.dir().store(&mut dir);
        rays.len().store(&mut lens);
        let (mut middle, mut reach, mut len) = ([0.0; 3], [0.0; 3], 0.0_f32);
        for axis in 0..3 {
            let (mut lo, mut hi) = (f32::INFINITY, f32::NEG_INFINITY);
            for x in dir[axis] {
                lo = if x < lo { x } else { lo };
                hi = if x > hi { x } else { hi };
            }
            middle[axis] = 0.5 * lo + 0.5 * hi;
            // Half the width, and more than all of these roundings.
            let size = if -lo > hi { -lo } else { hi };
            reach[axis] = 0.5 * (hi - lo) + size * bound::BEAM_REACH;
            len += size + reach[axis];
        }
        for x in lens {
            len = if x.is_nan() { x } else { len };
        }
        Self { middle, reach, len }
    }

    /// Which of eight triangles a ray may hit.
    #[inline(always)]
    pub(super) fn maybe<F: Lanes<Scalar = f32>>(&self, block: &SharedOriginBlock) -> u32 {
        let (middle, reach) = (Vec3::<F>::splat(self.middle), Vec3::<F>::splat(self.reach));
        let len = F::splat(self.len);
        let [u, v, w] = &block.forms;
        let (u, v, w) = (Vec3::<F>::load(u), Vec3::load(v), Vec3::load(w));

        // The most that a form comes to. Negative: its edge makes a sure miss.
        let slack = len * F::splat(bound::BEAM);
        let least = Self::most(u, middle, reach).min(Self::most(v, middle, reach));
        let least = least.min(Self::most(w, middle, reach)) + slack;

        // The sum of three is the denominator, of one sign all over the beam or not to be trusted.
        let sum = u + v + w;
        let (middle, reach) = (sum.dot_fused(middle), sum.abs().dot_fused(reach));
        let doubt = len.mul_add(F::load(&block.doubtful), reach);
        let ahead = middle.gt(doubt);
        let behind = middle.lt(-doubt);
        !(behind | (ahead & least.lt(F::splat(0.0)))).bits() & block.live
    }

    /// The most that a form comes to, but for rounding.
    #[inline(always)]
    fn most<F: Lanes<Scalar = f32>>(form: Vec3<F>, middle: Vec3<F>, reach: Vec3<F>) -> F {
        form.abs().dot_add(reach, form.dot_fused(middle))
    }
}
