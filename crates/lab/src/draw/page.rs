//! Combines charts and text into a self-contained HTML page that loads no scripts, fonts, or other
//! files.

use std::fmt::Write as _;

use super::svg::Svg;
use crate::methods::METHODS;

/// Sets the background and text colours for light and dark mode. The charts are drawn on white;
/// dark mode inverts their lightness and keeps their hues. On narrow screens, the charts keep their
/// size and can be scrolled.
const STYLE: &str = "\
:root { color-scheme: light dark; --paper: #ffffff; --ink: #222222; --faint: #dddddd }
@media (prefers-color-scheme: dark) {
  :root { --paper: #161616; --ink: #dddddd; --faint: #3a3a3a }
  figure svg { filter: invert(0.914) hue-rotate(180deg) }
}
body { margin: 2rem auto; max-width: 90rem; padding: 0 1rem; background: var(--paper);
  color: var(--ink); font: 1rem/1.5 system-ui, sans-serif }
p { max-width: 46rem }
figure, .wide { margin: 1rem 0; overflow-x: auto }
figure svg { display: block; width: 100%; height: auto }
@media (max-width: 70rem) { figure svg { width: auto } }
table { border-collapse: collapse }
td, th { border-bottom: 1px solid var(--faint); padding: 0.2rem 1rem 0.2rem 0; text-align: left }
";

/// A section of the page: a heading, a caption, and a chart.
#[derive(Debug)]
pub struct Section<'a> {
    /// The heading.
    pub title: &'a str,
    /// The caption.
    pub text: &'a str,
    /// The chart.
    pub picture: &'a Svg,
}

/// Builds a page with a title, charts, and a table of all methods.
pub fn page(title: &str, caption: &str, sections: &[Section<'_>]) -> String {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{0}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n<p>{1}</p>\n",
        escape(title),
        escape(caption).replace('\n', "<br>")
    );
    for Section { title, text, picture } in sections {
        let (title, text) = (escape(title), escape(text));
        let _ = write!(
            page,
            "<section>\n<h2>{title}</h2>\n<p>{text}</p>\n<figure tabindex=\"0\">\n{picture}</figure>\n</section>\n"
        );
    }
    page += "<section>\n<h2>The methods</h2>\n<div class=\"wide\" tabindex=\"0\">\n<table>\n\
             <tr><th>method</th><th>bits</th><th>source</th></tr>\n";
    for method in METHODS {
        let (name, source) = (escape(method.name), escape(method.source));
        let _ = writeln!(page, "<tr><td>{name}</td><td>{}</td><td>{source}</td></tr>", method.bits);
    }
    page + "</table>\n</div>\n</section>\n</body>\n</html>\n"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
