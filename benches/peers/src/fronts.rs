//! Draws the chart of speed and wrong answers on whole scenes, with a column per kind of ray and a
//! row per tracer.

use intertri_lab::draw::{Anchor, Font, Svg};

use crate::chart::{FAINT, GREY, INK, distinct, fastest, none_or, titled};
use crate::measure::Row;
use crate::report::grouped;

/// The tracers, each with a group of engines and a label. Only the fastest engine of a group
/// counts; `chart::fastest` defines which engines belong to it.
const TRACERS: [(&str, &str); 13] = [
    ("exact", "intertri exact, batches"),
    ("exact-query", "intertri, ray by ray"),
    ("embree-fast", "Embree, fast, f32"),
    ("embree-robust", "Embree, robust, f32"),
    ("tinybvh", "tinybvh, f32"),
    ("tinybvh-f64", "tinybvh, f64"),
    ("obvhs", "obvhs, f32"),
    ("bvh", "bvh, f32"),
    ("parry", "parry3d, f32"),
    ("parry-f64", "parry3d, f64"),
    ("libigl", "libigl, f64"),
    ("cgal-inexact", "CGAL, rounded points"),
    ("cgal", "CGAL, exact points"),
];

/// Limits on the share of wrong answers, each with the colour and label for shares up to that
/// limit.
const SHARES: [(f64, &str, &str); 5] = [
    (0.0, "#0072B2", "never wrong"),
    (1e-5, "#F3DE8A", "up to 1 in 100,000"),
    (1e-4, "#F0B038", "up to 1 in 10,000"),
    (1e-2, "#DE7026", "up to 1 in 100"),
    (1.0, "#A3201D", "more often"),
];

const ACROSS: usize = 4;
const LABELS: f64 = 166.0;
const CELL: [f64; 2] = [196.0, 19.0];
/// The width of the longest bar.
const BARS: f64 = 78.0;
const TOP: f64 = 84.0;
const HEADING: f64 = 30.0;

/// A tracer's figures for one kind of ray, over all scenes.
pub struct Figures {
    pub name: &'static str,
    /// The speed relative to Embree's fast mode: the geometric mean over the scenes.
    pub speed: f64,
    pub wrong: usize,
    pub rays: usize,
    /// Whether no other tracer is at least as good in both speed and accuracy, and better in one of
    /// them.
    pub is_on_front: bool,
}

impl Figures {
    fn share(&self) -> f64 {
        self.wrong as f64 / self.rays.max(1) as f64
    }

    /// Formats the speed, with more decimals for small values.
    pub fn speed(&self) -> String {
        let digits = if self.speed < 0.01 {
            4
        } else if self.speed < 0.1 {
            3
        } else {
            2
        };
        format!("{:.digits$}", self.speed)
    }

    /// Formats the share of wrong answers, for example as "1 in 1,000". `most` is the largest
    /// number of rays traced by any tracer.
    pub fn how_wrong(&self, most: usize) -> String {
        match self.wrong {
            0 if self.rays < most => format!("none in {}", grouped(self.rays)),
            0 => "none".into(),
            wrong => {
                let one_in = self.rays as f64 / wrong as f64;
                let digits = 10_f64.powf((one_in.log10().floor() - 1.0).max(0.0));
                let rounded = (one_in / digits).round() * digits;
                match one_in {
                    ..10.0 => format!("{:.0} %", 100.0 * self.share()),
                    _ => format!("1 in {}", grouped(rounded as usize)),
                }
            }
        }
    }
}

/// Returns each combination of a kind and an order of rays, in order of first appearance.
pub fn kinds(rows: &[Row]) -> Vec<(&str, &str)> {
    distinct(rows, |row| (row.kind.as_str(), row.order.as_str()))
}

/// Returns the chart's name for a kind of ray.
pub fn called(kind: &str) -> &str {
    match kind {
        "primary" => "Camera, row by row",
        "parallel" => "Parallel, row by row",
        "shadow" => "Shadow rays",
        "diffuse" => "Diffuse rays",
        "edges" => "Aimed at edges",
        "vertices" => "Aimed at vertices",
        "walls" => "In the planes of walls",
        "utm" => "Map coordinates (UTM)",
        other => other,
    }
}

