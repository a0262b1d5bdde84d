//! The filter for rays that share an origin, after document D: what depends on the triangle and the
//! viewpoint is computed once, and then a ray costs three dot products.
//!
//! ```text
//!   with A = c1 - o:   D = n·d   V = (h5 × A)·d   W = (A × h4)·d   U = D - V - W   T = n·A
//!                                                                                    t = T / D
//! ```
//!
//! Each edge function is a linear form of the direction. The forms are computed in f64, turned by the
//! sign of T, so that a hit in front has all of them positive, and scaled by their common bound, which
//! thus becomes |d|. Bounds and proof: `docs/numerics/certified.md`.

use crate::Triangle;
use crate::barycentric::Coefficients;
use crate::packet::{self, TriangleBlock};
use crate::simd::Vec3;
use crate::simd::{Lanes, Mask};

use super::bound;
use super::decided::Decided;
use super::edges::{Rays, enclose};

/// A triangle as it is seen from one origin.
//
// What nearly every test needs comes first, in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct SharedOriginTriangle {
    u: Vec3<f32>,
    v: Vec3<f32>,
    w: Vec3<f32>,
    /// Within `|d|` times this the sum of U, V and W does not tell the sign of D.
    doubtful: f32,
    n: Vec3<f32>,
    /// The numerator of t, positive; NaN where its sign is not sure.
    num: f32,
    /// `SLACK` times its bound.
    num_err: f32,
    /// D must exceed `|d|` times this for anything to be decided.
    least: f32,
    /// `|d|` times this is `SLACK` times the bound of n·d.
    den_err: f32,
    /// D must exceed `least` and this not to be parallel.
    parallel: f32,
    /// The share of the bound that is not the forms' own rounding.
    noise: f32,
    pub(super) triangle: Triangle,
    /// Nothing seen from here can hit it.
    pub(super) never: bool,
}

