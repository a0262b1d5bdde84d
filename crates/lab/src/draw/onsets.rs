//! Onset curves: small pictures, one a sweep, a line a method.

use std::collections::BTreeMap;

use super::axis::{Log, power, superscript};
use super::svg::{Anchor, FAINT, Font, GREY, INK, Svg};
use crate::methods::METHODS;
use crate::stress::{Onset, SWEEPS};

const COLUMNS: usize = 4;
const CELL: [f64; 2] = [345.0, 262.0];
const LEFT: f64 = 46.0;
const RIGHT: f64 = 330.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 222.0;

/// Colour and dashes of each method that is drawn, in the order of the table.
fn styles() -> BTreeMap<&'static str, (&'static str, &'static str)> {
    // Eight colours, solid; the others with dashes.
    const COLOURS: [&str; 7] =
        ["#0072B2", "#56B4E9", "#CC79A7", "#000000", "#E69F00", "#8A6FB0", "#999999"];
    let mut styles = BTreeMap::new();
    let (mut single, mut double) = (0, 0);
    for method in METHODS {
        let style = match method.name {
            "certified" => ("#D55E00", ""),
            "certified, one origin" => ("#D55E00", "4 2"),
            "double" => ("#D55E00", "2 3"),
            "fixed" => ("#D55E00", "8 3 2 3"),
            name if name.ends_with("f64") => {
                double += 1;
                ("#009E73", ["", "6 3", "2 2", "8 3 2 3", "10 2", "1 3"][(double - 1) % 6])
            }
            _ => {
                single += 1;
                (COLOURS[(single - 1) % 7], if single > 7 { "5 3" } else { "" })
            }
        };
        styles.insert(method.name, style);
    }
    styles
}

/// A small picture for each sweep: the share of wrong answers against the parameter, from where it is
/// harmless on the left.
pub fn onsets(onsets: &[Onset], caption: &str) -> Svg {
    let rows = (SWEEPS.len() + 1).div_ceil(COLUMNS);
    let [w, h] = CELL;
    let mut svg = Svg::new(COLUMNS as f64 * w + 20.0, rows as f64 * h + 100.0);
    let title =
        "Where methods begin to fail: share of wrong answers against the parameter of a family";
    svg.text([16.0, 28.0], title, Font::new(19.0, Anchor::Start).bold());
    let note = "rays that pass clear of all sides by a hundredth of the way across, but in the last picture; a line that is not seen lies below the picture";
    svg.text([16.0, 47.0], note, Font::new(12.0, Anchor::Start).fill(GREY));
    let at = |k: usize| [10.0 + w * (k % COLUMNS) as f64, 58.0 + h * (k / COLUMNS) as f64];
    for (k, sweep) in SWEEPS.iter().enumerate() {
        let own: Vec<_> = onsets.iter().filter(|onset| onset.sweep == sweep.name).collect();
        picture(&mut svg, at(k), sweep.name, sweep.from, sweep.to, &own);
    }
    legend(&mut svg, at(SWEEPS.len()), COLUMNS - SWEEPS.len() % COLUMNS);
    let font = Font::new(11.0, Anchor::Start).fill(GREY);
    for (k, line) in caption.lines().enumerate() {
        svg.text([16.0, 58.0 + rows as f64 * h + 14.0 + 14.0 * k as f64], line, font);
    }
    svg
}

fn picture(svg: &mut Svg, [ox, oy]: [f64; 2], name: &str, from: f64, to: f64, onsets: &[&Onset]) {
    let (left, right, top, bottom) = (ox + LEFT, ox + RIGHT, oy + TOP, oy + BOTTOM);
    let trials = onsets.iter().map(|onset| onset.trials).max().unwrap_or(1).max(10);
    let least = 10_f64.powf((0.7 / trials as f64).log10().floor().max(-5.0));
    let x = Log::new(from, to, [left, right]);
    let y = Log::new(1.0, least, [top, bottom]);
    svg.text([left, oy + 22.0], name, Font::new(13.0, Anchor::Start).bold());
    for k in y.decades(1) {
        let at = y.at(10_f64.powi(k));
        svg.line([left, at], [right, at], FAINT, 0.7);
        let text = if k == 0 { "all".to_owned() } else { power(k) };
        svg.text([left - 5.0, at + 4.0], &text, Font::new(10.0, Anchor::End));
    }
    let decades = (to / from).log10().abs();
    let every = [1, 2, 3, 5, 10, 20].into_iter().find(|&k| decades / f64::from(k) <= 7.0);
    for k in x.decades(every.unwrap_or(10)) {
        let at = x.at(10_f64.powi(k));
        svg.line([at, top], [at, bottom], FAINT, 0.7);
        let text = if k == 0 { "1".to_owned() } else { format!("10{}", superscript(k)) };
        svg.text([at, bottom + 14.0], &text, Font::new(10.0, Anchor::Middle));
    }
    svg.line([left, bottom], [right, bottom], INK, 1.0);
    svg.line([left, top], [left, bottom], INK, 1.0);

    for (method, (colour, dashes)) in &styles() {
        let own: Vec<_> = onsets.iter().filter(|onset| onset.method == *method).collect();
        // Stretches where errors were seen; elsewhere the line runs along the bottom.
        let place = |onset: &Onset| {
            let share = onset.share();
            [x.at(onset.parameter), if share > least { y.at(share) } else { bottom }]
        };
        for pair in own.windows(2) {
            let points = [place(pair[0]), place(pair[1])];
            if points.iter().any(|p| p[1] < bottom) {
                let wide = if colour == &"#D55E00" { 2.4 } else { 1.6 };
                svg.path(&points, colour, wide, dashes);
            }
        }
    }
}

fn legend(svg: &mut Svg, [ox, oy]: [f64; 2], cells: usize) {
    let styles = styles();
    let mut rows = METHODS.len();
    let columns = if cells > 1 { 2 } else { 1 };
    rows = rows.div_ceil(columns);
    let step = (CELL[1] - 30.0) / rows as f64;
    for (k, method) in METHODS.iter().enumerate() {
        let (x, y) = (ox + 60.0 + 300.0 * (k / rows) as f64, oy + 24.0 + step * (k % rows) as f64);
        let Some((colour, dashes)) = styles.get(method.name) else { continue };
        svg.path(&[[x, y - 4.0], [x + 42.0, y - 4.0]], colour, 2.2, dashes);
        svg.text([x + 50.0, y], method.name, Font::new(11.5, Anchor::Start));
    }
}
