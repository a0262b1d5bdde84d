//! Computes the f32 copies of many f64 rays, with the eight values of each ray in lanes.

use alloc::vec::Vec;

use super::{FAR_OUT, LocalFrame, SAME, below, end, pow2};
use crate::simd::{Lanes, Level, Mask, Simd, WithSimd};
use crate::{Ray, Ray64};

impl LocalFrame {
    /// Computes the copies of rays, with the same results as [`LocalFrame::ray`].
    #[inline]
    pub fn rays(&self, level: Level, rays: &[Ray64], copies: &mut Vec<Ray>) {
        copies.resize(rays.len(), super::DEAD);
        level.run(Copies { frame: self, rays, copies });
    }
}

struct Copies<'a> {
    frame: &'a LocalFrame,
    rays: &'a [Ray64],
    copies: &'a mut [Ray],
}

impl WithSimd for Copies<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { frame, rays, copies } = self;
        let ([x, y, z], scale) = (frame.centre, pow2(frame.up));
        let centre = S::F64x8::load(&[x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let scale = S::F64x8::load(&[scale, scale, scale, 1.0, scale, scale, scale, 1.0]);
        // Within these limits, the copy's t is the ray's t, and the ray's origin need not be
        // clamped.
        let (least, most) = (pow2(-SAME), pow2(SAME));
        let infinity = f64::INFINITY;
        let most = [FAR_OUT, FAR_OUT, FAR_OUT, infinity, most, most, most, infinity];
        let most = S::F64x8::load(&most);
        let least = S::F64x8::splat(least);
        for (ray, copy) in rays.iter().zip(copies) {
            let numbers: &[f64; 8] = bytemuck::cast_ref(ray);
            let placed = (S::F64x8::load(numbers) - centre) * scale;
            let size = placed.abs();
            let goes = size.ge(least).bits() & 0b0111_0000 != 0;
            let has_interval = ray.t_min < ray.t_max && ray.t_max > 0.0;
            // The comparison is false for NaN.
            if goes & has_interval && size.le(most).bits() == 0b1111_1111 {
                let to: &mut [f32; 8] = bytemuck::cast_mut(copy);
                placed.store_f32(to);
                copy.t_min = below(ray.t_min.max(0.0));
                copy.t_max = end(ray.t_max);
            } else {
                *copy = frame.odd_ray(ray);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::LocalFrame;
    use crate::simd::Level;
    use crate::{Ray, Ray64};

    /// Tests ordinary and unusual rays at every level.
    #[test]
    fn copies_in_lanes_are_those_of_one_ray() {
        let frame = LocalFrame::around(
            [[4e5, 5e6, -7.0], [5e5, 5.2e6, 900.0]],
            [[4e5, 5e6, -7.0], [5e5, 5.2e6, 900.0]],
        );
        let numbers =
            [4.3e5, -1.0, 0.1, 0.0, -0.0, 1e-300, 1e25, 3e40, f64::MAX, f64::INFINITY, f64::NAN];
        let at = |i: usize| numbers[i % numbers.len()];
        let rays: Vec<Ray64> = (0..numbers.len().pow(4))
            .map(|i| {
                let [a, b, c] = [i / 11, i / 121, i / 1331].map(at);
                let near = Ray64::new([4.3e5 + a, 5.1e6, 3.0], [0.3, b, -7.0]);
                match i % 4 {
                    0 => Ray64 { t_min: a, t_max: b, ..near },
                    1 => Ray64 { dir: [a, b, c], ..near },
                    2 => Ray64 { origin: [a, b, c], t_min: at(i), ..near },
                    _ => near,
                }
            })
            .collect();
        let bits = |ray: &Ray| bytemuck::cast::<Ray, [u32; 8]>(*ray);
        let mut copies = Vec::new();
        for level in Level::all() {
            frame.rays(level, &rays, &mut copies);
            for (ray, copy) in rays.iter().zip(&copies) {
                assert_eq!(bits(copy), bits(&frame.ray(ray)), "{ray:?}");
            }
        }
    }
}
