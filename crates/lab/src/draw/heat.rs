//! Draws the table of onsets, with methods in rows and sweeps in columns.

use super::marks::{colour_of, in_order, is_kernel};
use super::svg::{Anchor, Font, GREY, Svg, width};
use crate::stress::{Onset, SWEEPS, Sweep, first};

const CELL: [f64; 2] = [64.0, 25.0];
const LEFT: f64 = 186.0;
const TOP: f64 = 236.0;

/// Draws a table that shows, for each method and sweep, the first parameter value at which one
/// answer in 1,000 is wrong, or `none` if there is no such value in the range. A cell is darker if
/// the method fails sooner. `caption` is printed below.
pub fn heat(onsets: &[Onset], caption: &str) -> Svg {
    let [w, h] = CELL;
    let methods = in_order();
    let (columns, rows) = (SWEEPS.len() as f64, methods.len() as f64);
    let mut svg = Svg::new(LEFT + columns * w + 16.0, TOP + rows * h + 60.0);
    let title =
        "Where one answer in 1,000 is first wrong: rows are methods, columns are parameters";
    svg.text([16.0, 28.0], title, Font::new(18.0, Anchor::Start).bold());
    legend(&mut svg, [16.0, 52.0]);

    for (k, sweep) in SWEEPS.iter().enumerate() {
        heading(&mut svg, LEFT + w * k as f64, sweep);
    }
    for (i, method) in methods.into_iter().map(|method| method.name).enumerate() {
        let y = TOP + h * i as f64;
        let font = Font { bold: is_kernel(method), ..Font::new(12.0, Anchor::End) };
        svg.text([LEFT - 8.0, y + 17.0], method, font.fill(colour_of(method)));
        for (k, sweep) in SWEEPS.iter().enumerate() {
            cell(&mut svg, [LEFT + w * k as f64, y], sweep, method, onsets);
        }
    }
    let font = Font::new(11.0, Anchor::Start).fill(GREY);
    for (k, line) in caption.lines().enumerate() {
        svg.text([16.0, TOP + rows * h + 24.0 + 14.0 * k as f64], line, font);
    }
    svg
}

/// Draws the colour legend.
fn legend(svg: &mut Svg, [x, y]: [f64; 2]) {
    let font = Font::new(12.0, Anchor::Start).fill(GREY);
    let before =
        "each cell shows the first bad value; its colour runs from the harmless end of the range";
    svg.text([x, y], before, font);
    let mut at = x + width(before, 12.0) + 8.0;
    for k in 0..12 {
        svg.rect([at, y - 11.0], [10.0, 14.0], &shade(f64::from(k) / 11.0).0);
        at += 10.0;
    }
    svg.text([at + 8.0, y], "to the other end; none: not within the range", font);
}

/// Draws a column's heading: the name of the sweep, its axis label, and its range.
fn heading(svg: &mut Svg, x: f64, sweep: &Sweep) {
    let range = format!("from {} to {}", number(sweep.from), number(sweep.to));
    let font = Font::new(11.0, Anchor::Start).upright();
    svg.text([x + 20.0, TOP - 8.0], sweep.name, Font { size: 12.0, ..font }.bold());
    svg.text([x + 36.0, TOP - 8.0], sweep.axis, font);
    svg.text([x + 51.0, TOP - 8.0], &range, font.fill(GREY));
}

fn cell(svg: &mut Svg, at: [f64; 2], sweep: &Sweep, method: &str, onsets: &[Onset]) {
    let known = onsets.iter().any(|o| o.sweep == sweep.name && o.method == method);
    let (text, fill, ink) = match first(onsets, sweep.name, method) {
        Some(value) => {
            let share = (value / sweep.from).ln() / (sweep.to / sweep.from).ln();
            let (fill, ink) = shade(share);
            (number(value), fill, ink)
        }
        None if known => ("none".to_owned(), "#ffffff".to_owned(), "#8a8a8a"),
        None => ("?".to_owned(), "#ffffff".to_owned(), GREY),
    };
    svg.rect(at, CELL, &fill);
    svg.frame(at, CELL, "#cccccc");
    let font = Font::new(11.0, Anchor::Middle).fill(ink);
    svg.text([at[0] + CELL[0] / 2.0, at[1] + 16.5], &text, font);
}

/// Returns a cell's colour, from dark red (0) to pale yellow (1), and a text colour that is legible
/// on it. Medium orange is skipped, because no text is legible on it in both light mode and
/// inverted dark mode.
fn shade(share: f64) -> (String, &'static str) {
    let share = share.clamp(0.0, 1.0);
    let (from, to, place, ink) = if share < 0.45 {
        ([0x70, 0x12, 0x12], [0xb8, 0x4a, 0x10], share / 0.45, "#ffffff")
    } else {
        ([0xf2, 0xa4, 0x5c], [0xff, 0xf4, 0xcc], (share - 0.45) / 0.55, "#111111")
    };
    let mix = |c: usize| {
        let (a, b) = (f64::from(from[c]), f64::from(to[c]));
        (a + (b - a) * place).round() as u8
    };
    (format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2)), ink)
}

/// Formats a number with about two significant digits.
fn number(x: f64) -> String {
    if (0.01..1e4).contains(&x) {
        let digits = if x >= 10.0 {
            0
        } else if x >= 1.0 {
            1
        } else {
            2
        };
        let text = format!("{x:.digits$}");
        text.trim_end_matches(".0").to_owned()
    } else {
        format!("{x:.0e}")
    }
}
