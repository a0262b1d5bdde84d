//! Where rays from one origin cross the triangles that they are known to cross, in f64 lanes that hold
//! integers.
//!
//! ```text
//!   num:  n . a   v . dir   w . dir              a component of n, v or w has 43 bits, one of dir 18:
//!   den:  n . dir n . dir   n . dir              high and low halves of the former give sums that are
//!           = t     = u       = v    triangle    exact, and the two of them a number in two parts
//! ```

use super::quotient::{Parts, quotient, sum};
use crate::Hit;
use crate::barycentric::Coefficients;
use crate::hit_attributes::SharedOriginHit;
use crate::simd::Vec3;
use crate::simd::{Lanes, Mask, Simd, put_by_triangle};

/// A triangle of a grid as it is seen from one origin, ready to tell where a ray from there crosses it.
///
/// ```
/// use intertri::fixed::{Bits, Crossing, Grid, HitCoefficients, Ray};
/// use intertri::internal::SharedOriginHit;
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{Hit, TriangleBlock};
///
/// struct Meet<'a>(&'a TriangleBlock<8>, &'a Ray);
/// impl WithSimd for Meet<'_> {
///     type Output = (Hit, bool);
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let (mut coefficients, mut hit) = ([HitCoefficients::default(); 8], Hit::MISS);
///         let (corners, origin) = (self.0.corners(), self.1.to_f32().origin);
///         let indices = [0, 1, 2, 3, 4, 5, 6, 7];
///         HitCoefficients::eight_in::<S>(corners, &indices, origin, &mut coefficients);
///         let sure = coefficients[3].hit_in::<S>(self.1.to_f32().dir, &mut hit);
///         (hit, sure)
///     }
/// }
///
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let wall = grid.triangle_of([[0, 0, 5], [40, 0, 7], [0, 40, 5]])?;
/// let ray = grid.ray_of([1, 1, 0], [4, 5, 3])?;
/// let (hit, sure) = dispatch(Meet(&TriangleBlock::new(&[wall.to_f32(); 8]), &ray));
/// assert_eq!((hit, sure), (Crossing::of(&ray, &wall).unwrap().to_hit(&ray, 3), true));
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct HitCoefficients {
    /// By half and axis, the coefficients of the denominator, of the numerators of u and v, and of the
    /// denominator again.
    coefficients: [[[f64; 4]; 3]; 2],
    /// By half, the numerator of t.
    known: [[f64; 4]; 2],
    index: u32,
}

/// Added to a number and taken away again, it leaves a multiple of `2^22`.
const HALVES: f64 = 1.5 * (1_u128 << 74) as f64;

/// A vector in two halves, each of few bits.
type Halves<F> = [Vec3<F>; 2];

#[inline(always)]
fn halves<F: Lanes<Scalar = f64>>(v: Vec3<F>) -> Halves<F> {
    let above = Vec3 { x: F::splat(HALVES), y: F::splat(HALVES), z: F::splat(HALVES) };
    let high = (v + above) - above;
    [high, v - high]
}

/// The dot product with a vector that is in halves, exactly.
#[inline(always)]
fn dot<F: Lanes<Scalar = f64>>([high, low]: Halves<F>, v: Vec3<F>) -> Parts<F> {
    sum(high.dot_fused(v), low.dot_fused(v))
}

impl SharedOriginHit for HitCoefficients {
    #[inline(always)]
    fn eight_in<S: Simd>(
        [c1, c2, c3]: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        origin: [f32; 3],
        to: &mut [Self; 8],
    ) {
        let corners = [Vec3::<S::F64x8>::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];

        // f64 hold each of these exactly.
        let [x, y, z] = origin;
        let origin = Vec3::splat([x.into(), y.into(), z.into()]);
        let Coefficients { a, n, v, w, .. } = Coefficients::of(corners, origin);
        let (n, v, w) = (halves(n), halves(v), halves(w));
        let num = dot(n, a);
        for half in [0, 1] {
            let vectors = [n[half], v[half], w[half], n[half]];
            put_by_triangle::<S>(vectors, to.iter_mut().map(|seen| &mut seen.coefficients[half]));
        }
        let mut known = [[0.0; 8]; 2];
        num[0].store(&mut known[0]);
        num[1].store(&mut known[1]);
        for (i, triangle) in to.iter_mut().enumerate() {
            triangle.known = [[known[0][i], 0.0, 0.0, 0.0], [known[1][i], 0.0, 0.0, 0.0]];
            triangle.index = indices[i];
        }
    }

