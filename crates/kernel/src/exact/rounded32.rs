//! Computes correctly rounded t, u, and v in f32 with plain f64 arithmetic. The error bound nearly
//! always determines how a result rounds to f32.
//!
//! ```text
//!        ...●───────────┼───────────●──────      f32 and halfway points. If both ends of the
//!          f32   [═══] half        f32           error interval round alike, so does the quotient.
//! ```
//!
//! `docs/numerics/exact.md`, section 6, has the bounds and the proof.

use super::along::{NORMAL, attributes32, narrowed};
use super::input::subnormals_are_read;
use super::pairs::quotients_in;
use crate::hit_attributes::{Pairs, SharedHit};
use crate::simd::{Lanes, Mask, Simd, Vec3, lanes_of, put_by_triangle};
use crate::{Hit, Hit32, Ray, RayOf, Scalar, Triangle, TriangleOf};

/// `2^-49`, which is `16w`, where w is half an ulp of 1. The error of a volume in f64 is at most
/// `9w` times the volume's permanent, and dividing by a volume adds rounding errors of at most
/// `3w`.
pub(super) const DOUBT: f64 = 1.0 / (1_u64 << 49) as f64;

/// The number of unsure lanes from which it is faster to compute them side by side.
const SEVERAL: u32 = 2;

/// A denominator that several quotients share.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Over<D> {
    pub(super) err: D,
    pub(super) inverse: D,
}

/// The ends of the quotients' error intervals, rounded to f32.
pub(super) struct Ends<const N: usize> {
    least: [f32; N],
    pub(super) most: [f32; N],
    /// The lanes in which the error interval is valid.
    sure: u32,
}

impl<D: Lanes<Scalar = f64>> Over<D> {
    /// Prepares divisions by a denominator with an error of up to `err`.
    #[inline(always)]
    pub(super) fn new(den: D, err: D) -> Self {
        Self { err, inverse: D::splat(1.0) / den }
    }

    /// Divides a numerator with an error of up to `err`.
    #[inline(always)]
    pub(super) fn quotient<const N: usize>(&self, num: D, err: D) -> Ends<N> {
        let q = num * self.inverse;
        let doubt = q.abs().mul_add(self.err, err) * self.inverse.abs();
        let (mut least, mut most) = ([0.0; N], [0.0; N]);
        (q - doubt).store_f32(&mut least);
        (q + doubt).store_f32(&mut most);
        let sure = q.abs().ge(D::splat(NORMAL)) & doubt.le(q.abs());
        Ends { least, most, sure: sure.bits() }
    }
}

impl<const N: usize> Ends<N> {
    /// Returns a mask of the lanes whose quotients are proven to be correctly rounded.
    #[inline(always)]
    pub(super) fn sure_in<F: Lanes<Scalar = f32>>(&self) -> u32 {
        self.sure & F::load(&self.most).le(F::load(&self.least)).bits()
    }
}

/// Like [`HitCoefficients`](super::HitCoefficients), but for f32 hits.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct HitCoefficients32 {
    /// For each axis, the coefficients of the denominator, of the numerators of u and v, and of the
    /// denominator again.
    coefficients: [[f64; 4]; 3],
    /// The numerator of t.
    known: f64,
    /// The error bound on t's numerator.
    known_err: f64,
    /// The error bound on the dot products, relative to the sum of the magnitudes of the
    /// direction's components, or NaN if nothing is proven.
    share: f64,
    index: u32,
}

