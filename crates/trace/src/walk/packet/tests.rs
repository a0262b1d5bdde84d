//! Tests that packets test no more ray-triangle pairs than their rays need. `tests/orders.rs` tests
//! the results of packets with rays in every order.

use intertri::simd::{Level, Simd, WithSimd};
use intertri::{Counts, Hit32, Mode, Ray, Triangle};

use super::{Packets, RAYS};
use crate::Bvh;
use crate::walk::BatchOutput;
use crate::walk::bundle::Outcome;

/// Traces a packet. Returns the hits, or `None` if the packet was not traced, and the number of
/// ray-triangle pairs tested.
struct Trace<'a>(&'a Bvh, &'a [Ray]);

impl WithSimd for Trace<'_> {
    type Output = (Option<[Hit32; RAYS]>, u64);
    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let Self(bvh, rays) = self;
        let (mut hits, mut counts) = ([Hit32::MISS; RAYS], Counts::default());
        let mut packets = Packets::new(&bvh.tree, Mode::exact().filter(), true);
        let output = &mut BatchOutput::Hits32(&mut hits);
        let outcome = packets.trace::<S>((rays, 0), u64::MAX, output, &mut counts);
        let is_traced = matches!(outcome, Outcome::InPackets { left: 0 });
        (is_traced.then_some(hits), counts.tests)
    }
}

/// Traces one row of rays toward each of two distant groups of eight triangles. No ray may visit
/// the leaf of the other row's group.
#[test]
fn rays_visit_only_the_boxes_that_they_meet() {
    let place = |i: usize| (i % 8) as f32 + 100.0 * (i / 8) as f32;
    let triangle = |i| {
        let x = place(i);
        Triangle::new([x, 0.0, 5.0], [x + 0.9, 0.0, 5.0], [x, 0.9, 5.0])
    };
    let bvh = Bvh::new(&(0..RAYS).map(triangle).collect::<Vec<_>>()).unwrap();
    let rays: [Ray; RAYS] =
        std::array::from_fn(|i| Ray::new([place(i) + 0.2, 0.2, 0.0], [0.0, 0.0, 1.0]));
    for level in Level::all() {
        let (hits, tests) = level.run(Trace(&bvh, &rays));
        for (i, hit) in hits.expect("the rays are coherent").iter().enumerate() {
            assert_eq!(hit.triangle, i as u32, "{}", level.name());
        }
        // Each row of eight rays is tested against eight triangles.
        assert_eq!(tests, 128, "{}", level.name());
    }
}

/// Mixes coherent rays with rays that have empty intervals or NaN, infinite, or huge values. The
/// lanes of the latter must not visit anything, not even the empty slots of a node.
#[test]
fn rays_without_an_interval_do_not_disturb_the_others() {
    let (inf, nan) = (f32::INFINITY, f32::NAN);
    let row = |i: usize| Ray::new([i as f32, 0.0, 0.0], [0.01, 0.0, 1.0]).between(-inf, inf);
    let odd = [
        Ray::new([nan; 3], [-0.01, 0.0, 1.0]).between(-inf, inf),
        Ray::new([nan; 3], [0.01, 0.0, 1.0]).between(-inf, -inf),
        Ray::new([nan; 3], [0.01, 0.0, 1.0]).between(-inf, nan),
        Ray::new([3e38; 3], [0.01, 0.0, 1.0]).between(-inf, -inf),
        Ray::new([-3e38; 3], [0.01, 0.0, 1.0]).between(-inf, nan),
        Ray::new([3e38; 3], [-0.01, 0.0, 1.0]).between(-inf, -inf),
        Ray::new([0.0; 3], [inf, 0.0, 0.0]).between(0.0, 0.0),
    ];
    let wall = |z| Triangle::new([-50.0, -50.0, z], [100.0, -50.0, z], [-50.0, 100.0, z]);
    let mut traced = 0;
    for walls in [1, 3, 8, 40] {
        let bvh = Bvh::new(&(0..walls).map(|i| wall(1.0 + i as f32)).collect::<Vec<_>>()).unwrap();
        for (ray, count, at) in
            odd.iter().flat_map(|ray| [(ray, 16, 15), (ray, 16, 0), (ray, 15, 14)])
        {
            let mut rays: Vec<Ray> = (0..count).map(row).collect();
            rays[at] = *ray;
            // Put some rays in another octant.
            for ray in rays.iter_mut().skip(3).step_by(4).filter(|ray| ray.origin[0] < 100.0) {
                ray.dir[0] = -ray.dir[0];
            }
            let expected: Vec<_> = rays.iter().map(|ray| bvh.closest(ray)).collect();
            for level in Level::all() {
                let (Some(hits), _) = level.run(Trace(&bvh, &rays)) else { continue };
                traced += 1;
                for (hit, expected) in hits.iter().zip(&expected) {
                    let triangle = expected.map_or(Hit32::MISS.triangle, |hit| hit.triangle);
                    assert_eq!(hit.triangle, triangle, "{ray:?} at {at}, {}", level.name());
                }
            }
        }
    }
    assert!(traced > 100, "{traced}");
}

/// Tests directions with a zero component of either sign. A component of -0 arises, for example, if
/// a direction is negated.
#[test]
fn zeros_with_a_sign_miss_nothing() {
    let wall = Triangle::new([-1.0, -1.0, 0.0], [9.0, -1.0, 0.0], [-1.0, 9.0, 0.0]);
    let bvh = Bvh::new(&[wall]).unwrap();
    for signs in 0..8 {
        let zero = |k: usize| if signs >> k & 1 != 0 { -0.0 } else { 0.0 };
        let ahead = if signs & 4 != 0 { -1.0 } else { 1.0 };
        let ray =
            |i: usize| Ray::new([0.1 * i as f32, 0.1, -5.0 * ahead], [zero(0), zero(1), ahead]);
        let rays: [Ray; RAYS] = std::array::from_fn(ray);
        for level in Level::all() {
            let (hits, _) = level.run(Trace(&bvh, &rays));
            let hits = hits.expect("the rays are coherent");
            assert!(hits.iter().all(|hit| hit.t == 5.0), "{}: {:?}", level.name(), rays[0].dir);
        }
    }
}
