//! Draws onset curves as small multiples: one row per method, one column per sweep, so that no
//! curve hides another.

use super::axis::{Log, power, superscript};
use super::marks::{colour_of, in_order, is_kernel, pale_of};
use super::svg::{Anchor, FAINT, Font, GREY, INK, Svg};
use crate::stress::{Onset, SWEEPS, Sweep};

/// The number of sweeps side by side.
const COLUMNS: usize = 9;
/// The size of a cell, including its margins.
const CELL: [f64; 2] = [140.0, 38.0];
/// The margins to the right of a cell and above it.
const GAP: [f64; 2] = [28.0, 7.0];
const LEFT: f64 = 188.0;
/// The space above the first band.
const TOP: f64 = 74.0;
/// The space above a band's cells, for the headings.
const HEADING: f64 = 56.0;
/// The space below a band's cells.
const FOOT: f64 = 52.0;
/// The gap between the kernel's modes and the published methods.
const BETWEEN: f64 = 12.0;

/// Plots the share of wrong answers against the parameter, for each method and sweep, with harmless
/// values on the left. `caption` is printed below.
pub fn onsets(onsets: &[Onset], caption: &str) -> Svg {
    let [w, h] = CELL;
    let methods = in_order();
    let band = HEADING + methods.len() as f64 * h + BETWEEN + FOOT;
    let bands = SWEEPS.len().div_ceil(COLUMNS);
    let bottom = TOP + bands as f64 * band;
    let mut svg = Svg::new(LEFT + COLUMNS as f64 * w + 4.0, bottom + 40.0);
    let title = "Where methods begin to fail: a row for each method, a column for each parameter";
    svg.text([16.0, 30.0], title, Font::new(19.0, Anchor::Start).bold());
    let trials = onsets.iter().map(|onset| onset.trials).max().unwrap_or(1).max(10);
    let least = (0.7 / trials as f64).log10().floor().max(-5.0);
    let note = format!(
        "vertical axis: the share of wrong answers, from {} to all; none: no answer was wrong. Rays \
         avoid all sides by a hundredth of the triangle's size, except in the last column.",
        power(least as i32)
    );
    svg.text([16.0, 52.0], &note, Font::new(12.0, Anchor::Start).fill(GREY));

    for (k, sweeps) in SWEEPS.chunks(COLUMNS).enumerate() {
        let top = TOP + k as f64 * band;
        names(&mut svg, top + HEADING, least);
        for (column, sweep) in sweeps.iter().enumerate() {
            let left = LEFT + w * column as f64;
            let x = Log::new(sweep.from, sweep.to, [left, left + w - GAP[0]]);
            headings(&mut svg, top, left, sweep, &x);
            for (i, method) in methods.iter().enumerate() {
                let own = |o: &&Onset| o.sweep == sweep.name && o.method == method.name;
                let own: Vec<_> = onsets.iter().filter(own).collect();
                let y = scale(top + HEADING, i, least);
                cell(&mut svg, method.name, [&x, &y], sweep, least, &own);
            }
        }
    }
    let font = Font::new(11.0, Anchor::Start).fill(GREY);
    for (k, line) in caption.lines().enumerate() {
        svg.text([16.0, bottom + 14.0 + 14.0 * k as f64], line, font);
    }
    svg
}

/// Returns the vertical axis of a row, for shares from 1 at the top down to the smallest.
fn scale(top: f64, row: usize, least: f64) -> Log {
    let modes = in_order().iter().filter(|method| is_kernel(method.name)).count();
    let between = if row < modes { 0.0 } else { BETWEEN };
    let bottom = top + between + CELL[1] * (row + 1) as f64;
    Log::new(1.0, 10_f64.powf(least), [bottom - CELL[1] + GAP[1], bottom])
}

