//! Plots how long two ways of rendering an image take: ray tracing, and a z-buffer with shadow
//! volumes.

use serde::Serialize;

use super::axis::{Log, power};
use super::svg::{Anchor, FAINT, Font, GREY, INK, Svg, width};
use crate::tables::grouped;

/// The times of both approaches for one scene and one image size.
#[derive(Clone, Debug, Serialize)]
pub struct Race {
    /// The task, which is one of [`Race::TASKS`].
    pub task: &'static str,
    /// The number of triangles.
    pub triangles: usize,
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The time with one ray per pixel, in seconds.
    pub rays: f64,
    /// The time with the z-buffer or the shadow volumes, in seconds.
    pub raster: f64,
}

impl Race {
    /// The tasks: `seen` finds the hit at each pixel, and `lit` determines whether that hit is lit.
    pub const TASKS: [&str; 2] = ["seen", "lit"];
}

const PANEL: [f64; 2] = [560.0, 420.0];
// The positions of the axes within a panel.
const LEFT: f64 = 66.0;
const RIGHT: f64 = 545.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 372.0;
/// The colours of the image sizes, chosen so that colour-blind readers can tell them apart.
const COLOURS: [&str; 4] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7"];
const RASTER: &str = "6 4";

/// Draws two panels, for `seen` and `lit`, which plot the milliseconds per image against the number
/// of triangles. Lines are solid for rays and dashed for the z-buffer and the shadow volumes. Each
/// image size has its own colour, and a ring marks where its two lines cross. `caption` is printed
/// below.
pub fn crossover(races: &[Race], caption: &str) -> Svg {
    let [w, h] = PANEL;
    let mut svg = Svg::new(2.0 * w + 24.0, h + 130.0);
    let title = Font::new(20.0, Anchor::Start).bold();
    svg.text([20.0, 32.0], "Rays against the z-buffer and the shadow volumes", title);
    let mut sizes: Vec<[u32; 2]> = races.iter().map(|race| [race.width, race.height]).collect();
    sizes.sort_unstable();
    sizes.dedup();
    legend(&mut svg, [20.0, 56.0], &sizes);

    let ms = races.iter().flat_map(|race| [race.rays, race.raster]).map(|s| s * 1e3);
    let (least, most) = ms.fold((1.0_f64, 10.0_f64), |(lo, hi), x| (lo.min(x), hi.max(x)));
    let counts = races.iter().map(|race| race.triangles as f64);
    let (few, many) = counts.fold((1000.0_f64, 1e4_f64), |(lo, hi), x| (lo.min(x), hi.max(x)));
    for (k, task) in Race::TASKS.into_iter().enumerate() {
        let [ox, oy] = [12.0 + w * k as f64, 64.0];
        let x = Log::new(0.8 * few, 1.25 * many, [ox + LEFT, ox + RIGHT]);
        let y = Log::new(0.8 * least, 1.25 * most, [oy + BOTTOM, oy + TOP]);
        axes(&mut svg, [ox, oy], k, &x, &y);
        for (size, colour) in sizes.iter().zip(COLOURS.iter().cycle()) {
            let own = races.iter().filter(|race| race.task == task);
            let own: Vec<_> = own.filter(|race| [race.width, race.height] == *size).collect();
            let line = |of: fn(&Race) -> f64| -> Vec<[f64; 2]> {
                own.iter().map(|race| [x.at(race.triangles as f64), y.at(of(race) * 1e3)]).collect()
            };
            let (rays, raster) = (line(|race| race.rays), line(|race| race.raster));
            svg.path(&rays, colour, 2.0, "");
            svg.path(&raster, colour, 2.0, RASTER);
            for place in crossings(&rays, &raster) {
                svg.circle(place, 6.0, "none", INK);
            }
        }
    }
    let font = Font::new(11.0, Anchor::Start).fill(GREY);
    for (k, line) in caption.lines().enumerate() {
        svg.text([20.0, 64.0 + h + 18.0 + 15.0 * k as f64], line, font);
    }
    svg
}

fn legend(svg: &mut Svg, [x, y]: [f64; 2], sizes: &[[u32; 2]]) {
    let font = Font::new(12.5, Anchor::Start);
    let mut at = x;
    let mut entry = |text: &str, draw: &mut dyn FnMut(&mut Svg, f64)| {
        draw(svg, at);
        svg.text([at + 38.0, y], text, font);
        at += 58.0 + width(text, 12.5);
    };
    for (dashes, text) in [("", "rays"), (RASTER, "z-buffer, volumes")] {
        entry(text, &mut |svg, at| {
            svg.path(&[[at, y - 4.0], [at + 32.0, y - 4.0]], INK, 2.0, dashes);
        });
    }
    entry("crossing", &mut |svg, at| svg.circle([at + 26.0, y - 4.0], 6.0, "none", INK));
    for ([width, height], colour) in sizes.iter().zip(COLOURS.iter().cycle()) {
        entry(&format!("{width} × {height}"), &mut |svg, at| {
            svg.rect([at + 18.0, y - 10.0], [14.0, 12.0], colour);
        });
    }
}

fn axes(svg: &mut Svg, [ox, oy]: [f64; 2], panel: usize, x: &Log, y: &Log) {
    let (left, right, top, bottom) = (ox + LEFT, ox + RIGHT, oy + TOP, oy + BOTTOM);
    let heading = [
        "What each pixel shows: primary rays, z-buffer",
        "Whether it is lit: shadow rays, shadow volumes",
    ][panel];
    svg.text([left, oy + 28.0], heading, Font::new(14.0, Anchor::Start).bold());
    for k in x.decades(1) {
        let at = x.at(10_f64.powi(k));
        svg.line([at, top], [at, bottom], FAINT, 0.7);
        let text = if k < 7 { grouped(10_u64.pow(k.unsigned_abs())) } else { power(k) };
        svg.text([at, bottom + 16.0], &text, Font::new(11.0, Anchor::Middle));
    }
    for k in y.decades(1) {
        let at = y.at(10_f64.powi(k));
        svg.line([left, at], [right, at], FAINT, 0.7);
        svg.text([left - 6.0, at + 4.0], &power(k), Font::new(11.0, Anchor::End));
    }
    let font = Font::new(12.0, Anchor::Middle);
    svg.text([f64::midpoint(left, right), bottom + 34.0], "triangles", font);
    let middle = f64::midpoint(top, bottom);
    svg.text([ox + 18.0, middle], "milliseconds per picture", font.upright());
    svg.line([left, bottom], [right, bottom], INK, 1.2);
    svg.line([left, top], [left, bottom], INK, 1.2);
}

/// Returns the points where two polylines with the same x coordinates cross.
fn crossings(one: &[[f64; 2]], other: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut found = Vec::new();
    for (a, b) in one.windows(2).zip(other.windows(2)) {
        let (before, after) = (a[0][1] - b[0][1], a[1][1] - b[1][1]);
        if before * after < 0.0 {
            let t = before / (before - after);
            found.push([0, 1].map(|axis| a[0][axis] + t * (a[1][axis] - a[0][axis])));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::crossings;

    #[test]
    fn lines_cross_where_they_should() {
        let one = [[0.0, 0.0], [1.0, 0.0], [2.0, 4.0]];
        let other = [[0.0, 3.0], [1.0, 1.0], [2.0, 1.0]];
        assert_eq!(crossings(&one, &other), [[1.25, 1.0]]);
        assert!(crossings(&one, &one).is_empty());
    }
}
