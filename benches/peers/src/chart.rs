//! The charts: speed against wrong answers, bars for each scene and kind of ray, and speed against the number
//! of triangles.

use std::collections::BTreeSet;

use intertri_lab::draw::{Anchor, Font, Log, Svg, power};

use crate::measure::Row;
use crate::report::grouped;

const INK: &str = "#222222";
const GREY: &str = "#666666";
const FAINT: &str = "#dddddd";

/// The groups in the charts: a prefix of engine names, of which the fastest is drawn, a label, and a colour
/// from the palette of M. Okabe and K. Ito, which colour-blind people can tell apart.
const GROUPS: [(&str, &str, &str); 9] = [
    ("certified", "certified", "#D55E00"),
    ("exact", "exact", "#E69F00"),
    ("fixed", "fixed", "#F0E442"),
    ("embree-fast", "Embree, fast", "#0072B2"),
    ("embree-robust", "Embree, robust", "#56B4E9"),
    ("tinybvh", "tinybvh", "#222222"),
    ("obvhs", "obvhs", "#009E73"),
    ("parry", "parry3d", "#999999"),
    ("bvh", "bvh", "#CC79A7"),
];

/// The row that stands for a group in a cell.
fn fastest<'a>(rows: &[&'a Row], group: &str) -> Option<&'a Row> {
    let of = |row: &&&Row| match row.engine.strip_prefix(group) {
        // Our single calls and lower instruction sets are not the group's fastest form.
        Some(rest) => group != "certified" || rest.is_empty(),
        // A better build still counts as the fast mode.
        None => group == "embree-fast" && row.engine.starts_with("embree-high"),
    };
    rows.iter().filter(of).max_by(|a, b| a.speed[1].total_cmp(&b.speed[1])).copied()
}

