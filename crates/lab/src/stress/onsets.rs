//! Measures how often each method is wrong at each value of a sweep's parameter, and where errors
//! begin.

use rayon::prelude::*;
use serde::Serialize;

use super::clearance::is_clear;
use super::sweeps::{SWEEPS, Sweep, parameter};
use crate::case_answers::CaseAnswers;
use crate::families::{Case, find};
use crate::methods::METHODS;
use crate::rng::Rng;

/// A method's results at one value of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Onset {
    /// The name of the sweep.
    pub sweep: &'static str,
    /// The value of the parameter.
    pub parameter: f64,
    /// The method.
    pub method: &'static str,
    /// The number of cases, which may be smaller than requested if few of the family's cases are
    /// clear of all sides.
    pub trials: u64,
    /// The number of true hits that the method reports as misses.
    pub false_misses: u64,
    /// The number of true misses that the method reports as hits.
    pub false_hits: u64,
    /// The number of cases in which the method disagrees with the scalar f64 reference.
    pub not_reference: u64,
}

impl Onset {
    /// Returns the share of wrong answers.
    pub fn share(&self) -> f64 {
        (self.false_misses + self.false_hits) as f64 / self.trials.max(1) as f64
    }
}

/// A value of the parameter is kept only if at least this many cases are clear of all sides.
const ENOUGH: u64 = 100;

/// Runs all sweeps, each with `points` logarithmically spaced values and about `cases` cases per
/// value. The counts depend only on the seed, `points`, and `cases`. Calls `step` after each value.
pub fn sweep_all(seed: u64, points: usize, cases: u64, step: &(impl Fn() + Sync)) -> Vec<Onset> {
    let jobs: Vec<_> =
        SWEEPS.iter().flat_map(|sweep| (0..points).map(move |k| (sweep, k))).collect();
    let at = |&(sweep, k): &(&'static Sweep, usize)| {
        let share = k as f64 / (points - 1).max(1) as f64;
        let onsets = value(sweep, parameter(sweep, share), seed ^ (k as u64) << 32, cases);
        step();
        onsets
    };
    jobs.par_iter().flat_map_iter(at).collect()
}

fn value(sweep: &'static Sweep, parameter: f64, seed: u64, cases: u64) -> Vec<Onset> {
    let Some(family) = find(sweep.family) else { return Vec::new() };
    let mut rng = Rng::new(seed);
    let mut none = Onset {
        sweep: sweep.name,
        parameter,
        method: "",
        trials: 0,
        false_misses: 0,
        false_hits: 0,
        not_reference: 0,
    };
    let mut onsets = vec![none.clone(); METHODS.len()];
    for (onset, method) in onsets.iter_mut().zip(METHODS) {
        onset.method = method.name;
    }

    // In some families, few cases are clear. Skip the value if hardly any case is.
    let mut tries = 0;
    while none.trials < cases && tries < 16 * cases {
        tries += 512;
        let some = (0..512).map(|_| family.case_at(&mut rng, parameter));
        let some: Vec<Case> = some.filter(|case| !sweep.clear || is_clear(case)).collect();
        let asked = CaseAnswers::of(&some);
        none.trials += some.len() as u64;
        for (onset, answers) in onsets.iter_mut().zip(&asked.answers) {
            for (i, answer) in answers.iter().enumerate() {
                let is_hit = asked.oracle[i].is_hit();
                onset.false_misses += u64::from(is_hit && !answer.hit);
                onset.false_hits += u64::from(!is_hit && answer.hit);
                onset.not_reference += u64::from(answer.hit != asked.reference[i]);
            }
        }
    }
    for onset in &mut onsets {
        onset.trials = none.trials;
    }
    if none.trials < ENOUGH { Vec::new() } else { onsets }
}

/// Returns the first value, from the harmless end, at which at least one in 1,000 answers of a
/// method is wrong, or `None` if there is no such value.
pub fn first(onsets: &[Onset], sweep: &str, method: &str) -> Option<f64> {
    let mut own = onsets.iter().filter(|onset| onset.sweep == sweep && onset.method == method);
    own.find(|onset| onset.share() >= 1e-3).map(|onset| onset.parameter)
}