/// Computes the figures of each tracer for one kind and order of rays.
pub fn figures(rows: &[Row], (kind, order): (&str, &str)) -> Vec<Figures> {
    let rows: Vec<&Row> =
        rows.iter().filter(|row| row.kind == kind && row.order == order).collect();
    let scenes = distinct(rows.iter().copied(), |row| row.scene.as_str());
    // These rays often hit a point that several triangles share, and then each of these triangles
    // is right.
    let shared = matches!(kind, "edges" | "vertices" | "walls");
    let of = |(group, name): (&str, &'static str)| {
        let (mut logs, mut wrong, mut rays) = (Vec::new(), 0, 0);
        for scene in &scenes {
            let cell: Vec<&Row> = rows.iter().filter(|row| row.scene == *scene).copied().collect();
            let (row, base) = beside_embree(&cell, group)?;
            logs.push((row.speed[1] / base.speed[1]).ln());
            wrong += row.wrong_hits + if shared { 0 } else { row.wrong_triangles };
            rays += row.rays;
        }
        let speed = (logs.iter().sum::<f64>() / logs.len().max(1) as f64).exp();
        Some(Figures { name, speed, wrong, rays, is_on_front: false })
    };
    let mut all: Vec<Figures> = TRACERS.into_iter().filter_map(of).collect();
    for i in 0..all.len() {
        let (speed, share) = (all[i].speed, all[i].share());
        let better = |other: &Figures| {
            let (faster, righter) = (other.speed - speed, share - other.share());
            faster >= 0.0 && righter >= 0.0 && faster + righter > 0.0
        };
        all[i].is_on_front = !all.iter().any(better);
    }
    all
}

/// Returns a tracer's row for a scene, and the row of Embree's fast mode from the same run. A slow
/// tracer may have its own run with fewer rays.
fn beside_embree<'a>(cell: &[&'a Row], group: &str) -> Option<(&'a Row, &'a Row)> {
    let mut counts: Vec<usize> = cell.iter().map(|row| row.rays).collect();
    counts.sort_unstable();
    counts.dedup();
    counts.into_iter().rev().find_map(|count| {
        let run: Vec<&Row> = cell.iter().filter(|row| row.rays == count).copied().collect();
        Some((fastest(&run, group)?, fastest(&run, "embree-fast")?))
    })
}

/// Draws speed and wrong answers, with a bar for each tracer and kind of ray, coloured by the share
/// of wrong answers.
pub fn chart(rows: &[Row], caption: &str) -> Svg {
    let columns: Vec<_> = kinds(rows).iter().map(|&kind| (kind, figures(rows, kind))).collect();
    let across = columns.len().min(ACROSS);
    let block = HEADING + CELL[1] * TRACERS.len() as f64 + 12.0;
    let down = columns.len().div_ceil(ACROSS).max(1) as f64;
    let title = "Speed and wrong answers on whole scenes: longer is faster, blue is never wrong";
    let size = [36.0 + LABELS + CELL[0] * across as f64, TOP + block * down + 14.0];
    let mut svg = titled(size, title, caption);
    legend(&mut svg);
    let speeds = columns.iter().flat_map(|(_, figures)| figures.iter().map(|f| f.speed));
    let scale = BARS / speeds.fold(1.0, f64::max);
    for (i, ((kind, _), figures)) in columns.iter().enumerate() {
        let top = TOP + block * (i / ACROSS) as f64;
        if i % ACROSS == 0 {
            labels(&mut svg, top);
        }
        let left = 24.0 + LABELS + CELL[0] * (i % ACROSS) as f64;
        svg.text([left, top + 20.0], called(kind), Font::new(12.5, Anchor::Start).bold());
        let embree = left + scale;
        svg.line([embree, top + HEADING - 2.0], [embree, top + block - 12.0], GREY, 0.8);
        column(&mut svg, [left, top + HEADING], scale, figures);
    }
    svg
}

fn legend(svg: &mut Svg) {
    let mut x = 24.0;
    for (_, fill, label) in SHARES {
        svg.rect([x, 62.0], [12.0, 12.0], fill);
        svg.text([x + 17.0, 72.0], label, Font::new(11.0, Anchor::Start));
        x += 32.0 + 6.4 * label.len() as f64;
    }
    let front = "★ no other tracer is at least as good in both and better in one";
    svg.text([x + 4.0, 72.0], front, Font::new(11.0, Anchor::Start));
}

/// Draws the names of the tracers, to the left of a block.
fn labels(svg: &mut Svg, top: f64) {
    for (i, (group, name)) in TRACERS.iter().enumerate() {
        let y = top + HEADING + CELL[1] * i as f64;
        let font = Font::new(11.5, Anchor::End);
        let font = if group.starts_with("exact") { font.bold() } else { font };
        svg.text([24.0 + LABELS - 14.0, y + 12.0], name, font);
    }
}

