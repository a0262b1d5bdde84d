//! Runs an intersector on pairs: ray `i` against triangle `i`, eight at a time.

use intertri::simd::Vec3;
use intertri::simd::{Mask, Simd, WithSimd};
use intertri::{Ray, RayPacket, Triangle, TriangleBlock};

use super::intersector::Intersector;
use super::real::{Number, Real};
use crate::test_batch::Answer;

/// The arguments for testing pairs: the intersector, the pairs, and the slice for the answers.
/// `DOUBLE` selects f64 instead of f32.
pub(super) struct Pairs<'a, M, const DOUBLE: bool> {
    pub(super) intersector: M,
    pub(super) triangles: &'a [Triangle],
    pub(super) rays: &'a [Ray],
    pub(super) to: &'a mut [Answer],
}

impl<M: Intersector, const DOUBLE: bool> WithSimd for Pairs<'_, M, DOUBLE> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { intersector, triangles, rays, to } = self;
        for ((triangles, rays), to) in triangles.chunks(8).zip(rays.chunks(8)).zip(to.chunks_mut(8))
        {
            let (triangles, rays) = (TriangleBlock::<8>::new(triangles), RayPacket::<8>::new(rays));
            if DOUBLE {
                eight::<M, S::F64x8>(intersector, &triangles, &rays, to);
            } else {
                eight::<M, S::F32x8>(intersector, &triangles, &rays, to);
            }
        }
    }
}

#[inline(always)]
fn eight<M: Intersector, L: Real>(
    intersector: M,
    triangles: &TriangleBlock<8>,
    rays: &RayPacket<8>,
    to: &mut [Answer],
) {
    let [a, b, c] = triangles.corners();
    let triangle =
        intersector.triangle::<L>([Vec3::load_f32(a), Vec3::load_f32(b), Vec3::load_f32(c)]);
    let ray = intersector.ray::<L>(Vec3::load_f32(&rays.origin), Vec3::load_f32(&rays.dir));
    let (hit, t) = intersector.test(&triangle, &ray);
    let mut ts = [L::Scalar::nearest(0.0); 8];
    t.store(&mut ts);
    for (lane, to) in to.iter_mut().enumerate() {
        *to = Answer { hit: hit.bits() >> lane & 1 == 1, t: ts[lane].into() };
    }
}
