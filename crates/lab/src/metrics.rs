//! Measures each method's errors on each family, for a table with one row per method and family.

use rayon::prelude::*;
use serde::Serialize;

use crate::accuracy::{self, ErrorCounts};
use crate::case_answers::CaseAnswers;
use crate::families::{Case, Family};
use crate::methods::METHODS;
use crate::oracle::{exact_t, t_error, t_error_ulps, t_error_ulps_f32};
use crate::quantile::quantile;
use crate::rng::Rng;
use crate::test_batch::TestBatch;

/// A method's results on a family.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The family.
    pub family: &'static str,
    /// The method.
    pub method: &'static str,
    /// The number of ray/triangle pairs.
    pub trials: u64,
    /// The number of pairs that are hits according to the oracle.
    pub true_hits: u64,
    /// The number of true hits that the method reports as misses.
    pub false_misses: u64,
    /// The number of true misses that the method reports as hits.
    pub false_hits: u64,
    /// The number of hits whose `t` is NaN or infinite.
    pub t_not_finite: u64,
    /// The number of pairs for which the method disagrees with the oracle: false misses and false
    /// hits.
    #[serde(rename = "not_truth")]
    pub not_oracle: u64,
    /// The number of pairs for which the method disagrees with the scalar f64 reference.
    pub not_reference: u64,
    /// The number of rays that start inside a closed convex mesh, or 0 if the family has no such
    /// mesh.
    pub closed_trials: u64,
    /// The number of rays counted in `closed_trials` that hit nothing.
    pub leaks: u64,
    /// The number of rays counted in `closed_trials` that hit two or more triangles, although each
    /// ray leaves the mesh once.
    pub doubles: u64,
    /// The number of true hits whose `t` was compared with the exact `t`.
    pub t_trials: u64,
    /// The median relative error of `t`.
    pub t_median: f64,
    /// The relative error that 99.9 % of cases do not exceed.
    pub t_p999: f64,
    /// The largest relative error.
    pub t_worst: f64,
    /// The median error of `t` in ulps of the method's own precision.
    pub t_ulps_median: f64,
    /// The error in ulps that 99.9 % of cases do not exceed.
    pub t_ulps_p999: f64,
    /// The largest error in ulps.
    pub t_ulps_worst: f64,
}

/// The number of cases in one unit of work. Each unit generates its cases from its own seed.
const PIECE: u64 = 500;
/// The maximum number of true hits per unit of work for which the exact `t` is computed.
const EXACT: usize = 50;
/// The families whose scenes are closed convex meshes, each with its number of triangles.
const CLOSED: [(&str, usize); 3] =
    [("icosphere", 80), ("icosphere-exact", 80), ("cube-exact", 192)];

/// A method's results in one unit of work.
#[derive(Clone, Default)]
struct Tally {
    true_hits: u64,
    false_misses: u64,
    false_hits: u64,
    t_not_finite: u64,
    not_reference: u64,
    /// For each compared `t`, the relative error and the error in ulps.
    errors: Vec<[f64; 2]>,
}

