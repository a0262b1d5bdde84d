//! Speed against accuracy: a panel a workload.

use super::axis::{Log, power};
use super::labels::{Area, Wanted, place};
use super::svg::{Anchor, FAINT, Font, GREY, INK, Svg};
use super::{is_kernel, mark};
use crate::front::{Judge, fastest, front};
use crate::judge::Verdict;
use crate::tables::grouped;
use crate::timing::Time;
use crate::workloads::Workload;

const PANEL: [f64; 2] = [700.0, 470.0];
/// Within a panel: where the axes cross, where they end, and where the axis of errors breaks.
const LEFT: f64 = 72.0;
const RIGHT: f64 = 688.0;
const TOP: f64 = 46.0;
const BREAK: f64 = 318.0;
const BOTTOM: f64 = 425.0;

/// A method in a panel.
struct Point {
    name: String,
    faster: [f64; 3],
    /// The share of errors; 0 where none were seen.
    share: f64,
    /// The share of double counts, where they are counted.
    doubles: Option<f64>,
    trials: u64,
}

/// Four panels of all methods, each as wide as it is fastest: how many times faster than the scalar
/// f64 reference, and how often wrong. `caption` stands below.
pub fn chart(times: &[Time], verdicts: &[Verdict], caption: &str) -> Svg {
    let [w, h] = PANEL;
    let mut svg = Svg::new(2.0 * w + 24.0, 2.0 * h + 118.0);
    let title = Font::new(21.0, Anchor::Start).bold();
    svg.text([20.0, 32.0], "Speed against accuracy of ray/triangle tests", title);
    legend(&mut svg, [20.0, 54.0]);
    for (k, workload) in Workload::ALL.into_iter().enumerate() {
        let at = [12.0 + w * (k % 2) as f64, 66.0 + h * (k / 2) as f64];
        let front = front(workload, Judge::Truth, verdicts, times);
        panel(&mut svg, at, workload, &points(workload, times, verdicts), &front);
    }
    let font = Font::new(11.0, Anchor::Start).fill(GREY);
    for (k, line) in caption.lines().enumerate() {
        svg.text([20.0, 66.0 + 2.0 * h + 18.0 + 15.0 * k as f64], line, font);
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
        at += 40.0 + super::svg::width(text, 12.5);
    }
    svg.path(&[[at, y - 4.0], [at + 26.0, y - 4.0]], "#E69F00", 4.0, "");
    let front = "Pareto front: nothing is both faster and more often right";
    svg.text([at + 33.0, y], front, font);
    at += 60.0 + super::svg::width(front, 12.5);
    mark(svg, "published f32", [at, y - 4.0], 4.5, true);
    svg.text([at + 11.0, y], "hollow: none seen", font);
}

fn title(workload: Workload) -> (&'static str, &'static str) {
    match workload {
        Workload::Camera => ("Camera rays on a model", "rays with a wrong closest hit"),
        Workload::Secondary => {
            ("Secondary rays: one ray × many triangles", "rays with a wrong closest hit")
        }
        Workload::Edges => (
            "Rays exactly at shared edges and vertices",
            "rays that leak out of a closed mesh; the dash above: that hit two or more triangles",
        ),
        Workload::Mix => ("The adversarial mix", "pairs with hit or miss wrong"),
    }
}

fn points(workload: Workload, times: &[Time], verdicts: &[Verdict]) -> Vec<Point> {
    let of = |verdict: &Verdict| {
        let time = fastest(verdict, times)?;
        let share = |n: u64| n as f64 / verdict.trials.max(1) as f64;
        Some(Point {
            name: verdict.method.trim_end_matches(" f32").to_owned(),
            faster: [time.times_faster_p25, time.times_faster, time.times_faster_p75],
            share: share(Judge::Truth.errors(verdict)),
            doubles: (workload == Workload::Edges).then(|| share(verdict.doubles)),
            trials: verdict.trials,
        })
    };
    verdicts.iter().filter(|verdict| verdict.workload == workload.name()).filter_map(of).collect()
}

