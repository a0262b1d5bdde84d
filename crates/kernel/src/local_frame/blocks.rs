//! Computes the f32 copies of eight f64 triangles in lanes.

use super::{LocalFrame, nonzero_edge, pow2};
use crate::packet::TriangleBlock;
use crate::simd::{Lanes, Mask, Simd, Vec3};

impl LocalFrame {
    /// Computes the copies of eight triangles in lanes, with the same results as
    /// [`LocalFrame::triangle`]. `corners[k][axis][lane]` belongs to corner k+1. Lanes that are not
    /// `live` are dead.
    #[inline(always)]
    pub fn block_in<S: Simd>(&self, corners: &[[[f64; 8]; 3]; 3], live: u32) -> TriangleBlock<8> {
        let (centre, scale) =
            (Vec3::<S::F64x8>::splat(self.centre), S::F64x8::splat(pow2(self.up)));
        let [c1, c2, c3] = corners;
        let (c1, c2, c3) = (Vec3::<S::F64x8>::load(c1), Vec3::load(c2), Vec3::load(c3));
        // Multiplying by a power of two is exact, so a coordinate is rounded only twice: by the
        // difference in f64 and by the conversion to f32.
        let at = (c1 - centre) * scale;
        let (minus_h4, h5, h6) = ((c1 - c2) * scale, (c3 - c1) * scale, (c3 - c2) * scale);
        let mut block = TriangleBlock::of_copied_lanes([at, minus_h4, h5], h6, live);
        let [first, rest @ ..] = corners;
        for (edges, ends) in block.edges_of_copies().iter_mut().zip(rest) {
            for axis in 0..3 {
                for lane in 0..8 {
                    let edge = &mut edges[axis][lane];
                    *edge = nonzero_edge(*edge, first[axis][lane], ends[axis][lane]);
                }
            }
        }
        block
    }

    /// Computes the box around all live triangles; the box of each triangle is the same as in
    /// [`LocalFrame::bounds`]. The triangles must be finite. If no triangle is live, the box is
    /// inverted: its lower sides are infinity and its upper sides are minus infinity.
    #[inline(always)]
    pub fn bounds_in<S: Simd>(&self, corners: &[[[f64; 8]; 3]; 3], live: u32) -> [[f32; 3]; 2] {
        let scale = S::F64x8::splat(pow2(self.up));
        let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        if live == 0 {
            return bounds;
        }
        let live = <S::F32x8 as Lanes>::Mask::from_bits(live);
        let [c1, c2, c3] = corners;
        for axis in 0..3 {
            let centre = S::F64x8::splat(self.centre[axis]);
            let (a, b) = (S::F64x8::load(&c1[axis]), S::F64x8::load(&c2[axis]));
            let c = S::F64x8::load(&c3[axis]);
            // Rounding preserves order, so only the extremes need to be rounded.
            let (mut lo, mut hi) = ([0.0; 8], [0.0; 8]);
            ((a.min(b).min(c) - centre) * scale).store_f32(&mut lo);
            ((a.max(b).max(c) - centre) * scale).store_f32(&mut hi);
            let (least, most) = (bounds[0][axis], bounds[1][axis]);
            // Dead lanes must not widen the box.
            Lanes::select(live, S::F32x8::load(&lo), S::F32x8::splat(least)).store(&mut lo);
            Lanes::select(live, S::F32x8::load(&hi), S::F32x8::splat(most)).store(&mut hi);
            bounds[0][axis] = lo.into_iter().fold(least, f32::min).next_down();
            bounds[1][axis] = hi.into_iter().fold(most, f32::max).next_up();
        }
        bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Level, WithSimd};
    use crate::{Triangle64, TriangleOf};

    struct Eight<'a>(&'a LocalFrame, &'a [[[f64; 8]; 3]; 3], u32);

    impl WithSimd for Eight<'_> {
        type Output = (TriangleBlock<8>, [[f32; 3]; 2]);
        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            let Self(frame, corners, live) = self;
            (frame.block_in::<S>(corners, live), frame.bounds_in::<S>(corners, live))
        }
    }

    /// Tests ordinary and unusual triangles at every level.
    #[test]
    fn copies_in_lanes_are_those_of_one_triangle() {
        let frame = LocalFrame::around(
            [[4e5, 5e6, -7.0], [5e5, 5.2e6, 900.0]],
            [[4e5, 5e6, -7.0], [5e5, 5.2e6, 900.0]],
        );
        let numbers = [4.3e5, -1.0, 0.1, 0.0, -0.0, 1e-300, 1e25, -3e60, f64::MAX, 5.1e6, -7.0];
        let mut random = 1_u64;
        let mut next = || {
            random = random.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (random >> 33) as usize
        };
        for _ in 0..3000 {
            let (mut corners, live) = ([[[0.0; 8]; 3]; 3], next() as u32 & 0xff);
            for x in corners.as_flattened_mut().as_flattened_mut() {
                *x = 4.5e5 + (next() % 1000) as f64 / 7.0;
                if next() % 16 == 0 {
                    *x = numbers[next() % numbers.len()];
                }
            }
            let triangle = |lane: usize| -> Triangle64 {
                let corner = |k: usize| [0, 1, 2].map(|axis| corners[k][axis][lane]);
                TriangleOf([corner(0), corner(1), corner(2)])
            };
            let copies: [_; 8] = core::array::from_fn(|lane| frame.triangle(&triangle(lane)));
            let one_by_one = TriangleBlock::of_copies(&copies);
            let mut around = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
            for lane in (0..8).filter(|lane| live >> lane & 1 != 0) {
                let [lo, hi] = frame.bounds(&triangle(lane)).expect("the triangle is finite");
                for k in 0..3 {
                    around[0][k] = around[0][k].min(lo[k]);
                    around[1][k] = around[1][k].max(hi[k]);
                }
            }
            for level in Level::all() {
                let (block, bounds) = level.run(Eight(&frame, &corners, live));
                assert_eq!((block.live(), bounds), (live, around), "{corners:?}");
                let bits = |block: &TriangleBlock<8>| {
                    let longest = block.longest_edges().map(|x| x.to_bits() & !(1 << 31));
                    (block.corners().map(|rows| rows.map(|row| row.map(f32::to_bits))), longest)
                };
                let (parts, longest) = bits(&block);
                let (expected_parts, expected_longest) = bits(&one_by_one);
                assert_eq!(parts, expected_parts, "{corners:?}");
                // Treat all NaNs as equal.
                for (a, b) in longest.into_iter().zip(expected_longest) {
                    let same = a == b || (f32::from_bits(a).is_nan() && f32::from_bits(b).is_nan());
                    assert!(same, "{corners:?}");
                }
            }
        }
    }
}
