//! Plots how often each method is wrong for walls far from the coordinate origin, with one row for
//! each method and input precision.

use super::axis::{Log, power};
use super::marks::{colour_of, is_kernel, pale_of};
use super::svg::{Anchor, FAINT, Font, GREY, INK, Svg};
use crate::stress::{CONTENDERS, DISTANCES, InputPrecision, OffsetErrors};

const LEFT: f64 = 250.0;
const WIDE: f64 = 560.0;
const RIGHT: f64 = 112.0;
const TOP: f64 = 108.0;
/// The height of a row, including the space above it.
const ROW: f64 = 46.0;
const GAP: f64 = 9.0;
/// The space above a group of rows, for its heading.
const HEADING: f64 = 34.0;
/// The UTM northing, in metres, of the built-in house scene. The chart quotes the share of wrong
/// answers at the measured distance nearest to this northing.
const NORTHING: f64 = 528_980.0;

/// Plots the share of wrong answers against a wall's distance from the coordinate origin, for each
/// method in [`CONTENDERS`]. `caption` is printed below.
pub fn offsets(errors: &[OffsetErrors], caption: &str) -> Svg {
    let rows = CONTENDERS.len() as f64;
    let bottom = TOP + 2.0 * HEADING + rows * ROW;
    let mut svg = Svg::new(LEFT + WIDE + RIGHT, bottom + 82.0);
    let title = "Walls far from zero: answers for the coordinates as given, and rounded to f32";
    svg.text([16.0, 30.0], title, Font::new(18.0, Anchor::Start).bold());
    let trials = errors.iter().map(|errors| errors.trials).max().unwrap_or(1).max(10);
    let least = (0.7 / trials as f64).log10().floor().max(-5.0);
    let first = format!(
        "vertical axis: the share of wrong answers, from {} to all; none: no answer was wrong. Rays \
         start 1 nm to 10 cm",
        power(least as i32)
    );
    let notes = [
        &*first,
        "from a wall of 4 m by 3 m, toward it or away; a quarter pass through the diagonal between its \
         triangles.",
        "Rational arithmetic decides the true answers for the f64 coordinates.",
    ];
    for (k, note) in notes.into_iter().enumerate() {
        let font = Font::new(12.0, Anchor::Start).fill(GREY);
        svg.text([16.0, 52.0 + 16.0 * k as f64], note, font);
    }

    let x = Log::new(DISTANCES[0], DISTANCES[1], [LEFT, LEFT + WIDE]);
    let far = |distance: &f64| (distance / NORTHING).ln().abs();
    let distances = errors.iter().map(|errors| errors.distance);
    let near = distances.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(NORTHING);
    let at = format!("at {} km", (near / 1000.0).round());
    svg.text([LEFT + WIDE + 10.0, TOP + 8.0], &at, Font::new(11.0, Anchor::Start).bold());
    let mut y = TOP;
    for (i, &(method, given)) in CONTENDERS.iter().enumerate() {
        if i == 0 || CONTENDERS[i - 1].1 != given {
            y += HEADING;
            let heading = match given {
                InputPrecision::AsGiven => "f64, as given",
                InputPrecision::Rounded => "rounded to f32 first, as f32 ray tracers do",
            };
            svg.text([16.0, y - 10.0], heading, Font::new(12.5, Anchor::Start).bold());
        }
        let own: Vec<_> =
            errors.iter().filter(|e| e.method == method && e.given == given).collect();
        row(
            &mut svg,
            method,
            [&x, &Log::new(1.0, 10_f64.powf(least), [y + GAP, y + ROW])],
            (least, near),
            &own,
        );
        y += ROW;
    }

    let font = Font::new(11.0, Anchor::Middle).fill(GREY);
    for k in x.decades(1) {
        svg.text([x.at(10_f64.powi(k)), y + 16.0], &power(k), font);
    }
    let axis = "distance of the wall from zero, in metres";
    svg.text([LEFT + WIDE / 2.0, y + 34.0], axis, Font::new(12.0, Anchor::Middle));
    let font = Font::new(11.0, Anchor::Start).fill(GREY);
    for (k, line) in caption.lines().enumerate() {
        svg.text([16.0, bottom + 58.0 + 14.0 * k as f64], line, font);
    }
    svg
}

/// Draws a method's curve above its shaded area, and prints its share of wrong answers at the
/// distance `near`.
fn row(
    svg: &mut Svg,
    method: &str,
    [x, y]: [&Log; 2],
    (least, near): (f64, f64),
    errors: &[&OffsetErrors],
) {
    let (top, bottom) = (y.at(1.0), y.at(10_f64.powf(least)));
    let (left, right) = (x.at(DISTANCES[0]), x.at(DISTANCES[1]));
    for k in y.decades(1) {
        let at = y.at(10_f64.powi(k));
        svg.line([left, at], [right, at], FAINT, 0.6);
    }
    for k in x.decades(1) {
        let at = x.at(10_f64.powi(k));
        svg.line([at, top], [at, bottom], FAINT, 0.6);
    }
    let colour = colour_of(method);
    let bold = is_kernel(method);
    let middle = f64::midpoint(top, bottom) + 4.0;
    let font = Font { bold, ..Font::new(12.0, Anchor::End) };
    svg.text([left - 40.0, middle], method, font.fill(colour));
    let font = Font::new(9.5, Anchor::End).fill(GREY);
    svg.text([left - 4.0, top + 6.0], "all", font);
    svg.text([left - 4.0, bottom + 2.0], &power(least as i32), font);

    let place = |errors: &&OffsetErrors| {
        let share = errors.share();
        [x.at(errors.distance), if share > 0.0 { y.at(share).min(bottom) } else { bottom }]
    };
    let curve: Vec<_> = errors.iter().map(place).collect();
    let wrong = errors.iter().any(|errors| errors.share() > 0.0);
    if let (true, Some(first), Some(last)) = (wrong, curve.first(), curve.last()) {
        let mut area = vec![[first[0], bottom]];
        area.extend(&curve);
        area.push([last[0], bottom]);
        svg.polygon(&area, pale_of(method), "none");
        svg.path(&curve, colour, 1.6, "");
    } else {
        let font = Font { bold, ..Font::new(11.0, Anchor::Middle) };
        svg.text([f64::midpoint(left, right), middle], "none", font.fill(colour).halo());
    }
    svg.line([x.at(near), top - 3.0], [x.at(near), bottom], GREY, 1.0);
    svg.line([left, bottom], [right, bottom], INK, 0.9);
    svg.line([left, top], [left, bottom], INK, 0.9);

    let at_near = errors.iter().find(|errors| errors.distance.to_bits() == near.to_bits());
    if let Some(errors) = at_near {
        let text = match errors.share() {
            0.0 => "none".to_owned(),
            share if share < 0.001 => format!("{:.3} %", 100.0 * share),
            share => format!("{:.1} %", 100.0 * share),
        };
        let font = Font { bold, ..Font::new(12.0, Anchor::Start) };
        svg.text([right + 10.0, middle], &text, font.fill(colour));
    }
}
