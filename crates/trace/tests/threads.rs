//! Tests that batches traced on all threads return the same results as rays traced one by one. Run
//! this test under `ThreadSanitizer` to check for data races.

use intertri::{Hit, Mode, Ray, Triangle};
use intertri_trace::Bvh;

/// Returns a pseudo-random number in -1..1, computed from two indices.
fn number(i: usize, k: usize) -> f32 {
    let x = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(k as u32 * 7 + 11);
    (x.wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as f32 / 8_388_608.0 - 1.0
}

#[test]
fn many_rays_at_once_get_what_each_gets_alone() {
    let triangles: Vec<Triangle> = (0..20_000)
        .map(|i| {
            let at = [number(i, 0), number(i, 1), number(i, 2)];
            let corner = |k: usize| [0, 1, 2].map(|axis| at[axis] + 0.02 * number(i, k + axis));
            Triangle([corner(3), corner(6), corner(4)])
        })
        .collect();
    // Trace incoherent rays, which form streams, and the rays of an image, which form bundles.
    let mut rays: Vec<Ray> = (0..10_000)
        .map(|i| {
            let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(|k| number(i + 77_777, k));
            Ray::new([a, b, c], [d, e, f])
        })
        .collect();
    rays.extend((0..10_000).map(|i| {
        let [x, y] = [i % 100, i / 100].map(|k| k as f32 / 100.0 - 0.5);
        Ray::new([0.0, 0.0, -3.0], [x, y, 1.0])
    }));
    let mode = Mode::certified();
    let bvh = Bvh::new(&triangles).unwrap();
    let (mut closest, mut any) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
    bvh.query().mode(mode).closest_batch_into(&rays, &mut closest);
    bvh.query().mode(mode).any_batch_into(&rays, &mut any);
    for ((ray, hit), any) in rays.iter().zip(&closest).zip(&any) {
        assert_eq!(bvh.query().mode(mode).closest(ray), hit.some());
        assert_eq!(*any, hit.is_hit());
    }
    assert!(closest.iter().filter(|hit| hit.is_hit()).count() > 1000);
}
