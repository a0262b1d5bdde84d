//! Decides whether triangles are so small, compared with the packets of a bundle, that tracing rays
//! one by one is faster.
//!
//! ```text
//!   ┌─────────────┐
//!   │ ◿ ◿ ◿ ◿ ◿ ◿ │ H     If triangles of size w × h cover the projection once, a packet's window
//!   │ ◿ ◿ ◿ ◿ ◿ ◿ │       reaches 2 (W + w) (H + h) / (w h) of them.
//!   └─────────────┘
//!          W
//! ```
//!
//! The size of the triangles in a bundle's first leaves shows whether continuing is worthwhile,
//! before much work is done.

use intertri::internal::Outlines;
use intertri::simd::{Lanes, Mask, Simd};

use super::projection::Projection;
use crate::util::lane_ops::total;

/// If triangles that cover the projection once would make a packet reach more triangles than this,
/// tracing its rays one by one is faster.
const TOO_MANY: f32 = 56.0;

/// The corresponding limit for closest-hit queries.
const TOO_MANY_FOR_CLOSEST: f32 = 36.0;

/// Returns a mask of the packets that would reach too many triangles if all triangles had the
/// average size of the triangles in these leaves.
#[inline(always)]
pub(crate) fn too_dense<S: Simd>(
    projection: &Projection<S>,
    leaves: &[Outlines],
    closest: bool,
) -> u64 {
    // Compute the average size of the triangles. If a triangle extends to infinity, the average is
    // infinite, so the triangles do not count as small.
    let (mut sum, mut triangles) = ([0.0; 2], 0);
    for outlines in leaves {
        let ([widths, heights], live) = outlines.sizes::<S::F32x16>();
        sum = [sum[0] + total(widths), sum[1] + total(heights)];
        triangles += live.count_ones();
    }
    let [w, h] = [sum[0] / triangles as f32, sum[1] / triangles as f32];
    let too_many = if closest { TOO_MANY_FOR_CLOSEST } else { TOO_MANY };

    // Estimate how many triangles a packet reaches, averaged over its group.
    let mut packets = 0;
    for (number, (lo, hi)) in projection.rectangles().enumerate() {
        let used = projection.used.saturating_sub(16 * number).min(16);
        let load = S::F32x16::load;
        let (x, y) = (load(&hi[0]) - load(&lo[0]), load(&hi[1]) - load(&lo[1]));
        let reached = (x + S::F32x16::splat(w)) * (y + S::F32x16::splat(h));
        let given = <S::F32x16 as Lanes>::Mask::from_bits((1 << used) - 1);
        let reached = total(S::F32x16::select(given, reached, S::F32x16::splat(0.0)));
        if 2.0 * reached > too_many * used as f32 * w * h {
            packets |= ((1 << used) - 1) << (16 * number);
        }
    }
    packets
}

#[cfg(test)]
mod tests {
    use intertri::simd::{Level, Simd, WithSimd};
    use intertri::{Counts, Mode, Ray, Triangle};

    use crate::Bvh;
    use crate::walk::bundle::{Bundle, BundleRays, Common, Outcome, Projection, Results, Scratch};

    /// Finds the packets of a bundle that are left untraced, for a closest-hit or any-hit query.
    struct Left<'a>(&'a Bvh, &'a [Ray], bool);

