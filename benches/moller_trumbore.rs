//! A plain f32 test without an error bound, for comparison with `certified`: Möller and Trumbore,
//! "Fast, minimum storage ray/triangle intersection" (1997), two-sided, without an epsilon. The
//! closest hit is found without branches.

use intertri::simd::{Lanes, Simd, Vec3, WithSimd};
use intertri::{Ray, RayPacket, Triangle, TriangleOf};

use crate::Answer;

/// Finds the closest hits of all packets among all triangles, eight or sixteen rays at a time.
pub struct MollerTrumbore<'a, const N: usize> {
    /// The rays.
    pub packets: &'a [RayPacket<N>],
    /// The first corner and two edges of each triangle.
    pub triangles: &'a [[[f32; 3]; 3]],
}

/// Returns the first corner and the two edges that the test needs.
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

/// Returns the t of a hit, in plain scalar f32. Returns early as soon as a barycentric coordinate
/// shows a miss. This is the code that most people would write.
#[inline(always)]
fn hit(ray: &Ray, TriangleOf([a, b, c]): &Triangle, t_max: f32) -> Option<f32> {
    let sub = |p: &[f32; 3], q: &[f32; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let dot = |p: &[f32; 3], q: &[f32; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let cross = |p: &[f32; 3], q: &[f32; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let (e1, e2) = (sub(b, a), sub(c, a));
    let p = cross(&ray.dir, &e2);
    let det = dot(&e1, &p);
    if det == 0.0 {
        return None;
    }
    let inv = 1.0 / det;
    let s = sub(&ray.origin, a);
    let u = dot(&s, &p) * inv;
    if !(0.0..=1.0).contains(&u) {
        return None;
    }
    let q = cross(&s, &e1);
    let v = dot(&ray.dir, &q) * inv;
    if v < 0.0 || u + v > 1.0 {
        return None;
    }
    let t = dot(&e2, &q) * inv;
    (t > ray.t_min && t < t_max).then_some(t)
}

/// Finds the closest hit of each ray among the triangles in a slice.
pub fn scalar_closest(rays: &[Ray], triangles: &[Triangle]) -> Answer {
    let mut answer = Answer::default();
    for ray in rays {
        let (mut t_max, mut closest) = (ray.t_max, None);
        for (i, triangle) in triangles.iter().enumerate() {
            if let Some(t) = hit(ray, triangle, t_max) {
                (t_max, closest) = (t, Some(i as u64));
            }
        }
        if let Some(i) = closest {
            answer.add(i, f64::from(t_max));
        }
    }
    answer
}

/// Counts the rays that hit a triangle in the slice.
pub fn scalar_any(rays: &[Ray], triangles: &[Triangle]) -> Answer {
    let any = |ray: &&Ray| triangles.iter().any(|t| hit(ray, t, ray.t_max).is_some());
    Answer { hits: rays.iter().filter(any).count() as u64, mixed: 0 }
}
