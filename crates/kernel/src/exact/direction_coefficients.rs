//! The intersections of rays in one direction with triangles that the rays are known to hit, with
//! each value correctly rounded.
//!
//! ```text
//!   num:  n · a   p · a   q · a                    n = h4 × h5, p = d × h5, q = h4 × d
//!   den:  n · d   n · d   n · d                    Only a depends on the origin. The rest is
//!           = t     = u     = v    triangle        computed once for a triangle and a direction.
//! ```
//!
//! `docs/numerics/exact.md`, section 9, has the bounds and the proof.

use super::double::{Double, cross, difference, dot, parts, whole};
use super::input::subnormals_are_read;
use super::rounded::{DOUBT, Volume, quotient};
use super::rounded32::{DOUBT as DOUBT32, Ends, Over};
use crate::hit_attributes::SharedHit;
use crate::simd::{Lanes, Mask, Simd, Vec3, put_by_triangle};
use crate::{Hit, Hit32, Ray};

/// A triangle and a direction, prepared to compute correctly rounded hits of rays in that
/// direction.
///
/// ```
/// use intertri::internal::SharedHit;
/// use intertri::internal::exact::{self, DirectionCoefficients, DirectionCoefficients32};
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{Hit, Hit32, Ray, Triangle, TriangleBlock};
///
/// struct Meet<'a>(&'a TriangleBlock<8>, &'a Ray);
/// impl WithSimd for Meet<'_> {
///     type Output = [f64; 2];
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let (Self(block, ray), mut hit, mut hit32) = (self, Hit::MISS, Hit32::MISS);
///         let mut of = [DirectionCoefficients::default(); 8];
///         DirectionCoefficients::eight_in::<S>(block.corners(), &[7; 8], ray, &mut of);
///         assert!(of[3].hit_in::<S>(ray, &mut hit) && hit.triangle == 7);
///         let mut of = [DirectionCoefficients32::default(); 8];
///         DirectionCoefficients32::eight_in::<S>(block.corners(), &[7; 8], ray, &mut of);
///         assert!(of[3].hit_in::<S>(ray, &mut hit32) && hit32.triangle == 7);
///         [hit.t, hit32.t.into()]
///     }
/// }
///
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.5], [0.0, 1.0, 5.0]);
/// let ray = Ray::new([0.25, 0.5, 0.0], [-0.05, 0.1, 2.0]);
/// let (t, ..) = exact::attributes(&ray, &wall);
/// assert_eq!(dispatch(Meet(&TriangleBlock::new(&[wall; 8]), &ray)), [t, (t as f32).into()]);
/// ```
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct DirectionCoefficients {
    /// The coefficients of the numerators of t, u, and v, by part and axis, and the first corner.
    coefficients: [[[f64; 4]; 3]; 2],
    /// The two parts of the denominator, its error bound, and its inverse.
    den: [f64; 4],
    /// The error bound on the numerators, divided by the sum of the magnitudes of A's components.
    /// It is NaN if nothing is proven.
    share: f64,
    index: u32,
}

/// Like [`DirectionCoefficients`], but for f32 hits.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct DirectionCoefficients32 {
    /// For each axis, the coefficients of the numerators of t, u, and v, and the first corner.
    coefficients: [[f64; 4]; 3],
    /// The inverse of the denominator, and the denominator's error bound.
    over: Over<f64>,
    /// See [`DirectionCoefficients::share`].
    share: f64,
    index: u32,
}

/// Returns a bound on the permanents of n, p, and q with a vector, divided by the sum of the
/// magnitudes of the vector's components.
#[inline(always)]
fn largest_permanent<D: Lanes<Scalar = f64>>(h4: Vec3<D>, h5: Vec3<D>, dir: Vec3<D>) -> D {
    let (h4, h5, dir) = (h4.abs(), h5.abs(), dir.abs());
    let most = h4.permanents(h5).norm1().max(dir.permanents(h5).norm1());
    most.max(h4.permanents(dir).norm1())
}

