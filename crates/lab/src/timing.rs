//! Measures how long the methods take, running them side by side.
//!
//! In each turn, every method runs in each of its layouts for a fraction of a millisecond, so that
//! disturbances affect all methods alike. Each time is compared with the scalar f64 reference's
//! time in the same turn. The tables show the median and the quartiles of the ratios.

use intertri::simd::Level;
use serde::Serialize;

use crate::layout::{Form, Layout};
use crate::methods::{METHODS, reference_closest};
use crate::quantile::quantile;
use crate::rng::Rng;
use crate::test_batch::TestBatch;
use crate::workloads::{Model, Workload};

/// The time that a method took in one layout on one workload.
#[derive(Clone, Debug, Serialize)]
pub struct Time {
    /// The workload.
    pub workload: &'static str,
    /// The method.
    pub method: &'static str,
    /// The form of the layout.
    pub form: &'static str,
    /// The number of lanes.
    pub lanes: usize,
    /// The time per ray/triangle test in nanoseconds, as the median over the turns.
    pub ns_per_test: f64,
    /// The reference's time divided by this time, as the median over the turns.
    pub times_faster: f64,
    /// The lower quartile of the same ratio.
    pub times_faster_p25: f64,
    /// The upper quartile of the same ratio.
    pub times_faster_p75: f64,
}

/// The name of the scalar f64 reference in the tables.
pub const REFERENCE: &str = "reference";

/// The number of batches per turn.
const BUNDLES: usize = 12;

/// Measures every method in every layout that it supports. Calls `step` after each turn.
pub fn measure(
    workload: Workload,
    model: &Model,
    turns: usize,
    mut step: impl FnMut(),
) -> Vec<Time> {
    let mut rng = Rng::new(11);
    let batches: Vec<_> = (0..BUNDLES).map(|_| workload.batch(&mut rng, model)).collect();
    let tests: usize =
        batches.iter().map(|TestBatch { rays, triangles }| rays.len() * triangles.len()).sum();

    // Every method in every layout that it supports, with its time in seconds for each turn.
    let mut contenders = Vec::new();
    for method in METHODS {
        for form in [Form::Packets, Form::Blocks] {
            for lanes in [1, 4, 8, 16] {
                contenders.push((method, Layout { form, lanes }, Vec::new()));
            }
        }
    }
    let (level, mut nearest) = (Level::best(), Vec::new());
    let mut reference = Vec::new();
    // The first turn is a warm-up.
    for turn in 0..=turns {
        let seconds = reference_closest(&batches, &mut nearest);
        reference.push(seconds);
        for (method, layout, seconds) in &mut contenders {
            seconds.extend(method.closest(level, &batches, *layout, &mut nearest));
        }
        if turn == 0 {
            reference.clear();
            contenders.retain_mut(|(.., seconds)| seconds.pop().is_some());
        }
        step();
    }

    let time = |method, form, lanes, seconds: &[f64]| {
        let mut ratios: Vec<f64> = reference.iter().zip(seconds).map(|(a, b)| a / b).collect();
        let mut seconds = seconds.to_vec();
        Time {
            workload: workload.name(),
            method,
            form,
            lanes,
            ns_per_test: quantile(&mut seconds, 0.5) / tests as f64 * 1e9,
            times_faster: quantile(&mut ratios, 0.5),
            times_faster_p25: quantile(&mut ratios, 0.25),
            times_faster_p75: quantile(&mut ratios, 0.75),
        }
    };
    let mut times = vec![time(REFERENCE, "scalar", 1, &reference)];
    times.extend(contenders.iter().map(|(method, layout, seconds)| {
        time(method.name, layout.form.name(), layout.lanes, seconds)
    }));
    times
}
