//! Where rays from one origin meet the triangles that they are known to hit.
//!
//! ```text
//!   num:  nrm & a   V & dir   W & dir              what does not depend on the direction is
//!   den:  nrm & dir N & dir   N & dir              computed once for a triangle and an origin;
//!           = t       = u       = v    triangle    a ray takes a dot product and a division of
//!                                                  four lanes: nrm, V, W and N
//! ```
//!
//! Document A gives t, document D the weights. The operations and their order are the reference's, so
//! t has its bits.

use crate::double::Tri;
use crate::lanes::{Lanes, Mask, Simd};
use crate::{Coefficients, Hit, Vec3};

/// A triangle as it is seen from one origin, ready to tell where a ray from there meets it.
///
/// ```
/// use intertri::lanes::{Simd, WithSimd, dispatch};
/// use intertri::{Certified, Hit, Mode, Ray, Sight, Triangle, TrianglePack};
///
/// struct Meet<'a>(&'a TrianglePack<8>, &'a Ray);
/// impl WithSimd for Meet<'_> {
///     type Output = Hit;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Hit {
///         let (mut sights, mut hit) = ([Sight::default(); 8], Hit::MISS);
///         Sight::eight_in::<S>(self.0.corners(), &[0; 8], self.1.origin, &mut sights);
///         sights[3].hit_in::<S>(self.1.dir, &mut hit);
///         hit
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let (eight, ray) = ([at(5.0); 8], Ray::new([0.25, 0.5, 0.0], [-0.05, 0.0, 2.0]));
/// let hit = dispatch(Meet(&TrianglePack::new(&eight), &ray));
/// assert_eq!(hit, Certified::default().closest(&eight, &ray));
/// ```
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct Sight {
    /// By axis, the coefficients of t's denominator, of the numerators of u and v, and of their
    /// denominator.
    coefficients: [[f64; 4]; 3],
    /// The numerator of t, and last the triangle's index as bits.
    known: [f64; 4],
}

impl Sight {
    /// Eight triangles: `corners[k][axis][lane]` is of corner k+1.
    #[inline(always)]
    pub fn eight_in<S: Simd>(
        [c1, c2, c3]: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        origin: [f32; 3],
        to: &mut [Self; 8],
    ) {
        let corners = [Vec3::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
        let tri = Tri::new(corners);
        let [x, y, z] = origin;
        let origin = Vec3::<S::F64x8>::splat([x.into(), y.into(), z.into()]);
        let Coefficients { a, n, v, w, .. } = Coefficients::of(corners, origin);
        let rows = [
            by_triangle::<S>([tri.nrm.x, v.x, w.x, n.x]),
            by_triangle::<S>([tri.nrm.y, v.y, w.y, n.y]),
            by_triangle::<S>([tri.nrm.z, v.z, w.z, n.z]),
        ];
        let mut num = [0.0; 8];
        tri.nrm.dot(a).store(&mut num);
        for (i, sight) in to.iter_mut().enumerate() {
            for (row, coefficients) in rows.iter().zip(&mut sight.coefficients) {
                row[i / 4][i % 4].store(coefficients);
            }
            sight.known = [num[i], 0.0, 0.0, f64::from_bits(indices[i].into())];
        }
    }

    /// Where a ray that is known to hit the triangle meets it.
    #[inline(always)]
    pub fn hit_in<S: Simd>(&self, dir: [f32; 3], to: &mut Hit) {
        let dir = Vec3::<S::F64x4>::splat([dir[0].into(), dir[1].into(), dir[2].into()]);
        let lane = |i: u32| <S::F64x4 as Lanes>::Mask::from_bits(1 << i);
        let known = S::F64x4::load(&self.known);
        let sums = Vec3::load(&self.coefficients).dot(dir);
        let hit = S::F64x4::select(lane(0), known, sums) / S::first_and_last(sums);
        let to: &mut [f64; 4] = bytemuck::cast_mut(to);
        S::F64x4::select(lane(3), known, hit).store(to);
    }
}

/// Four numbers of each of eight triangles, those of one together.
#[inline(always)]
pub(crate) fn by_triangle<S: Simd>(numbers: [S::F64x8; 4]) -> [[S::F64x4; 4]; 2] {
    let mut rows = [[0.0; 8]; 4];
    for (lanes, row) in numbers.into_iter().zip(&mut rows) {
        lanes.store(row);
    }
    let [a, b, c, d] = &rows;
    let load = S::F64x4::load;
    [
        S::transpose_f64([load(a), load(b), load(c), load(d)]),
        S::transpose_f64([load(&a[4..]), load(&b[4..]), load(&c[4..]), load(&d[4..])]),
    ]
}
