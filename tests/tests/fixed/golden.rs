//! Tests that every level computes the same bits, by hashing many answers on a fixed scene.

use intertri::fixed::{Bits, Fixed, Grid, blocks};
use intertri::simd::Level;
use intertri::{Hit, Ray, Triangle};

use intertri_tests::grid_reference::crossing;

use super::{Numbers, solids};

/// The hash that every CPU must compute.
const GOLDEN: u64 = 0x092f_1c9c_c4a2_8321;

/// FNV-1a over 64-bit words.
fn mix(hash: u64, word: u64) -> u64 {
    (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3)
}

#[test]
fn the_answers_hash_to_the_golden_number_at_every_level() {
    // A sphere among loose triangles, on a fine and a coarse grid.
    let mut n = Numbers(42);
    let mut scene: Vec<Triangle> = solids::icosphere(3)
        .into_iter()
        .map(|corners| Triangle(corners.map(|c| c.map(|x| x * 0.75))))
        .collect();
    let mut number = || (n.next() >> 40) as f32 / 8_388_608.0 - 1.0;
    for _ in 0..500 {
        let at = [number(), number(), number()];
        let corners = [(); 3].map(|()| at.map(|x| (x + 0.25 * number()).clamp(-1.0, 1.0)));
        scene.push(Triangle(corners));
    }
    let eye = [0.9, 0.8, -0.95];
    let rays: Vec<Ray> = (0..1500)
        .map(|i| {
            let corner = scene[i * 7 % scene.len()].0[i % 3];
            let target = if i % 3 == 0 { [number(), number(), number()] } else { corner };
            let origin = if i < 1000 { eye } else { [number(), number(), number()] };
            Ray::new(origin, [0, 1, 2].map(|axis| target[axis] - origin[axis]))
        })
        .collect();

    for level in Level::all() {
        let fixed = Fixed::at(level);
        let mut hash = 0xcbf2_9ce4_8422_2325;
        for bits in [Bits::FINE, Bits::COARSE, Bits::of_grid(6).unwrap()] {
            let points = scene.iter().flat_map(|t| t.0).chain(rays.iter().map(|ray| ray.origin));
            let grid = Grid::around(points, bits).unwrap();
            let triangles: Vec<_> = scene.iter().map(|t| grid.triangle(t).unwrap()).collect();
            let blocks = blocks(&triangles);
            let rays: Vec<_> = rays.iter().map(|ray| grid.ray(ray).unwrap()).collect();
            let mut hits = vec![Hit::MISS; rays.len()];
            fixed.closest_batch(&blocks, &rays, &mut hits);
            for (ray, hit) in rays.iter().zip(&hits) {
                let one = fixed.closest(&blocks, ray).unwrap_or(Hit::MISS);
                assert_eq!(*hit, one);
                let count = fixed.crossings(&blocks, ray);
                assert_eq!(fixed.any(&blocks, ray), hit.is_hit());
                // For a miss, the index is hashed as 64 one bits.
                let triangle = hit.some().map_or(u64::MAX, |hit| hit.triangle.into());
                for word in [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), triangle] {
                    hash = mix(hash, word);
                }
                hash = mix(mix(hash, count.signed as u64), count.unsigned);
                // The hits are in order of the exact t; hash them in order of the triangles.
                let mut all = fixed.all(&blocks, ray);
                let t = |i: u32| crossing(ray, &triangles[i as usize]).unwrap().t;
                assert!(all.is_sorted_by_key(|hit| (t(hit.triangle), hit.triangle)), "{all:?}");
                all.sort_unstable_by_key(|hit| hit.triangle);
                for hit in all {
                    hash = mix(mix(hash, hit.triangle.into()), hit.t.to_bits());
                }
            }
        }
        println!("{} {hash:#018x}", level.name());
        assert_eq!(hash, GOLDEN, "{}", level.name());
    }
}
