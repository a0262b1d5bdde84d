//! Draws one panel of the chart, with all methods on one workload.

use super::axis::{Log, power};
use super::labels::{Area, PointLabel, place};
use super::marks::{colour_of, in_order, is_kernel, mark};
use super::svg::{Anchor, FAINT, Font, GREY, INK, Svg};
use crate::methods::Method;
use crate::tables::grouped;
use crate::workloads::Workload;

/// The x coordinate of the left end of a panel's axes.
const LEFT: f64 = 72.0;
/// The x coordinate of the right end of a panel's axes.
const RIGHT: f64 = 692.0;
/// The y coordinate of the top end of a panel's axes.
const TOP: f64 = 46.0;
/// The y coordinate at which the error axis breaks.
const BREAK: f64 = 350.0;
/// The space for the name of the fastest method, to the right of its mark.
const ROOM: f64 = 138.0;
/// The height of a row for a method without observed errors.
const ROW: f64 = 15.0;
/// The font size of names.
const SIZE: f64 = 11.5;

/// A method's results, shown as a mark in a panel.
pub(super) struct Point {
    pub(super) name: String,
    pub(super) faster: [f64; 3],
    /// The share of errors, or 0 if none were seen.
    pub(super) share: f64,
    /// The share of double counts, if they are counted.
    pub(super) doubles: Option<f64>,
    pub(super) trials: u64,
}

/// Returns the height of a panel in which `rows` methods without observed errors have separate
/// rows.
pub(super) fn height(rows: usize) -> f64 {
    bottom(rows) + 52.0
}

/// Returns the y coordinate of the bottom end of a panel's axes.
fn bottom(rows: usize) -> f64 {
    BREAK + ROW * rows as f64 + 24.0
}

/// Returns the number of methods without observed errors.
pub(super) fn rows(points: &[Point]) -> usize {
    points.iter().filter(|p| p.share == 0.0).count()
}

fn title(workload: Workload) -> (&'static str, &'static str) {
    match workload {
        Workload::Camera => ("Camera rays on a model", "rays with a wrong closest hit"),
        Workload::Secondary => {
            ("Secondary rays: one ray × many triangles", "rays with a wrong closest hit")
        }
        Workload::Edges => (
            "Rays exactly at shared edges and vertices",
            "rays that leak out of a closed mesh; dash: rays that hit two or more triangles",
        ),
        Workload::Mix => ("The adversarial mix", "pairs with a wrong hit or miss"),
    }
}

/// The positions and scales of a panel's axes.
struct Axes<'a> {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    /// The y coordinate below which the methods without observed errors are listed, one per row,
    /// with the fastest first.
    broken: f64,
    rows: Vec<&'a str>,
    x: Log,
    y: Log,
}

impl<'a> Axes<'a> {
    fn new([ox, oy]: [f64; 2], points: &'a [Point], rows: usize) -> Self {
        let (left, right, top) = (ox + LEFT, ox + RIGHT, oy + TOP);
        let bottom = oy + bottom(rows);
        let broken = oy + BREAK;
        let fastest = points.iter().fold(10.0, |far: f64, p| far.max(p.faster[2]));
        let slowest = points.iter().fold(0.85, |far: f64, p| far.min(0.9 * p.faster[0]));
        let x = Log::new(slowest, fastest, [left, right - ROOM]);
        let seen = points.iter().flat_map(|p| [p.share, p.doubles.unwrap_or(0.0)]);
        let least = seen.filter(|&share| share > 0.0).fold(0.1, f64::min);
        let y = Log::new(1.0, 10_f64.powf(least.log10().floor()), [top, broken - 14.0]);
        let mut none: Vec<&Point> = points.iter().filter(|p| p.share == 0.0).collect();
        none.sort_by(|a, b| b.faster[1].total_cmp(&a.faster[1]));
        let rows = none.into_iter().map(|p| p.name.as_str()).collect();
        Self { left, right, top, bottom, broken, rows, x, y }
    }

