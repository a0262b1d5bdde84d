//! Decides whether parallel rays are traced in bundles or in packets, by the work that each has taken.
//!
//! Bundles are faster where several rays hit a triangle, and slower where triangles are small compared
//! with the distance between rays. How small they are is not known beforehand, so both are tried on a
//! few rays. Work is counted, not timed, so that on one thread, the same rays are always traced in the
//! same way.

use crate::util::patience::Patience;
use crate::walk::bundle::Outcome;

/// Costs in nanoseconds, for closest hits and for any hit. They are from measurements on one machine
/// (docs/notes/2026-11-29-parallel-bundles.md); only their ratios matter.
#[derive(Clone, Copy)]
struct Costs {
    /// The cost of a ray in a bundle that takes no work.
    ray: f32,
    /// The cost of a node or leaf that a packet visits.
    visit: f32,
    /// The cost of a ray that is not traced in a packet.
    alone: f32,
}

const CLOSEST: Costs = Costs { ray: 18.0, visit: 170.0, alone: 180.0 };
const ANY: Costs = Costs { ray: 12.0, visit: 115.0, alone: 140.0 };

/// The cost of a packet test, or comparable work, in a bundle.
const WORK: f32 = 12.0;

/// A bundle is given up once it costs this many times as much as packets: in a trial, where these have
/// just traced the rays beside it, and otherwise.
const LIMITS: [f32; 2] = [0.8, 2.0];

/// The number of turns until the next trial. It doubles each time that the choice stays the same.
const TURNS: [usize; 2] = [8, 64];

/// If rays cost this many times as much as those of the last trials, the next trial begins.
const SURPRISE: f32 = 4.0;

/// What was learned from the rays so far.
#[derive(Clone)]
pub(crate) struct Choice {
    costs: Costs,
    /// During a trial, the cost per ray of packets.
    trial: Option<f32>,
    /// The costs per ray of bundles and of packets in all trials; earlier trials count less. Since
    /// sums are compared, rays that hit nothing, and are cheap in any case, hardly count.
    sums: [f32; 2],
    /// What the trials count together.
    weight: f32,
    /// The turns until the next trial.
    wait: Patience,
}

impl Choice {
    pub(crate) fn new(any: bool) -> Self {
        let costs = if any { ANY } else { CLOSEST };
        Self { costs, trial: None, sums: [0.0; 2], weight: 0.0, wait: Patience::new(TURNS) }
    }

    /// Returns whether bundles are the better choice, as far as is known.
    fn are_bundles_better(&self) -> bool {
        self.sums[0] <= self.sums[1]
    }

    /// Returns the mean cost of packets in trials.
    fn packets(&self) -> f32 {
        self.sums[1] / self.weight.max(1.0)
    }

    /// Returns whether the next rays are part of a trial, for which a few suffice.
    pub(super) fn is_trial(&self) -> bool {
        !self.wait.is_waiting()
    }

    /// Returns the maximum work for a bundle of several rays, or `None` if they are to be traced in
    /// packets.
    pub(super) fn limit(&self, rays: usize) -> Option<usize> {
        let cost = if self.is_trial() {
            // Packets come first: they set the limit for a bundle.
            LIMITS[0] * self.trial?
        } else {
            self.are_bundles_better().then_some(LIMITS[1] * self.packets())?
        };
        let limit = (cost - self.costs.ray) / WORK;
        Some((limit.max(1.0) * rays as f32) as usize)
    }

    /// Adds what a bundle took, and a mask of the packets that it left.
    pub(super) fn took_bundle(&mut self, work: usize, left: u64, rays: usize) {
        let share = |count: usize| count as f32 / rays as f32;
        let left = share((16 * left.count_ones() as usize).min(rays));
        let cost = self.costs.ray + WORK * share(work);
        let Some(packets) = self.trial.take() else {
            return self.took(cost + left * self.packets());
        };
        let before = self.are_bundles_better();
        self.sums = [0.5 * self.sums[0] + cost + left * packets, 0.5 * self.sums[1] + packets];
        self.weight = 0.5 * self.weight + 1.0;
        if self.are_bundles_better() != before {
            self.wait = Patience::new(TURNS);
        }
        self.wait.tried(false);
    }

    /// Adds the number of nodes and leaves that packets visited.
    pub(super) fn took_packets(&mut self, visits: usize, outcome: &Outcome, rays: usize) {
        let share = |count: usize| count as f32 / rays as f32;
        let left = if let Outcome::InPackets { left } = outcome { *left } else { u64::MAX };
        let alone = share((16 * left.count_ones() as usize).min(rays));
        let cost = self.costs.visit * share(visits) + self.costs.alone * alone;
        if self.is_trial() {
            self.trial = Some(cost);
        } else {
            self.took(cost);
        }
    }

    /// Ends a turn without a trial, in which rays had this cost.
    fn took(&mut self, cost: f32) {
        if cost > SURPRISE * self.sums[0].min(self.sums[1]) / self.weight.max(1.0) {
            self.wait = Patience::new(TURNS);
        } else {
            self.wait.pass();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Choice;
    use crate::walk::bundle::Outcome;

    /// Traces groups of rays whose bundles and packets take this much work per ray, and returns
    /// whether each group was a bundle, and how many rays were.
    fn trace(choice: &mut Choice, groups: usize, [work, visits]: [f32; 2]) -> (Vec<bool>, usize) {
        let (mut bundles, mut rays) = (Vec::new(), 0);
        for _ in 0..groups {
            let count = if choice.is_trial() { 256 } else { 1024 };
            let is_bundle = if let Some(limit) = choice.limit(count) {
                let all = (work * count as f32) as usize;
                let left = if all > limit { u64::MAX >> (64 - count / 16) } else { 0 };
                choice.took_bundle(all.min(limit), left, count);
                rays += if left == 0 { count } else { 0 };
                true
            } else {
                let visits = (visits * count as f32) as usize;
                choice.took_packets(visits, &Outcome::InPackets { left: 0 }, count);
                false
            };
            bundles.push(is_bundle);
        }
        (bundles, rays)
    }

    #[test]
    fn the_cheaper_way_is_chosen_and_changes_with_the_rays() {
        let mut choice = Choice::new(false);
        let (few, some) = ([0.5, 0.5], [9.0, 0.4]);
        let (bundles, _) = trace(&mut choice, 10, few);
        assert_eq!(bundles, [&[false], &[true; 9][..]].concat());
        // In a dense part, a bundle is given up, and a trial follows.
        let (bundles, rays) = trace(&mut choice, 64, some);
        assert!(bundles.iter().filter(|is_bundle| **is_bundle).count() < 10, "{bundles:?}");
        assert!(rays < 3 * 1024, "{rays}");
        let (bundles, _) = trace(&mut choice, 200, few);
        assert!(bundles[100..].iter().filter(|is_bundle| **is_bundle).count() > 90);
    }
}
