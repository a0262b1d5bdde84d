//! The appearance of a method in every chart: its colour and the shape of its mark.

use super::svg::Svg;
use crate::methods::{METHODS, Method};

/// The colours of methods, from the palette of M. Okabe and K. Ito. Colour-blind readers can tell
/// them apart, and they differ in brightness when printed in grey.
mod colour {
    pub(super) const KERNEL: &str = "#D55E00";
    pub(super) const DOUBLE: &str = "#009E73";
    pub(super) const SINGLE: &str = "#0072B2";
}

/// The colours that fill the areas under the methods' curves.
mod pale {
    pub(super) const KERNEL: &str = "#F9DDCA";
    pub(super) const DOUBLE: &str = "#CDEBE1";
    pub(super) const SINGLE: &str = "#CCE3F2";
}

/// Returns the methods in the order of a chart's rows: the kernel's modes, then the published
/// methods.
pub(super) fn in_order() -> Vec<&'static Method> {
    let (mut modes, published): (Vec<_>, Vec<_>) =
        METHODS.iter().partition(|method| is_kernel(method.name));
    modes.extend(published);
    modes
}

/// Returns whether a method is one of the kernel's modes.
pub(super) fn is_kernel(method: &str) -> bool {
    ["certified", "exact", "fixed"].iter().any(|mode| method.starts_with(mode))
}

/// Returns the colour of a method.
pub(super) fn colour_of(method: &str) -> &'static str {
    if is_kernel(method) {
        colour::KERNEL
    } else if method.ends_with("f64") {
        colour::DOUBLE
    } else {
        colour::SINGLE
    }
}

/// Returns the colour of the area under a method's curve.
pub(super) fn pale_of(method: &str) -> &'static str {
    if is_kernel(method) {
        pale::KERNEL
    } else if method.ends_with("f64") {
        pale::DOUBLE
    } else {
        pale::SINGLE
    }
}

/// Draws a method's mark: a diamond for the kernel's modes, a square for f64, and a disc for f32.
/// The mark is hollow if no error was seen.
pub(super) fn mark(svg: &mut Svg, method: &str, [x, y]: [f64; 2], r: f64, hollow: bool) {
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