/// Draws the methods' names and the numbers at the ends of their axes.
fn names(svg: &mut Svg, top: f64, least: f64) {
    for (row, method) in in_order().into_iter().map(|method| method.name).enumerate() {
        let y = scale(top, row, least);
        let (all, bottom) = (y.at(1.0), y.at(10_f64.powf(least)));
        let font = Font { bold: is_kernel(method), ..Font::new(12.0, Anchor::End) };
        let middle = f64::midpoint(all, bottom) + 4.0;
        svg.text([LEFT - 34.0, middle], method, font.fill(colour_of(method)));
        let font = Font::new(9.5, Anchor::End).fill(GREY);
        svg.text([LEFT - 4.0, all + 6.0], "all", font);
        svg.text([LEFT - 4.0, bottom + 2.0], &power(least as i32), font);
    }
}

/// Draws a column's title and the numbers above and below its cells.
fn headings(svg: &mut Svg, top: f64, left: f64, sweep: &Sweep, x: &Log) {
    svg.text([left, top + 16.0], sweep.name, Font::new(10.5, Anchor::Start).bold());
    svg.text([left, top + 31.0], sweep.axis, Font::new(11.0, Anchor::Start));
    let below = top + HEADING + in_order().len() as f64 * CELL[1] + BETWEEN;
    let font = Font::new(10.0, Anchor::Middle).fill(GREY);
    for k in ticks(sweep, x) {
        let text = if k == 0 { "1".to_owned() } else { format!("10{}", superscript(k)) };
        for y in [top + HEADING - 4.0, below + 14.0] {
            svg.text([x.at(10_f64.powi(k)), y], &text, font);
        }
    }
    svg.text([left, below + 29.0], sweep.axis, Font::new(11.0, Anchor::Start));
}

/// Returns the powers of ten to label, at most four.
fn ticks(sweep: &Sweep, x: &Log) -> Vec<i32> {
    let decades = (sweep.to / sweep.from).log10().abs();
    let every = [1, 2, 3, 4, 5, 10, 20].into_iter().find(|&k| decades / f64::from(k) < 4.0);
    x.decades(every.unwrap_or(20))
}

/// Draws a method's curve in a sweep above its shaded area, or prints a note such as `none` if
/// there is no curve to draw.
fn cell(
    svg: &mut Svg,
    method: &str,
    [x, y]: [&Log; 2],
    sweep: &Sweep,
    least: f64,
    onsets: &[&Onset],
) {
    let (left, right) = (x.at(sweep.from), x.at(sweep.to));
    let (top, bottom) = (y.at(1.0), y.at(10_f64.powf(least)));
    for k in y.decades(1) {
        let at = y.at(10_f64.powi(k));
        svg.line([left, at], [right, at], FAINT, 0.6);
    }
    for k in ticks(sweep, x) {
        let at = x.at(10_f64.powi(k));
        svg.line([at, top], [at, bottom], FAINT, 0.6);
    }
    let place = |onset: &&Onset| {
        let share = onset.share();
        [x.at(onset.parameter), if share > 0.0 { y.at(share).min(bottom) } else { bottom }]
    };
    let curve: Vec<_> = onsets.iter().map(place).collect();
    let colour = colour_of(method);
    if let (true, Some(first), Some(last)) =
        (onsets.iter().any(|onset| onset.share() > 0.0), curve.first(), curve.last())
    {
        let mut area = vec![[first[0], bottom]];
        area.extend(&curve);
        area.push([last[0], bottom]);
        svg.polygon(&area, pale_of(method), "none");
        svg.path(&curve, colour, 1.6, "");
    } else {
        let text = if onsets.is_empty() { "not measured" } else { "none" };
        let font = Font { bold: is_kernel(method), ..Font::new(10.5, Anchor::Middle) };
        let at = [f64::midpoint(left, right), f64::midpoint(top, bottom) + 4.0];
        svg.text(at, text, font.fill(colour).halo());
    }
    svg.line([left, bottom], [right, bottom], INK, 0.9);
    svg.line([left, top], [left, bottom], INK, 0.9);
}