    #[inline(always)]
    fn hit_in<S: Simd>(&self, [x, y, z]: [f32; 3], to: &mut Hit) -> bool {
        let dir = Vec3::<S::F64x4>::splat([x.into(), y.into(), z.into()]);
        let [high, low] = &self.coefficients;
        let sums = dot([Vec3::load(high), Vec3::load(low)], dir);
        let den = [S::first_and_last(sums[0]), S::first_and_last(sums[1])];
        let first = <S::F64x4 as Lanes>::Mask::from_bits(1);
        let [high, low] = &self.known;
        let num = [
            S::F64x4::select(first, S::F64x4::load(high), sums[0]),
            S::F64x4::select(first, S::F64x4::load(low), sums[1]),
        ];
        let (hit, sure) = quotient(num, den);

        // Zeros have no sign, and the last lane is none.
        let numbers: &mut [f64; 4] = bytemuck::cast_mut(to);
        hit.abs().store(numbers);
        (to.triangle, to.geometry) = (self.index, 0);
        sure.bits() & 0b111 == 0b111
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TriangleBlock;
    use crate::fixed::{Bits, Grid, Ratio, Ray, Triangle, scalar};
    use crate::simd::{Level, WithSimd};

    /// Where a ray crosses the triangles of a block, all from its origin.
    struct Cross<'a>(&'a TriangleBlock<8>, &'a Ray);
    impl WithSimd for Cross<'_> {
        type Output = [(Hit, bool); 8];
        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            let indices = [9, 8, 7, 6, 5, 4, 3, u32::MAX - 1];
            let mut coefficients = [HitCoefficients::default(); 8];
            HitCoefficients::eight_in::<S>(
                self.0.corners(),
                &indices,
                self.1.to_f32().origin,
                &mut coefficients,
            );
            let mut hits = [(Hit::MISS, false); 8];
            for (triangle, (hit, sure)) in coefficients.iter().zip(&mut hits) {
                *sure = triangle.hit_in::<S>(self.1.to_f32().dir, hit);
            }
            hits
        }
    }

    /// At the ends of every budget, and in between.
    #[test]
    fn what_is_sure_is_rounded_once() {
        let mut state = 3_u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            (state >> 33) % n
        };
        let (mut crossed, mut unsure) = (0, 0);
        for b in 1..=20 {
            let bits = Bits::of_grid(b).unwrap();
            let grid = Grid::at(bits, 3, [0; 3]).unwrap();
            let mut number = |end: i32| match below(6) {
                0 => end,
                1 => -end,
                2 => end - 1,
                3 => 0,
                _ => below(2 * end as u64 + 1) as i32 - end,
            };
            for _ in 0..4000 {
                let mut vector = |end| [number(end), number(end), number(end)];
                let (end, far) = (1 << bits.b(), 1 << bits.q());
                let (origin, dir) = (vector(end), vector(far));
                let triangles: [_; 8] = core::array::from_fn(|_| {
                    grid.triangle_of([vector(end), vector(end), vector(end)]).unwrap()
                });
                let Ok(ray) = grid.ray_of(origin, dir) else { continue };
                let block = TriangleBlock::new(&triangles.each_ref().map(Triangle::to_f32));
                for level in Level::all() {
                    let hits = level.run(Cross(&block, &ray));
                    for (lane, (hit, sure)) in hits.into_iter().enumerate() {
                        let Some(crossing) = scalar::crossing(&ray, &triangles[lane]) else {
                            continue;
                        };
                        let Ratio { den, .. } = crossing.t;
                        let weight = |num: u64| Ratio { num: num.into(), den }.to_f64(0);
                        let exact = [
                            crossing.t.to_f64(ray.exponent()),
                            weight(crossing.v),
                            weight(crossing.w),
                        ];
                        let of_one = crossing.to_hit(&ray, 0);
                        assert_eq!([of_one.t, of_one.u, of_one.v], exact);
                        crossed += 1;
                        if sure {
                            let bits = [hit.t, hit.u, hit.v].map(f64::to_bits);
                            assert_eq!(bits, exact.map(f64::to_bits), "{ray:?} {level:?} {lane}");
                            let index = [9, 8, 7, 6, 5, 4, 3, u32::MAX - 1][lane];
                            assert_eq!(hit.triangle, index);
                        } else {
                            unsure += 1;
                        }
                    }
                }
            }
        }
        let levels = Level::all().count();
        assert!(crossed > 20_000 * levels && unsure < crossed / 1000, "{unsure} of {crossed}");
    }
}
