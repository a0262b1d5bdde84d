//! An SVG image, built from a few kinds of shapes and from text in drawing order.

use std::fmt::{self, Write as _};

/// The colour of text and axes.
pub(super) const INK: &str = "#222222";
/// The colour of background lines.
pub(super) const FAINT: &str = "#dddddd";
/// The colour of background text.
pub(super) const GREY: &str = "#666666";

/// An image under construction. The y axis points downward.
#[derive(Clone, Debug)]
pub struct Svg {
    width: f64,
    height: f64,
    body: String,
}

/// The part of a text that is placed at the given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

/// The appearance of text.
#[derive(Clone, Copy, Debug)]
pub struct Font<'a> {
    pub(super) size: f64,
    pub(super) anchor: Anchor,
    pub(super) bold: bool,
    pub(super) fill: &'a str,
    /// Whether the text is rotated a quarter turn counter-clockwise.
    pub(super) upright: bool,
    /// Whether the text has a white border, so that it is legible on top of lines.
    pub(super) halo: bool,
}

impl<'a> Font<'a> {
    /// Creates a font for dark text of the given size.
    pub fn new(size: f64, anchor: Anchor) -> Self {
        Self { size, anchor, bold: false, fill: INK, upright: false, halo: false }
    }
    /// Makes the text bold.
    pub fn bold(self) -> Self {
        Self { bold: true, ..self }
    }
    /// Sets the text's colour.
    pub fn fill(self, fill: &'a str) -> Self {
        Self { fill, ..self }
    }
    /// Rotates the text a quarter turn counter-clockwise.
    pub fn upright(self) -> Self {
        Self { upright: true, ..self }
    }
    /// Gives the text a white border.
    pub fn halo(self) -> Self {
        Self { halo: true, ..self }
    }
}

/// Returns the approximate width of a text in the fonts that [`Svg`] names.
pub fn width(text: &str, size: f64) -> f64 {
    text.chars()
        .map(|c| match c {
            'i' | 'l' | 'j' | '.' | ',' | '\'' | '|' => 0.32,
            't' | 'f' | 'r' | ' ' | '(' | ')' | '-' => 0.42,
            'm' | 'w' | 'M' | 'W' | '×' | '%' => 0.95,
            c if c.is_uppercase() => 0.72,
            _ => 0.63,
        })
        .sum::<f64>()
        * size
}

impl Svg {
    /// Creates a blank white image of the given size.
    pub fn new(width: f64, height: f64) -> Self {
        let mut svg = Self { width, height, body: String::new() };
        svg.rect([0.0, 0.0], [width, height], "#ffffff");
        svg
    }

    fn push(&mut self, element: fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.body, "{element}");
    }

    /// Draws a filled rectangle, given its upper left corner and its size.
    pub fn rect(&mut self, [x, y]: [f64; 2], [w, h]: [f64; 2], fill: &str) {
        self.push(format_args!(
            r#"<rect x="{x:.2}" y="{y:.2}" width="{w:.2}" height="{h:.2}" fill="{fill}"/>"#
        ));
    }

    pub(super) fn frame(&mut self, [x, y]: [f64; 2], [w, h]: [f64; 2], stroke: &str) {
        self.push(format_args!(
            r#"<rect x="{x:.2}" y="{y:.2}" width="{w:.2}" height="{h:.2}" fill="none" stroke="{stroke}"/>"#
        ));
    }

    /// Draws a straight line.
    pub fn line(&mut self, a: [f64; 2], b: [f64; 2], stroke: &str, wide: f64) {
        let ([x1, y1], [x2, y2]) = (a, b);
        self.push(format_args!(
            r#"<line x1="{x1:.2}" y1="{y1:.2}" x2="{x2:.2}" y2="{y2:.2}" stroke="{stroke}" stroke-width="{wide}"/>"#
        ));
    }

    /// Draws an open line through points, solid or with a dash pattern such as `6 3`.
    pub fn path(&mut self, points: &[[f64; 2]], stroke: &str, wide: f64, dashes: &str) {
        let points: Vec<_> = points.iter().map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
        let points = points.join(" ");
        let dashes = match dashes {
            "" => String::new(),
            dashes => format!(r#" stroke-dasharray="{dashes}""#),
        };
        self.push(format_args!(
            r#"<polyline points="{points}" fill="none" stroke="{stroke}" stroke-width="{wide}" stroke-linejoin="round"{dashes}/>"#
        ));
    }

    pub(super) fn polygon(&mut self, points: &[[f64; 2]], fill: &str, stroke: &str) {
        let points: Vec<_> = points.iter().map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
        let points = points.join(" ");
        self.push(format_args!(r#"<polygon points="{points}" fill="{fill}" stroke="{stroke}"/>"#));
    }

    /// Draws a filled circle with a border.
    pub fn circle(&mut self, [x, y]: [f64; 2], r: f64, fill: &str, stroke: &str) {
        self.push(format_args!(
            r#"<circle cx="{x:.2}" cy="{y:.2}" r="{r}" fill="{fill}" stroke="{stroke}"/>"#
        ));
    }

    /// Draws text whose baseline runs through a point.
    pub fn text(&mut self, [x, y]: [f64; 2], text: &str, font: Font<'_>) {
        let Font { size, anchor, bold, fill, upright, halo } = font;
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let weight = if bold { r#" font-weight="bold""# } else { "" };
        let halo = if halo {
            r##" paint-order="stroke" stroke="#ffffff" stroke-width="3" stroke-linejoin="round""##
        } else {
            ""
        };
        let turn = if upright {
            format!(r#" transform="rotate(-90 {x:.2} {y:.2})""#)
        } else {
            String::new()
        };
        let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        self.push(format_args!(
            r#"<text x="{x:.2}" y="{y:.2}" font-size="{size}" text-anchor="{anchor}" fill="{fill}"{weight}{halo}{turn}>{text}</text>"#
        ));
    }
}

impl fmt::Display for Svg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, height, body } = self;
        writeln!(
            f,
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" font-family="DejaVu Sans, Verdana, Arial, Helvetica, sans-serif">"#
        )?;
        write!(f, "{body}</svg>")
    }
}
