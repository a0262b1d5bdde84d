//! The plain, uncertified f32 test that certified is held against: Möller and Trumbore, "Fast, minimum
//! storage ray/triangle intersection" (1997), two-sided, without an epsilon. The closest hit, without
//! a branch.

use intertri::simd::{Lanes, Simd, Vec3, WithSimd};
use intertri::{RayPacket, Triangle, TriangleOf};

use crate::Answer;

/// The closest hits of all packets among all triangles, eight or sixteen rays at a time.
pub struct MollerTrumbore<'a, const N: usize> {
    /// The rays.
    pub packets: &'a [RayPacket<N>],
    /// First corner and two edges.
    pub triangles: &'a [[[f32; 3]; 3]],
}

/// The corner and the edges that the test wants.
pub fn edges(TriangleOf([a, b, c]): &Triangle) -> [[f32; 3]; 3] {
    let sub = |p: &[f32; 3]| [0, 1, 2].map(|k| p[k] - a[k]);
    [*a, sub(b), sub(c)]
}

impl<const N: usize> MollerTrumbore<'_, N> {
    #[inline(always)]
    fn with_lanes<F: Lanes<Scalar = f32>>(&self) -> Answer {
        let mut answer = Answer::default();
        for packet in self.packets {
            let (org, dir) = (Vec3::<F>::load(&packet.origin), Vec3::<F>::load(&packet.dir));
            let t_min = F::load(&packet.t_min);
            let mut best = F::load(&packet.t_max);
            let mut index = F::splat(f32::NAN);
            for (i, &[a, e1, e2]) in self.triangles.iter().enumerate() {
                let (a, e1, e2) = (Vec3::splat(a), Vec3::splat(e1), Vec3::splat(e2));
                let p = dir.cross_fused(e2);
                let inv = F::splat(1.0) / e1.dot_fused(p);
                let s = org - a;
                let u = s.dot_fused(p) * inv;
                let q = s.cross_fused(e1);
                let v = dir.dot_fused(q) * inv;
                let t = e2.dot_fused(q) * inv;
                let zero = F::splat(0.0);
                let inside = u.ge(zero) & v.ge(zero) & (u + v).le(F::splat(1.0));
                let hit = inside & t.gt(t_min) & t.lt(best);
                best = F::select(hit, t, best);
                index = F::select(hit, F::splat(i as f32), index);
            }
            let (mut ts, mut indices) = ([0.0; N], [0.0; N]);
            best.store(&mut ts);
            index.store(&mut indices);
            for (t, index) in ts.into_iter().zip(indices) {
                if !index.is_nan() {
                    answer.add(index as u64, f64::from(t));
                }
            }
        }
        answer
    }
}

impl WithSimd for MollerTrumbore<'_, 8> {
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        self.with_lanes::<S::F32x8>()
    }
}

impl WithSimd for MollerTrumbore<'_, 16> {
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        self.with_lanes::<S::F32x16>()
    }
}