    /// Returns the position of a method's mark.
    fn at(&self, p: &Point) -> [f64; 2] {
        let row = self.rows.iter().position(|&name| name == p.name);
        let of_row = |row: usize| self.broken + ROW * (row as f64 + 0.8);
        [self.x.at(p.faster[1]), row.map_or_else(|| self.y.at(p.share), of_row)]
    }
}

/// Draws a panel with its upper left corner at the given point and with space for `rows` rows.
pub(super) fn panel(
    svg: &mut Svg,
    [ox, oy]: [f64; 2],
    workload: Workload,
    points: &[Point],
    rows: usize,
    front: &[&str],
) {
    if points.is_empty() {
        return;
    }
    let axes = Axes::new([ox, oy], points, rows);
    let (heading, what) = title(workload);
    svg.text([axes.left, oy + 22.0], heading, Font::new(15.0, Anchor::Start).bold());
    svg.text([axes.left, oy + 38.0], &format!("share of {what}"), Font::new(12.0, Anchor::Start));

    grid(svg, &axes);
    broken_axis(svg, &axes, points.iter().map(|p| p.trials).max().unwrap_or(1));
    not_timed(svg, &axes, points);
    let on_front = |p: &Point| front.iter().any(|name| name.trim_end_matches(" f32") == p.name);
    let steps = staircase(&axes, points.iter().filter(|p| on_front(p)).collect());
    svg.path(&steps, "#E69F00", 4.0, "");
    marks(svg, &axes, points);
    let is_bold = |p: &Point| on_front(p) || is_kernel(&p.name);
    labels(svg, &axes, points, is_bold, &steps);
    names_of_rows(svg, &axes, points, is_bold);
}

