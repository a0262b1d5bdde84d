//! Finds the Pareto front: the methods that no other method matches or beats in both speed and
//! accuracy.

use crate::accuracy::{ErrorCounts, ON_GRID};
use crate::timing::Time;
use crate::workloads::Workload;

/// The standard against which a method's answers are judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Baseline {
    /// The exact oracle. For [`Workload::Edges`], only leaks count as errors; double hits are
    /// listed separately.
    Oracle,
    /// The scalar f64 reference.
    Reference,
}

impl Baseline {
    /// Returns the number of a method's wrong answers.
    pub fn wrong(self, errors: &ErrorCounts) -> u64 {
        match self {
            Self::Reference => errors.not_reference,
            Self::Oracle if errors.workload == Workload::Edges.name() => errors.leaks,
            Self::Oracle => errors.wrong,
        }
    }
}

/// Returns the time of a method at its fastest number of lanes, in the workload's form. [`ON_GRID`]
/// has the same time as `fixed`, because it does the same work on inputs that do not need snapping.
pub fn fastest<'a>(errors: &ErrorCounts, times: &'a [Time]) -> Option<&'a Time> {
    let method = if errors.method == ON_GRID { "fixed" } else { errors.method };
    let form = Workload::ALL.into_iter().find(|w| w.name() == errors.workload)?.form().name();
    let own =
        |time: &&Time| (time.workload, time.method, time.form) == (errors.workload, method, form);
    times.iter().filter(own).max_by(|a, b| a.times_faster.total_cmp(&b.times_faster))
}

/// Returns the Pareto front on a workload, with the fastest method first. Each method on the front
/// gives fewer wrong answers than every faster method. If two methods are equal, the front contains
/// the one that comes first in the table. The `fixed` mode is included as [`ON_GRID`], on the
/// inputs for which it guarantees exact answers.
pub fn pareto_front(
    workload: Workload,
    baseline: Baseline,
    error_counts: &[ErrorCounts],
    times: &[Time],
) -> Vec<&'static str> {
    let takes_part =
        |errors: &&ErrorCounts| errors.workload == workload.name() && errors.method != "fixed";
    let mut order: Vec<(f64, f64, &ErrorCounts)> = error_counts
        .iter()
        .filter(takes_part)
        .filter_map(|errors| {
            let share = baseline.wrong(errors) as f64 / errors.trials as f64;
            Some((fastest(errors, times)?.times_faster, share, errors))
        })
        .collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    order.retain(|&(_, share, _)| {
        let more_right = share < least;
        least = least.min(share);
        more_right
    });
    order.iter().map(|(.., errors)| errors.method).collect()
}

#[cfg(test)]
mod tests {
    use super::{Baseline, fastest, pareto_front};
    use crate::accuracy::ErrorCounts;
    use crate::timing::Time;
    use crate::workloads::Workload;

    fn time(method: &'static str, lanes: usize, times_faster: f64) -> Time {
        let workload = "camera";
        let form = "packets";
        let (p25, p75) = (times_faster, times_faster);
        Time {
            workload,
            method,
            form,
            lanes,
            ns_per_test: 1.0,
            times_faster,
            times_faster_p25: p25,
            times_faster_p75: p75,
        }
    }

    #[test]
    fn the_pareto_front_has_what_is_not_beaten_in_both() {
        let errors = |method, wrong, not_reference| {
            let (workload, trials) = ("camera", 100);
            ErrorCounts { workload, method, trials, wrong, not_reference, ..ErrorCounts::default() }
        };
        let error_counts = [
            errors("slow and right", 0, 5),
            errors("fast", 9, 9),
            errors("beaten", 9, 9),
            errors("middling", 4, 0),
            errors("slower and as right", 4, 0),
            errors("not timed", 0, 0),
        ];
        let mut times = vec![
            time("slow and right", 8, 2.0),
            time("fast", 4, 1.0),
            time("fast", 16, 9.0),
            time("beaten", 8, 8.0),
            time("middling", 8, 5.0),
            time("slower and as right", 8, 3.0),
        ];
        times.push(Time { form: "packs", ..time("slow and right", 8, 99.0) });
        times.push(Time { workload: "mix", ..time("slow and right", 8, 99.0) });
        let front = |baseline| pareto_front(Workload::Camera, baseline, &error_counts, &times);
        assert_eq!(front(Baseline::Oracle), ["fast", "middling", "slow and right"]);
        assert_eq!(front(Baseline::Reference), ["fast", "middling"]);
        assert_eq!(fastest(&error_counts[1], &times).unwrap().lanes, 16);
        assert!(fastest(&error_counts[5], &times).is_none());
    }
}
