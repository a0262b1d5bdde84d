//! Packets test no more pairs than their rays need. What they answer is tested with every order of rays
//! (`tests/orders.rs`).

use intertri::simd::{Level, Simd, WithSimd};
use intertri::{Counts, Hit32, Mode, Ray, Triangle};

use super::{Packets, RAYS};
use crate::Bvh;
use crate::walk::BatchOutput;
use crate::walk::bundle::Outcome;

/// A packet's hits, and the number of pairs of a ray and a triangle that it tests.
struct Trace<'a>(&'a Bvh, &'a [Ray; RAYS]);

impl WithSimd for Trace<'_> {
    type Output = ([Hit32; RAYS], u64);
    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let Self(bvh, rays) = self;
        let (mut hits, mut counts) = ([Hit32::MISS; RAYS], Counts::default());
        let mut packets = Packets::new(&bvh.tree, Mode::exact().filter(), true);
        let output = &mut BatchOutput::Hits32(&mut hits);
        let outcome = packets.trace::<S>((rays, 0), output, &mut counts);
        assert!(matches!(outcome, Outcome::InPackets { left: 0 }));
        (hits, counts.tests)
    }
}

/// Two groups of eight triangles far apart, and a row of rays toward each. No ray visits the other group's leaf.
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
        for (i, hit) in hits.iter().enumerate() {
            assert_eq!(hit.triangle, i as u32, "{}", level.name());
        }
        // Eight rays with eight triangles, twice.
        assert_eq!(tests, 128, "{}", level.name());
    }
}
