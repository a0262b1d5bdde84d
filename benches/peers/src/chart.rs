//! Draws two charts: bars for each scene and kind of ray, and speed against the number of
//! triangles. The modules that draw the other charts also use the helper functions defined here.

use std::collections::BTreeSet;

use intertri_lab::draw::{Anchor, Font, Log, Svg, power};

use crate::measure::Row;
use crate::report::grouped;

pub const INK: &str = "#222222";
pub const GREY: &str = "#666666";
pub const FAINT: &str = "#dddddd";

/// A group in a chart: a prefix for engine names, a label, and a colour. Only the fastest engine in
/// each group is drawn; [`fastest`] decides which names belong to a group. The colours are from
/// Okabe and Ito's colour-blind-safe palette.
pub type Group = (&'static str, &'static str, &'static str);

/// The groups for our modes.
const GROUPS: [Group; 3] = [
    ("certified", "certified", "#D55E00"),
    ("exact", "exact", "#E69F00"),
    ("fixed", "fixed", "#F0E442"),
];
/// The groups for the other tracers.
pub const OTHERS: [Group; 6] = [
    ("embree-fast", "Embree, fast", "#0072B2"),
    ("embree-robust", "Embree, robust", "#56B4E9"),
    ("tinybvh", "tinybvh", "#222222"),
    ("obvhs", "obvhs", "#009E73"),
    ("parry", "parry3d", "#999999"),
    ("bvh", "bvh", "#CC79A7"),
];

fn groups() -> impl Iterator<Item = Group> {
    GROUPS.into_iter().chain(OTHERS)
}

/// Returns an empty chart with a title and a caption, which take up 60 units of its height.
pub fn titled([width, height]: [f64; 2], title: &str, caption: &str) -> Svg {
    let mut svg = Svg::new(width, height);
    svg.text([24.0, 30.0], title, Font::new(18.0, Anchor::Start).bold());
    svg.text([24.0, 50.0], caption, Font::new(11.0, Anchor::Start).fill(GREY));
    svg
}

/// Formats a number of wrong answers for the tables, with "none" in place of 0.
pub fn none_or(wrong: usize) -> String {
    if wrong == 0 { "none".into() } else { grouped(wrong) }
}

/// Returns the row of the fastest engine in a group, or `None` if no row belongs to the group.
pub fn fastest<'a>(rows: &[&'a Row], group: &str) -> Option<&'a Row> {
    let of = |row: &&&Row| match row.engine.strip_prefix(group) {
        // The same library in a different precision counts as a different tracer.
        Some(rest) if rest.ends_with("-f64") || rest == "-inexact" => false,
        // Variants of our modes, such as single-ray calls, are separate contenders.
        Some(rest) => !matches!(group, "certified" | "exact") || rest.is_empty(),
        // Rows of the high-quality build also count as the fast mode.
        None => group == "embree-fast" && row.engine.starts_with("embree-high"),
    };
    rows.iter().filter(of).max_by(|a, b| a.speed[1].total_cmp(&b.speed[1])).copied()
}

/// Returns the distinct values, in order of appearance.
pub fn distinct<'a, T: PartialEq>(
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

/// Draws the bars, with one row of panels per scene and one panel per kind of ray.
pub fn bars(rows: &[Row], caption: &str) -> Svg {
    const PANEL: [f64; 2] = [330.0, 175.0];
    let scenes = distinct(rows, |row| (row.scene.as_str(), row.triangles));
    let kinds = distinct(rows, |row| row.kind.as_str());
    let [w, h] = PANEL;
    let (left, top) = (24.0, 60.0);
    let height = top + h * scenes.len() as f64 + 30.0;
    let title = "Million rays per second, and wrong answers per million rays";
    let mut svg = titled([left + w * kinds.len() as f64 + 20.0, height], title, caption);
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
        groups().filter_map(|(group, name, fill)| Some((fastest(cell, group)?, name, fill)));
    let drawn: Vec<_> = drawn.collect();
    let most = drawn.iter().fold(0.0, |most: f64, (row, ..)| most.max(row.speed[2]));
    let scale = (w - NAMES - 100.0) / most.max(1e-9);
    for (i, (row, name, fill)) in drawn.iter().enumerate() {
        let top = y + 26.0 + ROW * i as f64;
        let [low, middle, high] = row.speed.map(|speed| x + NAMES + speed * scale);
        svg.text([x + NAMES - 6.0, top + 11.0], name, Font::new(11.0, Anchor::End));
        svg.rect([x + NAMES, top], [middle - x - NAMES, ROW - 4.0], fill);
        let centre = top + (ROW - 4.0) / 2.0;
        svg.line([low, centre], [high, centre], INK, 1.0);
        let wrong = row.wrong_hits + row.wrong_triangles;
        // The answers of `fixed` are exact for the snapped scene, and differ only due to the grid.
        let how = if row.engine == "fixed" { "due to the grid" } else { "wrong" };
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

/// Plots speed against the number of triangles on logarithmic axes, with one panel per kind of ray.
pub fn growth(rows: &[Row], caption: &str) -> Svg {
    let kinds = distinct(rows, |row| row.kind.as_str());
    let (w, h) = (430.0, 380.0);
    let title = "Million rays per second by number of triangles, for ever finer bumpy spheres";
    let mut svg = titled([24.0 + w * kinds.len() as f64, h + 74.0], title, caption);
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
        for (i, (group, name, stroke)) in groups().enumerate() {
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