fn column(svg: &mut Svg, [left, top]: [f64; 2], scale: f64, all: &[Figures]) {
    let most = all.iter().map(|figures| figures.rays).max().unwrap_or(0);
    for (i, (_, name)) in TRACERS.iter().enumerate() {
        let y = top + CELL[1] * i as f64;
        svg.line([left, y + 16.5], [left + CELL[0] - 14.0, y + 16.5], FAINT, 0.6);
        let Some(figures) = all.iter().find(|figures| figures.name == *name) else {
            svg.text([left + 4.0, y + 12.0], "–", Font::new(10.5, Anchor::Start).fill(GREY));
            continue;
        };
        let share = figures.share();
        let colour = SHARES.iter().find(|(limit, ..)| share <= *limit);
        let wide = (figures.speed * scale).max(1.0);
        svg.rect([left, y + 2.0], [wide, 12.0], colour.map_or(INK, |(_, fill, _)| *fill));
        let after = left + wide + 4.0;
        svg.text([after, y + 12.0], &figures.speed(), Font::new(10.5, Anchor::Start).halo());
        let wrong = figures.how_wrong(most);
        let font = Font::new(10.5, Anchor::End);
        let font = if figures.wrong == 0 { font.fill("#0072B2") } else { font.fill(GREY) };
        svg.text([left + CELL[0] - 16.0, y + 12.0], &wrong, font.halo());
        if figures.is_on_front {
            svg.text([left - 6.5, y + 12.5], "★", Font::new(11.0, Anchor::Middle));
        }
    }
}

/// Formats the chart's figures as a Markdown table, with a row per tracer that lists its speed and
/// wrong answers for each kind of ray.
pub fn table(rows: &[Row]) -> String {
    let kinds = kinds(rows);
    let columns: Vec<_> = kinds.iter().map(|&kind| figures(rows, kind)).collect();
    let most = |column: &Vec<Figures>| column.iter().map(|figures| figures.rays).max().unwrap_or(0);
    let line = |head: &str, cells: &[String]| format!("| {head} | {} |\n", cells.join(" | "));
    let heads: Vec<String> = kinds.iter().map(|(kind, _)| short(kind).to_owned()).collect();
    let rays: Vec<String> = columns.iter().map(|column| grouped(most(column))).collect();
    let rule = line("---", &vec!["---".to_owned(); heads.len()]);
    let mut table = line("", &heads) + &rule + &line("rays", &rays);
    for (_, name) in TRACERS {
        let cell = |column: &Vec<Figures>| {
            let figures = column.iter().find(|figures| figures.name == name)?;
            let star = if figures.is_on_front { "★ " } else { "" };
            let wrong = none_or(figures.wrong);
            let fewer = figures.rays < most(column);
            let of = if fewer { format!(" of {}", grouped(figures.rays)) } else { String::new() };
            Some(format!("{star}{}, {wrong}{of}", figures.speed()))
        };
        let cells: Vec<String> =
            columns.iter().map(|column| cell(column).unwrap_or_default()).collect();
        if cells.iter().any(|cell| !cell.is_empty()) {
            table += &line(name, &cells);
        }
    }
    table
}

