//! The table of onsets: methods against sweeps.

use super::marks::is_kernel;
use super::svg::{Anchor, Font, GREY, Svg};
use crate::methods::METHODS;
use crate::stress::{Onset, SWEEPS, first};

const CELL: [f64; 2] = [58.0, 25.0];
const LEFT: f64 = 190.0;
const TOP: f64 = 190.0;

/// For each method and sweep the parameter at which one answer in 1,000 is first wrong, the darker
/// the sooner; an empty field where none was.
pub fn heat(onsets: &[Onset], caption: &str) -> Svg {
    let [w, h] = CELL;
    let (columns, rows) = (SWEEPS.len() as f64, METHODS.len() as f64);
    let mut svg = Svg::new(LEFT + columns * w + 60.0, TOP + rows * h + 70.0);
    let title = "The parameter at which one answer in 1,000 is first wrong";
    svg.text([16.0, 28.0], title, Font::new(18.0, Anchor::Start).bold());
    let note = "dark: near the harmless end of the range; empty: not reached within it";
    svg.text([16.0, 47.0], note, Font::new(12.0, Anchor::Start).fill(GREY));

    for (k, sweep) in SWEEPS.iter().enumerate() {
        let x = LEFT + w * (k as f64 + 0.5) + 4.0;
        svg.text([x, TOP - 8.0], sweep.name, Font::new(11.5, Anchor::Start).upright());
    }
    for (i, method) in METHODS.iter().enumerate() {
        let y = TOP + h * i as f64;
        let bold = is_kernel(method.name);
        let font = Font { bold, ..Font::new(12.0, Anchor::End) };
        svg.text([LEFT - 8.0, y + 17.0], method.name, font);
        for (k, sweep) in SWEEPS.iter().enumerate() {
            let at = [LEFT + w * k as f64, y];
            let known = onsets.iter().any(|o| o.sweep == sweep.name && o.method == method.name);
            let value = first(onsets, sweep.name, method.name);
            let share = value.map(|x| (x / sweep.from).ln() / (sweep.to / sweep.from).ln());
            let (fill, ink) = match share {
                Some(share) => shade(share),
                None => ("#ffffff".to_owned(), GREY),
            };
            svg.rect(at, [w, h], &fill);
            svg.frame(at, [w, h], "#cccccc");
            let text = match value {
                Some(value) => number(value),
                None if known => String::new(),
                None => "?".to_owned(),
            };
            let font = Font::new(10.5, Anchor::Middle).fill(ink);
            svg.text([at[0] + w / 2.0, y + 16.5], &text, font);
        }
    }
    let font = Font::new(11.0, Anchor::Start).fill(GREY);
    for (k, line) in caption.lines().enumerate() {
        svg.text([16.0, TOP + rows * h + 24.0 + 14.0 * k as f64], line, font);
    }
    svg
}

/// A field's colour, from dark red (0) to pale yellow (1), and the ink that is read on it.
fn shade(share: f64) -> (String, &'static str) {
    let share = share.clamp(0.0, 1.0);
    let stops = [[0x8b, 0x1a, 0x1a], [0xd5, 0x5e, 0x00], [0xf0, 0xb0, 0x50], [0xff, 0xf4, 0xcc]];
    let place = share * 3.0;
    let k = (place as usize).min(2);
    let mix = |c: usize| {
        let (a, b) = (f64::from(stops[k][c]), f64::from(stops[k + 1][c]));
        (a + (b - a) * (place - k as f64)).round() as u8
    };
    let ink = if share < 0.45 { "#ffffff" } else { "#222222" };
    (format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2)), ink)
}

/// A number in two digits.
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