/// The distinct values, in order of appearance.
fn distinct<'a, T: PartialEq>(
    rows: impl IntoIterator<Item = &'a Row>,
    key: impl Fn(&'a Row) -> T,
) -> Vec<T> {
    let mut keys = Vec::new();
    for row in rows {
        let key = key(row);
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys
}

/// The position of a group in a panel.
struct Point {
    name: &'static str,
    fill: &'static str,
    /// The geometric mean over the scenes of the speed as a multiple of Embree's.
    speed: f64,
    /// The share of rays with a wrong answer, over all scenes.
    wrong: f64,
}

/// The point of each group, ordered by the share of wrong answers, largest first, then by speed.
fn points(rows: &[&Row]) -> Vec<Point> {
    let scenes = distinct(rows.iter().copied(), |row| row.scene.as_str());
    let point = |(group, name, fill): (&'static str, &'static str, &'static str)| {
        let (mut logs, mut wrong, mut rays) = (Vec::new(), 0, 0);
        for scene in &scenes {
            let cell: Vec<&Row> = rows.iter().filter(|row| row.scene == *scene).copied().collect();
            let (row, base) = (fastest(&cell, group)?, fastest(&cell, "embree-fast")?);
            logs.push((row.speed[1] / base.speed[1]).ln());
            // Neighbours share the point that these rays aim at, so either triangle is right.
            let shared = matches!(row.kind.as_str(), "edges" | "vertices");
            wrong += row.wrong_hits + if shared { 0 } else { row.wrong_triangles };
            rays += row.rays;
        }
        let speed = (logs.iter().sum::<f64>() / logs.len() as f64).exp();
        Some(Point { name, fill, speed, wrong: wrong as f64 / rays.max(1) as f64 })
    };
    // `fixed` answers for another scene, on its grid, and `certified` as the document does.
    let geometry = GROUPS.into_iter().filter(|(group, ..)| !["fixed", "certified"].contains(group));
    let single = ("exact-query", "exact, a ray a call", "#E69F00");
    let mut points: Vec<Point> = geometry.chain([single]).filter_map(point).collect();
    points.sort_by(|a, b| b.wrong.total_cmp(&a.wrong).then(b.speed.total_cmp(&a.speed)));
    points
}

/// Speed against wrong answers: one panel for each kind and order of rays, one point for each tracer.
pub fn scatter(rows: &[Row], caption: &str) -> Svg {
    const ACROSS: usize = 3;
    const PANEL: [f64; 2] = [400.0, 430.0];
    let kinds = distinct(rows, |row| (row.kind.as_str(), row.order.as_str()));
    let across = kinds.len().min(ACROSS);
    let size =
        [40.0 + PANEL[0] * across as f64, 76.0 + PANEL[1] * kinds.len().div_ceil(ACROSS) as f64];
    let mut svg = Svg::new(size[0], size[1]);
    let title = "How fast, and what share of rays is answered wrongly: whole scenes";
    svg.text([24.0, 30.0], title, Font::new(18.0, Anchor::Start).bold());
    svg.text([24.0, 50.0], caption, Font::new(11.0, Anchor::Start).fill(GREY));
    for (i, (kind, order)) in kinds.into_iter().enumerate() {
        let cell: Vec<&Row> =
            rows.iter().filter(|row| row.kind == kind && row.order == order).collect();
        let at = [24.0 + PANEL[0] * (i % ACROSS) as f64, 62.0 + PANEL[1] * (i / ACROSS) as f64];
        let name = match kind {
            "primary" => "Camera rays",
            "shadow" => "Shadow rays to a light",
            "light" => "Shadow rays from a light",
            "diffuse" => "Diffuse rays",
            "surface" => "Diffuse rays from rounded points",
            "edges" => "Camera rays aimed at edges",
            "vertices" => "Camera rays aimed at vertices",
            other => other,
        };
        scatter_panel(&mut svg, at, PANEL, &format!("{name}, in {order}"), &points(&cell));
    }
    svg
}

/// A panel of [`scatter`]. Tracers that were never wrong are listed below its axis, one under the other.
fn scatter_panel(svg: &mut Svg, [x, y]: [f64; 2], [w, h]: [f64; 2], name: &str, points: &[Point]) {
    // Leave enough height for all of them.
    const NEVER: f64 = 13.0 * GROUPS.len() as f64;
    let (left, right, top, bottom) = (x + 44.0, x + w - 24.0, y + 34.0, y + h - 46.0);
    let border = bottom - NEVER;
    svg.text([left, y + 22.0], name, Font::new(13.0, Anchor::Start).bold());
    let (along, up) = (Log::new(0.03, 3.0, [left, right]), Log::new(3e-7, 1.0, [border, top]));
    svg.rect([left, border], [right - left, NEVER], "#f3f3f3");
    for e in up.decades(1) {
        let at = up.at(10_f64.powi(e));
        svg.line([left, at], [right, at], FAINT, 0.7);
        svg.text([left - 6.0, at + 4.0], &power(e), Font::new(10.0, Anchor::End));
    }
    for tick in [0.05, 0.1, 0.2, 0.5, 1.0, 2.0] {
        let (at, stroke) = (along.at(tick), if tick == 1.0 { INK } else { FAINT });
        svg.line([at, top], [at, bottom], stroke, 0.7);
        svg.text([at, bottom + 15.0], &tick.to_string(), Font::new(10.0, Anchor::Middle));
    }
    svg.text([left - 6.0, border + 16.0], "never", Font::new(10.0, Anchor::End));
    let (middle, axis) = (f64::midpoint(left, right), "times as fast as Embree's fast mode");
    svg.text([middle, bottom + 32.0], axis, Font::new(11.0, Anchor::Middle));

    let (mut row, mut label, mut circles) = (border + 13.0, top, Vec::new());
    for point in points {
        let at = along.at(point.speed.clamp(0.03, 3.0));
        let height = if point.wrong == 0.0 { row } else { up.at(point.wrong.max(3e-7)) };
        if point.wrong == 0.0 {
            (label, row) = (row, row + 13.0);
        } else {
            label = height.max(label + 12.5);
        }
        // The label goes on the side with more space, below the labels above it.
        let crowded = (0.3..0.8).contains(&point.speed);
        let (side, anchor) = if crowded { (-12.0, Anchor::End) } else { (12.0, Anchor::Start) };
        svg.line([at, height], [at + side, label], point.fill, 0.8);
        circles.push(([at, height], point));
        let font = Font::new(10.5, anchor).halo();
        let font = if point.name.starts_with("exact") { font.bold() } else { font };
        svg.text([at + 1.2 * side, label + 4.0], point.name, font);
    }
    // Draw points last, so that no label hides one.
    for (at, point) in circles {
        let hollow = if point.wrong == 0.0 { "white" } else { point.fill };
        svg.circle(at, 4.2, hollow, point.fill);
    }
    svg.line([left, top], [left, bottom], INK, 1.2);
    svg.line([left, bottom], [right, bottom], INK, 1.2);
}

/// Bars: one row of panels for each scene, one panel for each kind of ray.
pub fn bars(rows: &[Row], caption: &str) -> Svg {
    const PANEL: [f64; 2] = [330.0, 175.0];
    let scenes = distinct(rows, |row| (row.scene.as_str(), row.triangles));
    let kinds = distinct(rows, |row| row.kind.as_str());
    let [w, h] = PANEL;
    let (left, top) = (24.0, 60.0);
    let height = top + h * scenes.len() as f64 + 30.0;
    let mut svg = Svg::new(left + w * kinds.len() as f64 + 20.0, height);
    let title = "Million rays a second, and of a million rays those answered wrongly";
    svg.text([left, 30.0], title, Font::new(18.0, Anchor::Start).bold());
    svg.text([left, 50.0], caption, Font::new(11.0, Anchor::Start).fill(GREY));
    for (i, (scene, triangles)) in scenes.iter().enumerate() {
        for (j, kind) in kinds.iter().enumerate() {
            let cell: Vec<&Row> =
                rows.iter().filter(|row| row.scene == *scene && row.kind == *kind).collect();
            let at = [left + w * j as f64, top + h * i as f64];
            panel(&mut svg, at, [w - 20.0, h], &format!("{scene}, {kind}"), *triangles, &cell);
        }
    }
    svg
}

fn panel(
    svg: &mut Svg,
    [x, y]: [f64; 2],
    [w, _]: [f64; 2],
    name: &str,
    triangles: usize,
    cell: &[&Row],
) {
    const NAMES: f64 = 92.0;
    const ROW: f64 = 17.0;
    svg.text([x, y + 18.0], name, Font::new(13.0, Anchor::Start).bold());
    let count = format!("{} triangles", grouped(triangles));
    svg.text([x + w, y + 18.0], &count, Font::new(10.0, Anchor::End).fill(GREY));
    let drawn =
        GROUPS.iter().filter_map(|&(group, name, fill)| Some((fastest(cell, group)?, name, fill)));
    let drawn: Vec<_> = drawn.collect();
    let most = drawn.iter().fold(0.0, |most: f64, (row, ..)| most.max(row.speed[2]));
    let scale = (w - NAMES - 100.0) / most.max(1e-9);
    for (i, (row, name, fill)) in drawn.iter().enumerate() {
        let top = y + 26.0 + ROW * i as f64;
        let [low, middle, high] = row.speed.map(|speed| x + NAMES + speed * scale);
        svg.text([x + NAMES - 6.0, top + 11.0], name, Font::new(11.0, Anchor::End));
        svg.rect([x + NAMES, top], [middle - x - NAMES, ROW - 4.0], fill);
        let center = top + (ROW - 4.0) / 2.0;
        svg.line([low, center], [high, center], INK, 1.0);
        let wrong = row.wrong_hits + row.wrong_triangles;
        // Answers on a grid are for another scene.
        let how = if row.engine == "fixed" { "by the grid" } else { "wrong" };
        let wrong = match wrong as f64 * 1e6 / row.rays.max(1) as f64 {
            0.0 => format!("none {how}"),
            share if share < 1.0 => format!("1 {how}"),
            share => format!("{} {how}", grouped(share.round() as usize)),
        };
        let text = format!("{:.1}", row.speed[1]);
        svg.text([high + 5.0, top + 11.0], &text, Font::new(11.0, Anchor::Start).bold());
        let after = high + 12.0 + 6.6 * text.len() as f64;
        svg.text([after, top + 11.0], &wrong, Font::new(10.0, Anchor::Start).fill(GREY));
    }
}

/// Speed against triangles, both axes logarithmic: one panel for each kind.
pub fn growth(rows: &[Row], caption: &str) -> Svg {
    let kinds = distinct(rows, |row| row.kind.as_str());
    let (w, h) = (430.0, 380.0);
    let mut svg = Svg::new(24.0 + w * kinds.len() as f64, h + 74.0);
    let title = "Million rays a second against triangles: a sphere with bumps, ever finer";
    svg.text([24.0, 30.0], title, Font::new(18.0, Anchor::Start).bold());
    svg.text([24.0, 50.0], caption, Font::new(11.0, Anchor::Start).fill(GREY));
    let counts: BTreeSet<usize> = rows.iter().map(|row| row.triangles).collect();
    let (Some(&few), Some(&many)) = (counts.first(), counts.last()) else { return svg };
    for (k, kind) in kinds.iter().enumerate() {
        let (left, right) = (24.0 + w * k as f64 + 44.0, 24.0 + w * (k + 1) as f64 - 24.0);
        let (top, bottom) = (86.0, h + 26.0);
        let x = Log::new(few as f64 * 0.8, many as f64 * 1.25, [left, right]);
        let y = Log::new(1.0, 500.0, [bottom, top]);
        svg.text([left, 76.0], kind, Font::new(14.0, Anchor::Start).bold());
        for e in x.decades(1) {
            let at = x.at(10_f64.powi(e));
            svg.line([at, top], [at, bottom], FAINT, 0.7);
            svg.text([at, bottom + 15.0], &power(e), Font::new(10.0, Anchor::Middle));
        }
        for tick in [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0] {
            svg.line([left, y.at(tick)], [right, y.at(tick)], FAINT, 0.7);
            svg.text(
                [left - 6.0, y.at(tick) + 4.0],
                &tick.to_string(),
                Font::new(10.0, Anchor::End),
            );
        }
        let middle = f64::midpoint(left, right);
        svg.text([middle, bottom + 31.0], "triangles", Font::new(11.0, Anchor::Middle));
        for (i, (group, name, stroke)) in GROUPS.into_iter().enumerate() {
            let point = |&triangles: &usize| {
                let cell: Vec<&Row> = rows
                    .iter()
                    .filter(|row| row.triangles == triangles && row.kind == *kind)
                    .collect();
                Some([x.at(triangles as f64), y.at(fastest(&cell, group)?.speed[1])])
            };
            let points: Vec<_> = counts.iter().filter_map(point).collect();
            if points.is_empty() {
                continue;
            }
            svg.path(&points, stroke, 2.2, "");
            for &point in &points {
                svg.circle(point, 3.2, stroke, stroke);
            }
            if k == 0 {
                let at = [left + 8.0, bottom - 10.0 - 16.0 * i as f64];
                svg.line([at[0], at[1] - 4.0], [at[0] + 22.0, at[1] - 4.0], stroke, 2.2);
                svg.text([at[0] + 28.0, at[1]], name, Font::new(11.0, Anchor::Start));
            }
        }
        svg.line([left, top], [left, bottom], INK, 1.2);
        svg.line([left, bottom], [right, bottom], INK, 1.2);
    }
    svg
}
