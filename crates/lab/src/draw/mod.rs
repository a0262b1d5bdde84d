//! The pictures: speed against accuracy, onset curves, the table of onsets, edge maps; and what any
//! picture is drawn with.

mod axis;
mod chart;
mod crossover;
mod edge_maps;
mod heat;
mod labels;
mod onsets;
mod page;
mod png;
mod svg;

pub use axis::{Log, power};
pub use chart::chart;
pub use crossover::{Race, crossover};
pub use edge_maps::edge_maps;
pub use heat::heat;
pub use onsets::onsets;
pub use page::{Section, page};
pub use png::png;
pub use svg::{Anchor, Font, Svg};

/// The colours of methods: those of M. Okabe and K. Ito, which the colour-blind tell apart and a
/// printer in grey prints in different greys.
mod colour {
    pub(super) const KERNEL: &str = "#D55E00";
    pub(super) const DOUBLE: &str = "#009E73";
    pub(super) const SINGLE: &str = "#0072B2";
}

/// Whether a method of the table is one of the kernel's modes.
fn is_kernel(method: &str) -> bool {
    ["double", "certified", "fixed"].iter().any(|mode| method.starts_with(mode))
}

/// The colour of a method.
fn colour_of(method: &str) -> &'static str {
    if is_kernel(method) {
        colour::KERNEL
    } else if method.ends_with("f64") {
        colour::DOUBLE
    } else {
        colour::SINGLE
    }
}

/// A shape for each of the three kinds: diamond, square, disc; hollow where nothing was seen.
fn mark(svg: &mut Svg, method: &str, [x, y]: [f64; 2], r: f64, hollow: bool) {
    let colour = colour_of(method);
    let fill = if hollow { "#ffffff" } else { colour };
    if is_kernel(method) {
        let r = 1.35 * r;
        svg.polygon(&[[x - r, y], [x, y - r], [x + r, y], [x, y + r]], fill, colour);
    } else if method.ends_with("f64") {
        let r = 0.9 * r;
        svg.polygon(
            &[[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]],
            fill,
            colour,
        );
    } else {
        svg.circle([x, y], r, fill, colour);
    }
}