impl SharedHit for DirectionCoefficients {
    #[inline(always)]
    fn eight_in<S: Simd>(
        [c1, c2, c3]: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        ray: &Ray,
        to: &mut [Self; 8],
    ) {
        let corners = [Vec3::<S::F64x8>::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
        let ([c1, c2, c3], dir) = (corners, Vec3::splat_f32(ray.dir));
        let ((h4, x), (h5, y)) = (difference(c2, c1), difference(c3, c1));
        let (n, p, q) = (cross(h4, h5), cross(dir, h5), cross(h4, dir));
        let den = Volume::new(dir, &n, h4, h5);
        let (n, p, q) = (parts(&n), parts(&p), parts(&q));
        for (half, last) in [c1, Vec3::splat([0.0; 3])].into_iter().enumerate() {
            let rows = [n[half], p[half], q[half], last];
            put_by_triangle::<S>(rows, to.iter_mut().map(|seen| &mut seen.coefficients[half]));
        }

        // If a difference is not exact, nothing is proven.
        let exact = (x + y).le(Lanes::splat(0.0));
        let exact = if subnormals_are_read() { exact } else { Mask::from_bits(0) };
        let share = largest_permanent(h4, h5, dir) * Lanes::splat(DOUBT);
        let share = Lanes::select(exact, share, Lanes::splat(f64::NAN));
        let inverse = <S::F64x8 as Lanes>::splat(1.0) / den.value.high;
        let mut known = [[0.0; 8]; 5];
        for (number, row) in
            [den.value.high, den.value.low, den.err, inverse, share].into_iter().zip(&mut known)
        {
            number.store(row);
        }
        for (i, seen) in to.iter_mut().enumerate() {
            seen.den = [known[0][i], known[1][i], known[2][i], known[3][i]];
            (seen.share, seen.index) = (known[4][i], indices[i]);
        }
    }

    #[inline(always)]
    fn hit_in<S: Simd>(&self, ray: &Ray, to: &mut Hit) -> bool {
        let [high, low] = &self.coefficients;
        let [[.., x], [.., y], [.., z]] = *high;
        let (a, rest) = difference::<f64>(Vec3 { x, y, z }, Vec3::splat_f32(ray.origin));
        let rows = whole([Vec3::<S::F64x4>::load(high), Vec3::load(low)]);
        let (splat, [den, den_low, den_err, inverse]) = (<S::F64x4 as Lanes>::splat, self.den);
        let num = Volume {
            value: dot(&rows, Vec3::splat([a.x, a.y, a.z])),
            err: splat(self.share * a.abs().norm1()),
        };
        let den =
            Volume { value: Double { high: splat(den), low: splat(den_low) }, err: splat(den_err) };
        let (hit, sure) = quotient(&num, &den, splat(inverse));
        let numbers: &mut [f64; 4] = bytemuck::cast_mut(to);
        hit.store(numbers);
        (to.triangle, to.geometry) = (self.index, 0);
        sure.bits() & 0b111 == 0b111 && rest <= 0.0
    }
}

impl SharedHit<Hit32> for DirectionCoefficients32 {
    #[inline(always)]
    fn eight_in<S: Simd>(
        [c1, c2, c3]: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        ray: &Ray,
        to: &mut [Self; 8],
    ) {
        let corners = [Vec3::<S::F64x8>::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
        let ([c1, c2, c3], dir) = (corners, Vec3::splat_f32(ray.dir));
        let (h4, h5) = (c2 - c1, c3 - c1);
        let (n, p, q) = (h4.cross_fused(h5), dir.cross_fused(h5), h4.cross_fused(dir));
        put_by_triangle::<S>([n, p, q, c1], to.iter_mut().map(|seen| &mut seen.coefficients));

        let doubt = Lanes::splat(if subnormals_are_read() { DOUBT32 } else { f64::NAN });
        let permanent = h4.abs().permanents(h5.abs()).dot_fused(dir.abs());
        let over = Over::new(n.dot_fused(dir), permanent * doubt);
        let mut known = [[0.0; 8]; 3];
        over.inverse.store(&mut known[0]);
        over.err.store(&mut known[1]);
        (largest_permanent(h4, h5, dir) * doubt).store(&mut known[2]);
        for (i, seen) in to.iter_mut().enumerate() {
            seen.over = Over { inverse: known[0][i], err: known[1][i] };
            (seen.share, seen.index) = (known[2][i], indices[i]);
        }
    }

    #[inline(always)]
    fn hit_in<S: Simd>(&self, ray: &Ray, to: &mut Hit32) -> bool {
        let (sums, err) = self.numerators::<S>(ray);
        let (splat, over) = (<S::F64x4 as Lanes>::splat, self.over);
        let over = Over { inverse: splat(over.inverse), err: splat(over.err) };
        let ends: Ends<4> = over.quotient(sums, splat(err));
        let [t, u, v, _] = ends.most;
        *to = Hit32::new([t, u, v], self.index);
        ends.sure_in::<S::F32x4>() & 0b111 == 0b111
    }
}

impl DirectionCoefficients32 {
    /// Returns the numerators of t, u, and v in the first three lanes, and their error bound.
    #[inline(always)]
    fn numerators<S: Simd>(&self, ray: &Ray) -> (S::F64x4, f64) {
        let [[.., x], [.., y], [.., z]] = self.coefficients;
        let a = Vec3 { x, y, z } - Vec3::<f64>::splat_f32(ray.origin);
        let (coefficients, size) = (Vec3::<S::F64x4>::load(&self.coefficients), a.abs().norm1());
        let sums = coefficients.dot_fused(Vec3::splat([a.x, a.y, a.z]));
        (sums, self.share * size)
    }
}

#[cfg(test)]
mod tests {
    use super::super::along::attributes32_by_integers;
    use super::super::{Tier, attributes_from};
    use super::{DirectionCoefficients, DirectionCoefficients32, Over};
    use crate::exact::test_numbers::random;
    use crate::hit_attributes::SharedHit;
    use crate::simd::{Lanes, Level, Simd, WithSimd};
    use crate::{Hit, Hit32, Ray, Triangle, TriangleBlock};