/// Draws the ticks and the grid lines.
fn grid(svg: &mut Svg, axes: &Axes<'_>) {
    let &Axes { left, right, top, bottom, x, y, .. } = axes;
    for tick in [1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0] {
        if x.at(tick) < right - 8.0 {
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
    let faster = "times faster than the scalar f64 reference, each method at its best width";
    svg.text([f64::midpoint(left, right), bottom + 31.0], faster, Font::new(12.0, Anchor::Middle));
    svg.line([x.at(1.0), top], [x.at(1.0), bottom], INK, 1.2);
}

/// Draws the error axis with its break. Methods without observed errors go below the break.
fn broken_axis(svg: &mut Svg, axes: &Axes<'_>, trials: u64) {
    let &Axes { left, right, top, bottom, broken, .. } = axes;
    svg.rect([left, broken], [right - left, bottom - broken], "#f4f4f4");
    svg.line([left, top], [left, broken - 7.0], INK, 1.2);
    svg.line([left, broken], [left, bottom], INK, 1.2);
    for at in [broken - 7.0, broken] {
        svg.line([left - 5.0, at + 3.0], [left + 5.0, at - 3.0], INK, 1.2);
    }
    svg.line([left, bottom], [right, bottom], INK, 1.2);
    let none = f64::midpoint(broken, bottom);
    svg.text([left - 6.0, none - 2.0], "none in", Font::new(11.0, Anchor::End));
    svg.text([left - 6.0, none + 12.0], &short(trials), Font::new(11.0, Anchor::End));
    let bound = format!("none in {} (< {:.0e} at 95 %)", grouped(trials), 3.0 / trials as f64);
    svg.text([right - 4.0, bottom - 6.0], &bound, Font::new(10.0, Anchor::End).fill(GREY));
}

/// Lists the methods that are not in the panel.
fn not_timed(svg: &mut Svg, axes: &Axes<'_>, points: &[Point]) {
    let is_there = |method: &&Method| points.iter().any(|p| label_of(&p.name) == method.name);
    let absent = in_order().into_iter().filter(|method| !is_there(method));
    let absent: Vec<_> = absent.map(|method| method.name).collect();
    if !absent.is_empty() {
        let text = format!("not timed here: {}", absent.join("; "));
        let at = [axes.left + 8.0, axes.bottom - 6.0];
        svg.text(at, &text, Font::new(10.0, Anchor::Start).fill(GREY));
    }
}

/// Returns the Pareto front as steps, from the fastest method downward.
fn staircase(axes: &Axes<'_>, mut front: Vec<&Point>) -> Vec<[f64; 2]> {
    front.sort_by(|a, b| b.faster[1].total_cmp(&a.faster[1]));
    let mut steps: Vec<[f64; 2]> = Vec::new();
    for p in front {
        let [px, py] = axes.at(p);
        if let Some(&[_, last]) = steps.last() {
            steps.push([px, last]);
        }
        steps.push([px, py]);
    }
    if let (Some(&[first, _]), Some(&[_, last])) = (steps.first(), steps.last()) {
        steps.insert(0, [first, axes.top]);
        steps.push([axes.left, last]);
    }
    steps
}

/// Draws the methods: their spread, their double counts, and their marks.
fn marks(svg: &mut Svg, axes: &Axes<'_>, points: &[Point]) {
    for p in points {
        let [px, py] = axes.at(p);
        svg.line([axes.x.at(p.faster[0]), py], [axes.x.at(p.faster[2]), py], GREY, 1.0);
        if let Some(doubles) = p.doubles.filter(|&share| share > 0.0) {
            let up = axes.y.at(doubles);
            svg.path(&[[px, py], [px, up]], "#999999", 0.7, "2 2");
            svg.line([px - 3.0, up], [px + 3.0, up], GREY, 1.6);
        }
    }
    for p in points {
        mark(svg, &label_of(&p.name), axes.at(p), 4.3, p.share == 0.0);
    }
}

/// Draws the names of the methods with errors, clear of the marks and the Pareto front.
fn labels(
    svg: &mut Svg,
    axes: &Axes<'_>,
    points: &[Point],
    is_bold: impl Fn(&Point) -> bool,
    front: &[[f64; 2]],
) {
    let &Axes { left, right, top, broken, x, y, .. } = axes;
    let wanted: Vec<_> = points
        .iter()
        .filter(|p| p.share > 0.0)
        .map(|p| PointLabel { text: p.name.clone(), at: axes.at(p), bold: is_bold(p) })
        .collect();
    let bounds = Area { lo: [left + 4.0, top - 2.0], hi: [right + 2.0, broken - 4.0] };
    let mut obstacles: Vec<_> = wanted.iter().map(|label| label.at).collect();
    obstacles.extend(points.iter().filter_map(|p| Some([x.at(p.faster[1]), y.at(p.doubles?)])));
    for pair in front.windows(2) {
        let along =
            |k: i32| [0, 1].map(|c| pair[0][c] + (pair[1][c] - pair[0][c]) * f64::from(k) / 64.0);
        obstacles.extend((0..=64).map(along));
    }
    for (label, placed) in wanted.iter().zip(place(&wanted, SIZE, bounds, &obstacles)) {
        if let Some(end) = placed.leader {
            svg.line(label.at, end, "#888888", 0.6);
        }
        let font = Font { bold: label.bold, ..Font::new(SIZE, Anchor::Start) }.halo();
        svg.text(placed.left, &label.text, font.fill(colour_of(&label_of(&label.text))));
    }
}

/// Draws the names of the methods without errors, each in its row, to the right of its spread.
/// Lower rows are slower, so lines drawn upward from them pass to the left of the names.
fn names_of_rows(
    svg: &mut Svg,
    axes: &Axes<'_>,
    points: &[Point],
    is_bold: impl Fn(&Point) -> bool,
) {
    for p in points.iter().filter(|p| p.share == 0.0) {
        let [px, py] = axes.at(p);
        let left = (px + 10.0).max(axes.x.at(p.faster[2]) + 5.0);
        let font = Font { bold: is_bold(p), ..Font::new(SIZE, Anchor::Start) };
        svg.text([left, py + 4.0], &p.name, font.fill(colour_of(&label_of(&p.name))));
    }
}

/// Converts a label to the method's name in the table.
fn label_of(text: &str) -> String {
    if is_kernel(text) || text.ends_with("f64") { text.to_owned() } else { format!("{text} f32") }
}

/// Returns a short label for a count.
fn short(n: u64) -> String {
    match n {
        0..10_000 => grouped(n),
        10_000..1_000_000 => format!("{} thousand", n / 1000),
        _ => format!("{:.1} million", n as f64 * 1e-6),
    }
}
