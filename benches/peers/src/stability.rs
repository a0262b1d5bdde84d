//! Draws the stability chart, which plots nanoseconds per ray against how hostile a scene is.

use intertri_lab::draw::{Anchor, Font, Log, Svg, power};

use crate::chart::{FAINT, Group, INK, OTHERS, distinct, fastest, none_or, titled};
use crate::measure::Row;
use crate::report::grouped;

/// intertri's two kinds of calls.
const OURS: [Group; 2] =
    [("exact", "exact, batches", "#D55E00"), ("exact-query", "exact, ray by ray", "#E69F00")];

const PANEL: [f64; 2] = [590.0, 360.0];
const ACROSS: usize = 2;

/// Returns the title of a panel, the label of its axis, and a function that formats an amount.
fn described(kind: &str) -> (&str, &str, fn(f64) -> String) {
    match kind {
        "stray" => ("A stray triangle", "its distance, in sizes of the scene", distance),
        "stray-diffuse" => {
            ("A stray triangle, diffuse rays", "its distance, in sizes of the scene", distance)
        }
        "origin" => ("Far origins", "their distance, in sizes of the scene", distance),
        "thin" => {
            ("Thin triangles", "length of a triangle over its width", |x| grouped(x as usize))
        }
        "edges" => ("Rays aimed at edges", "share of the rays", share),
        "vertices" => ("Rays aimed at vertices", "share of the rays", share),
        other => (other, "", |x| x.to_string()),
    }
}

fn distance(x: f64) -> String {
    if x == 0.0 { "plain".into() } else { power(x.log10().round() as i32) }
}

fn share(x: f64) -> String {
    format!("{} %", 100.0 * x)
}

/// Formats a ratio of times, with at least two digits.
fn factor(x: f64) -> String {
    if x < 10.0 { format!("{x:.1}") } else { format!("{x:.0}") }
}

/// Returns a tracer's point in the chart: the geometric mean of the nanoseconds per ray over the
/// scenes, the number of wrong answers, and the number of rays.
fn point(rows: &[&Row], group: &str) -> Option<(f64, usize, usize)> {
    let (mut logs, mut wrong, mut rays) = (Vec::new(), 0, 0);
    for scene in distinct(rows.iter().copied(), |row| row.scene.as_str()) {
        let cell: Vec<&Row> = rows.iter().filter(|row| row.scene == scene).copied().collect();
        let row = fastest(&cell, group)?;
        logs.push((1e3 / row.speed[1]).ln());
        // Adjacent triangles share the points that these rays aim at, so either triangle is right.
        let shared = matches!(row.kind.as_str(), "edges" | "vertices");
        wrong += row.wrong_hits + if shared { 0 } else { row.wrong_triangles };
        rays += row.rays;
    }
    let mean = logs.iter().sum::<f64>() / logs.len().max(1) as f64;
    (!logs.is_empty()).then(|| (mean.exp(), wrong, rays))
}

/// Draws one panel for each cause, with one line for each tracer.
pub fn chart(rows: &[Row], caption: &str) -> Svg {
    let kinds = distinct(rows, |row| row.kind.as_str());
    let across = kinds.len().clamp(1, ACROSS);
    let down = kinds.len().div_ceil(ACROSS);
    let title = "Stability of time: nanoseconds per ray as scenes become more hostile";
    let size = [24.0 + PANEL[0] * across as f64, 64.0 + PANEL[1] * down as f64];
    let mut svg = titled(size, title, caption);
    for (i, kind) in kinds.iter().enumerate() {
        let of: Vec<&Row> = rows.iter().filter(|row| row.kind == *kind).collect();
        let at = [24.0 + PANEL[0] * (i % ACROSS) as f64, 58.0 + PANEL[1] * (i / ACROSS) as f64];
        panel(&mut svg, at, kind, &of);
    }
    svg
}