    impl WithSimd for Left<'_> {
        type Output = Option<u64>;
        #[inline(always)]
        fn run<S: Simd>(self) -> Option<u64> {
            let Self(bvh, rays, any) = self;
            let rays =
                BundleRays { rays, first: intertri::RayId(0), next: &[], common: Common::Origin };
            let projection = &mut Projection::<S>::empty();
            let scratch = (projection, &mut Scratch::default(), &mut Results::default());
            let counts = &mut Counts::default();
            let (tree, filter) = (&bvh.tree, Mode::certified().filter());
            let bundle = Bundle { tree, filter, any, every: false, limit: usize::MAX };
            match bundle.trace::<S>(&rays, scratch, counts) {
                Outcome::Traced { left, .. } => Some(left),
                _ => None,
            }
        }
    }

    #[test]
    fn groups_are_left_where_triangles_are_small_beside_packets() {
        // Use sheets of squares of a given size, and four groups of rays. Rays are closer together
        // in the first two groups than in the other two.
        let sheet = |size: f32| {
            let count = (8.0 / size) as usize;
            let at = |x: usize, y: usize| [x as f32 * size - 4.0, y as f32 * size - 4.0, 0.0];
            let squares = (0..count * count).map(|i| (i % count, i / count));
            let halves = squares.flat_map(|(x, y)| {
                let (a, b) = (at(x + 1, y), at(x, y + 1));
                [Triangle([at(x, y), a, b]), Triangle([at(x + 1, y + 1), a, b])]
            });
            Bvh::new(&halves.collect::<Vec<_>>()).unwrap()
        };
        let ray = |i: usize| {
            let (group, packet, lane) = (i / 256, i / 16 % 16, i % 16);
            let apart = if group < 2 { 0.05 } else { 0.1 };
            let along = |packet: usize, lane: usize| (4 * packet + lane) as f32 * apart - 0.8;
            let (x, y) = (along(packet % 4, lane % 4), along(packet / 4, lane / 4));
            Ray::new([0.0, 0.0, 5.0], [x, y, -5.0])
        };
        let rays: Vec<Ray> = (0..1024).map(ray).collect();
        let (smaller, small, large) = (sheet(0.04), sheet(0.05), sheet(0.3));
        for level in Level::all() {
            for any in [false, true] {
                assert_eq!(level.run(Left(&small, &rays, any)), Some(u64::MAX << 32));
                assert_eq!(level.run(Left(&large, &rays, any)), Some(0));
                assert_eq!(level.run(Left(&small, &rays[..512], any)), Some(0));
            }
            assert_eq!(level.run(Left(&smaller, &rays[..512], false)), Some(u64::MAX >> 32));
            assert_eq!(level.run(Left(&smaller, &rays[..512], true)), Some(0));
        }
    }

    /// Tests many slivers whose boxes every packet reaches. A bundle in random order gives up after
    /// the work allowed for the whole bundle, because no part of it would be narrower.
    #[test]
    fn bundles_in_random_order_are_not_split() {
        let sliver = |i: usize| {
            let z = i as f32 / 4096.0;
            Triangle([[-4.0, -4.0, z], [4.0, 4.0, z], [4.0, 4.001, z]])
        };
        let bvh = Bvh::new(&(0..4096).map(sliver).collect::<Vec<_>>()).unwrap();
        let ray = |i: usize| {
            let [x, y] = [i % 32, i / 32].map(|k| k as f32 / 8.0 - 1.9);
            Ray::new([0.0, 0.0, 20.0], [x, y + 0.05, -20.0])
        };
        let rays: Vec<Ray> = (0..1024).map(|i| ray(i * 389 % 1024)).collect();
        for level in Level::all() {
            let [left, work] = level.run(Work(&bvh, &rays));
            assert!(left == 64 && work < 16 * 1024, "{left} packets left, work {work}");
        }
    }

    /// Finds the number of packets that a bundle leaves untraced, and the amount of work.
    struct Work<'a>(&'a Bvh, &'a [Ray]);

    impl WithSimd for Work<'_> {
        type Output = [usize; 2];
        #[inline(always)]
        fn run<S: Simd>(self) -> [usize; 2] {
            let Self(bvh, rays) = self;
            let rays =
                BundleRays { rays, first: intertri::RayId(0), next: &[], common: Common::Origin };
            let projection = &mut Projection::<S>::empty();
            let scratch = (projection, &mut Scratch::default(), &mut Results::default());
            let (tree, filter) = (&bvh.tree, Mode::certified().filter());
            let bundle = Bundle { tree, filter, any: false, every: false, limit: usize::MAX };
            match bundle.trace::<S>(&rays, scratch, &mut Counts::default()) {
                Outcome::Traced { left, work } => [left.count_ones() as usize, work],
                _ => [usize::MAX; 2],
            }
        }
    }
}
