//! Compares every mode, width and form of the kernel with the reference, for every family.

use crate::common;
use intertri::simd::Level;
use intertri_lab::families::{FAMILIES, Family};
use intertri_lab::rng::Rng;
use intertri_tests::{as_source, check_kernel};

/// Tests scenes of different shapes: one triangle and many rays, many triangles and one ray, and
/// several of both, with every possible number of live lanes in the last packet, including none.
/// Each scene runs at one level.
fn family(family: &Family, pairs: usize, seed: u64) -> (usize, usize) {
    let levels: Vec<Level> = Level::all().collect();
    let mut rng = Rng::new(seed);
    let (mut done, mut hits, mut scenes, mut shapes) = (0, 0, 0, 0);
    while done < pairs {
        scenes += 1;
        let (triangles, rays, turn) = match rng.below(4) {
            0 => (1, rng.below(18), scenes),
            1 => (rng.below(18), 1, scenes),
            2 => {
                shapes += 1;
                // In the next round, each shape runs at the next level.
                (shapes % 18, shapes / 18 % 18, shapes + shapes / (18 * 18))
            }
            _ => (1 + rng.below(3), 1 + rng.below(17), scenes),
        };
        let level = &levels[turn % levels.len()..][..1];
        let scene = common::scene(family, &mut rng, triangles, rays);
        hits += check_kernel(&scene, level).unwrap_or_else(|difference| {
            panic!("{} (seed {seed}): {difference}\n{}", family.name, as_source(&scene))
        });
        done += scene.triangles.len() * scene.rays.len();
    }
    (done, hits)
}

/// Prints a line after each family, so that a long run leaves a record even if it is cut off.
fn all_families(pairs: usize, seed: u64) {
    let each = pairs.div_ceil(FAMILIES.len());
    let (mut tests, mut hits) = (0, 0);
    for (some, met) in common::each_family(|_, f| {
        let (tests, hits) = family(f, each, seed);
        println!("{:20} {tests:10} pairs, {hits:10} hits, 0 differences", f.name);
        (tests, hits)
    }) {
        tests += some;
        hits += met;
    }
    println!("{tests} pairs, {hits} hits, each in every width and form: 0 differences");
}

#[test]
fn five_million_pairs_agree_with_the_reference() {
    all_families(5_000_000, 1);
}

#[test]
#[ignore = "slow: takes several minutes"]
fn a_hundred_million_pairs_agree_with_the_reference() {
    all_families(100_000_000, 2);
}