fn panel(svg: &mut Svg, [ox, oy]: [f64; 2], workload: Workload, points: &[Point], front: &[&str]) {
    if points.is_empty() {
        return;
    }
    let (left, right, top, bottom) = (ox + LEFT, ox + RIGHT, oy + TOP, oy + BOTTOM);
    let broken = oy + BREAK;
    let (heading, what) = title(workload);
    svg.text([left, oy + 22.0], heading, Font::new(15.0, Anchor::Start).bold());
    svg.text([left, oy + 38.0], &format!("share of {what}"), Font::new(12.0, Anchor::Start));

    // The axes.
    let fastest = points.iter().fold(10.0, |far: f64, p| far.max(p.faster[2]));
    let slowest = points.iter().fold(0.85, |far: f64, p| far.min(0.9 * p.faster[0]));
    let x = Log::new(slowest, 1.25 * fastest, [left, right]);
    let seen = points.iter().flat_map(|p| [p.share, p.doubles.unwrap_or(0.0)]);
    let least = seen.filter(|&share| share > 0.0).fold(0.1, f64::min);
    let y = Log::new(1.0, 10_f64.powf(least.log10().floor()), [top, broken - 14.0]);
    for tick in [1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0] {
        if tick < 1.25 * fastest {
            svg.line([x.at(tick), top], [x.at(tick), bottom], FAINT, 0.7);
            let text = if tick == 1.0 { "1×".to_owned() } else { tick.to_string() };
            svg.text([x.at(tick), bottom + 15.0], &text, Font::new(11.0, Anchor::Middle));
        }
    }
    for k in y.decades(1) {
        let at = y.at(10_f64.powi(k));
        svg.line([left, at], [right, at], FAINT, 0.7);
        svg.text([left - 6.0, at + 4.0], &power(k), Font::new(11.0, Anchor::End));
    }
    let faster = "times faster than the scalar f64 reference, each method as wide as suits it";
    svg.text([f64::midpoint(left, right), bottom + 31.0], faster, Font::new(12.0, Anchor::Middle));
    svg.line([x.at(1.0), top], [x.at(1.0), bottom], INK, 1.2);

    // The break: below it nothing was seen.
    svg.rect([left, broken], [right - left, bottom - broken], "#f4f4f4");
    svg.line([left, top], [left, broken - 7.0], INK, 1.2);
    svg.line([left, broken], [left, bottom], INK, 1.2);
    for at in [broken - 7.0, broken] {
        svg.line([left - 5.0, at + 3.0], [left + 5.0, at - 3.0], INK, 1.2);
    }
    svg.line([left, bottom], [right, bottom], INK, 1.2);
    let trials = points.iter().map(|p| p.trials).max().unwrap_or(1);
    let none = f64::midpoint(broken, bottom);
    svg.text([left - 6.0, none - 2.0], "none in", Font::new(11.0, Anchor::End));
    svg.text([left - 6.0, none + 12.0], &short(trials), Font::new(11.0, Anchor::End));
    let bound = format!("none in {} (< {:.0e} at 95 %)", grouped(trials), 3.0 / trials as f64);
    svg.text([right - 4.0, bottom - 6.0], &bound, Font::new(10.0, Anchor::End).fill(GREY));

    // The Pareto front, down from the fastest.
    let height = |share: f64| if share > 0.0 { y.at(share) } else { broken + 44.0 };
    let at = |p: &Point| [x.at(p.faster[1]), height(p.share)];
    let on_front = |p: &&Point| front.iter().any(|name| name.trim_end_matches(" f32") == p.name);
    let mut order: Vec<&Point> = points.iter().filter(on_front).collect();
    order.sort_by(|a, b| b.faster[1].total_cmp(&a.faster[1]));
    let mut steps: Vec<[f64; 2]> = Vec::new();
    for p in &order {
        let [px, py] = at(p);
        if let Some(&[_, last]) = steps.last() {
            steps.push([px, last]);
        }
        steps.push([px, py]);
    }
    if let (Some(&[first, _]), Some(&[_, last])) = (steps.first(), steps.last()) {
        steps.insert(0, [first, top]);
        steps.push([left, last]);
    }
    svg.path(&steps, "#E69F00", 4.0, "");

    // The points: their spread, their double counts, themselves.
    for p in points {
        let [px, py] = at(p);
        svg.line([x.at(p.faster[0]), py], [x.at(p.faster[2]), py], GREY, 1.0);
        if let Some(doubles) = p.doubles.filter(|&share| share > 0.0) {
            let up = y.at(doubles);
            svg.path(&[[px, py], [px, up]], "#999999", 0.7, "2 2");
            svg.line([px - 3.0, up], [px + 3.0, up], GREY, 1.6);
        }
    }
    for p in points {
        mark(svg, &p.name, at(p), 4.3, p.share == 0.0);
    }
    // The labels.
    let wanted: Vec<_> = points
        .iter()
        .map(|p| {
            let bold = on_front(&p) || is_kernel(&p.name);
            Wanted { text: p.name.clone(), at: at(p), bold }
        })
        .collect();
    let bounds = Area { lo: [left + 4.0, top - 2.0], hi: [right + 2.0, bottom - 2.0] };
    let mut obstacles: Vec<_> = wanted.iter().map(|label| label.at).collect();
    obstacles.extend(points.iter().filter_map(|p| Some([x.at(p.faster[1]), y.at(p.doubles?)])));
    for pair in steps.windows(2) {
        let along =
            |k: i32| [0, 1].map(|c| pair[0][c] + (pair[1][c] - pair[0][c]) * f64::from(k) / 64.0);
        obstacles.extend((0..=64).map(along));
    }
    for (label, placed) in wanted.iter().zip(place(&wanted, 11.0, bounds, &obstacles)) {
        if let Some(end) = placed.leader {
            svg.line(label.at, end, "#888888", 0.6);
        }
        let font = Font { bold: label.bold, ..Font::new(11.0, Anchor::Start) };
        svg.text(placed.left, &label.text, font.fill(super::colour_of(&label_of(&label.text))));
    }
}

/// The name of a method in the table, from that on its label.
fn label_of(text: &str) -> String {
    if is_kernel(text) || text.ends_with("f64") { text.to_owned() } else { format!("{text} f32") }
}

/// A count in few characters.
fn short(n: u64) -> String {
    match n {
        0..10_000 => grouped(n),
        10_000..1_000_000 => format!("{} thousand", n / 1000),
        _ => format!("{:.1} million", n as f64 * 1e-6),
    }
}