impl SharedOriginTriangle {
    /// What depends on N triangles and the origin.
    #[inline(always)]
    pub(super) fn all<D: Lanes<Scalar = f64>, const N: usize>(
        block: &TriangleBlock<N>,
        origin: [f32; 3],
        threshold: f64,
    ) -> [Self; N] {
        let [c1, c2, c3] = block.corners();
        let corners = [Vec3::<D>::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
        let eye = Vec3::splat([origin[0].into(), origin[1].into(), origin[2].into()]);
        let Coefficients { a, h4, h5, n, v, w } = Coefficients::of(corners, eye);
        let (h6, t, u) = (corners[2] - corners[1], n.dot(a), n - v - w);

        // The bound of the forms, of the reference's noise, and of the origin's rounding. A shorter edge
        // counts as so long: then nothing is decided of it, and no number below is subnormal in f32.
        let shortest = D::splat(packet::SHORTEST.into());
        let (h, form) = (longest(h4, h5, h6).max(shortest), longest(u, v, w));
        let (away, normal) = (a.dot(a).sqrt(), n.dot(n).sqrt());
        let noise = D::splat(bound::NOISE.into()) * h * (away + h);
        let offset = D::splat(bound::ORIGIN.into()) * h * eye.norm1();
        let scale = D::splat(1.0) / (D::splat(bound::FORM.into()) * form + noise + offset);

        // In front of the triangle or behind, T has the same sign as D wherever it is hit.
        let num_err = D::splat(bound::NOISE.into()) * h * h * away;
        let turn = D::select(t.abs().gt(num_err), scale.flip(t), D::splat(f64::NAN));
        let hh = h * h * scale;
        let den_err =
            D::splat(bound::FORM.into()) * normal * scale + D::splat(bound::NOISE.into()) * hh;
        let least = D::splat(bound::GRAZING.into()) * hh;
        let parallel = D::splat(bound::PARALLEL.into()) * D::splat(threshold) * normal * scale;

        // What is not finite is never hit. What has no area in f64 may have some: the resolver knows.
        let infinity = D::splat(f64::INFINITY);
        let possible = normal.lt(infinity) & away.lt(infinity);

        // To f32, and from lanes to triangles.
        let slack = D::splat(bound::SLACK.into());
        let (zero, mut single) = ([[0.0; N]; 3], [[0.0; N]; 7]);
        let mut forms = [zero; 4];
        for (to, form) in forms.iter_mut().zip([u, v, w, n]) {
            (form.x * turn).store_f32(&mut to[0]);
            (form.y * turn).store_f32(&mut to[1]);
            (form.z * turn).store_f32(&mut to[2]);
        }
        (t * turn).store_f32(&mut single[0]);
        (num_err * scale * slack).store_f32(&mut single[1]);
        (least + D::splat(8.0)).store_f32(&mut single[2]);
        (least + den_err).store_f32(&mut single[3]);
        (den_err * slack).store_f32(&mut single[4]);
        parallel.store_f32(&mut single[5]);
        ((noise + offset) * scale).store_f32(&mut single[6]);
        let mut all = [Self::NOTHING; N];
        for (i, seen) in all.iter_mut().enumerate() {
            let form = |k: usize| Vec3 { x: forms[k][0][i], y: forms[k][1][i], z: forms[k][2][i] };
            *seen = Self {
                u: form(0),
                v: form(1),
                w: form(2),
                n: form(3),
                num: single[0][i],
                num_err: single[1][i],
                doubtful: single[2][i],
                least: single[3][i],
                den_err: single[4][i],
                parallel: single[5][i],
                noise: single[6][i],
                triangle: block.triangle(i),
                never: possible.bits() >> i & 1 == 0,
            };
        }
        all
    }

    /// What is never hit.
    const NOTHING: Self = {
        let zero = Vec3 { x: 0.0, y: 0.0, z: 0.0 };
        Self {
            u: zero,
            v: zero,
            w: zero,
            doubtful: 0.0,
            n: zero,
            num: 0.0,
            num_err: 0.0,
            least: 0.0,
            den_err: 0.0,
            parallel: 0.0,
            noise: 0.0,
            triangle: Triangle([[0.0; 3]; 3]),
            never: true,
        }
    };
}

/// The length of the longest of three. Not a closure, which would be compiled without the level's
/// instructions.
#[inline(always)]
fn longest<D: Lanes<Scalar = f64>>(x: Vec3<D>, y: Vec3<D>, z: Vec3<D>) -> D {
    x.dot(x).max(y.dot(y)).max(z.dot(z)).sqrt()
}

/// Eight triangles as they are seen from one origin.
///
/// ```
/// use intertri::internal::{Filter, SharedOriginBlock};
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{Certified, ClosestHits, Counts, LaneQueries, Mode, Ray, RayPacket, Triangle};
/// use intertri::TriangleBlock;
///
/// /// What the first of eight rays hits first.
/// struct First<'a>(Filter<'a>, &'a RayPacket<8>, &'a [Triangle]);
/// impl WithSimd for First<'_> {
///     type Output = Option<(u32, u32)>;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let Self(filter, packet, triangles) = self;
///         let block = TriangleBlock::new(triangles);
///         let eight: SharedOriginBlock = filter.shared_origin_in::<S>(&block, packet.ray(0).origin);
///         let rays = filter.prepare_packet_in::<S, 8>(packet);
///         let (mut closest, mut counts) = (ClosestHits::new(&packet.t_max), Counts::default());
///         let find = |place: u32| triangles[place as usize];
///         let (live, counts) = (1, &mut counts);
///         filter.shared_origin_closest_in(&rays, &[eight], 0, find, live, &mut closest, counts);
///         assert_eq!(counts.tests, 2);
///         closest.lane(0).triangle()
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let packet = RayPacket::new(&[Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0])]);
/// assert_eq!(dispatch(First(Certified::default().test(), &packet, &[at(5.0), at(3.0)])), Some((1, 1)));
/// ```
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct SharedOriginBlock {
    /// U, V and W, by axis and triangle.
    pub(super) forms: [[[f32; 8]; 3]; 3],
    pub(super) doubtful: [f32; 8],
    /// Bit i is set where there is a triangle that can be hit.
    pub(super) live: u32,
    pub(super) each: [SharedOriginTriangle; 8],
}

impl SharedOriginBlock {
    /// What depends on the triangles and the origin.
    #[inline(always)]
    pub(super) fn new<D: Lanes<Scalar = f64>>(
        block: &TriangleBlock<8>,
        origin: [f32; 3],
        threshold: f64,
    ) -> Self {
        let each = SharedOriginTriangle::all::<D, 8>(block, origin, threshold);
        let (mut forms, mut doubtful, mut live) = ([[[0.0; 8]; 3]; 3], [0.0; 8], 0);
        for (i, seen) in each.iter().enumerate() {
            for (to, from) in forms.iter_mut().zip([seen.u, seen.v, seen.w]) {
                to[0][i] = from.x;
                to[1][i] = from.y;
                to[2][i] = from.z;
            }
            doubtful[i] = seen.doubtful;
            live |= u32::from(!seen.never) << i;
        }
        Self { forms, doubtful, live: live & block.live(), each }
    }
}

/// The three forms of rays that start at the origin of a seen.
#[derive(Clone, Copy)]
pub(super) struct Forms<F> {
    dir: Vec3<F>,
    len: F,
    /// U, V and W, each with its bound |d| added: negative where the edge makes a sure miss.
    u: F,
    v: F,
    w: F,
}

