//! The phrases that several reports share.

use std::fmt;
use std::path::Path;

use crate::engine::fixed::GridReport;

/// The model's file, or the built-in scene.
pub(crate) fn model(path: Option<&Path>) -> String {
    path.map_or("the built-in scene".to_owned(), |path| path.display().to_string())
}

/// So many rays in so much time.
pub(crate) fn rate(rays: u64, seconds: f64) -> String {
    if seconds > 0.0 {
        format!("{:.2} million a second", rays as f64 / seconds * 1e-6)
    } else {
        "no time taken".to_owned()
    }
}

/// A line about the grid, if there is one.
pub(crate) fn write_grid(f: &mut fmt::Formatter<'_>, grid: Option<GridReport>) -> fmt::Result {
    let Some(GridReport { bits, direction_bits, step, moved, strays }) = grid else {
        return Ok(());
    };
    writeln!(
        f,
        "{bits:>12} bits of grid and {direction_bits} of direction: a step is {step:.1e}, points moved by up to \
         {moved:.1e}, rays stray by less than {strays:.1e}"
    )
}
