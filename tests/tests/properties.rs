//! Property tests on scenes with arbitrary coordinates. Proptest shrinks a failing scene to a
//! minimal one.
//!
//! Unlike the families of `intertri-lab`, these scenes do not target known weaknesses of
//! ray/triangle tests. A failing scene is printed as a fixture, and its seed is saved in
//! `fixtures/proptest-regressions`.

use intertri::simd::Level;
use intertri::{Ray, Triangle};
use intertri_tests::{Scene, as_source, check_hierarchy, check_kernel};
use proptest::prelude::*;
use proptest::test_runner::{Config, FileFailurePersistence, RngSeed, TestError, TestRunner};
use std::cell::Cell;

const KEPT: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/proptest-regressions/properties.txt");

/// Generates arbitrary f32 values, including NaN and infinities.
fn any_bits() -> BoxedStrategy<f32> {
    any::<u32>().prop_map(f32::from_bits).boxed()
}

/// Generates small integers, so that rays often meet edges exactly, triangles coincide, and hits
/// are at the ends of intervals.
fn grid() -> BoxedStrategy<f32> {
    (-2..=2_i8).prop_map(f32::from).boxed()
}

/// Generates numbers between -2 and 2 with full mantissas, small integers, and occasionally numbers
/// with arbitrary bit patterns.
fn mixed() -> BoxedStrategy<f32> {
    prop_oneof![8 => -2.0..2.0_f32, 8 => grid(), 1 => any_bits()].boxed()
}

/// Generates scenes of 1 to 20 triangles and 1 to 20 rays, with coordinates drawn from `x`.
fn scenes(x: &BoxedStrategy<f32>) -> impl Strategy<Value = Scene> + use<> {
    let point = || [x.clone(), x.clone(), x.clone()];
    let triangle = [point(), point(), point()].prop_map(Triangle);
    let interval = prop_oneof![3 => Just((0.0, f32::INFINITY)), 1 => (x.clone(), x.clone())];
    let ray = (point(), point(), interval).prop_map(|(origin, dir, (t_min, t_max))| Ray {
        origin,
        t_min,
        dir,
        t_max,
    });
    let threshold = prop_oneof![Just(1e-9), Just(0.0), Just(0.25)];
    let (triangles, rays) =
        (prop::collection::vec(triangle, 1..=20), prop::collection::vec(ray, 1..=20));
    (triangles, rays, threshold).prop_map(|(triangles, rays, threshold)| Scene {
        triangles,
        rays,
        threshold,
    })
}

/// Checks 256 scenes, which are the same in every run. Together they must have at least
/// `hits_at_least` hits.
fn hold(x: &BoxedStrategy<f32>, hits_at_least: usize) {
    let mut runner = TestRunner::new(Config {
        cases: 256,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: Some(Box::new(FileFailurePersistence::Direct(KEPT))),
        ..Config::default()
    });
    let levels: Vec<Level> = Level::all().collect();
    let hits = Cell::new(0);
    let result = runner.run(&scenes(x), |scene| {
        let some = check_kernel(&scene, &levels).map_err(TestCaseError::fail)?;
        check_hierarchy(&scene, &levels).map_err(TestCaseError::fail)?;
        hits.set(hits.get() + some);
        Ok(())
    });
    match result {
        Ok(()) => {}
        Err(TestError::Fail(why, scene)) => panic!("{why}\n{}", as_source(&scene)),
        Err(TestError::Abort(why)) => panic!("{why}"),
    }
    println!("{} hits", hits.get());
    assert!(hits.get() >= hits_at_least, "{} hits are too few", hits.get());
}

#[test]
fn scenes_of_any_bits() {
    hold(&any_bits(), 500);
}

#[test]
fn scenes_on_a_small_grid() {
    hold(&grid(), 800);
}

#[test]
fn scenes_of_mixed_numbers() {
    hold(&mixed(), 500);
}