fn panel(svg: &mut Svg, [x, y]: [f64; 2], kind: &str, rows: &[&Row]) {
    let (left, right, top, bottom) =
        (x + 44.0, x + PANEL[0] - 172.0, y + 32.0, y + PANEL[1] - 46.0);
    let (title, axis, label) = described(kind);
    svg.text([left, y + 20.0], title, Font::new(13.5, Anchor::Start).bold());
    let amounts = distinct(rows.iter().copied(), |row| row.amount);
    let step = (right - left - 24.0) / (amounts.len().max(2) - 1) as f64;
    let along = |i: usize| left + 12.0 + step * i as f64;
    let up = Log::new(20.0, 50_000.0, [bottom, top]);
    for tick in [20.0, 50.0, 100.0, 200.0, 500.0, 1e3, 2e3, 5e3, 1e4, 2e4, 5e4] {
        svg.line([left, up.at(tick)], [right, up.at(tick)], FAINT, 0.7);
        let text = if tick < 1e3 { format!("{tick} ns") } else { format!("{} µs", tick / 1e3) };
        svg.text([left - 5.0, up.at(tick) + 4.0], &text, Font::new(10.0, Anchor::End));
    }
    for (i, amount) in amounts.iter().enumerate() {
        let font = Font::new(10.5, Anchor::Middle);
        svg.text([along(i), bottom + 15.0], &label(*amount), font);
    }
    let middle = f64::midpoint(left, right);
    svg.text([middle, bottom + 32.0], axis, Font::new(11.0, Anchor::Middle));
    svg.line([left, top], [left, bottom], INK, 1.2);
    svg.line([left, bottom], [right, bottom], INK, 1.2);

    let mut ends = Vec::new();
    // Draw our lines last, on top of the others.
    for (group, name, stroke) in OURS.into_iter().chain(OTHERS).rev() {
        let at = |amount: f64| rows.iter().filter(move |row| row.amount == amount).copied();
        let points: Vec<_> = amounts
            .iter()
            .enumerate()
            .filter_map(|(i, &amount)| {
                let (time, wrong, _) = point(&at(amount).collect::<Vec<_>>(), group)?;
                Some(([along(i), up.at(time.clamp(20.0, 50_000.0))], time, wrong > 0))
            })
            .collect();
        let (Some(first), Some(last)) = (points.first(), points.last()) else { continue };
        let line: Vec<_> = points.iter().map(|(at, ..)| *at).collect();
        let is_ours = group.starts_with("exact");
        svg.path(&line, stroke, if is_ours { 2.8 } else { 1.6 }, "");
        for &(at, _, wrong) in &points {
            svg.circle(at, 3.6, if wrong { stroke } else { "white" }, stroke);
        }
        ends.push((last.0[1], format!("{name} ×{}", factor(last.1 / first.1)), stroke, is_ours));
    }
    labels(svg, right, [top, bottom], ends);
}

/// Draws the names at the ends of the lines, without overlap.
fn labels(
    svg: &mut Svg,
    right: f64,
    [top, bottom]: [f64; 2],
    mut ends: Vec<(f64, String, &str, bool)>,
) {
    const APART: f64 = 14.0;
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut places: Vec<f64> = ends.iter().map(|end| end.0).collect();
    // Push down labels that are too close together, then push up those beyond the end of the axis.
    for i in 1..places.len() {
        places[i] = places[i].max(places[i - 1] + APART);
    }
    let mut limit = bottom;
    for place in places.iter_mut().rev() {
        *place = place.min(limit).max(top);
        limit = *place - APART;
    }
    for ((end, name, stroke, is_ours), place) in ends.iter().zip(places) {
        svg.line([right - 8.0, *end], [right + 8.0, place], stroke, 0.8);
        let font = Font::new(11.0, Anchor::Start);
        let font = if *is_ours { font.bold() } else { font };
        svg.text([right + 11.0, place + 4.0], name, font);
    }
}

/// Formats the figures of the chart as a Markdown table, with a row per case that lists the
/// nanoseconds per ray and the wrong answers of each tracer.
pub fn table(rows: &[Row]) -> String {
    let tracers: Vec<Group> = OURS.into_iter().chain(OTHERS).collect();
    let names: Vec<&str> = tracers.iter().map(|(_, name, _)| *name).collect();
    let mut table = format!("| nanoseconds, wrong answers | rays | {} |\n", names.join(" | "));
    table += &format!("|{}\n", " --- |".repeat(names.len() + 2));
    for (kind, amount) in distinct(rows, |row| (row.kind.as_str(), row.amount)) {
        let case: Vec<&Row> =
            rows.iter().filter(|row| row.kind == kind && row.amount == amount).collect();
        let points: Vec<_> = tracers.iter().map(|(group, ..)| point(&case, group)).collect();
        let rays = points.iter().flatten().map(|point| point.2).max().unwrap_or(0);
        let cell = |point: &Option<(f64, usize, usize)>| {
            let text = |(time, wrong, _): (f64, usize, usize)| {
                format!("{}, {}", grouped(time.round() as usize), none_or(wrong))
            };
            point.map(text).unwrap_or_default()
        };
        let cells: Vec<String> = points.iter().map(cell).collect();
        let (title, _, label) = described(kind);
        table += &format!(
            "| {}: {} | {} | {} |\n",
            title.to_lowercase(),
            label(amount),
            grouped(rays),
            cells.join(" | ")
        );
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_the_faster_of_two_runs_and_its_wrong_answers() {
        let row = |amount: f64, engine: &str, speed: f64, wrong: [usize; 2]| Row {
            scene: "bunny".into(),
            kind: "origin".into(),
            amount,
            engine: engine.into(),
            rays: 1000,
            speed: [speed; 3],
            wrong_hits: wrong[0],
            wrong_triangles: wrong[1],
            ..Row::default()
        };
        let rows = [
            row(0.0, "exact", 10.0, [0, 0]),
            row(0.0, "exact", 20.0, [0, 0]),
            row(0.0, "exact-query", 40.0, [0, 0]),
            row(0.0, "embree-fast-16", 8.0, [1, 2000]),
            row(1e4, "exact", 0.5, [0, 0]),
        ];
        let table = table(&rows);
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(
            lines[2],
            "| far origins: plain | 1,000 | 50, none | 25, none | 125, 2,001 |  |  |  |  |  |"
        );
        assert_eq!(lines[3], "| far origins: 10⁴ | 1,000 | 2,000, none |  |  |  |  |  |  |  |");
    }
}