impl<F: Lanes<Scalar = f32>> Forms<F> {
    /// Three dot products.
    #[inline(always)]
    pub(super) fn new(seen: &SharedOriginTriangle, of: &Rays<F>) -> Self {
        let (dir, len) = (of.dir(), of.len());
        let form = |f: Vec3<f32>| dir.dot_add(Vec3::splat([f.x, f.y, f.z]), len);
        Self { dir, len, u: form(seen.u), v: form(seen.v), w: form(seen.w) }
    }

    /// Where no edge makes a sure miss.
    #[inline(always)]
    pub(super) fn maybe(&self, seen: &SharedOriginTriangle) -> F::Mask {
        let Self { len, u, v, w, .. } = *self;
        let sure = (u + v + w).abs().gt(len * F::splat(seen.doubtful));
        !(sure & u.or_sign(v).or_sign(w).negative())
    }

    /// Where the edge of a form makes a sure miss, and where a sure hit, by a bound of its own: `sum` is
    /// the form with |d| added.
    #[inline(always)]
    fn sharper(&self, seen: &SharedOriginTriangle, form: Vec3<f32>, sum: F) -> (F::Mask, F::Mask) {
        let size = self.dir.abs().dot_fused(Vec3::splat([form.x, form.y, form.z]).abs());
        let noise = self.len * F::splat(seen.noise);
        let bound = size.mul_add(F::splat(bound::FORM), noise);
        let weight = sum - self.len;
        (weight.lt(-bound), weight.gt(bound))
    }

    /// As [`super::edges::Edges::decide`]; `None` where every lane is a miss after all.
    #[inline(always)]
    pub(super) fn decide(
        &self,
        seen: &SharedOriginTriangle,
        of: &Rays<F>,
        far: F,
        live: u32,
    ) -> Option<Decided<F>> {
        let splat = F::splat;
        let Self { dir, len, u, v, w } = *self;

        // The sum of three is not as sharp as a dot product of its own. Below zero the ray goes away
        // from the triangle.
        let den = dir.dot_fused(Vec3::splat([seen.n.x, seen.n.y, seen.n.z]));
        let den_abs = den.abs();
        let sure = den_abs.gt(len * splat(seen.least));
        let outside = u.or_sign(v).or_sign(w).or_sign(den).negative();
        let maybe = !(sure & outside);
        if maybe.bits() & live == 0 {
            return None;
        }

        // The plane's t and its enclosure.
        let den_err = len * splat(seen.den_err);
        let (t_lo, t_hi) = enclose(splat(seen.num), splat(seen.num_err), den_abs, den_err);
        let out_of_range = sure & (t_hi.lt(of.below()) | t_lo.gt(far));

        // A hit, if nothing is in doubt.
        let clear = sure
            & !out_of_range
            & den.gt(len.mul_add(splat(seen.least), splat(seen.parallel)))
            & t_lo.gt(of.above())
            & t_hi.lt(splat(f32::INFINITY));
        let mut hit = (maybe & clear & u.min(v).min(w).gt(len + len)).bits() & live;
        let mut undecided = (maybe & !out_of_range).bits() & live & !hit;
        if undecided != 0 {
            let (u_out, u_in) = self.sharper(seen, seen.u, u);
            let (v_out, v_in) = self.sharper(seen, seen.v, v);
            let (w_out, w_in) = self.sharper(seen, seen.w, w);
            hit |= (clear & u_in & v_in & w_in).bits() & undecided;
            undecided &= !((sure & (u_out | v_out | w_out)).bits() | hit);
        }
        Some(Decided { hit, undecided, t_lo, t_hi })
    }
}

#[cfg(test)]
mod tests {
    use crate::{Certified, Hit, Mode, Ray, Threshold, Triangle};

    /// Of so small a triangle f32 cannot hold the normal that its forms are measured by.
    #[test]
    fn a_tiny_triangle_far_away_is_not_lost() {
        let triangle = Triangle([
            [9.5433e-41, -1.0898e-41, -6.0177e-41],
            [-3.22383e-40, 3.86597e-40, 3.49218e-40],
            [2.62275e-40, -3.7393e-40, -3.08894e-40],
        ]);
        let far = 536_870_900.0;
        let rays = [Ray::new([far, -far, -far], [-4.0, 4.0, 4.0]); 64];
        let mode = Certified::new(Threshold::ZERO);
        let mut hits = [Hit::MISS; 64];
        mode.closest_batch(&[triangle], &rays, &mut hits);
        assert_eq!(mode.closest(&[triangle], &rays[0]), hits[0].some());
        assert!(hits[0].is_hit());
    }
}
