//! Counts the errors of every method on a workload.

use rayon::prelude::*;

use super::closed_mesh::leaks_and_doubles;
use super::closest::closest;
use super::error_counts::{ErrorCounts, ON_GRID};
use super::pairs::pairs;
use crate::methods::METHODS;
use crate::rng::Rng;
use crate::workloads::{Model, Workload};

/// The number of rays in one unit of work. Each unit generates its rays from its own seed.
const PIECE: u64 = 256;

/// Counts the errors of every method that supports the workload, over at least `rays` rays. Calls
/// `step` with the number of rays just completed. The counts depend only on the seed, the number of
/// rays, and the model.
pub fn count_errors(
    workload: Workload,
    model: &Model,
    seed: u64,
    rays: u64,
    step: &(impl Fn(u64) + Sync),
) -> Vec<ErrorCounts> {
    let pieces = rays.div_ceil(PIECE);
    let none = || {
        let names = METHODS.iter().map(|method| method.name).chain([ON_GRID]);
        let errors =
            |method| ErrorCounts { workload: workload.name(), method, ..ErrorCounts::default() };
        names.map(errors).collect::<Vec<_>>()
    };
    let mut error_counts = (0..pieces)
        .into_par_iter()
        .map(|piece| {
            let mut rng = Rng::new(seed ^ (workload as u64) << 56 ^ piece << 8);
            let mut error_counts = none();
            let mut done = 0;
            while done < PIECE {
                done += match workload {
                    Workload::Mix => pairs(&mut rng, &mut error_counts),
                    Workload::Edges => {
                        leaks_and_doubles(&workload.batch(&mut rng, model), &mut error_counts)
                    }
                    _ => closest(&workload.batch(&mut rng, model), &mut error_counts),
                };
            }
            step(done);
            error_counts
        })
        .reduce(none, |mut sum, more| {
            for (sum, more) in sum.iter_mut().zip(more) {
                sum.trials += more.trials;
                sum.wrong += more.wrong;
                sum.leaks += more.leaks;
                sum.doubles += more.doubles;
                sum.not_reference += more.not_reference;
            }
            sum
        });
    error_counts.retain(|errors| errors.trials > 0);
    error_counts
}
