//! Plots speed against accuracy, with one panel per workload.

use super::marks::mark;
use super::panel::{self, Point, panel};
use super::svg::{Anchor, Font, GREY, Svg, width};
use crate::accuracy::ErrorCounts;
use crate::pareto::{Baseline, fastest, pareto_front};
use crate::timing::Time;
use crate::workloads::Workload;

/// The width of a panel.
const WIDTH: f64 = 704.0;
/// The y coordinate of the top of the upper panels.
const TOP: f64 = 66.0;

/// Draws four panels, which show how much faster than the scalar f64 reference each method is at
/// its best lane count, and how often it is wrong. Every method without observed errors has its own
/// row. `caption` is printed below.
pub fn chart(times: &[Time], error_counts: &[ErrorCounts], caption: &str) -> Svg {
    let points = Workload::ALL.map(|workload| points(workload, times, error_counts));
    // Adjacent panels have the same height.
    let rows = [0, 2].map(|k| panel::rows(&points[k]).max(panel::rows(&points[k + 1])));
    let tops = [TOP, TOP + panel::height(rows[0])];
    let bottom = tops[1] + panel::height(rows[1]);
    let mut svg = Svg::new(2.0 * WIDTH + 24.0, bottom + 52.0);
    let title = Font::new(21.0, Anchor::Start).bold();
    svg.text([20.0, 32.0], "Speed against accuracy of ray/triangle tests", title);
    legend(&mut svg, [20.0, 54.0]);
    for (k, workload) in Workload::ALL.into_iter().enumerate() {
        let at = [12.0 + WIDTH * (k % 2) as f64, tops[k / 2]];
        let front = pareto_front(workload, Baseline::Oracle, error_counts, times);
        panel(&mut svg, at, workload, &points[k], rows[k / 2], &front);
    }
    let font = Font::new(11.0, Anchor::Start).fill(GREY);
    for (k, line) in caption.lines().enumerate() {
        svg.text([20.0, bottom + 18.0 + 15.0 * k as f64], line, font);
    }
    svg
}

fn legend(svg: &mut Svg, [x, y]: [f64; 2]) {
    let font = Font::new(12.5, Anchor::Start);
    let mut at = x;
    for (method, text) in [
        ("published f32", "published methods in f32"),
        ("published f64", "in f64"),
        ("certified", "the modes of the kernel"),
    ] {
        mark(svg, method, [at + 6.0, y - 4.0], 4.5, false);
        svg.text([at + 17.0, y], text, font);
        at += 40.0 + width(text, 12.5);
    }
    svg.path(&[[at, y - 4.0], [at + 26.0, y - 4.0]], "#E69F00", 4.0, "");
    let front = "Pareto front: nothing is both faster and more often right";
    svg.text([at + 33.0, y], front, font);
    at += 60.0 + width(front, 12.5);
    mark(svg, "published f32", [at, y - 4.0], 4.5, true);
    svg.text([at + 11.0, y], "hollow: none seen", font);
}

fn points(workload: Workload, times: &[Time], error_counts: &[ErrorCounts]) -> Vec<Point> {
    let of = |errors: &ErrorCounts| {
        let time = fastest(errors, times)?;
        let share = |n: u64| n as f64 / errors.trials.max(1) as f64;
        Some(Point {
            name: errors.method.trim_end_matches(" f32").to_owned(),
            faster: [time.times_faster_p25, time.times_faster, time.times_faster_p75],
            share: share(Baseline::Oracle.wrong(errors)),
            doubles: (workload == Workload::Edges).then(|| share(errors.doubles)),
            trials: errors.trials,
        })
    };
    error_counts.iter().filter(|errors| errors.workload == workload.name()).filter_map(of).collect()
}