impl SharedHit<Hit32> for HitCoefficients32 {
    #[inline(always)]
    fn eight_in<S: Simd>(
        [c1, c2, c3]: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        ray: &Ray,
        to: &mut [Self; 8],
    ) {
        let corners = [Vec3::<S::F64x8>::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
        let [c1, c2, c3] = corners;
        let origin = Vec3::splat_f32(ray.origin);
        let (a, h4, h5) = (c1 - origin, c2 - c1, c3 - c1);
        let (n, v, w) = (h4.cross_fused(h5), h5.cross_fused(a), a.cross_fused(h4));
        put_by_triangle::<S>([n, v, w, n], to.iter_mut().map(|seen| &mut seen.coefficients));

        // Use the largest of the three cross products' error bounds for all of them.
        let (abs_a, abs_h4, abs_h5) = (a.abs(), h4.abs(), h5.abs());
        let of_n = abs_h4.permanents(abs_h5);
        let most = (of_n.norm1().max(abs_h5.permanents(abs_a).norm1()))
            .max(abs_a.permanents(abs_h4).norm1());
        let doubt = if subnormals_are_read() { DOUBT } else { f64::NAN };
        let (mut known, doubt) = ([[0.0; 8]; 3], Lanes::splat(doubt));
        n.dot_fused(a).store(&mut known[0]);
        (of_n.dot_fused(abs_a) * doubt).store(&mut known[1]);
        (most * doubt).store(&mut known[2]);
        for (i, seen) in to.iter_mut().enumerate() {
            (seen.known, seen.known_err) = (known[0][i], known[1][i]);
            (seen.share, seen.index) = (known[2][i], indices[i]);
        }
    }

    #[inline(always)]
    fn hit_in<S: Simd>(&self, ray: &Ray, to: &mut Hit32) -> bool {
        let [x, y, z] = ray.dir;
        let dir = Vec3::<S::F64x4>::splat_f32(ray.dir);
        let sums = Vec3::load(&self.coefficients).dot_fused(dir);
        let size = f64::from(x.abs()) + f64::from(y.abs()) + f64::from(z.abs());
        let err = <S::F64x4 as Lanes>::splat(self.share * size);

        // Divide all lanes by the last, which holds D. The first lane is for t, whose numerator is
        // already known.
        let first = <S::F64x4 as Lanes>::Mask::from_bits(1);
        let num = Lanes::select(first, Lanes::splat(self.known), sums);
        let num_err = Lanes::select(first, Lanes::splat(self.known_err), err);
        let over = Over::<S::F64x4>::new(S::first_and_last(sums), err);
        let ends: Ends<4> = over.quotient(num, num_err);
        let [t, u, v, _] = ends.most;
        *to = Hit32::new([t, u, v], self.index);
        ends.sure_in::<S::F32x4>() & 0b111 == 0b111
    }
}

/// Writes the f32 hits of the first `len` lanes, with t, u, and v correctly rounded. The other
/// elements are meaningless.
#[inline(always)]
pub(crate) fn hits32_in<S: Simd>(pairs: &Pairs, len: usize, hits: &mut [Hit32; 8]) {
    let doubt = <S::F64x8 as Lanes>::splat(if subnormals_are_read() { DOUBT } else { f64::NAN });
    let (corners, origin, dir) = pairs.lanes::<S::F64x8>(0);
    let [t, u, v] = ends::<_, 8>(corners, origin, dir, doubt);
    let sure = t.sure_in::<S::F32x8>() & u.sure_in::<S::F32x8>() & v.sure_in::<S::F32x8>();
    let mut unsure = !sure;
    // A hit is a row of five numbers: t, u, v, the triangle's index as bits, and the geometry, 0.
    let rows: &mut [[f32; 5]; 8] = bytemuck::cast_mut(hits);
    for (from, rows) in [0, 4].into_iter().zip(rows.chunks_exact_mut(4)) {
        let load = S::F32x4::load;
        let columns = [
            load(&t.most[from..]),
            load(&u.most[from..]),
            load(&v.most[from..]),
            load(pairs.indices(from)),
        ];
        for (row, hit) in rows.iter_mut().zip(S::transpose(columns)) {
            hit.store(row);
            row[4] = 0.0;
        }
    }
    unsure &= (1 << len) - 1;
    if unsure != 0 {
        round_unsure::<S>(pairs, unsure, hits);
    }
}

/// Computes the hits of lanes that plain f64 cannot round. This function is out of line to keep registers
/// free for the common case.
#[cold]
#[inline(never)]
fn round_unsure<S: Simd>(pairs: &Pairs, mut unsure: u32, hits: &mut [Hit32; 8]) {
    // Two-part numbers suffice for most, for example for weights close to 0 beside an edge.
    if unsure.count_ones() >= SEVERAL {
        let ([t, u, v], sure) = S::vectorize(
            #[inline(always)]
            || quotients_in::<S>(pairs),
        );
        for lane in lanes_of(unsure & sure) {
            if let Some(numbers) = narrowed([t[lane], u[lane], v[lane]]) {
                hits[lane] = Hit32::new(numbers, pairs.index(lane));
                unsure &= !(1 << lane);
            }
        }
    }
    for lane in lanes_of(unsure) {
        let (ray, triangle, index) = pairs.pair(lane);
        hits[lane] = hit32_of_pair(&ray, &triangle, index.0);
    }
}

/// Computes t, u, and v up to their error intervals.
#[inline(always)]
fn ends<D: Lanes<Scalar = f64>, const N: usize>(
    [c1, c2, c3]: [Vec3<D>; 3],
    origin: Vec3<D>,
    dir: Vec3<D>,
    doubt: D,
) -> [Ends<N>; 3] {
    let (a, h4, h5) = (c1 - origin, c2 - c1, c3 - c1);
    let (n, moment) = (h4.cross_fused(h5), a.cross_fused(dir));
    let (of_n, of_moment) = (h4.abs().permanents(h5.abs()), a.abs().permanents(dir.abs()));
    let over = Over::new(n.dot_fused(dir), permanent(of_n, dir) * doubt);
    [
        over.quotient(n.dot_fused(a), permanent(of_n, a) * doubt),
        over.quotient(h5.dot_fused(moment), permanent(of_moment, h5) * doubt),
        over.quotient(-h4.dot_fused(moment), permanent(of_moment, h4) * doubt),
    ]
}

/// Returns the f32 hit of a ray on a triangle that it is known to hit, with t, u, and v correctly
/// rounded.
#[inline(always)]
pub(crate) fn hit32_alone(ray: &Ray, triangle: &Triangle, index: u32) -> Hit32 {
    let vector = |[x, y, z]: [f32; 3]| Vec3::<f64> { x: x.into(), y: y.into(), z: z.into() };
    let [c1, c2, c3] = triangle.0;
    let corners = [vector(c1), vector(c2), vector(c3)];
    let doubt = if subnormals_are_read() { DOUBT } else { f64::NAN };
    let [t, u, v] = ends::<f64, 1>(corners, vector(ray.origin), vector(ray.dir), doubt);
    if t.sure_in::<f32>() & u.sure_in::<f32>() & v.sure_in::<f32>() != 0 {
        Hit32::new([t.most[0], u.most[0], v.most[0]], index)
    } else {
        hit32_of_pair(ray, triangle, index)
    }
}

/// Computes the permanent of a volume from the permanents of a cross product and the third vector.
#[inline(always)]
fn permanent<D: Lanes<Scalar = f64>>(product: Vec3<D>, by: Vec3<D>) -> D {
    product.dot_fused(by.abs())
}

/// Computes the hit of a pair exactly.
#[cold]
#[inline(never)]
fn hit32_of_pair(ray: &Ray, triangle: &Triangle, index: u32) -> Hit32 {
    Hit32::new(attributes32(ray, triangle), index)
}

/// Converts a hit found by `exact` to f32. The hit's t, u, and v must be correctly rounded for the
/// ray and the triangle.
#[inline(always)]
pub fn hit32<S: Scalar>(hit: &Hit, ray: &RayOf<S>, triangle: &TriangleOf<S>) -> Hit32 {
    let numbers = narrowed([hit.t, hit.u, hit.v]).unwrap_or_else(|| attributes32(ray, triangle));
    Hit32 { geometry: hit.geometry, ..Hit32::new(numbers, hit.triangle) }
}
