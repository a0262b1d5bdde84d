//! Where methods begin to fail: families swept by their parameter.

use rayon::prelude::*;
use serde::Serialize;

use crate::cases::{Asked, is_clear};
use crate::families::{Case, find};
use crate::rng::Rng;
use crate::subjects::SUBJECTS;

/// A family and the way its parameter goes, from where it is harmless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// What is swept, for a heading.
    pub name: &'static str,
    /// The family.
    pub family: &'static str,
    /// The harmless end.
    pub from: f64,
    /// The other end.
    pub to: f64,
    /// Whether only cases count that pass clear of the sides. Not where closeness is the parameter.
    pub clear: bool,
}

/// All sweeps. A family that hurts at both ends is swept twice, from the middle.
pub const SWEEPS: &[Sweep] = &[
    sweep("needle, ratio", "needle", 1.0, 1e-12),
    sweep("cap, ratio", "cap", 1.0, 1e-12),
    sweep("sliver, ratio", "sliver", 1.0, 1e-12),
    sweep("grazing angle", "grazing", 1.0, 1e-12),
    sweep("distance / size", "far", 1.0, 1e9),
    sweep("size at distance 1", "tiny", 1.0, 1e-7),
    sweep("offset, size 1", "offset", 1.0, 1e9),
    sweep("offset, size in step", "offset-large", 1.0, 1e9),
    sweep("scale, down", "scale", 1.0, 1e-30),
    sweep("scale, up", "scale", 1.0, 1e30),
    sweep("|dir|, short", "direction", 1.0, 1e-30),
    sweep("|dir|, long", "direction", 1.0, 1e30),
    sweep("near overflow", "overflow", 1e12, 3e38),
    sweep("near underflow", "underflow", 1e-12, 1e-44),
    sweep("threshold met by |vd|", "threshold-vd", 1e-15, 0.5),
    sweep("threshold met by t", "threshold-t", 1e-15, 1e3),
    Sweep { clear: false, ..sweep("f32 steps off an edge", "edge-steps", 1_048_576.0, 1.0) },
];

const fn sweep(name: &'static str, family: &'static str, from: f64, to: f64) -> Sweep {
    Sweep { name, family, from, to, clear: true }
}

/// How a method fares at one value of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Onset {
    /// What is swept.
    pub sweep: &'static str,
    /// The value of the parameter.
    pub parameter: f64,
    /// The method.
    pub method: &'static str,
    /// Cases that counted; may be fewer than asked for where few of the family's are clear.
    pub trials: u64,
    /// True hits called a miss.
    pub false_misses: u64,
    /// True misses called a hit.
    pub false_hits: u64,
    /// Disagreements with the scalar f64 reference.
    pub not_reference: u64,
}

impl Onset {
    /// The share of wrong answers.
    pub fn share(&self) -> f64 {
        (self.false_misses + self.false_hits) as f64 / self.trials.max(1) as f64
    }
}

/// At least so many of the tries must be clear for a value of the parameter to be shown.
const ENOUGH: u64 = 100;

/// Sweeps: `points` values in equal ratios, about `cases` cases each. The counts depend on the seed
/// and these numbers alone. `step` is called after each value.
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

/// The value at a share of the way, by roots alone so that it has the same bits everywhere: bisected
/// sixteen times.
fn parameter(sweep: &Sweep, share: f64) -> f64 {
    let (mut lo, mut hi, mut from, mut to) = (0.0, 1.0, sweep.from, sweep.to);
    for _ in 0..16 {
        if share <= lo {
            return from;
        }
        if share >= hi {
            return to;
        }
        let middle = f64::midpoint(lo, hi);
        let value = from.sqrt() * to.sqrt();
        if share < middle {
            (hi, to) = (middle, value);
        } else {
            (lo, from) = (middle, value);
        }
    }
    from
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
    let mut onsets = vec![none.clone(); SUBJECTS.len()];
    for (onset, subject) in onsets.iter_mut().zip(SUBJECTS) {
        onset.method = subject.name;
    }

    // Few cases of some families are clear; where hardly any is, there is nothing to see.
    let mut tries = 0;
    while none.trials < cases && tries < 16 * cases {
        tries += 512;
        let some = (0..512).map(|_| family.case_at(&mut rng, parameter));
        let some: Vec<Case> = some.filter(|case| !sweep.clear || is_clear(case)).collect();
        let asked = Asked::of(&some);
        none.trials += some.len() as u64;
        for (onset, answers) in onsets.iter_mut().zip(&asked.answers) {
            for (i, answer) in answers.iter().enumerate() {
                let is_hit = asked.truth[i].is_hit();
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

/// The first value, from the harmless end, at which at least one in 1,000 answers of a method is
/// wrong; `None` if there is none.
pub fn first(onsets: &[Onset], sweep: &str, method: &str) -> Option<f64> {
    let mut own = onsets.iter().filter(|onset| onset.sweep == sweep && onset.method == method);
    own.find(|onset| onset.share() >= 1e-3).map(|onset| onset.parameter)
}

#[cfg(test)]
mod tests {
    use super::{SWEEPS, first, parameter, sweep_all};
    use crate::families::find;

    #[test]
    fn sweeps_go_from_end_to_end_within_their_families() {
        for sweep in SWEEPS {
            let param = find(sweep.family).unwrap().param.unwrap();
            let (lo, hi) = (param.from.min(param.to), param.from.max(param.to));
            assert!(sweep.from >= lo && sweep.from <= hi && sweep.to >= lo && sweep.to <= hi);
            assert_eq!(parameter(sweep, 0.0), sweep.from);
            assert_eq!(parameter(sweep, 1.0), sweep.to);
            let middle = sweep.from.sqrt() * sweep.to.sqrt();
            assert!((parameter(sweep, 0.5) / middle - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn methods_fail_where_theory_says() {
        let onsets = sweep_all(8, 7, 600, &|| ());
        assert_eq!(onsets, sweep_all(8, 7, 600, &|| ()));
        let at = |sweep, method| first(&onsets, sweep, method);
        // A fixed epsilon has a scale; the products of f32 under- and overflow; a threshold on t
        // forbids long directions.
        assert!(at("scale, down", "Möller–Trumbore ε f32").unwrap() > 1e-11);
        assert!(at("scale, down", "Möller–Trumbore f32").unwrap() < 1e-11);
        assert!(at("scale, up", "Möller–Trumbore f32").is_some());
        assert_eq!(at("scale, up", "Möller–Trumbore f64"), None);
        assert!(at("|dir|, long", "certified").is_some());
        assert_eq!(at("|dir|, long", "Möller–Trumbore f32"), None);
        // Constants in the axes of the scene do not survive to be moved; differences do.
        assert!(at("offset, size 1", "Baldwin–Weber f32").is_some());
        assert_eq!(at("offset, size 1", "Embree fast f32"), None);
        // The kernel fails where the reference fails, and nowhere else.
        let certified = onsets.iter().filter(|onset| onset.method == "certified");
        assert!(certified.map(|onset| onset.not_reference).sum::<u64>() == 0);
    }
}