/// Returns the column heading for a kind of ray.
fn short(kind: &str) -> &str {
    match kind {
        "primary" => "camera",
        "utm" => "map (UTM)",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(scene: &str, engine: &str, rays: usize, speed: f64) -> Row {
        Row {
            scene: scene.into(),
            kind: "primary".into(),
            order: "rows".into(),
            engine: engine.into(),
            rays,
            speed: [0.5 * speed, speed, 2.0 * speed],
            ..Row::default()
        }
    }

    fn wrong(row: Row, wrong_hits: usize, wrong_triangles: usize) -> Row {
        Row { wrong_hits, wrong_triangles, ..row }
    }

    fn figures_of<'a>(all: &'a [Figures], label: &str) -> &'a Figures {
        all.iter().find(|figures| figures.name == label).expect(label)
    }

    const OURS: &str = "intertri exact, batches";
    const EMBREE: &str = "Embree, fast, f32";

    #[test]
    fn ratios_are_to_the_fastest_call_of_embree_in_the_same_scene() {
        let rows = [
            row("bunny", "embree-fast-1", 1000, 10.0),
            row("bunny", "embree-fast-16", 1000, 20.0),
            row("bunny", "embree-robust-16", 1000, 99.0),
            row("bunny", "exact", 1000, 160.0),
            row("kitchen", "embree-fast-1", 1000, 4.0),
            row("kitchen", "embree-fast-16", 1000, 3.0),
            row("kitchen", "exact", 1000, 2.0),
        ];
        let all = figures(&rows, ("primary", "rows"));
        // 8 times as fast in one scene and half as fast in the other: the geometric mean is 2.
        assert!((figures_of(&all, OURS).speed - 2.0).abs() < 1e-12);
        assert!((figures_of(&all, EMBREE).speed - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_tracer_that_had_fewer_rays_is_compared_with_embree_on_the_same_rays() {
        let rows = [
            row("bunny", "embree-fast-16", 1000, 20.0),
            row("bunny", "exact", 1000, 20.0),
            row("bunny", "embree-fast-16", 10, 5.0),
            row("bunny", "libigl", 10, 1.0),
        ];
        let all = figures(&rows, ("primary", "rows"));
        let libigl = figures_of(&all, "libigl, f64");
        assert!((libigl.speed - 0.2).abs() < 1e-12, "{}", libigl.speed);
        assert_eq!(libigl.rays, 10);
        assert_eq!(figures_of(&all, EMBREE).rays, 1000);
    }

    #[test]
    fn a_tracer_that_lacks_a_scene_has_no_figures() {
        let rows = [
            row("bunny", "embree-fast-16", 1000, 20.0),
            row("bunny", "obvhs-2", 1000, 80.0),
            row("kitchen", "embree-fast-16", 1000, 20.0),
        ];
        let all = figures(&rows, ("primary", "rows"));
        assert!(all.iter().all(|figures| figures.name == EMBREE));
    }

    #[test]
    fn wrong_answers_of_all_scenes_add_up() {
        let rows = [
            wrong(row("bunny", "embree-fast-16", 1000, 20.0), 1, 20),
            wrong(row("kitchen", "embree-fast-16", 500, 20.0), 300, 4000),
        ];
        let all = figures(&rows, ("primary", "rows"));
        let embree = figures_of(&all, EMBREE);
        assert_eq!((embree.wrong, embree.rays), (4321, 1500));
    }

    #[test]
    fn only_hit_or_miss_counts_where_neighbours_share_the_point() {
        for kind in ["edges", "vertices", "walls"] {
            let row = wrong(row("bunny", "embree-fast-16", 1000, 20.0), 7, 20);
            let rows = [Row { kind: kind.into(), ..row }];
            assert_eq!(figures(&rows, (kind, "rows"))[0].wrong, 7, "{kind}");
        }
    }

    #[test]
    fn our_batches_are_not_credited_with_our_single_calls() {
        let rows = [
            row("bunny", "embree-fast-16", 1000, 20.0),
            row("bunny", "exact", 1000, 10.0),
            row("bunny", "exact-query", 1000, 40.0),
        ];
        let all = figures(&rows, ("primary", "rows"));
        assert!((figures_of(&all, OURS).speed - 0.5).abs() < 1e-12);
        assert!((figures_of(&all, "intertri, ray by ray").speed - 2.0).abs() < 1e-12);
    }

    #[test]
    fn the_table_says_of_how_many_rays_where_there_were_fewer() {
        let rows = [
            wrong(row("bunny", "embree-fast-16", 1000, 20.0), 3, 0),
            row("bunny", "exact", 1000, 10.0),
            row("bunny", "embree-fast-16", 10, 5.0),
            wrong(row("bunny", "libigl", 10, 0.1), 0, 2),
        ];
        let expected = "|  | camera |\n| --- | --- |\n| rays | 1,000 |\n\
            | intertri exact, batches | ★ 0.50, none |\n\
            | Embree, fast, f32 | ★ 1.00, 3 |\n\
            | libigl, f64 | 0.020, 2 of 10 |\n";
        assert_eq!(table(&rows), expected);
    }

    #[test]
    fn the_front_is_what_nothing_else_beats_in_both() {
        let rows = [
            wrong(row("bunny", "embree-fast-16", 1000, 20.0), 3, 0),
            wrong(row("bunny", "embree-robust-16", 1000, 19.0), 3, 0),
            row("bunny", "exact", 1000, 18.0),
            row("bunny", "parry-f64", 1000, 2.0),
        ];
        let all = figures(&rows, ("primary", "rows"));
        let on_front: Vec<_> = all.iter().filter(|f| f.is_on_front).map(|f| f.name).collect();
        assert_eq!(on_front, [OURS, EMBREE]);
    }
}
