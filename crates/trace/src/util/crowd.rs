//! Estimates where most points are, so that a few far points do not matter.

/// The number of points in the sample.
const SAMPLE: usize = 1000;

/// Estimates, from a sample, the box that contains most points.
pub(crate) fn crowd(points: impl ExactSizeIterator<Item = [f64; 3]>) -> [[f64; 3]; 2] {
    let step = points.len().div_ceil(SAMPLE).max(1);
    let some = points.step_by(step);
    let some: Vec<[f64; 3]> = some.filter(|corner| corner.iter().all(|x| x.is_finite())).collect();
    let mut crowd = [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]];
    for k in 0..3 {
        let mut along: Vec<f64> = some.iter().map(|corner| corner[k]).collect();
        along.sort_unstable_by(f64::total_cmp);
        // Ignore a tenth of the points at each end of the axis.
        if let Some(last) = along.len().checked_sub(1) {
            crowd[0][k] = along[last / 10];
            crowd[1][k] = along[last - last / 10];
        }
    }
    crowd
}
