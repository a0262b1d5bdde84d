//! The Pareto front: the methods that none beats in both, in speed and in being right.

use crate::judge::{ON_GRID, Verdict};
use crate::timing::Time;
use crate::workloads::Workload;

/// Against whom a method is right or wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judge {
    /// The exact truth; of [`Workload::Edges`] only leaks count, double counts stand beside them.
    Truth,
    /// The scalar f64 reference.
    Reference,
}

impl Judge {
    /// How many answers of a method were wrong.
    pub fn errors(self, verdict: &Verdict) -> u64 {
        match self {
            Self::Reference => verdict.not_reference,
            Self::Truth if verdict.workload == Workload::Edges.name() => verdict.leaks,
            Self::Truth => verdict.wrong,
        }
    }
}

/// The time of a verdict's method where it is fastest, in the form of the workload. [`ON_GRID`] has
/// the time of `fixed`, which works alike on what it need not snap.
pub fn fastest<'a>(verdict: &Verdict, times: &'a [Time]) -> Option<&'a Time> {
    let method = if verdict.method == ON_GRID { "fixed" } else { verdict.method };
    let form = Workload::ALL.into_iter().find(|w| w.name() == verdict.workload)?.form().name();
    let own =
        |time: &&Time| (time.workload, time.method, time.form) == (verdict.workload, method, form);
    times.iter().filter(own).max_by(|a, b| a.times_faster.total_cmp(&b.times_faster))
}

/// The front on a workload, the fastest first: each is more often right than all faster ones. Of
/// equals the first in the table. `fixed` takes part by [`ON_GRID`], on what it promises to be right
/// for.
pub fn front(
    workload: Workload,
    judge: Judge,
    verdicts: &[Verdict],
    times: &[Time],
) -> Vec<&'static str> {
    let takes_part =
        |verdict: &&Verdict| verdict.workload == workload.name() && verdict.method != "fixed";
    let mut order: Vec<(f64, f64, &Verdict)> = verdicts
        .iter()
        .filter(takes_part)
        .filter_map(|verdict| {
            let share = judge.errors(verdict) as f64 / verdict.trials as f64;
            Some((fastest(verdict, times)?.times_faster, share, verdict))
        })
        .collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    order.retain(|&(_, share, _)| {
        let more_right = share < least;
        least = least.min(share);
        more_right
    });
    order.iter().map(|(.., verdict)| verdict.method).collect()
}

#[cfg(test)]
mod tests {
    use super::{Judge, fastest, front};
    use crate::judge::Verdict;
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
    fn a_front_has_who_is_not_beaten_in_both() {
        let verdict = |method, wrong, not_reference| {
            let (workload, trials) = ("camera", 100);
            Verdict { workload, method, trials, wrong, not_reference, ..Verdict::default() }
        };
        let verdicts = [
            verdict("slow and right", 0, 5),
            verdict("fast", 9, 9),
            verdict("beaten", 9, 9),
            verdict("middling", 4, 0),
            verdict("slower and as right", 4, 0),
            verdict("not timed", 0, 0),
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
        let front = |judge| front(Workload::Camera, judge, &verdicts, &times);
        assert_eq!(front(Judge::Truth), ["fast", "middling", "slow and right"]);
        assert_eq!(front(Judge::Reference), ["fast", "middling"]);
        assert_eq!(fastest(&verdicts[1], &times).unwrap().lanes, 16);
        assert!(fastest(&verdicts[5], &times).is_none());
    }
}