    /// Computes the hits of eight parallel rays, each with its own triangle, in both formats.
    struct Meet<'a>(&'a [Triangle; 8], &'a [Ray; 8]);

    impl WithSimd for Meet<'_> {
        type Output = [(Option<Hit>, Option<Hit32>); 8];
        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            let Self(triangles, rays) = self;
            let (block, indices) = (TriangleBlock::<8>::new(triangles), &[0, 1, 2, 3, 4, 5, 6, 7]);
            let mut of = [DirectionCoefficients::default(); 8];
            let mut of32 = [DirectionCoefficients32::default(); 8];
            DirectionCoefficients::eight_in::<S>(block.corners(), indices, &rays[7], &mut of);
            DirectionCoefficients32::eight_in::<S>(block.corners(), indices, &rays[7], &mut of32);
            core::array::from_fn(|i| {
                let (mut hit, mut hit32) = (Hit::MISS, Hit32::MISS);
                let sure = of[i].hit_in::<S>(&rays[i], &mut hit);
                let sure32 = of32[i].hit_in::<S>(&rays[i], &mut hit32);
                (sure.then_some(hit), sure32.then_some(hit32))
            })
        }
    }

    /// Compares t, u, and v with those computed with integers, also for needles, for triangles seen
    /// edge-on, and for origins so far away that most digits cancel.
    #[test]
    fn what_is_sure_is_rounded_right() {
        let (mut random, cases) = (random(), 1200);
        let (mut sure, levels) = ([[0; 3]; 2], Level::all().count());
        for i in 0..cases {
            let mut number = |size: f32| size * random() as f32;
            let (flat, away) = ([1.0, 1e-3, 1e-6][i % 3], [1.0, 1e3, 1e6][i / 3 % 3]);
            let mut point = |size: f32| [number(size), number(size), number(size)];
            let mix =
                |a: [f32; 3], b: [f32; 3], s: f32| [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]));
            let add = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|k| a[k] + b[k]);
            let is_needle = i / 9 % 2 == 0;
            let triangles: [Triangle; 8] = core::array::from_fn(|_| {
                let (a, b) = (point(2.0), point(2.0));
                let c = if is_needle { add(mix(a, b, 0.3), point(flat)) } else { point(2.0) };
                Triangle([a, b, c])
            });
            // The direction is nearly in the plane of one of the triangles.
            let [a, b, c] = triangles[i % 8].0;
            let in_plane = mix(b, c, 0.4);
            let dir = add([0, 1, 2].map(|k| in_plane[k] - a[k]), point(flat));
            let rays: [Ray; 8] = core::array::from_fn(|lane| {
                let [a, b, c] = triangles[lane].0;
                let [x, y, t] = point(1.0).map(|x| x + 0.5);
                let (at, t) = (mix(mix(a, b, x), c, y), t * away);
                Ray::new([0, 1, 2].map(|k| at[k] - t * dir[k]), dir)
            });
            for level in Level::all() {
                let hits = level.run(Meet(&triangles, &rays));
                for (lane, ((hit, hit32), ray)) in hits.into_iter().zip(&rays).enumerate() {
                    let triangle = &triangles[lane];
                    if let Some(hit) = hit {
                        sure[0][i / 3 % 3] += 1;
                        let (t, u, v) = attributes_from(Tier::Narrow, ray, triangle);
                        let bits = [hit.t, hit.u, hit.v].map(f64::to_bits);
                        assert_eq!(bits, [t, u, v].map(f64::to_bits), "{ray:?} {triangle:?}");
                        assert_eq!(hit.triangle, lane as u32);
                    }
                    if let Some(hit) = hit32 {
                        sure[1][i / 3 % 3] += 1;
                        let exact = attributes32_by_integers(ray, triangle);
                        let bits = [hit.t, hit.u, hit.v].map(f32::to_bits);
                        assert_eq!(bits, exact.map(f32::to_bits), "{ray:?} {triangle:?}");
                        assert_eq!(hit.triangle, lane as u32);
                    }
                }
            }
        }
        // The farther away the origins are, the fewer are sure.
        let each = cases * 8 / 3 * levels;
        let shares = sure.map(|sure| sure.map(|sure| sure as f64 / each as f64));
        let least = [[0.95, 0.9, 0.9], [0.7, 0.55, 0.08]];
        for (share, least) in shares.iter().flatten().zip(least.iter().flatten()) {
            assert!(share > least, "{shares:?}");
        }
    }

    /// Computes the numerators of a triangle and a ray and the denominator, and their error bounds.
    struct Volumes<'a>(&'a Triangle, &'a Ray);

    impl WithSimd for Volumes<'_> {
        type Output = ([f64; 4], [f64; 2]);
        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            let Self(&triangle, ray) = self;
            let block = TriangleBlock::<8>::new(&[triangle; 8]);
            let mut of = [DirectionCoefficients32::default(); 8];
            DirectionCoefficients32::eight_in::<S>(block.corners(), &[0; 8], ray, &mut of);
            let (sums, err) = of[0].numerators::<S>(ray);
            let (mut volumes, Over { inverse, err: den_err }) = ([0.0; 4], of[0].over);
            sums.store(&mut volumes);
            volumes[3] = 1.0 / inverse;
            (volumes, [err, den_err])
        }
    }

    /// Searches for large errors by hill climbing. The proof allows half of the bound; with a
    /// constant half as large, the search would find more than that.
    #[test]
    fn volumes_are_within_their_bounds() {
        for level in Level::all() {
            let (mut random, mut most) = (random(), 0.0_f64);
            for _ in 0..60 {
                // Powers of two of different sizes make cross products inexact, too.
                let mut number = || {
                    let size = f64::from(1_u32 << ((random() + 0.5) * 10.0) as u32);
                    (size * (random() * 33_554_432.0).trunc()) as f32
                };
                let mut all = [0.0; 15].map(|_: f32| number());
                let mut used = 0.0;
                for step in 0..3000 {
                    let before = all;
                    all[(step * 7) % 15] = number();
                    let now = used_share(&all, level);
                    if now < used {
                        all = before;
                    } else {
                        used = now;
                    }
                }
                most = most.max(used);
            }
            assert!(0.25 < most && most < 0.5, "{most}, {}", level.name());
        }
    }

    /// Returns the largest error as a multiple of its bound.
    fn used_share(numbers: &[f32; 15], level: Level) -> f64 {
        let point = |i: usize| [numbers[i], numbers[i + 1], numbers[i + 2]];
        let (triangle, ray) =
            (Triangle([point(0), point(3), point(6)]), Ray::new(point(9), point(12)));
        let minus =
            |a: usize, b: usize| [0, 1, 2].map(|k| numbers[a + k] as i128 - numbers[b + k] as i128);
        let (a, h4, h5) = (minus(0, 9), minus(3, 0), minus(6, 0));
        let d = ray.dir.map(|x| x as i128);
        let volume = |x: [i128; 3], y: [i128; 3], z: [i128; 3]| -> i128 {
            (0..3)
                .map(|k| x[k] * (y[(k + 1) % 3] * z[(k + 2) % 3] - y[(k + 2) % 3] * z[(k + 1) % 3]))
                .sum()
        };
        let exact = [volume(a, h4, h5), volume(a, d, h5), volume(a, h4, d), volume(d, h4, h5)];
        let (volumes, [err, den_err]) = level.run(Volumes(&triangle, &ray));
        let off = |i: usize| {
            let bound = if i < 3 { err } else { den_err };
            (volumes[i] as i128 - exact[i]).unsigned_abs() as f64 / bound
        };
        (0..4).map(off).fold(0.0, f64::max)
    }
}