/// Runs every method on at least `cases` cases of a family. Calls `step` with the number of cases
/// just completed. The counts depend only on the seed and the number of cases.
pub fn metrics(family: &Family, seed: u64, cases: u64, step: &(impl Fn(u64) + Sync)) -> Vec<Row> {
    let pieces: Vec<(Vec<Tally>, Vec<ErrorCounts>)> = (0..cases.div_ceil(PIECE))
        .into_par_iter()
        .map(|piece| {
            let mut rng = Rng::new(seed ^ piece << 8);
            let cases: Vec<Case> = (0..PIECE).map(|_| family.case(&mut rng)).collect();
            let found = (ask(&cases), closed(family, &mut rng));
            step(PIECE);
            found
        })
        .collect();

    let row = |(k, method): (usize, &crate::methods::Method)| {
        let sum =
            |of: fn(&Tally) -> u64| pieces.iter().map(|(found, _)| of(&found[k])).sum::<u64>();
        let closed = |of: fn(&ErrorCounts) -> u64| {
            pieces.iter().filter_map(|(_, error_counts)| error_counts.get(k)).map(of).sum::<u64>()
        };
        let (false_misses, false_hits) = (sum(|f| f.false_misses), sum(|f| f.false_hits));
        let errors = || pieces.iter().flat_map(|(found, _)| &found[k].errors);
        let mut relative: Vec<f64> = errors().map(|e| e[0]).collect();
        let mut ulps: Vec<f64> = errors().map(|e| e[1]).collect();
        Row {
            family: family.name,
            method: method.name,
            trials: pieces.len() as u64 * PIECE,
            true_hits: sum(|f| f.true_hits),
            false_misses,
            false_hits,
            t_not_finite: sum(|f| f.t_not_finite),
            not_oracle: false_misses + false_hits,
            not_reference: sum(|f| f.not_reference),
            closed_trials: closed(|v| v.trials),
            leaks: closed(|v| v.leaks),
            doubles: closed(|v| v.doubles),
            t_trials: relative.len() as u64,
            t_median: quantile(&mut relative, 0.5),
            t_p999: quantile(&mut relative, 0.999),
            t_worst: quantile(&mut relative, 1.0),
            t_ulps_median: quantile(&mut ulps, 0.5),
            t_ulps_p999: quantile(&mut ulps, 0.999),
            t_ulps_worst: quantile(&mut ulps, 1.0),
        }
    };
    METHODS.iter().enumerate().map(row).collect()
}

/// Runs all methods on a list of cases.
fn ask(cases: &[Case]) -> Vec<Tally> {
    let asked = CaseAnswers::of(cases);
    // Compute the exact t of the first true hits.
    let hits = (0..cases.len()).filter(|&i| asked.oracle[i].is_hit()).take(EXACT);
    let exact: Vec<_> =
        hits.filter_map(|i| Some((i, exact_t(&cases[i].triangle, &cases[i].ray)?))).collect();
    let of_method = |(method, answers): (&crate::methods::Method, &Vec<_>)| {
        let answers: &[crate::test_batch::Answer] = answers;
        let mut found = Tally::default();
        for (i, answer) in answers.iter().enumerate() {
            let is_hit = asked.oracle[i].is_hit();
            found.true_hits += u64::from(is_hit);
            found.false_misses += u64::from(is_hit && !answer.hit);
            found.false_hits += u64::from(!is_hit && answer.hit);
            found.t_not_finite += u64::from(answer.hit && !answer.t.is_finite());
            found.not_reference += u64::from(answer.hit != asked.reference[i]);
        }
        for (i, exact) in exact.iter().filter(|(i, _)| answers[*i].hit) {
            let t = answers[*i].t;
            let ulps = match method.bits {
                24 => t_error_ulps_f32(t as f32, exact),
                _ => t_error_ulps(t, exact),
            };
            found.errors.push([t_error(t, exact), ulps]);
        }
        found
    };
    METHODS.iter().zip(&asked.answers).map(of_method).collect()
}

/// Counts the leaks and double hits on a family of closed convex meshes, for the rays that start
/// inside. Returns an empty list for other families.
fn closed(family: &Family, rng: &mut Rng) -> Vec<ErrorCounts> {
    let Some(&(_, triangles)) = CLOSED.iter().find(|(name, _)| *name == family.name) else {
        return Vec::new();
    };
    let scene = family.scene(rng, triangles, 64);
    let mut batch = TestBatch { rays: scene.rays, triangles: scene.triangles };
    let triangles = &batch.triangles;
    batch.rays.retain(|ray| accuracy::is_within(triangles, ray.origin));
    let mut error_counts = vec![ErrorCounts::default(); METHODS.len()];
    accuracy::leaks_and_doubles(&batch, &mut error_counts);
    error_counts
}
